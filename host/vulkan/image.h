// The graphics engine draws into an Image, a Vulkan image that owns its memory.
#pragma once
#include "vulkan/device.h"

namespace viewpeel {

// An Image has two dimensions. It is drawn into as an attachment and copied from, always in the layout GENERAL.
class Image {
 public:
  Image() = default;
  Image(const Device& device, uint32_t width, uint32_t height, VkFormat format, VkImageUsageFlags usage,
        VkImageAspectFlags aspect);
  ~Image();
  Image(Image&& other) noexcept;
  Image& operator=(Image&& other) noexcept;

  VkImage handle() const { return image_; }
  VkImageView view() const { return view_; }
  VkImageAspectFlags aspect() const { return aspect_; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkImageAspectFlags aspect_ = 0;
};

}  // namespace viewpeel
