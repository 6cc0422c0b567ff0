// Progress is one line on the terminal, rewritten after every batch of directions and every replicate; in a log it is a
// line a minute.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include <viewpeel/compute.h>

#include "stopwatch.h"

namespace viewpeel::program {

// Returns how far the goal is, from 0 to 1; nothing where nobody knows.
//   In: elapsed_s: since the run began. Errors fall with the root of the number of replicates.
std::optional<double> measureFraction(const Request& request, const Progress& progress, double elapsed_s);

// Returns a line of at most 79 characters: phase, percent, remaining time, and what is being counted.
//   In: elapsed_s: since the run began; counted_s: since counting began
std::string describeProgress(const Request& request, const Progress& progress, double elapsed_s, double counted_s);

class ProgressLine {
 public:
  // In: request: referred to; shows: false for --quiet
  ProgressLine(const Request& request, bool shows);
  // Shows the name of a phase that has no numbers, such as reading; on a terminal alone.
  void begin(const std::string& phase) const;
  // Returns a function for Observer::on_progress; empty where nothing is shown. It refers to this line.
  std::function<void(const Progress&)> listener();
  void clear() const;

 private:
  void show(const Progress& progress);

  const Request& request_;
  bool shows_, is_terminal_;
  double seconds_apart_;
  Clock::time_point start_ = Clock::now(), shown_ = start_, counting_ = start_;
  std::optional<Progress::Phase> phase_;  // of the last call
};

}  // namespace viewpeel::program
