// A CheckpointKeeper writes and reads the checkpoint of a run, for --checkpoint and --resume.
#pragma once
#include <chrono>
#include <string>

#include <CLI/CLI.hpp>

#include <viewpeel/compute.h>

#include "io/file_lock.h"

namespace viewpeel::program {

struct CheckpointOptions {
  std::string file;  // empty: there is no checkpoint
  bool resume = false;
  double seconds_apart = 10;
};

void addCheckpointOptions(CLI::App* command, CheckpointOptions& options);

// Refuses to overwrite an existing file by mistake.    Throws: Error bad_usage where the file exists or cannot be
// written.
void requireNewCheckpoint(const std::string& file);

// Keeps the checkpoint of one run up to date.
class CheckpointKeeper {
 public:
  // Lets the run continue from its checkpoint, if there is one. Call it before the run's plan.
  //   Throws: Error bad_usage where the file exists without --resume, belongs to another run, is in use by another run,
  //     or cannot be written; as FormFactorRun::resumeFrom.
  CheckpointKeeper(const CheckpointOptions& options, FormFactorRun& run);

  // Returns a line about the checkpoint that was found.
  std::string describe() const;

  // Writes the checkpoint if enough time has passed since the last one, or if `last`. A failure is only a warning, for
  // the run is worth more than its checkpoint. A file that another run has put in its place is left alone.
  void keep(const FormFactorRun& run, bool last);
  // Returns whether the last attempt to write succeeded.
  bool isKept() const { return is_kept_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  CheckpointOptions options_;
  std::string found_;  // replicates that the file has, as text; empty where the run starts afresh
  FileLock lock_;      // of the file that was read or written last
  Clock::time_point written_ = Clock::now();
  Seconds pause_;  // between writes
  bool is_kept_ = true;
};

}  // namespace viewpeel::program
