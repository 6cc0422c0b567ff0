#include "program/only_environment.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include <fmt/format.h>

#include "program/command_line.h"
#include "program/commands.h"
#include "program/interrupts.h"
#include "program/progress_line.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/summary.h"
#include "program/warnings.h"
#include "stopwatch.h"
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

constexpr size_t kMostRows = 20;
// This tolerance stands for none: a run with only a time limit must go on until time is up.
constexpr double kNoTolerance = 1e-300;
// Sky and ground are split to the standard error that the form factors reached, but not below this one. Where form
// factors are exact, their standard error of 0 would otherwise ask for directions without end.
constexpr double kLeastTolerance = 1e-4;

std::string describeRows(const EnvironmentParts& parts, bool has_up) {
  const Ids& ids = parts.ids;
  std::vector<uint32_t> order(ids.count());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, std::greater(), [&](uint32_t id) { return parts.all[id].value; });
  order.resize(std::min(order.size(), kMostRows));
  size_t width = 4;
  for (const uint32_t id : order) width = std::max(width, ids.names[id].size());
  std::string text = fmt::format("largest form factors to the environment\n  {:<{}}  form factor  standard error{}\n",
                                 "from", width, has_up ? "        up      down" : "");
  for (const uint32_t id : order) {
    text += fmt::format("  {:<{}}  {:11.6f}  {:14.1e}", ids.names[id], width, parts.all[id].value,
                        parts.all[id].standard_error);
    if (has_up) text += fmt::format("  {:8.6f}  {:8.6f}", parts.up[id].value, parts.down[id].value);
    text += "\n";
  }
  return text + fmt::format("errors     largest standard error of all rows {:.1e}\n", parts.largest_standard_error);
}

EnvironmentRequest environmentRequestOf(const ComputeOptions& options) {
  const Request& request = options.request;
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  EnvironmentRequest environment{.by = request.by, .two_sided = request.two_sided};
  if (options.up) environment.up = *options.up;
  environment.tolerance = tolerance ? tolerance->standard_error : kNoTolerance;
  environment.seed = request.seed;
  environment.time_limit_s = request.time_limit_s;
  return environment;
}

void printJson(const ComputeOptions& options, const EnvironmentParts& parts, const OutputContent& content,
               bool is_reached, double seconds) {
  Json report = startReport();
  addScene(report, *content.scene);
  report["largest_standard_error"] = parts.largest_standard_error;
  report["replicates"] = parts.replicates;
  report["directions"] = parts.directions;
  report["seconds"] = seconds;
  report["goal_reached"] = is_reached;
  report["files"] = jsonOf(options.files);
  report["status"] = is_reached ? 0 : kGoalMissed;
  printReport(std::move(report), content);
}

}  // namespace

void checkOnlyEnvironment(const CLI::App* command, const ComputeOptions& options) {
  for (const char* name : {"--from",       "--pair",       "--blocker",    "--relative",   "--epsilon",
                           "--directions", "--replicates", "--resolution", "--finest",     "--sampling",
                           "--sampler",    "--unoccluded", "--pair-lines", "--promise",    "--engine",
                           "--device",     "--batch",      "--part",       "--checkpoint", "--resume",
                           "--balance",    "--closure",    "--drop-below", "--show",       "--first-replicate",
                           "--verbose"})
    if (command->get_option(name)->count())
      throw Error(ErrorCode::bad_usage, fmt::format("{} is of a matrix; leave it out with --only environment", name));
  for (const std::string& output : options.output.files) checkEnvironmentOutput(output);
  if (options.output.to_stdout) checkEnvironmentOutput("output." + options.output.format);
}

int computeOnlyEnvironment(const ComputeOptions& options) {
  checkFiles(options);
  ProgressLine progress(options.request, !options.quiet);
  progress.begin("reading " + options.scene);
  const Scene scene = loadSceneOf(options.scene, options.request.scene_options, options.groups);
  progress.clear();
  if (options.talks()) fmt::print("{}{}", describeProcessor(), describeScene(scene));
  std::fflush(stdout);
  warnOfBacksOf(options, scene);
  const EnvironmentRequest request = environmentRequestOf(options);
  const auto start = Clock::now();
  const EnvironmentParts parts = measureEnvironment(scene, request, {.on_progress = progress.listener()});
  const double seconds = secondsSince(start);
  progress.clear();
  const bool is_reached = parts.is_reached || request.tolerance == kNoTolerance;
  const FormFactors alone = environmentAlone(parts);
  OutputContent content{.form_factors = alone,
                        .scene = &scene,
                        .parameters = {{"version", VIEWPEEL_VERSION},
                                       {"by", request.by == By::surface ? "surface" : "polygon"},
                                       {"two-sided", request.two_sided ? "yes" : "no"},
                                       {"seed", std::to_string(request.seed)},
                                       {"replicates", std::to_string(parts.replicates)},
                                       {"all_directions", std::to_string(parts.directions)},
                                       {"largest_standard_error", fmt::format("{}", parts.largest_standard_error)}},
                        .parts = options.up ? &parts : nullptr,
                        .has_environment_alone = true};
  addOrigin(options.request, content.parameters);
  writeOutputs(content, options.output, !options.quiet && !options.json, "");
  if (!is_reached)
    complain(
        fmt::format("the goal was not reached: largest standard error {:.1e}; give more --seconds, or a coarser "
                    "--tolerance",
                    parts.largest_standard_error));
  if (options.json) printJson(options, parts, content, is_reached, seconds);
  if (options.talks())
    fmt::print("{}{}work       {}, {}, {:.2f} s\n{}", describeRows(parts, options.up.has_value()),
               options.up ? describeParts(parts) : "", counted(parts.replicates, "replicate"),
               counted(parts.directions, "direction"), seconds, describeWritten(options.files));
  return is_reached ? 0 : kGoalMissed;
}

std::optional<EnvironmentParts> splitEnvironmentOf(const ComputeOptions& options, const Scene& scene,
                                                   const Result& result, const Observer& observer) {
  if (!options.up) return std::nullopt;
  EnvironmentRequest request = environmentRequestOf(options);
  const auto* guarantee = std::get_if<EpsilonDelta>(&options.request.goal);
  if (guarantee) request.tolerance = guarantee->epsilon;
  else if (request.tolerance == kNoTolerance)
    request.tolerance = std::max(result.largest_standard_error, kLeastTolerance);
  EnvironmentParts parts = measureEnvironment(scene, request, observer);
  if (!parts.is_reached)
    warn(
        fmt::format("sky and ground are apart to a standard error of {:.1e} alone; give more --seconds, or a coarser "
                    "goal",
                    parts.largest_standard_error));
  return splitEnvironment(result.form_factors, std::move(parts));
}

std::string describeParts(const EnvironmentParts& parts) {
  double area = 0, up = 0, down = 0;
  for (uint32_t id = 0; id < parts.ids.count(); ++id) {
    area += parts.ids.areas[id];
    up += parts.ids.areas[id] * parts.up[id].value;
    down += parts.ids.areas[id] * parts.down[id].value;
  }
  return fmt::format("horizon    {:.4g} % of all emitted radiation leaves the scene upwards, {:.4g} % downwards\n",
                     100 * up / area, 100 * down / area);
}

}  // namespace viewpeel::program
