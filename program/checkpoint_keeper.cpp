#include "program/checkpoint_keeper.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "program/options.h"
#include "program/warnings.h"
#include <viewpeel/error.h>
#include "io/checkpoint.h"
#include "io/write_file.h"
#include "sums/run_sums.h"

namespace viewpeel::program {
namespace {

bool isReadable(const std::string& file) { return ::access(file.c_str(), R_OK) == 0; }

// The pause after a write is at least 20 times as long as the write took, so that writing takes at most 5 % of a run.
constexpr int kRunPerWrite = 20;

}  // namespace

void addCheckpointOptions(CLI::App* command, CheckpointOptions& options) {
  CLI::Option* file = command
                          ->add_option("--checkpoint", options.file,
                                       "Keep what was counted in this file, to go on with --resume or to merge")
                          ->type_name("FILE");
  command->add_flag("--resume", options.resume, "Go on from the checkpoint's file; start afresh where there is none")
      ->needs(file);
  command
      ->add_option("--checkpoint-seconds", options.seconds_apart,
                   "Least time between two writes of the checkpoint, which take 5 % of the time at most")
      ->type_name("S")
      ->check([](const std::string& text) { return isNumber(text, 0, 1e9); })
      ->needs(file)
      ->capture_default_str();
}

void requireNewCheckpoint(const std::string& file) {
  if (std::filesystem::exists(file) && !std::filesystem::is_directory(file))
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("{}: there is a checkpoint already; go on from it with --resume, or remove it first", file));
  checkWritable(file);
}

CheckpointKeeper::CheckpointKeeper(const CheckpointOptions& options, FormFactorRun& run)
    : options_(options), pause_(options.seconds_apart) {
  run.settings();  // refuses runs that a checkpoint cannot hold
  if (!options_.resume || !std::filesystem::exists(options_.file)) {
    requireNewCheckpoint(options_.file);
    return;
  }
  if (!std::filesystem::is_directory(options_.file) && !lock_.take(options_.file) && isReadable(options_.file))
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: another run is keeping its checkpoint there; wait for its end, or take another file",
                            options_.file));
  found_ = run.resumeFrom(options_.file);
  checkWritable(options_.file);
}

std::string CheckpointKeeper::describe() const {
  const std::string what = !found_.empty()   ? fmt::format("goes on after replicates {}", found_)
                           : options_.resume ? "not there yet, starts afresh"
                                             : "new";
  return fmt::format("checkpoint {}: {}\n", options_.file, what);
}

void CheckpointKeeper::keep(const FormFactorRun& run, bool last) {
  const auto start = Clock::now();
  if (run.replicateCount() == 0 || !run.sums().isWhole() || (!last && start - written_ < pause_)) return;
  try {
    if (std::filesystem::exists(options_.file) && !lock_.isOn(options_.file))
      throw Error(ErrorCode::output,
                  fmt::format("{}: another run has put its own there; this one is not kept", options_.file));
    writeCheckpoint(run.settings(), run.sums(), options_.file, &lock_);
    is_kept_ = true;
  } catch (const std::exception& error) {
    if (is_kept_ || last) warn(fmt::format("checkpoint: {}", error.what()));
    is_kept_ = false;
  }
  written_ = Clock::now();
  pause_ = std::max(Seconds(options_.seconds_apart), kRunPerWrite * Seconds(written_ - start));
}

}  // namespace viewpeel::program
