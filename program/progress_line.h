// The progress is one line on the terminal, rewritten after every batch of directions and every replicate.
#pragma once
#include <functional>

#include <viewpeel/compute.h>

#include "stopwatch.h"

namespace viewpeel::program {

class ProgressLine {
 public:
  // Shows nothing where stderr is no terminal.    In: request: referred to
  ProgressLine(const Request& request, bool shows);
  // Returns a function for Observer::on_progress; empty where nothing is shown. It refers to this line.
  std::function<void(const Progress&)> listener();
  void clear() const;

 private:
  void show(const Progress& progress);
  std::string describe(const Progress& progress) const;

  const Request& request_;
  bool shows_;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
};

}  // namespace viewpeel::program
