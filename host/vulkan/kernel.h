// A Kernel is a Vulkan pipeline, made of the SPIR-V that the build has embedded in the library.
#pragma once
#include <span>
#include <vector>

#include "vulkan/device.h"

namespace viewpeel {

// A ShaderModule is a Vulkan shader module made of SPIR-V.
class ShaderModule {
 public:
  ShaderModule(const Device& device, std::span<const uint32_t> spirv);
  ~ShaderModule() { vkDestroyShaderModule(device_, module_, nullptr); }
  ShaderModule(const ShaderModule&) = delete;
  ShaderModule& operator=(const ShaderModule&) = delete;
  VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits stage) const;

 private:
  VkDevice device_;
  VkShaderModule module_ = VK_NULL_HANDLE;
};

// A Kernel is a compute or graphics pipeline. Its input is one push-constant struct and, where it reads texels, texel
// buffers at bindings 0, 1, ...
class Kernel {
 public:
  Kernel() = default;
  // Makes a compute kernel.
  //   In: push_bytes: size of the push-constant struct; constants: specialisation constants 0, 1, ... of the shader;
  //     texel_buffers: number of texel buffers
  Kernel(const Device& device, std::span<const uint32_t> spirv, uint32_t push_bytes,
         const std::vector<uint32_t>& constants = {}, uint32_t texel_buffers = 0);
  // Makes a graphics kernel for dynamic rendering. It draws triangle strips without vertex buffers into one colour and
  // one depth attachment.
  //   In: colour, depth: formats of the attachments; nearer: comparison by which a fragment's depth must pass against
  //     the depth that is stored
  Kernel(const Device& device, std::span<const uint32_t> vertex_spirv, std::span<const uint32_t> fragment_spirv,
         VkFormat colour, VkFormat depth, uint32_t push_bytes, VkCompareOp nearer = VK_COMPARE_OP_LESS);
  ~Kernel();
  Kernel(Kernel&& other) noexcept;
  Kernel& operator=(Kernel&& other) noexcept;

  VkPipeline pipeline() const { return pipeline_; }
  VkPipelineLayout layout() const { return layout_; }
  VkShaderStageFlags stages() const { return stages_; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkDescriptorSetLayout texels_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkShaderStageFlags stages_ = 0;
};

}  // namespace viewpeel
