// An engine that tells an observer when it counts.
#pragma once
#include <functional>
#include <memory>

#include <viewpeel/engine.h>

namespace viewpeel {

//   In: on_count as in Observer; empty: the engine itself
std::unique_ptr<Engine> observed(std::unique_ptr<Engine> engine, std::function<void(bool begins)> on_count);

}  // namespace viewpeel
