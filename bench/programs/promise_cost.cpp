// This bench compares the predicted costs of promises and of estimates with measured ones. It prints CSV on stdout.
//   promise_cost FILE... [--tolerance T]...
//
// A row is a scene and a tolerance. Columns have CPU seconds of whole runs, measured and predicted, and the ratio of
// promise to estimate, measured and predicted. A measured run goes from the plan to the result; the program's start,
// --start seconds, is added to it, because the prediction has it too.
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "bench/support/measure.h"
#include "bench/support/run_time.h"
#include <viewpeel/compute.h>
#include <viewpeel/error.h>

namespace viewpeel::bench {
namespace {

struct Cost {
  double measured_s;
  PlanSummary plan;
};

Cost measure(const Scene& scene, double tolerance, bool is_promise) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.engine = EngineKind::host;
  request.promise = is_promise;
  std::optional<Result> result;
  const RunTime time = timeOf([&] { result = computeFormFactors(scene, request); });
  return {time.cpu_seconds, result->plan};
}

void compare(const std::string& file, double tolerance, double start_s) {
  const Scene scene = loadScene(file);
  const Cost promise = measure(scene, tolerance, true), estimate = measure(scene, tolerance, false);
  const double promise_s = promise.measured_s + start_s, estimate_s = estimate.measured_s + start_s;
  if (!promise.plan.line_guarantee)
    throw Error(ErrorCode::bad_usage, fmt::format("{}: a promise has no lines here", file));
  const LineGuaranteeFigures& predicted = *promise.plan.line_guarantee;
  fmt::print("{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f},{:.2f}\n", file, scene.polygons.size(), tolerance, promise_s,
             predicted.cost, estimate_s, predicted.estimate_cost, promise_s / estimate_s,
             predicted.cost / predicted.estimate_cost);
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  std::vector<std::string> files;
  std::vector<double> tolerances{1e-2, 1e-3};
  double start_s = 7e-3;
  CLI::App app("Costs of promises and estimates, measured and predicted: CSV on stdout");
  app.add_option("files", files)->required();
  app.add_option("--tolerance", tolerances)->check(CLI::PositiveNumber);
  app.add_option("--start", start_s, "of the program, s")->check(CLI::NonNegativeNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print("# commit {}; CPU seconds\n", bench::commitOf(VIEWPEEL_SOURCE));
    fmt::print("file,polygons,tolerance,promise,predicted,estimate,predicted,ratio,predicted\n");
    for (const std::string& file : files)
      for (const double tolerance : tolerances) bench::compare(file, tolerance, start_s);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
