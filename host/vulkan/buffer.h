// A Buffer is a Vulkan buffer that owns its memory.
#pragma once
#include <cstring>
#include <span>

#include "vulkan/device.h"

namespace viewpeel {

// The memory of a buffer is on the device, or mapped for the host to write (upload) or read (readback).
enum class MemoryUse { device, upload, readback };

// Shaders reach a Buffer by its device address and, where it has a texel format, as texels. Each Buffer allocates
// memory separately, so it does not suit many small buffers.
class Buffer {
 public:
  Buffer() = default;
  // Makes a buffer of at least size_bytes.    In: texels: format of its texels, if shaders read it as texels
  //   Throws: Error memory, which names the size, where the device has no room or allows fewer texels.
  Buffer(const Device& device, VkDeviceSize size_bytes, MemoryUse use, VkFormat texels = VK_FORMAT_UNDEFINED);
  ~Buffer();
  Buffer(Buffer&& other) noexcept;
  Buffer& operator=(Buffer&& other) noexcept;

  VkBuffer handle() const { return buffer_; }
  VkBufferView texels() const { return texels_; }
  VkDeviceAddress address() const { return address_; }
  VkDeviceSize sizeBytes() const { return size_bytes_; }

  // Returns the mapped memory of upload and readback buffers.
  template <class T>
  std::span<T> mapped() const {
    return {static_cast<T*>(mapped_), size_bytes_ / sizeof(T)};
  }
  template <class T>
  void write(std::span<const T> values) {
    std::memcpy(mapped_, values.data(), values.size_bytes());
  }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkBufferView texels_ = VK_NULL_HANDLE;
  VkDeviceAddress address_ = 0;
  VkDeviceSize size_bytes_ = 0;
  void* mapped_ = nullptr;
};

}  // namespace viewpeel
