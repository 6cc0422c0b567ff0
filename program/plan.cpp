#include <optional>

#include <fmt/format.h>

#include <viewpeel/compute.h>

#include "program/checkpoint_keeper.h"
#include "program/commands.h"
#include "program/compute_options.h"
#include "program/describe_run.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/summary.h"
#include "run/summaries.h"
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

// Makes and prints the plan of a run, without counting.
int runPlan(const ComputeOptions& options) {
  if (options.only_environment)
    throw Error(ErrorCode::bad_usage, "--only environment has no plan; viewpeel compute measures it in seconds");
  if (options.row_blocks)
    throw Error(ErrorCode::bad_usage, "--row-blocks has no plan of its own; viewpeel compute plans as it runs");
  checkFiles(options);
  const Scene scene = loadSceneOf(options.scene, options.request.scene_options, options.groups);
  checkScene(options, scene);
  FormFactorRun run(scene, options.request);
  if (options.talks()) fmt::print("{}", describePlace(run, scene));
  std::fflush(stdout);
  warnOfBacksOf(options, scene);
  std::optional<CheckpointKeeper> keeper;
  if (options.keepsCheckpoint()) keeper.emplace(options.checkpoint, run);
  const PlanSummary& plan = run.makePlan();
  if (options.talks())
    fmt::print("{}{}{}", describePlan(run), describeAlternatives(plan), keeper ? keeper->describe() : "");
  const double seconds = run.measureSeconds();
  run.checkDevice();
  if (options.json) {
    Json report = startReport();
    addScene(report, scene);
    report["plan"] = jsonOf(plan);
    report["plan"]["expected_seconds"] = seconds;
    report["division"] = run.division();
    report["files"] = jsonOf(options.files);
    printReport(std::move(report));
    return 0;
  }
  if (!options.talks()) return 0;
  if (!plan.guarantee && !(plan.pilot_seconds > 0))
    fmt::print("expected   {} in all: {} for the plan, {} to count\n", inWords(plan.plan_seconds + seconds),
               inWords(plan.plan_seconds), inWords(seconds));
  fmt::print("{}", run.division());
  return 0;
}

}  // namespace

void addPlan(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand(
      "plan", "Say what `compute` would do with the same options, how long it would take and in how much memory");
  const auto settle = addComputeOptions(command);
  command->callback([=, &chosen] { chosen = [options = settle()] { return runPlan(*options); }; });
}

}  // namespace viewpeel::program
