#include "program/checkpoint_keeper.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>
#include <unistd.h>

#include "program/options.h"
#include "error.h"
#include "io/write_file.h"

namespace viewpeel::program {
namespace {

bool isReadable(const std::string& file) { return ::access(file.c_str(), R_OK) == 0; }

constexpr std::array<std::string_view, 6> kPlanned = {"--closed-forms", "--directions", "--resolution", "--finest", "--range", "--block"};  // settings that a plan may choose
constexpr int kRunPerWrite = 20;  // times as long as writing took, at least, passes to the next: writing takes no more than 5 %

}  // namespace

void addCheckpointOptions(CLI::App* command, CheckpointOptions& options) {
  CLI::Option* file = command->add_option("--checkpoint", options.file, "Keep what was counted in this file, to go on with --resume or to merge")->type_name("FILE");
  command->add_flag("--resume", options.resume, "Go on from the checkpoint's file; start afresh where there is none")->needs(file);
  command->add_option("--checkpoint-seconds", options.seconds_apart, "Least time between two writes of the checkpoint, which take 5 % of the time at most")
      ->type_name("S")->check([](const std::string& text) { return isNumber(text, 0, 1e9); })->needs(file)->capture_default_str();
}

void requireNewCheckpoint(const std::string& file) {
  if (std::filesystem::exists(file) && !std::filesystem::is_directory(file))
    throw Error(ErrorCode::bad_usage, fmt::format("{}: there is a checkpoint already; go on from it with --resume, or remove it first", file));
  checkWritable(file);
}

CheckpointKeeper::CheckpointKeeper(const CheckpointOptions& options, const Settings& asked, uint64_t first_replicate)
    : options_(options), pause_(options.seconds_apart) {
  if (!options_.resume || !std::filesystem::exists(options_.file)) {
    requireNewCheckpoint(options_.file);
    return;
  }
  if (!std::filesystem::is_directory(options_.file) && !lock_.take(options_.file) && isReadable(options_.file))
    throw Error(ErrorCode::bad_usage, fmt::format("{}: another run is keeping its checkpoint there; wait for its end, or take another file", options_.file));
  Checkpoint found = readCheckpoint(options_.file);
  Settings unplanned = found.settings;
  std::erase_if(unplanned, [](const auto& setting) { return std::ranges::find(kPlanned, setting.first) != kPlanned.end(); });
  requireSameSettings(asked, unplanned, options_.file);
  const ReplicateRange expected{first_replicate, first_replicate + found.sums.replicateCount()};
  if (found.sums.replicates != std::vector{expected})
    throw Error(ErrorCode::bad_usage, fmt::format("{}: holds replicates {}, not all from --first-replicate {} on; merge it with those that are missing",
                                                  options_.file, describeReplicates(found.sums.replicates), first_replicate));
  checkWritable(options_.file);
  resumed_ = std::move(found.sums);
  found_ = std::move(found.settings);
}

void CheckpointKeeper::setSettings(Settings settings) {
  if (resumed_) requireSameSettings(settings, found_, options_.file);
  settings_ = std::move(settings);
}

std::string CheckpointKeeper::describe() const {
  const std::string what = resumed_ ? fmt::format("goes on after replicates {}", describeReplicates(resumed_->replicates))
                                    : options_.resume ? "not there yet, starts afresh" : "new";
  return fmt::format("checkpoint {}: {}\n", options_.file, what);
}

void CheckpointKeeper::keep(const RunSums& sums, bool last) {
  const auto start = Clock::now();
  if (sums.replicates.empty() || !sums.isWhole() || (!last && start - written_ < pause_)) return;
  try {
    if (std::filesystem::exists(options_.file) && !lock_.isOn(options_.file))
      throw Error(ErrorCode::output, fmt::format("{}: another run has put its own there; this one is not kept", options_.file));
    writeCheckpoint(settings_, sums, options_.file);
    lock_.take(options_.file);
    is_kept_ = true;
  } catch (const std::exception& error) {
    if (is_kept_ || last) fmt::print(stderr, "viewpeel: warning: checkpoint: {}\n", error.what());
    is_kept_ = false;
  }
  written_ = Clock::now();
  pause_ = std::max(Seconds(options_.seconds_apart), kRunPerWrite * Seconds(written_ - start));
}

}  // namespace viewpeel::program
