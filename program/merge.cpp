#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "program/checkpoint_keeper.h"
#include "program/commands.h"
#include "program/options.h"
#include "program/outputs.h"
#include "program/result_json.h"
#include "program/stored_run.h"
#include "program/summary.h"
#include "estimator/find_guesses.h"
#include "io/checkpoint.h"
#include "io/file_lock.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

struct MergeCommand {
  std::vector<std::string> inputs;
  OutputOptions output;
  std::vector<std::string> scene;  // its files
  std::string checkpoint, groups;
  bool resume = false, quiet = false, json = false;

  bool talks() const { return !quiet && !json && !output.to_stdout; }
};

// Adds an existing checkpoint of the output's name to the files that are merged, and locks it.
void addExisting(MergeCommand& command, FileLock& lock) {
  if (!std::filesystem::exists(command.checkpoint)) return;
  if (!lock.take(command.checkpoint))
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: a run is keeping its checkpoint there; wait for its end, or take another file",
                            command.checkpoint));
  command.inputs.push_back(command.checkpoint);
}

void checkCommand(const MergeCommand& command) {
  checkOutputs(command.output.files, command.checkpoint, false, !command.scene.empty());
  if (command.json && command.output.to_stdout)
    throw Error(ErrorCode::bad_usage, "--json and -o - both print on standard output; leave out one of them");
  if (command.scene.empty() && !command.output.shown.empty())
    throw Error(ErrorCode::bad_usage, "--show names surfaces of a scene; give it by --scene");
  if (command.scene.empty() && !command.groups.empty())
    throw Error(ErrorCode::bad_usage, "--groups names the faces of a scene; give it by --scene");
  if (!command.checkpoint.empty() && !command.resume) requireNewCheckpoint(command.checkpoint);
}

int runMerge(MergeCommand command) {
  checkCommand(command);
  std::vector<std::string> names = command.output.files;
  if (!command.checkpoint.empty()) names.insert(names.begin(), command.checkpoint);
  const std::vector<PlannedFile> files = planFiles(names);
  FileLock lock;
  if (command.resume) addExisting(command, lock);
  StoredRun run(command.inputs, command.scene, command.groups);
  const Checkpoint& merged = run.merged();
  if (!command.output.files.empty() || command.output.to_stdout) run.requireErrors();
  const Scene* scene = run.scene();
  if (scene) {
    const By by = findSetting(merged.settings, "--by") == "surface" ? By::surface : By::polygon;
    checkShown(*scene, makeIds(*scene, by, findSetting(merged.settings, "--two-sided") == "yes"), command.output.shown);
  }
  if (!command.checkpoint.empty()) writeCheckpoint(merged.settings, merged.sums, command.checkpoint, &lock);
  const Estimate estimate = run.estimate();
  const std::vector<std::pair<uint32_t, uint32_t>> guesses = findGuesses(merged.sums, estimate.form_factors);
  std::optional<DroppedBelow> below;
  if (command.output.drop_below > 0) below = dropBelow(estimate.form_factors, command.output.drop_below);
  const OutputContent content{.form_factors = below ? below->kept : estimate.form_factors,
                              .scene = scene,
                              .parameters = parametersOf(merged.settings, estimate),
                              .shown = command.output.shown,
                              .ccx_version = command.output.ccx_version,
                              .guesses = &guesses,
                              .dropped = below ? &below->dropped : nullptr};
  writeOutputs(content, command.output, !command.quiet && !command.json, "");
  if (command.json) {
    Json report = startReport();
    addEstimate(report, estimate);
    report["settings"] = jsonOf(parametersOf(merged.settings, estimate));
    report["replicate_ranges"] = describeReplicates(merged.sums.replicates);
    report["files"] = jsonOf(files);
    printReport(std::move(report), content);
  }
  if (!command.talks()) return 0;
  for (const auto& [name, value] : merged.settings) fmt::print("{:<14} {}\n", name, value);
  fmt::print("{:<14} {}\n{}", "replicates", describeReplicates(merged.sums.replicates), describeResult(estimate));
  if (below) fmt::print("{}", describeDropped(estimate.form_factors.ids(), below->dropped));
  fmt::print("work       {} replicates, {}{}\n", estimate.replicates,
             describeDirections(estimate, findSetting(merged.settings, "--rays").has_value()),
             describeDirected(estimate));
  fmt::print("{}", describeWritten(files));
  return 0;
}

}  // namespace

void addMerge(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<MergeCommand>();
  CLI::App* command = app.add_subcommand(
      "merge", "Add up checkpoints of different replicates of one run; of one alone, show it and write its results");
  command->add_option("CHECKPOINT", options->inputs, "Files of --checkpoint, in any order")->required();
  startGroup(command, kOutput);
  addOutputOptions(command, options->output);
  command
      ->add_option(
          "--scene", options->scene,
          "The scene that was computed: for unoccluded form factors of pairs with few lines, which checkpoints "
          "of more than 2,896 polygons do not keep; for the polygons of .vtp, and of .h5. Once for each of its files, "
          "in the order in which they were computed")
      ->type_name("FILE")
      ->allow_extra_args(false);
  addGroupsOption(command, options->groups);
  command
      ->add_option("--checkpoint", options->checkpoint,
                   "Write the sum as a checkpoint, to go on with or to merge again")
      ->type_name("FILE");
  command
      ->add_flag("--resume", options->resume,
                 "Add to what the file of --checkpoint holds; write it where there is none")
      ->needs(command->get_option("--checkpoint"));
  CLI::Option* quiet = command->add_flag("-q,--quiet", options->quiet, "Print nothing but errors");
  command->add_flag("--json", options->json, kJsonHelp)->excludes(quiet);
  command->callback([options, command, &chosen] {
    settleOutputs(command, options->output);
    chosen = [options] { return runMerge(*options); };
  });
}

}  // namespace viewpeel::program
