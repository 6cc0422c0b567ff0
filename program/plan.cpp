#include <fmt/format.h>

#include <viewpeel/compute.h>

#include "program/commands.h"
#include "program/describe_run.h"
#include "program/option_table.h"
#include "program/options.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/summary.h"
#include "run/summaries.h"

namespace viewpeel::program {
namespace {

// Does everything but the run.
int runPlan(const std::string& scene_file, const Request& request, bool as_json) {
  const Scene scene = loadSceneOf(scene_file, request.scene_options);
  FormFactorRun run(scene, request);
  if (!as_json) fmt::print("{}", describePlace(run, scene));
  std::fflush(stdout);
  const PlanSummary& plan = run.makePlan();
  if (!as_json) fmt::print("{}", describePlan(run));
  const bool has_time = plan.guarantee || plan.line_guarantee || plan.pilot_seconds > 0;
  const double seconds = has_time ? plan.seconds : run.measureSeconds();
  run.checkDevice();
  if (as_json) {
    Json report = startReport();
    addScene(report, scene);
    report["plan"] = jsonOf(plan);
    if (!has_time) report["plan"]["expected_seconds"] = seconds;
    report["division"] = run.division();
    printReport(std::move(report));
    return 0;
  }
  if (!has_time)
    fmt::print("expected   {} for {}\n", inWords(seconds), counted(request.amount.replicates, "replicate"));
  fmt::print("{}", run.division());
  return 0;
}

}  // namespace

void addPlan(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand(
      "plan", "Say what `compute` would do with the same options, how long it would take and in how much memory");
  const auto options = addRequestOptions(command);
  const auto as_json = std::make_shared<bool>(false);
  startGroup(command, kOutput);
  command->add_flag("--json", *as_json, kJsonHelp);
  command->callback([=, &chosen] {
    chosen = [scene = options->scene, request = requestOf(command, *options), as_json] {
      return runPlan(scene, request, *as_json);
    };
  });
}

}  // namespace viewpeel::program
