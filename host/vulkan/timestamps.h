// Timestamps measures how long passes take on the device.
#pragma once
#include <vector>

#include "vulkan/device.h"

namespace viewpeel {

// A Timestamps records marks in a command buffer and measures the time between them.
class Timestamps {
 public:
  Timestamps() = default;
  //   In: count: the number of marks that it can record
  Timestamps(const Device& device, uint32_t count);
  ~Timestamps();
  Timestamps(Timestamps&& other) noexcept;
  Timestamps& operator=(Timestamps&& other) noexcept;

  // Forgets all marks; it must be recorded before the first mark.
  void reset(VkCommandBuffer commands);
  // Records a mark after all commands so far. Beyond `count` marks, or without a clock, it does nothing.
  void mark(VkCommandBuffer commands);
  // Returns the seconds between consecutive marks: double[marks - 1], or none without a clock. The commands must have
  // finished.
  std::vector<double> seconds() const;

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  uint32_t count_ = 0, marked_ = 0;
  double seconds_per_tick_ = 0;
  uint64_t valid_ = 0;
};

}  // namespace viewpeel
