#include "vulkan/commands.h"

#include <utility>
#include <vector>

namespace viewpeel {

Commands::Commands(const Device& device) : Commands() {  // delegates, so that the destructor runs if this body throws
  device_ = device.handle();
  queue_ = device.queue();
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.queueFamilyIndex = device.queueFamily();
  check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  buffer.commandPool = pool_;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  check(vkAllocateCommandBuffers(device_, &buffer, &commands_), "vkAllocateCommandBuffers");
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  check(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
}

Commands::~Commands() {
  if (!pool_) return;
  vkDestroyFence(device_, fence_, nullptr);
  vkDestroyCommandPool(device_, pool_, nullptr);
}

Commands::Commands(Commands&& other) noexcept { *this = std::move(other); }

Commands& Commands::operator=(Commands&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(queue_, other.queue_);
  std::swap(pool_, other.pool_);
  std::swap(commands_, other.commands_);
  std::swap(fence_, other.fence_);
  return *this;
}

void Commands::begin() {
  check(vkResetCommandPool(device_, pool_, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
}

void Commands::barrier() {
  VkMemoryBarrier2 everything{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  everything.srcStageMask = everything.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  everything.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  everything.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &everything;
  vkCmdPipelineBarrier2(commands_, &info);
}

void Commands::bind(const Kernel& kernel, VkPipelineBindPoint point) {
  vkCmdBindPipeline(commands_, point, kernel.pipeline());
}

void Commands::copy(const Buffer& from, const Buffer& to, VkDeviceSize size_bytes, VkDeviceSize from_offset,
                    VkDeviceSize to_offset) {
  const VkBufferCopy region{from_offset, to_offset, size_bytes};
  vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
}

void Commands::prepare(const Image& image) {
  VkImageMemoryBarrier2 transition{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  transition.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  transition.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  transition.newLayout = VK_IMAGE_LAYOUT_GENERAL;
  transition.image = image.handle();
  transition.subresourceRange = {image.aspect(), 0, 1, 0, 1};
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &transition;
  vkCmdPipelineBarrier2(commands_, &dependency);
}

void Commands::fill(const Buffer& buffer, uint32_t word, VkDeviceSize size_bytes) {
  vkCmdFillBuffer(commands_, buffer.handle(), 0, size_bytes, word);
}

void Commands::bindTexels(const Kernel& kernel, std::span<const VkBufferView> views) {
  std::vector<VkWriteDescriptorSet> writes;
  for (uint32_t k = 0; k < views.size(); ++k) {
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstBinding = k;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    write.pTexelBufferView = &views[k];
    writes.push_back(write);
  }
  vkCmdPushDescriptorSetKHR(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.layout(), 0,
                            static_cast<uint32_t>(writes.size()), writes.data());
}

void Commands::submit() {
  // This barrier makes writes visible to the host, which reads mapped memory after it has waited for the fence.
  VkMemoryBarrier2 host{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  host.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  host.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  host.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
  host.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &host;
  vkCmdPipelineBarrier2(commands_, &dependency);
  check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  buffer.commandBuffer = commands_;
  VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &buffer;
  check(vkQueueSubmit2(queue_, 1, &submit, fence_), "vkQueueSubmit2");
}

void Commands::wait() {
  check(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  check(vkResetFences(device_, 1, &fence_), "vkResetFences");
}

}  // namespace viewpeel
