#include <memory>

#include <fmt/format.h>

#include "program/checkpoint_keeper.h"
#include "program/commands.h"
#include "program/options.h"
#include "program/outputs.h"
#include "program/summary.h"
#include <viewpeel/error.h>
#include "estimator/face_exchanges.h"
#include "io/checkpoint.h"
#include "run/settings.h"

namespace viewpeel::program {
namespace {

struct MergeCommand {
  std::vector<std::string> inputs, outputs, shown;
  std::string checkpoint, scene, ccx_version = "2.20";
  bool quiet = false;
};

// A MergedScene makes unoccluded form factors of pairs that no checkpoint keeps.
struct MergedScene {
  Scene scene;
  Ids face_ids;
  FaceExchanges exchanges;

  MergedScene(const std::string& file, const SceneOptions& options, bool two_sided)
      : scene(loadScene(file, options)),
        face_ids(makeIds(scene, By::polygon, two_sided)),
        exchanges(nullptr, scene, face_ids) {}
};

int runMerge(const MergeCommand& command) {
  checkOutputs(command.outputs, command.checkpoint, false, !command.scene.empty());
  if (command.scene.empty() && !command.shown.empty())
    throw Error(ErrorCode::bad_usage, "--show names surfaces of a scene; give it by --scene");
  if (!command.checkpoint.empty()) requireNewCheckpoint(command.checkpoint);
  Checkpoint merged = mergeCheckpoints({command.inputs.begin(), command.inputs.end()});
  if (!command.outputs.empty() && merged.sums.replicateCount() < 2)
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: holds 1 replicate, a standard error needs 2; go on with it, or merge it with others",
                            command.inputs.front()));
  std::unique_ptr<MergedScene> of;
  if (!command.scene.empty()) {
    of = std::make_unique<MergedScene>(command.scene, sceneOptionsOf(merged.settings),
                                       findSetting(merged.settings, "--two-sided") == "yes");
    const std::string computed = findSetting(merged.settings, "scene").value_or("");
    if (identityOf(of->scene) != computed)
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: another scene than that of {}: {}, not {}; give the scene that was computed",
                              command.scene, command.inputs.front(), identityOf(of->scene), computed));
  }
  if (of)
    checkShown(of->scene,
               makeIds(of->scene, findSetting(merged.settings, "--by") == "surface" ? By::surface : By::polygon,
                       of->face_ids.two_sided),
               command.shown);
  const bool is_sparse = merged.sums.prior_sums && merged.sums.prior_sums->by() == By::polygon &&
                         !merged.sums.prior_sums->prior().has_all_pairs;
  if (is_sparse && !of)
    fmt::print(stderr,
               "viewpeel: warning: pairs with few lines are sampled alone, and those that no line met left "
               "out; for their unoccluded form factors give --scene FILE\n");
  if (is_sparse && of) of->exchanges.learn(merged.sums);
  if (!command.checkpoint.empty()) writeCheckpoint(merged.settings, merged.sums, command.checkpoint);
  const Estimate estimate = makeEstimate(merged.sums, EstimateOptions{}.relative_floor,
                                         is_sparse && of ? of->exchanges.rows() : ExchangeRow{});
  writeOutputs({estimate.form_factors, nullptr, of ? &of->scene : nullptr, parametersOf(merged.settings, estimate),
                command.shown, command.ccx_version},
               command.outputs);
  if (command.quiet) return 0;
  for (const auto& [name, value] : merged.settings) fmt::print("{:<14} {}\n", name, value);
  fmt::print("{:<14} {}\n{}", "replicates", describeReplicates(merged.sums.replicates), describeResult(estimate));
  fmt::print("work       {} replicates, {} directions{}\n", estimate.replicates, estimate.directions,
             describeDirected(estimate));
  if (!command.checkpoint.empty()) fmt::print("written    {}\n", command.checkpoint);
  for (const std::string& output : command.outputs) fmt::print("written    {}\n", output);
  return 0;
}

}  // namespace

void addMerge(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<MergeCommand>();
  CLI::App* command = app.add_subcommand(
      "merge", "Add up checkpoints of different replicates of one run; of one alone, show it and write its results");
  command->add_option("CHECKPOINT", options->inputs, "Files of --checkpoint, in any order")->required();
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
  command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  command->callback([options, &chosen] { chosen = [options] { return runMerge(*options); }; });
}

}  // namespace viewpeel::program
