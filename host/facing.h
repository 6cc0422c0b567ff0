// This header makes the facing rules of shaders/facing.h usable in C++.
#pragma once
#include <cstdint>

namespace viewpeel {
using uint = std::uint32_t;
#include "../shaders/facing.h"
}  // namespace viewpeel
