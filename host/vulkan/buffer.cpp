#include "vulkan/buffer.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

VkMemoryPropertyFlags memoryFlags(MemoryUse use) {
  switch (use) {
    case MemoryUse::device:
      return VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    case MemoryUse::upload:
      return VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    case MemoryUse::readback:
      return VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT |
             VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  }
  return 0;
}

VkDeviceSize texelBytes(VkFormat format) {
  return format == VK_FORMAT_R32_UINT ? 4 : format == VK_FORMAT_R32G32_UINT ? 8 : 16;
}

[[noreturn]] void refuse(const Device& device, VkDeviceSize size_bytes) {
  throw Error(ErrorCode::memory,
              fmt::format("{}: cannot allocate {:.1f} MiB; try a smaller --resolution or scene, or --by surface",
                          device.description().name, static_cast<double>(size_bytes) / 1048576.0));
}

}  // namespace

// The delegated constructor has finished before this body runs, so the destructor is called if the body throws.
Buffer::Buffer(const Device& device, VkDeviceSize size_bytes, MemoryUse use, VkFormat texels) : Buffer() {
  device_ = device.handle();
  size_bytes_ = std::max<VkDeviceSize>(size_bytes, 16);
  if (size_bytes_ > device.maxAllocationBytes()) refuse(device, size_bytes_);
  if (texels != VK_FORMAT_UNDEFINED &&
      size_bytes_ / texelBytes(texels) > device.properties().limits.maxTexelBufferElements)
    refuse(device, size_bytes_);
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = size_bytes_;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
               VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
               VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  check(vkCreateBuffer(device_, &info, nullptr, &buffer_), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_, buffer_, &needs);
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  allocation.allocationSize = needs.size;
  allocation.memoryTypeIndex = device.memoryType(needs.memoryTypeBits, memoryFlags(use));
  if (vkAllocateMemory(device_, &allocation, nullptr, &memory_) != VK_SUCCESS) refuse(device, needs.size);
  check(vkBindBufferMemory(device_, buffer_, memory_, 0), "vkBindBufferMemory");
  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = buffer_;
  address_ = vkGetBufferDeviceAddress(device_, &address);
  if (texels != VK_FORMAT_UNDEFINED) {
    VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    view.buffer = buffer_;
    view.format = texels;
    view.range = size_bytes_ / texelBytes(texels) * texelBytes(texels);
    check(vkCreateBufferView(device_, &view, nullptr, &texels_), "vkCreateBufferView");
  }
  if (use != MemoryUse::device) check(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &mapped_), "vkMapMemory");
}

Buffer::~Buffer() {
  if (!buffer_) return;
  if (texels_) vkDestroyBufferView(device_, texels_, nullptr);
  vkDestroyBuffer(device_, buffer_, nullptr);
  vkFreeMemory(device_, memory_, nullptr);
}

Buffer::Buffer(Buffer&& other) noexcept { *this = std::move(other); }

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(texels_, other.texels_);
  std::swap(address_, other.address_);
  std::swap(size_bytes_, other.size_bytes_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

}  // namespace viewpeel
