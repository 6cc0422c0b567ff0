// What --checkpoint and --resume do.
#pragma once
#include <chrono>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "io/checkpoint.h"
#include "io/file_lock.h"

namespace viewpeel::program {

struct CheckpointOptions {
  std::string file;  // empty: none is kept
  bool resume = false;
  double seconds_apart = 10;
};

void addCheckpointOptions(CLI::App* command, CheckpointOptions& options);

// That nothing is written over by mistake.    Throws: Error bad_usage where there is such a file, or none can be written.
void requireNewCheckpoint(const std::string& file);

// Keeps the checkpoint of one run up to date.
class CheckpointKeeper {
 public:
  // Reads what there is to go on with.
  //   In: asked: what is known of the run before it is planned
  //   Throws: Error bad_usage where there is a file and nobody said to resume, it is of another run, another run is keeping it, or none can be written;
  //     as readCheckpoint.
  CheckpointKeeper(const CheckpointOptions& options, const Settings& asked, uint64_t first_replicate);

  // Of the checkpoint to go on with, its plan's included; none where the run starts afresh.
  const Settings& found() const { return found_; }
  // All that decides about counts, once the run is planned.    Throws: Error bad_usage where the checkpoint is of another run.
  void setSettings(Settings settings);

  // nullptr where the run starts afresh.
  const RunSums* resumed() const { return resumed_ ? &*resumed_ : nullptr; }
  // One line: what was found.
  std::string describe() const;

  // Writes where the last time is long enough ago, or `last`. A failure is a warning: the run is worth more than its checkpoint. What another run has put there
  // is left alone.
  void keep(const RunSums& sums, bool last);
  // False where the last attempt failed.
  bool isKept() const { return is_kept_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  CheckpointOptions options_;
  Settings settings_, found_;
  std::optional<RunSums> resumed_;
  FileLock lock_;  // on the file that was read or written last
  Clock::time_point written_ = Clock::now();
  Seconds pause_;  // between writes
  bool is_kept_ = true;
};

}  // namespace viewpeel::program
