// A ProgressLine shows progress: on a terminal one line, rewritten after every batch of directions and every replicate;
// in a log a line a minute.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include <viewpeel/compute.h>

#include "stopwatch.h"

namespace viewpeel::program {

// Returns the progress towards the goal, from 0 to 1; nothing where it cannot be predicted.
//   In: elapsed_s: since the run began    Method: R replicates are taken to have errors in proportion to R^-1/2.
std::optional<double> measureFraction(const Request& request, const Progress& progress, double elapsed_s);

// Returns a line of up to 79 characters: phase, percent, remaining time, and the count.
//   In: elapsed_s: since the run began; counted_s: since counting began
std::string describeProgress(const Request& request, const Progress& progress, double elapsed_s, double counted_s);

// Returns how long an estimate with an end takes, from the replicates that it has counted, for a run of more than some
// seconds; else nothing.    In: counted_s: since counting began    Out: a line of the summary
std::optional<std::string> predictEnd(const Request& request, const Progress& progress, double counted_s);

class ProgressLine {
 public:
  // In: request: kept by reference; shows: false for --quiet
  ProgressLine(const Request& request, bool shows);
  // Shows the name of a phase that has no numbers, such as reading, if stderr is a terminal.
  void begin(const std::string& phase) const;
  // Returns a function for Observer::on_progress; empty where nothing is shown. It keeps a reference to this object.
  std::function<void(const Progress&)> listener();
  void clear() const;
  // Returns predictEnd() of the last progress.
  std::optional<std::string> predict() const;

 private:
  void show(const Progress& progress);

  const Request& request_;
  bool shows_, is_terminal_;
  double seconds_apart_;
  Clock::time_point start_ = Clock::now(), shown_ = start_, counting_ = start_;
  Progress last_;                         // what show() had last
  std::optional<Progress::Phase> phase_;  // its phase; nothing before the first call
};

}  // namespace viewpeel::program
