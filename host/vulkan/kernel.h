#pragma once
#include <span>

#include "vulkan/device.h"

namespace viewpeel {

// A shader module made from embedded SPIR-V.
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

// A pipeline, compute or graphics, whose only input is one push-constant struct.
class Kernel {
 public:
  Kernel() = default;
  // A compute kernel. local_size_x becomes specialisation constant 0 of a shader that leaves it open.
  Kernel(const Device& device, std::span<const uint32_t> spirv, uint32_t push_bytes, uint32_t local_size_x = 0);
  // A graphics kernel without vertex buffers: triangle strips, one colour and one depth attachment of the formats given, depth
  // test LESS, as dynamic rendering.
  Kernel(const Device& device, std::span<const uint32_t> vertex_spirv, std::span<const uint32_t> fragment_spirv,
         VkFormat colour, VkFormat depth, uint32_t push_bytes);
  ~Kernel();
  Kernel(Kernel&& other) noexcept;
  Kernel& operator=(Kernel&& other) noexcept;

  VkPipeline pipeline() const { return pipeline_; }
  VkPipelineLayout layout() const { return layout_; }
  VkShaderStageFlags stages() const { return stages_; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkShaderStageFlags stages_ = 0;
};

}  // namespace viewpeel
