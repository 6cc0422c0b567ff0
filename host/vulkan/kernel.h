// A Kernel is a Vulkan pipeline, made of the SPIR-V that the build has embedded in the library.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <tuple>
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

// A Pipeline is a Vulkan pipeline with its layout.
struct Pipeline {
  explicit Pipeline(VkDevice in) : device(in) {}
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  VkDevice device;
  VkDescriptorSetLayout texels = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline handle = VK_NULL_HANDLE;
};

// ComputePipelines are the compute pipelines of a device. Kernels that are alike share one, for drivers take long to
// make it, and several engines may follow one another on a device.
class ComputePipelines {
 public:
  // Returns the pipeline with these properties, and makes it where it is new. Several threads may call it at once.
  //   In: as of Kernel; spirv: never freed or changed, for its address stands for it
  std::shared_ptr<const Pipeline> find(const Device& device, std::span<const uint32_t> spirv, uint32_t push_bytes,
                                       const std::vector<uint32_t>& constants, uint32_t texel_buffers);
  size_t count() const { return made_.size(); }

 private:
  using Key = std::tuple<const uint32_t*, uint32_t, std::vector<uint32_t>, uint32_t>;
  std::mutex mutex_;
  std::map<Key, std::shared_ptr<const Pipeline>> made_;
};

// A Kernel is a compute or graphics pipeline. Its input is one push-constant struct and, where it reads texels, texel
// buffers at bindings 0, 1, ...
class Kernel {
 public:
  Kernel() = default;
  // Makes a compute kernel. It shares the pipeline of a kernel that was made alike on the device.
  //   In: spirv: embedded in the library; push_bytes: size of the push-constant struct; constants: specialisation
  //     constants 0, 1, ... of the shader; texel_buffers: number of texel buffers
  Kernel(const Device& device, std::span<const uint32_t> spirv, uint32_t push_bytes,
         const std::vector<uint32_t>& constants = {}, uint32_t texel_buffers = 0);
  // Makes a graphics kernel for dynamic rendering. It draws triangle strips without vertex buffers into one colour and
  // one depth attachment.
  //   In: colour, depth: formats of the attachments; nearer: comparison by which a fragment's depth must pass against
  //     the depth that is stored
  Kernel(const Device& device, std::span<const uint32_t> vertex_spirv, std::span<const uint32_t> fragment_spirv,
         VkFormat colour, VkFormat depth, uint32_t push_bytes, VkCompareOp nearer = VK_COMPARE_OP_LESS);

  VkPipeline pipeline() const { return made_ ? made_->handle : VK_NULL_HANDLE; }
  VkPipelineLayout layout() const { return made_ ? made_->layout : VK_NULL_HANDLE; }
  VkShaderStageFlags stages() const { return stages_; }

 private:
  std::shared_ptr<const Pipeline> made_;
  VkShaderStageFlags stages_ = 0;
};

}  // namespace viewpeel
