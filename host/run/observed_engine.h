// An observed engine calls an observer when it counts.
#pragma once
#include <functional>
#include <memory>

#include <viewpeel/engine.h>

namespace viewpeel {

// Wraps an engine for its observer.
//   In: on_count as in Observer; empty: the engine itself is returned
std::unique_ptr<Engine> observed(std::unique_ptr<Engine> engine, std::function<void(bool begins)> on_count);

}  // namespace viewpeel
