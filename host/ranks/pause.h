#pragma once
#include <algorithm>
#include <chrono>
#include <thread>

namespace viewpeel {

// A Pause between two looks for a message doubles each time, up to a millisecond, so that a waiting rank takes no
// processor from others.
class Pause {
 public:
  void wait() {
    std::this_thread::sleep_for(next_);
    next_ = std::min(2 * next_, kMost);
  }

 private:
  static constexpr std::chrono::microseconds kMost{1000};
  std::chrono::microseconds next_{20};
};

}  // namespace viewpeel
