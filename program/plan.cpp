#include <fmt/format.h>

#include <viewpeel/compute.h>

#include "program/commands.h"
#include "program/describe_run.h"
#include "program/request_options.h"
#include "program/summary.h"
#include "run/summaries.h"

namespace viewpeel::program {
namespace {

// Does everything but the run.
int runPlan(const std::string& scene_file, const Request& request) {
  const Scene scene = loadSceneOf(scene_file, request.scene_options);
  FormFactorRun run(scene, request);
  fmt::print("{}", describePlace(run, scene));
  std::fflush(stdout);
  const PlanSummary& plan = run.makePlan();
  fmt::print("{}", describePlan(run));
  if (!plan.guarantee && !plan.line_guarantee && !(plan.pilot_seconds > 0))
    fmt::print("expected   {} for {}\n", inWords(run.measureSeconds()),
               counted(request.amount.replicates, "replicate"));
  fmt::print("{}", run.division());
  run.checkDevice();
  return 0;
}

}  // namespace

void addPlan(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand(
      "plan", "Say what `compute` would do with the same options, how long it would take and in how much memory");
  const auto options = addRequestOptions(command);
  command->callback([=, &chosen] {
    chosen = [scene = options->scene, request = requestOf(command, *options)] { return runPlan(scene, request); };
  });
}

}  // namespace viewpeel::program
