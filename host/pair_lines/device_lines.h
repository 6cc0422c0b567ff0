// DeviceLines draws lines between many pairs of patches on a Vulkan device, with the same bits as LineDrawer.
//
// A batch of tasks takes these passes, in order:
//   prepare  where the lines of a task start and end
//   place    the blockers of each task, in single precision about its smaller patch
//   draw     the lines of portions of up to 16 blocks, and their sums
// The host adds the sums of a task's portions in their order.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "pair_lines/draw_lines.h"
#include "vulkan/device.h"

namespace viewpeel {

// A LineTask asks for lines between two patches.
struct LineTask {
  uint32_t a, b;  // patches
  LineWay way = LineWay::points;
  double exchange = 0;  // exchange area with nothing in between, unit-ball units squared, above 0
  std::span<const PlacedBlocker> between;
  std::array<uint32_t, 4> scrambles{};
  uint32_t first = 0, end = 0;  // from block `first` to before block `end`, of 16 lines each
};

// Draws the lines of a task on the processor.
DrawnLines drawOnHost(const LineTask& task, std::span<const Patch> patches, const std::vector<Blocker>& blockers,
                      Vectors vectors);

struct DeviceLinesOptions {
  uint64_t most_tests = 0;          // of lines against blockers in a batch; 0: as many as take well under a second
  uint64_t most_bytes = 256 << 20;  // of a batch on the device
};

class DeviceLines {
 public:
  // Tasks with more blockers go to the processor: software devices end loops after 65,535 turns.
  static constexpr size_t kMostBlockers = 400;

  //   In: device, patches: kept by reference
  //   Throws: Error device.    Cost: kernels are compiled, 1 s on lavapipe.
  DeviceLines(const Device& device, std::span<const Patch> patches, std::span<const Blocker> blockers,
              const DeviceLinesOptions& options = {});
  ~DeviceLines();
  DeviceLines(DeviceLines&&) noexcept;
  DeviceLines& operator=(DeviceLines&&) noexcept;

  static bool takes(const LineTask& task) { return task.between.size() <= kMostBlockers; }

  // Draws the lines of tasks.
  //   In: tasks: each must pass takes(); stop: called before each batch, may throw, may be empty
  //   Out: the sums of each task, as drawOnHost() returns them, to the last bit
  //   Error: as LineDrawer's, if the device rounds as IEEE 754 does by default; agree() tests this.
  //   Throws: Error device, Error memory where not even small batches fit.
  //   Cost: some 0.5 KB a task, 164 bytes a blocker, and 24 bytes a portion on the device. Two batches are in flight.
  std::vector<DrawnLines> draw(std::span<const LineTask> tasks, const std::function<void()>& stop = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Returns whether the device draws the lines of some of these tasks with the same bits as the processor.
bool agree(DeviceLines& device_lines, std::span<const LineTask> tasks, std::span<const Patch> patches,
           const std::vector<Blocker>& blockers);

}  // namespace viewpeel
