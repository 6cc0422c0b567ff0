#include <memory>

#include <fmt/format.h>

#include "program/checkpoint_keeper.h"
#include "program/commands.h"
#include "program/options.h"
#include "program/outputs.h"
#include "program/result_json.h"
#include "program/stored_run.h"
#include "program/summary.h"
#include "io/checkpoint.h"

namespace viewpeel::program {
namespace {

struct MergeCommand {
  std::vector<std::string> inputs, outputs, shown;
  std::string checkpoint, scene, ccx_version = "2.20";
  bool quiet = false, json = false;
};

int runMerge(const MergeCommand& command) {
  checkOutputs(command.outputs, command.checkpoint, false, !command.scene.empty());
  if (command.scene.empty() && !command.shown.empty())
    throw Error(ErrorCode::bad_usage, "--show names surfaces of a scene; give it by --scene");
  if (!command.checkpoint.empty()) requireNewCheckpoint(command.checkpoint);
  std::vector<std::string> names = command.outputs;
  if (!command.checkpoint.empty()) names.insert(names.begin(), command.checkpoint);
  const std::vector<PlannedFile> files = planFiles(names);
  StoredRun run(command.inputs, command.scene);
  const Checkpoint& merged = run.merged();
  if (!command.outputs.empty()) run.requireErrors();
  const Scene* scene = run.scene();
  if (scene) {
    const By by = findSetting(merged.settings, "--by") == "surface" ? By::surface : By::polygon;
    checkShown(*scene, makeIds(*scene, by, findSetting(merged.settings, "--two-sided") == "yes"), command.shown);
  }
  if (!command.checkpoint.empty()) writeCheckpoint(merged.settings, merged.sums, command.checkpoint);
  const Estimate estimate = run.estimate();
  writeOutputs({estimate.form_factors, nullptr, scene, parametersOf(merged.settings, estimate), command.shown, nullptr,
                command.ccx_version},
               command.outputs);
  if (command.json) {
    Json report = startReport();
    addEstimate(report, estimate);
    report["settings"] = jsonOf(parametersOf(merged.settings, estimate));
    report["replicate_ranges"] = describeReplicates(merged.sums.replicates);
    report["files"] = jsonOf(files);
    printReport(std::move(report), estimate.form_factors);
  }
  if (command.quiet || command.json) return 0;
  for (const auto& [name, value] : merged.settings) fmt::print("{:<14} {}\n", name, value);
  fmt::print("{:<14} {}\n{}", "replicates", describeReplicates(merged.sums.replicates), describeResult(estimate));
  fmt::print("work       {} replicates, {} directions{}\n", estimate.replicates, estimate.directions,
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
  addOutputOptions(command, options->outputs, options->shown, options->ccx_version);
  command
      ->add_option(
          "--scene", options->scene,
          "The scene that was computed: for unoccluded form factors of pairs with few lines, which checkpoints "
          "of more than 2,896 polygons do not keep; for the polygons of .vtp, and of .h5")
      ->type_name("FILE");
  command
      ->add_option("--checkpoint", options->checkpoint,
                   "Write the sum as a checkpoint, to go on with or to merge again")
      ->type_name("FILE");
  CLI::Option* quiet = command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  command->add_flag("--json", options->json, kJsonHelp)->excludes(quiet);
  command->callback([options, &chosen] { chosen = [options] { return runMerge(*options); }; });
}

}  // namespace viewpeel::program
