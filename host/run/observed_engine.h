// An observed engine notifies an observer when it begins to count and when it ends.
#pragma once
#include <functional>
#include <memory>

#include <viewpeel/engine.h>

namespace viewpeel {

// Returns an engine that notifies on_count around each call of count().
//   In: on_count: as in Observer; where it is empty, the engine itself is returned
std::unique_ptr<Engine> observed(std::unique_ptr<Engine> engine, std::function<void(bool begins)> on_count);

}  // namespace viewpeel
