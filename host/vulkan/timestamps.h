// Times of passes on the device.
#pragma once
#include <vector>

#include "vulkan/device.h"

namespace viewpeel {

// Timestamps measure the device's time between marks in a command buffer.
class Timestamps {
 public:
  Timestamps() = default;
  Timestamps(const Device& device, uint32_t count);
  ~Timestamps();
  Timestamps(Timestamps&& other) noexcept;
  Timestamps& operator=(Timestamps&& other) noexcept;

  // Forgets all marks. It is called before the first mark.
  void reset(VkCommandBuffer commands);
  void mark(VkCommandBuffer commands);
  // Returns the seconds between consecutive marks; the commands must have finished.
  std::vector<double> seconds() const;

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  uint32_t count_ = 0, marked_ = 0;
  double seconds_per_tick_ = 0;
  uint64_t valid_ = 0;
};

}  // namespace viewpeel
