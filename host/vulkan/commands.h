// Commands wraps a Vulkan command buffer, with typed push constants and a fence to wait for.
#pragma once
#include <span>

#include "vulkan/buffer.h"
#include "vulkan/image.h"
#include "vulkan/kernel.h"

namespace viewpeel {

// A Commands is a command buffer that is recorded, submitted and waited for, again and again.
class Commands {
 public:
  explicit Commands(const Device& device);
  ~Commands();
  Commands(Commands&& other) noexcept;
  Commands& operator=(Commands&& other) noexcept;

  VkCommandBuffer handle() const { return commands_; }
  // Begins to record; the commands recorded before are dropped.
  void begin();
  // Records a barrier: all commands before it are finished, and what they wrote is visible, before any command after
  // it.
  void barrier();
  void bind(const Kernel& kernel, VkPipelineBindPoint point);
  template <class Args>
  void push(const Kernel& kernel, const Args& args) {
    vkCmdPushConstants(commands_, kernel.layout(), kernel.stages(), 0, sizeof(Args), &args);
  }
  // Binds the buffers that a kernel reads as texels, in the order of its bindings.
  void bindTexels(const Kernel& kernel, std::span<const VkBufferView> views);
  template <class Args>
  void dispatch(const Kernel& kernel, const Args& args, uint32_t groups_x, uint32_t groups_y, uint32_t groups_z = 1) {
    bind(kernel, VK_PIPELINE_BIND_POINT_COMPUTE);
    push(kernel, args);
    vkCmdDispatch(commands_, groups_x, groups_y, groups_z);
  }
  template <class Args>
  void dispatchIndirect(const Kernel& kernel, const Args& args, const Buffer& groups, VkDeviceSize offset) {
    bind(kernel, VK_PIPELINE_BIND_POINT_COMPUTE);
    push(kernel, args);
    vkCmdDispatchIndirect(commands_, groups.handle(), offset);
  }
  void copy(const Buffer& from, const Buffer& to, VkDeviceSize size_bytes, VkDeviceSize from_offset = 0,
            VkDeviceSize to_offset = 0);
  // Records the transition of an image to the layout GENERAL, before its first use. Its contents are lost.
  void prepare(const Image& image);
  void fill(const Buffer& buffer, uint32_t word, VkDeviceSize size_bytes = VK_WHOLE_SIZE);
  // Ends recording and submits the commands to the queue.    Throws: Error device where the device is lost.
  void submit();
  // Waits until the submitted commands have finished.    Throws: Error device where the device is lost.
  void wait();
  void submitAndWait() {
    submit();
    wait();
  }

 private:
  Commands() = default;

  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace viewpeel
