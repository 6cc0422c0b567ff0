// This bench compares the planned method of `--tolerance T` with methods chosen by hand, in CPU time to the same goal.
// It prints CSV on stdout.
//   plan_grid [--scene NAME]... [--tolerance T]... [--seeds K]
//
// Scenes and their truths are those of support/truth.h; a truth is a run at a fifth of the least tolerance. By hand, a
// scene is computed with lines for all pairs, with mixtures (estimator/line_mixture.h) of several least form factors,
// and along common directions alone, with several numbers of directions and several lattices. In a mixture
// common directions count the pairs without lines. In open scenes there are mixtures with rays in their place, too. A
// method by hand counts where its largest true error is at most T for every seed. So common directions stop at their
// true error, which no plan knows. Lines and mixtures stop as planned runs do.
// The columns `planned` and `by_hand` have medians of CPU seconds over the seeds, of all threads, from the scene in
// memory to the form factors, the plan's own cost included. The columns after them have the largest true errors of all
// seeds, of form factors and of row sums. `ratio` is the planned time over the time by hand; below 1 no method by hand
// is as fast.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "bench/support/measure.h"
#include "bench/support/run_time.h"
#include "bench/support/truth.h"
#include "estimator/line_run.h"
#include "estimator/plan_rays.h"
#include "rays/ray_engine.h"
#include "run/setup.h"

namespace viewpeel::bench {
namespace {

struct Options {
  std::vector<std::string> scenes{"touching", "street",   "office",   "room",
                                  "city1000", "room2496", "city2900", "office9280"};
  std::vector<double> tolerances{3e-2, 1e-2, 3e-3, 1e-3};
  uint32_t seeds = 3;
};

// A Job is the scene and goal that all methods are compared for.
struct Job {
  const std::string& name;
  const Scene& scene;
  const FormFactors& truth;
  double tolerance;
  bool is_open;  // whether rows see an environment
  uint32_t seeds;
};

struct Outcome {
  std::string method;
  double cpu_seconds = INFINITY;  // median over seeds
  double largest_error = INFINITY, largest_of_sums = INFINITY;
  bool reaches = false;  // whether the largest error is within the goal
};

// A Method computes the form factors for one seed. It may give up, and return nothing, after `most_seconds` of CPU
// time.
using Method = std::function<std::optional<FormFactors>(const Job&, uint64_t seed, double most_seconds)>;

// Runs a method for all seeds, or until one misses the goal.
Outcome measure(const Job& job, const std::string& name, const Method& method, double most_seconds = INFINITY) {
  std::vector<double> seconds;
  Outcome outcome{name, 0, 0, 0, true};
  for (uint64_t seed = 1; seed <= job.seeds && outcome.reaches; ++seed) {
    std::optional<FormFactors> found;
    seconds.push_back(timeOf([&] { found = method(job, seed, most_seconds); }).cpu_seconds);
    if (!found) return {name};
    const Comparison comparison = compare(*found, job.truth);
    outcome.largest_error = std::max(outcome.largest_error, comparison.largest);
    outcome.largest_of_sums = std::max(outcome.largest_of_sums, comparison.largest_of_sums);
    outcome.reaches = outcome.largest_error <= job.tolerance;
  }
  outcome.cpu_seconds = median(seconds);
  return outcome;
}

// Runs the lines of pairs whose unoccluded form factor is at least that of the mixture, while the engine counts the
// other pairs. Returns nothing if it gives up.    In: give_up_at: CPU seconds of this process
std::optional<FormFactors> runLines(const Job& job, const Setup& setup, uint64_t seed, Engine& engine,
                                    const LineMixture& mixture, RayEngine* rays, double give_up_at) {
  EstimateOptions options = setup.estimate();
  options.directions = mixture.directions;
  options.rays = rays;
  PairLines lines(job.scene, setup.faceIds(), {}, seed);
  std::vector<LinePair> pairs = planLines(lines, lines.find(mixture.least_form_factor), setup.faceIds(), setup.ids(),
                                          options, job.is_open, INFINITY);
  LineRun run(engine, job.scene, setup.faceIds(), lines, std::move(pairs), mixture.least_form_factor, options);
  while (!run.isDone()) {
    if (cpuSecondsOf(RUSAGE_SELF) > give_up_at) return {};
    run.step();
  }
  return run.estimate().form_factors;
}

Request requestWithLines(const Job& job, uint64_t seed) {
  Request request = requestFor(job.name, job.tolerance, seed);
  request.pair_lines = true;
  return request;
}

// Returns the method of lines for all pairs, while rays of each polygon's own see what leaves the scene.
Method linesOfAll() {
  return [](const Job& job, uint64_t seed, double most_seconds) {
    const double begun = cpuSecondsOf(RUSAGE_SELF);
    const Setup setup(job.scene, requestWithLines(job, seed), {}, {});
    const std::unique_ptr<RayEngine> rays = makeRayEngine(job.scene, setup.faceIds(), setup.lattices().lattice);
    const LineMixture mixture;
    rays->setRays(std::vector<uint32_t>(setup.faceIds().count(), mixture.directions));
    return runLines(job, setup, seed, *rays, mixture, rays.get(), begun + most_seconds);
  };
}

// Returns the method of lines for pairs whose unoccluded form factor is at least `share` of the goal, while common
// directions count the others.
Method linesOf(double share) {
  return [share](const Job& job, uint64_t seed, double most_seconds) {
    const double begun = cpuSecondsOf(RUSAGE_SELF);
    const Setup setup(job.scene, requestWithLines(job, seed), {}, {});
    LineMixture mixture = setup.mixture();
    mixture.least_form_factor = share * job.tolerance;
    Lattices lattices = setup.lattices();
    lattices.lattice.resolution = mixture.resolution;
    const std::vector<SizeGroup> groups = planGroups(job.scene, setup.faceIds(), setup.sampling(), mixture.resolution,
                                                     mixture.resolution, mixture.directions);
    const std::unique_ptr<Engine> engine = makeEngine(lattices, job.scene, setup.faceIds(), groups);
    return runLines(job, setup, seed, *engine, mixture, nullptr, begun + most_seconds);
  };
}

// Returns the method of pair lines from `share` of the goal, while rays of each polygon's own count the other pairs. A
// pilot says how many rays polygons need.
Method linesBesideRays(double share) {
  return [share](const Job& job, uint64_t seed, double most_seconds) {
    const double begun = cpuSecondsOf(RUSAGE_SELF);
    const Setup setup(job.scene, requestWithLines(job, seed), {}, {});
    const std::unique_ptr<RayEngine> rays = makeRayEngine(job.scene, setup.faceIds(), setup.lattices().lattice);
    std::vector<uint32_t> rows(setup.faceIds().count());
    std::iota(rows.begin(), rows.end(), 0);
    const RayPlanner planner(*rays, job.scene, setup.faceIds(), rows, seed, false);
    LineMixture mixture = rayMixtureFor(setup.estimate(), planner.plan(setup.estimate()).outside);
    mixture.least_form_factor = share * job.tolerance;
    rays->setRays(mixture.rays);
    return runLines(job, setup, seed, *rays, mixture, rays.get(), begun + most_seconds);
  };
}

// Returns the method of a fixed number of common directions.
Method directionsOf(uint32_t directions, int resolution, int finest) {
  return [=](const Job& job, uint64_t seed, double) -> std::optional<FormFactors> {
    Request request = requestFor(job.name, job.tolerance, seed);
    request.goal = FixedAmount{.directions = directions, .resolution = resolution, .finest = finest};
    request.unoccluded = true;
    return computeFormFactors(job.scene, request).form_factors;
  };
}

// Returns the cheapest method by hand that reaches the goal.    In: most_seconds: slower methods are not of interest
Outcome findBest(const Job& job, double most_seconds) {
  Outcome best{"none", most_seconds};
  const auto consider = [&](const Outcome& outcome) {
    fmt::print(stderr, "  {}: {:.3g} s, largest error {:.3g}, of row sums {:.3g}\n", outcome.method,
               outcome.cpu_seconds, outcome.largest_error, outcome.largest_of_sums);
    if (outcome.reaches && outcome.cpu_seconds < best.cpu_seconds) best = outcome;
    return outcome;
  };
  consider(measure(job, "lines", linesOfAll(), best.cpu_seconds));
  for (const double share : {1.0 / 30, 1.0 / 10, 1.0 / 3})
    consider(measure(job, fmt::format("lines from {:.2g} T", share), linesOf(share), best.cpu_seconds));
  for (const double share : {1.0 / 10, 1.0 / 3})
    if (job.is_open)
      consider(measure(job, fmt::format("rays, lines from {:.2g} T", share), linesBesideRays(share), best.cpu_seconds));
  for (const auto& [resolution, finest] : std::vector<std::pair<int, int>>{{64, 0}, {64, 512}, {128, 0}, {128, 2048}})
    for (uint32_t directions = 16;; directions *= 2) {
      const std::string name = fmt::format("8 x {} directions, {} spacings{}", directions, resolution,
                                           finest ? fmt::format(", windows of {}", finest) : "");
      const Outcome outcome = consider(measure(job, name, directionsOf(directions, resolution, finest)));
      if (outcome.reaches || outcome.cpu_seconds > best.cpu_seconds) break;
    }
  return best;
}

void compareMethods(const std::string& name, const Options& options) {
  const Scene scene = makeJudgedScene(name);
  const FormFactors truth = computeTruth(scene, name, std::ranges::min(options.tolerances) / 5);
  const bool is_open = std::ranges::any_of(truth.entries(), [&](const auto& entry) { return entry.j == kEnvironment; });
  for (const double tolerance : options.tolerances) {
    fmt::print(stderr, "{}, {}\n", name, tolerance);
    PlanSummary plan;
    const auto runAsPlanned = [&](const Job&, uint64_t seed, double) -> std::optional<FormFactors> {
      Result result = computeFormFactors(scene, requestFor(name, tolerance, seed));
      plan = std::move(result.plan);
      return std::move(result.form_factors);
    };
    Job job{name, scene, truth, INFINITY, is_open, options.seeds};  // no error of a planned run ends its seeds
    const Outcome planned = measure(job, "planned", runAsPlanned);
    job.tolerance = tolerance;
    const Outcome best = findBest(job, 2 * planned.cpu_seconds);
    const bool is_mixture = plan.pair_lines && plan.pair_lines->least_form_factor > 0,
               has_rays = is_mixture && plan.pair_lines->has_rays;
    fmt::print("{},{},{},{},{:.3g},{:.3g},{:.3g},\"{}\",{:.3g},{:.3g},{:.3g},{:.2f}\n", name, scene.faces.size(),
               tolerance,
               has_rays          ? "rays"
               : is_mixture      ? "mixture"
               : plan.pair_lines ? "lines"
                                 : "directions",
               planned.cpu_seconds, planned.largest_error, planned.largest_of_sums, best.method, best.cpu_seconds,
               best.largest_error, best.largest_of_sums, planned.cpu_seconds / best.cpu_seconds);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  viewpeel::bench::Options options;
  CLI::App app("Compares planned runs with the best method by hand.");
  app.add_option("--scene", options.scenes)->check(CLI::IsMember(viewpeel::bench::judgedScenes()));
  app.add_option("--tolerance", options.tolerances)->check(CLI::PositiveNumber);
  app.add_option("--seeds", options.seeds)->check(CLI::PositiveNumber)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  fmt::print("# commit {}; CPU seconds\n", viewpeel::bench::commitOf(VIEWPEEL_SOURCE));
  fmt::print(
      "scene,polygons,tolerance,plan,planned,planned_error,planned_sums,method,by_hand,by_hand_error,by_hand_sums,"
      "ratio\n");
  for (const std::string& scene : options.scenes) viewpeel::bench::compareMethods(scene, options);
  return 0;
}
