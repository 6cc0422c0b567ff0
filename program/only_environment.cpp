#include "program/only_environment.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include <fmt/format.h>

#include "estimator/environment_rays.h"
#include "program/command_line.h"
#include "program/commands.h"
#include "program/interrupts.h"
#include "program/progress_line.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/summary.h"
#include "program/warnings.h"
#include "run/rules.h"
#include "stopwatch.h"
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

constexpr size_t kMostEnvironmentRows = 20;
// All pairs of n polygons take about the time of this many expected rays, or quick rays, times n^2. In cities of 1,000
// to 6,400 triangles a tenth of them see each other, each of which takes as long as seven rays that are not quick. At
// 1e-3 they took as long as 10, 5.7 and 5.2 n^2 quick rays in cities of 1,016, 2,892 and 3,996 triangles.
constexpr double kRaysOfPairs = 0.4, kQuickRaysOfPairs = 5;
// This tolerance stands for none: a run with only a time limit must go on until time is up.
constexpr double kNoTolerance = 1e-300;
// Sky and ground are split to the standard error that the form factors reached, but not below this one. Where form
// factors are exact, their standard error of 0 would otherwise ask for directions without end.
constexpr double kLeastSpread = 1e-4;

std::string describeRows(const EnvironmentParts& parts, bool has_up) {
  const Ids& ids = parts.ids;
  std::vector<uint32_t> order(ids.count());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, std::greater(), [&](uint32_t id) { return parts.all[id].value; });
  order.resize(std::min(order.size(), kMostEnvironmentRows));
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

// Returns the form factors of all rows to the environment; 0 where no row was asked for.
std::vector<double> environmentOf(const FormFactors& form_factors) {
  std::vector<double> all;
  for (uint32_t row = 0; row < form_factors.ids().count(); ++row)
    all.push_back(form_factors.ids().isRequested(row) ? form_factors.formFactor(row, kEnvironment).value : 0);
  return all;
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

// A Measurement is the environment of all rows, and what was done for it, as text.
struct Measurement {
  EnvironmentParts parts;
  std::string work;
};

std::string describeWork(const EnvironmentParts& parts) {
  return fmt::format("{}, {}{}", counted(parts.replicates, "replicate"), counted(parts.directions, "direction"),
                     parts.rays ? fmt::format(", {} from {} of their own", counted(parts.rays, "ray"),
                                              counted(parts.rows_with_rays, "row"))
                                : "");
}

// Measures the environment by directions and rays. Where rays are more work than the lines of all pairs, the pairs give
// it: a row's environment is 1 less its pairs, most of which nothing blocks. Sky and ground then need rays for their
// shares.
Measurement measure(const ComputeOptions& options, const Scene& scene, EnvironmentRequest request,
                    const Observer& observer) {
  const auto polygons = double(scene.polygons.size());
  // Beyond kMostPairLineFaces a plan by pairs may take long, and then be one by directions.
  if (std::holds_alternative<Tolerance>(options.request.goal) && scene.faces.size() <= kMostPairLineFaces)
    request.most_rays =
        (hasQuickRays(scene, request.tolerance) ? kQuickRaysOfPairs : kRaysOfPairs) * polygons * polygons;
  EnvironmentParts parts = measureEnvironment(scene, request, observer);
  if (parts.is_reached || !request.most_rays) return {parts, describeWork(parts)};
  request.most_rays.reset();
  Request by_pairs = options.request;
  by_pairs.promise = false;  // the environment's standard errors are asked for, no intervals
  by_pairs.lines_for_all = true;
  FormFactorRun run(scene, by_pairs, observer);
  const PlanSummary& plan = run.makePlan();
  if (!plan.pair_lines || plan.pair_lines->least_form_factor > 0) {
    parts = measureEnvironment(scene, request, observer);
    return {parts, describeWork(parts)};
  }
  while (!run.isDone()) run.step();
  const Result result = run.result();
  request.whole_environment = environmentOf(result.form_factors);
  if (options.up) parts = measureEnvironment(scene, request, observer);
  const bool is_reached = result.goal_reached && (!options.up || parts.is_reached);
  parts = splitEnvironment(result.form_factors, std::move(parts));
  parts.is_reached = is_reached;
  if (!options.up) {
    parts.largest_standard_error = 0;
    for (const Measured& all : parts.all)
      parts.largest_standard_error = std::max(parts.largest_standard_error, all.standard_error);
  }
  return {parts, fmt::format("{}; lines of {} of polygons, {}", describeWork(parts),
                             counted(plan.pair_lines->clear + plan.pair_lines->partial, "pair"),
                             counted(result.replicates, "replicate"))};
}

void printJson(const ComputeOptions& options, const EnvironmentParts& parts, const OutputContent& content,
               bool is_reached, double seconds) {
  Json report = startReport();
  addScene(report, *content.scene);
  report["largest_standard_error"] = parts.largest_standard_error;
  report["replicates"] = parts.replicates;
  report["directions"] = parts.directions;
  report["rays"] = parts.rays;
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
  progress.begin(fmt::format("reading {}", fmt::join(options.scene, ", ")));
  const Scene scene = loadSceneOf(options.scene, options.request.scene_options, options.groups);
  progress.clear();
  if (options.talks()) fmt::print("{}{}", describeProcessor(), describeScene(scene));
  std::fflush(stdout);
  warnOfBacksOf(options, scene);
  const EnvironmentRequest request = environmentRequestOf(options);
  const auto start = Clock::now();
  const Measurement measured = measure(options, scene, request, {.on_progress = progress.listener()});
  const EnvironmentParts& parts = measured.parts;
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
    fmt::print("{}{}work       {}, {:.2f} s\n{}", describeRows(parts, options.up.has_value()),
               options.up ? describeParts(parts) : "", measured.work, seconds, describeWritten(options.files));
  return is_reached ? 0 : kGoalMissed;
}

std::optional<EnvironmentParts> splitEnvironmentOf(const ComputeOptions& options, const Scene& scene,
                                                   const Result& result, const Observer& observer) {
  if (!options.up) return std::nullopt;
  EnvironmentRequest request = environmentRequestOf(options);
  const auto* guarantee = std::get_if<EpsilonDelta>(&options.request.goal);
  if (guarantee) request.tolerance = guarantee->epsilon;
  else if (request.tolerance == kNoTolerance) request.tolerance = std::max(result.largest_standard_error, kLeastSpread);
  request.whole_environment = environmentOf(result.form_factors);
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
