// A Kernel is a pipeline made of embedded SPIR-V, with its layout.
#pragma once
#include <span>
#include <vector>

#include "vulkan/device.h"

namespace viewpeel {

// A ShaderModule is made from embedded SPIR-V.
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

// A pipeline, compute or graphics, whose input is one push-constant struct and, where it reads texels, buffers at
// bindings 0, 1, ...
class Kernel {
 public:
  Kernel() = default;
  // A compute kernel. constants: specialisation constants 0, 1, ... of the shader.
  Kernel(const Device& device, std::span<const uint32_t> spirv, uint32_t push_bytes,
         const std::vector<uint32_t>& constants = {}, uint32_t texel_buffers = 0);
  // Makes a graphics kernel without vertex buffers: triangle strips, one colour and one depth attachment of these
  // formats, as dynamic rendering.
  //   In: nearer: how a fragment's depth compares to the depth it replaces
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
