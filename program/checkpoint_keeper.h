// A CheckpointKeeper does the work of --checkpoint and --resume.
#pragma once
#include <chrono>
#include <string>

#include <CLI/CLI.hpp>

#include <viewpeel/compute.h>

#include "io/file_lock.h"

namespace viewpeel::program {

struct CheckpointOptions {
  std::string file;  // empty: none is kept
  bool resume = false;
  double seconds_apart = 10;
};

void addCheckpointOptions(CLI::App* command, CheckpointOptions& options);

// Makes sure that no file is written over by mistake.    Throws: Error bad_usage where there is such a file, or none
// can be written.
void requireNewCheckpoint(const std::string& file);

// Keeps the checkpoint of one run up to date.
class CheckpointKeeper {
 public:
  // Lets the run go on from its checkpoint, where there is one. Call it before the run's plan.
  //   Throws: Error bad_usage where there is a file without --resume, it is of another run, another run is keeping it,
  //     or none can be written; as FormFactorRun::resumeFrom.
  CheckpointKeeper(const CheckpointOptions& options, FormFactorRun& run);

  // Returns one line about the checkpoint found.
  std::string describe() const;

  // Writes where the last time is long enough ago, or `last`. A failure is a warning: the run is worth more than its
  // checkpoint. A file that another run has put there is left alone.
  void keep(const FormFactorRun& run, bool last);
  // Returns false where the last attempt failed.
  bool isKept() const { return is_kept_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  CheckpointOptions options_;
  std::string found_;  // replicates to go on after, in words; empty where the run starts afresh
  FileLock lock_;      // on the file that was read or written last
  Clock::time_point written_ = Clock::now();
  Seconds pause_;  // between writes
  bool is_kept_ = true;
};

}  // namespace viewpeel::program
