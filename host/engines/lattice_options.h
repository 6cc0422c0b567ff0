#pragma once
#include <cstdint>

namespace viewpeel {

// A window of 2043 x 2043 points is the largest whose groups of 64 every device can dispatch in one row (65,535).
constexpr int kMaxResolution = 2039;

// What the engines that count lattice points have in common. None but `resolution` changes a result.
struct LatticeOptions {
  int resolution = 64;            // lattice spacings across the unit ball's diameter, 1 to kMaxResolution
  uint32_t batch_directions = 0;  // directions peeled at once; 0 chooses by memory
  uint64_t counter_budget_bytes = 2ull << 30;
  uint32_t list_capacity = 0;     // of the compute engine's tile lists at first, for tests of their growth; 0 chooses
};

}  // namespace viewpeel
