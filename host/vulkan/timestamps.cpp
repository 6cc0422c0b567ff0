#include "vulkan/timestamps.h"

#include <utility>

namespace viewpeel {

Timestamps::Timestamps(const Device& device, uint32_t count) : device_(device.handle()), count_(count) {
  uint32_t family_count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device.physical(), &family_count, nullptr);
  std::vector<VkQueueFamilyProperties> families(family_count);
  vkGetPhysicalDeviceQueueFamilyProperties(device.physical(), &family_count, families.data());
  const uint32_t bits = families[device.queueFamily()].timestampValidBits;
  if (bits == 0) return;  // without a clock on the device mark() does nothing
  valid_ = bits >= 64 ? ~0ull : (1ull << bits) - 1;
  seconds_per_tick_ = double(device.properties().limits.timestampPeriod) * 1e-9;
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = count;
  check(vkCreateQueryPool(device_, &info, nullptr, &pool_), "vkCreateQueryPool");
}

Timestamps::~Timestamps() {
  if (pool_) vkDestroyQueryPool(device_, pool_, nullptr);
}

Timestamps::Timestamps(Timestamps&& other) noexcept { *this = std::move(other); }

Timestamps& Timestamps::operator=(Timestamps&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(pool_, other.pool_);
  std::swap(count_, other.count_);
  std::swap(marked_, other.marked_);
  std::swap(seconds_per_tick_, other.seconds_per_tick_);
  std::swap(valid_, other.valid_);
  return *this;
}

void Timestamps::reset(VkCommandBuffer commands) {
  marked_ = 0;
  if (pool_) vkCmdResetQueryPool(commands, pool_, 0, count_);
}

void Timestamps::mark(VkCommandBuffer commands) {
  if (pool_ && marked_ < count_) vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, marked_++);
}

std::vector<double> Timestamps::seconds() const {
  std::vector<uint64_t> ticks(marked_);
  if (marked_ == 0) return {};
  check(vkGetQueryPoolResults(device_, pool_, 0, marked_, marked_ * sizeof(uint64_t), ticks.data(), sizeof(uint64_t),
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  std::vector<double> times;
  for (uint32_t k = 1; k < marked_; ++k)
    times.push_back(double((ticks[k] - ticks[k - 1]) & valid_) * seconds_per_tick_);
  return times;
}

}  // namespace viewpeel
