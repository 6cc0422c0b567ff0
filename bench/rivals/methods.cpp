#include "bench/rivals/methods.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/compute.h>

#include "engines/engine_factory.h"
#include "estimator/find_prior.h"
#include <viewpeel/error.h>
#include "bench/rivals/hemicube.h"
#include "bench/rivals/ray_ladders.h"
#include "bench/support/measure.h"
#include "reference/exact/exact_engine.h"
#include "bench/rivals/view3d.h"

namespace viewpeel::bench {
namespace {

constexpr uint32_t kReplicates = 8;  // the program's default
constexpr uint32_t kProfileDirections = 64, kProfileRepeats = 5;
constexpr size_t kManyPolygons = 5000;       // in larger scenes one run of hemicubes takes minutes
constexpr uint64_t kLongRunSeed = 1u << 20;  // different from the seeds of all ladders

void addUp(const FormFactors& form_factors, const Scene& scene, ExchangeMatrix& exchange, std::vector<double>& rest,
           double* rms, LongRun* errors) {
  const double unit = 1 / (scene.scale * scene.scale);
  double squares = 0;
  for (const FormFactors::Entry& entry : form_factors.entries()) {
    const double error = entry.exchange_area.standard_error * unit, area_i = scene.polygons[entry.i].area;
    if (entry.j >= kEnvironment) {
      rest[entry.i] += entry.exchange_area.value * unit;
      if (errors) errors->largest_rest_error = std::max(errors->largest_rest_error, error / area_i);
    }
    if (entry.j >= kEnvironment || entry.i == entry.j) continue;
    exchange.at(entry.i, entry.j) = entry.exchange_area.value * unit;
    const double area_j = scene.polygons[entry.j].area;
    if (errors) errors->standard_errors.at(entry.i, entry.j) = error;
    squares += error * error * (1 / (area_i * area_i) + 1 / (area_j * area_j));
  }
  const double n = exchange.count();
  if (rms) *rms = std::sqrt(squares / (n * (n - 1)));
}

Outcome outcomeOf(const Estimate& estimate, const Scene& scene, RunTime time) {
  Outcome outcome{ExchangeMatrix(static_cast<uint32_t>(scene.polygons.size())), 0.0, time, {}};
  outcome.rest.resize(scene.polygons.size());
  addUp(estimate.form_factors, scene, outcome.exchange, outcome.rest, &*outcome.standard_error, nullptr);
  return outcome;
}

// Counts twice: the first call compiles and tunes, and the second compiles the tuned kernels.
void warmUp(Engine& engine) {
  for (uint64_t replicate = 0; replicate < 2; ++replicate)
    engine.count(sampleDirections(Sampler::fibonacci, 16, 5, replicate));
}

// Viewpeel makes viewpeel's own methods, all by polygon.
class Viewpeel {
 public:
  Viewpeel(const Device& device, const Scene& scene)
      : device_(device), scene_(scene), ids_(makeIds(scene, By::polygon, false)) {}

  // Engines are the settings of the engine that a runner makes.
  struct Engines {
    EngineKind kind = EngineKind::compute;
    LatticeOptions lattice;
  };

  // Returns a runner whose amounts are directions of a replicate.
  //   In: unoccluded: resolution of the lattice that gives visibilities to unoccluded form factors; 0: plain counts
  Runner runner(const Engines& engines, Sampler sampler, int unoccluded) const {
    const auto make = [this, engines](const Device& device, bool measure_work) {
      LatticeOptions lattice = engines.lattice;
      lattice.measure_work = measure_work;
      return (engines.kind == EngineKind::exact ? reference::exactEngines() : latticeEngines(engines.kind, &device))(
          scene_, ids_, lattice);
    };
    Runner runner;
    std::shared_ptr<Engine> engine;
    runner.setup_seconds = secondsOf([&] {
      engine = make(device_, false);
      warmUp(*engine);
    });
    // The profile runs on a device object of its own. On a queue that has drawn, lavapipe reports times of dispatches
    // one pass late.
    const Device apart({.selector = std::to_string(device_.description().index)});
    if (const std::unique_ptr<Engine> measured = make(apart, true); measured->work())
      runner.profile = profileOf(*measured);
    runner.run = [this, engine, sampler, unoccluded](double amount, uint64_t seed) {
      EstimateOptions options;
      options.sampler = sampler;
      options.directions = static_cast<uint32_t>(amount);
      options.replicates = kReplicates;
      options.seed = seed;
      std::optional<Estimate> estimate;
      const RunTime time = timeOf([&] {
        estimate = unoccluded ? withUnoccluded(*engine, groupAsOne(scene_, unoccluded), options)
                              : estimateFormFactors(*engine, scene_, ids_, options);
      });
      return outcomeOf(*estimate, scene_, time);
    };
    return runner;
  }

  // Returns a runner that computes as the program does by default. Engine, device, kernels, plan and prior are all in
  // its time. Amounts are tolerances.    In: pair_lines: empty: as the plan decides
  Runner planned(std::optional<bool> pair_lines) const {
    return throughTheFrontDoor([](double amount) { return Goal(Tolerance{amount}); }, pair_lines);
  }

  // Returns a runner in the same way. Amounts are root mean squares of all errors.
  Runner plannedForRms() const {
    return throughTheFrontDoor([](double amount) { return Goal(RootMeanSquare{amount}); }, {});
  }

  // Returns a runner in the same way, without a plan. Amounts are directions of a replicate.
  Runner fixed() const {
    return throughTheFrontDoor([](double amount) { return Goal(FixedAmount{static_cast<uint32_t>(amount)}); }, {});
  }

  // Runs by common directions alone, so that pair lines are judged by another method.
  Result runLong(double seconds) const {
    return computeFormFactors(scene_, requestOf(Seconds{seconds}, kLongRunSeed, false));
  }

 private:
  Request requestOf(Goal goal, uint64_t seed, std::optional<bool> pair_lines) const {
    Request request{.goal = goal, .pair_lines = pair_lines, .promise = false, .seed = seed};
    request.engine = on_host_ ? EngineKind::host : EngineKind::compute;
    request.device.selector = std::to_string(device_.description().index);
    return request;
  }

  Runner throughTheFrontDoor(std::function<Goal(double amount)> goal_of, std::optional<bool> pair_lines) const {
    Runner runner;
    runner.run = [this, goal_of, pair_lines](double amount, uint64_t seed) {
      const Request request = requestOf(goal_of(amount), seed, pair_lines);
      std::optional<Result> result;
      const RunTime time = timeOf([&] { result = computeFormFactors(scene_, request); });
      Outcome outcome = outcomeOf(*result, scene_, time);
      outcome.chosen = optionsOf(result->plan);
      return outcome;
    };
    return runner;
  }

  Estimate withUnoccluded(Engine& engine, const std::vector<SizeGroup>& groups, EstimateOptions options) const {
    FaceExchanges exchanges(on_host_ ? nullptr : &device_, scene_, ids_);
    options.exchanges = &exchanges;
    const FoundPrior found = findPrior(engine, exchanges, scene_, ids_, groups, options, choosePriorPilot(options));
    options.prior = &found.prior;
    return estimateFormFactors(engine, scene_, ids_, options);
  }

  static Profile profileOf(Engine& engine) {
    warmUp(engine);
    // The least of a few repeats counts, for other work may take a core during a pass.
    std::vector<double> passes;
    for (uint64_t repeat = 0; repeat < kProfileRepeats; ++repeat) {
      const Work before = *engine.work();
      engine.count(sampleDirections(Sampler::fibonacci, kProfileDirections, 6, repeat));
      const Work& after = *engine.work();
      passes.resize(after.pass_seconds.size(), INFINITY);
      for (size_t k = 0; k < passes.size(); ++k)
        passes[k] = std::min(passes[k], after.pass_seconds[k].second - before.pass_seconds[k].second);
    }
    const Work& work = *engine.work();
    const double all = std::accumulate(passes.begin(), passes.end(), 0.0);
    Profile profile{work.memory_bytes, {}};
    for (size_t k = 0; k < passes.size(); ++k)
      profile.passes += fmt::format("{}{} {:.3f}", k ? "; " : "", work.pass_seconds[k].first, passes[k] / all);
    return profile;
  }

  const Device& device_;
  const Scene& scene_;
  Ids ids_;
  const bool on_host_ = device_.description().kind == "cpu";
};

void addRivals(const Device& device, const Scene& scene, const MethodOptions& options, std::vector<Ladder>& ladders) {
  addRayLadders(scene, ladders);
  const std::vector<uint32_t> all{32, 64, 128, 256, 512}, some{32, 128};
  for (const uint32_t resolution : options.full&& scene.polygons.size() < kManyPolygons ? all : some)
    ladders.push_back({"hemicube", fmt::format("resolution={} ", resolution), "points_per_polygon", true,
                       climbBy(1, 4, 1u << 16), [&device, &scene, resolution] {
                         Runner runner;
                         std::shared_ptr<Hemicube> hemicube;
                         runner.setup_seconds = secondsOf([&] {
                           hemicube = std::make_shared<Hemicube>(device, scene, resolution);
                           hemicube->lookOnce();  // the first draw compiles
                         });
                         runner.run = [hemicube](double amount, uint64_t seed) {
                           ExchangeMatrix exchange;
                           const RunTime time =
                               timeOf([&] { exchange = hemicube->compute(static_cast<uint32_t>(amount), seed); });
                           return Outcome{std::move(exchange), std::nullopt, time, {}};
                         };
                         return runner;
                       }});
  if (options.view3d.empty()) return;
  std::vector<Ladder::Rung> rungs;  // time about doubles with each smaller eps
  for (int k = 2; k <= 9; ++k) rungs.push_back({std::pow(10.0, -k), std::pow(2.0, k)});
  ladders.push_back({"view3d", "", "eps", false, rungs, [&scene, options] {
                       if (scene.polygons.size() > options.view3d_most_polygons)
                         throw Error(ErrorCode::limit, "View3D takes long at every eps; raise --view3d-most");
                       Runner runner;
                       runner.run = [&scene, options](double amount, uint64_t) {
                         View3dRun run = runView3d(options.view3d, scene, amount, options.work_directory);
                         for (double& value : run.exchange.values()) value /= scene.scale * scene.scale;
                         return Outcome{std::move(run.exchange), std::nullopt, run.time, {}};
                       };
                       return runner;
                     }});
}

}  // namespace

std::vector<Ladder::Rung> climbBy(double first, double factor, double last) {
  std::vector<Ladder::Rung> rungs;
  for (double amount = first; amount <= last * 1.001; amount *= factor) rungs.push_back({amount, amount});
  return rungs;
}

std::vector<Ladder> makeLadders(const Device& device, const Scene& scene, const MethodOptions& options) {
  const auto viewpeel = std::make_shared<Viewpeel>(device, scene);
  std::vector<Ladder> ladders;
  const auto add = [&](const std::string& method, const std::string& parameters, const Viewpeel::Engines& engines,
                       Sampler sampler, int unoccluded, double first) {
    ladders.push_back({method, parameters, "directions", method != "exact" && !method.starts_with("host"),
                       climbBy(first, 4, 1u << 22), [=] { return viewpeel->runner(engines, sampler, unoccluded); }});
  };
  std::vector<Ladder::Rung> tolerances;  // time is taken as proportional to 1 / tolerance
  for (const double tolerance : {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5})
    tolerances.push_back({tolerance, 1 / tolerance});
  ladders.push_back({"planned", "", "tolerance", true, tolerances, [viewpeel] { return viewpeel->planned({}); }});
  ladders.push_back(
      {"planned_directions", "", "tolerance", true, tolerances, [viewpeel] { return viewpeel->planned(false); }});
  std::vector<Ladder::Rung> means;
  for (const double rms : {1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6}) means.push_back({rms, 1 / rms});
  ladders.push_back({"planned_rms", "", "rms", true, means, [viewpeel] { return viewpeel->plannedForRms(); }});
  ladders.push_back(
      {"fixed", "", "directions", true, climbBy(32, 4, 1u << 22), [viewpeel] { return viewpeel->fixed(); }});
  const std::vector<int> all = options.full ? std::vector<int>{64, 128, 256, 512} : std::vector<int>{64, 256}, one{128};
  for (const Sampler sampler : {Sampler::fibonacci, Sampler::jittered, Sampler::iid})
    for (const bool unoccluded : {false, true})
      for (const int resolution : sampler == Sampler::fibonacci ? all : one)
        add(fmt::format("{}{}", nameOf(sampler), unoccluded ? "_unoccluded" : ""),
            fmt::format("resolution={} ", resolution),
            {EngineKind::compute, {.resolution = resolution, .count_blocked = unoccluded}}, sampler,
            unoccluded ? resolution : 0, 32);
  for (const bool unoccluded : {false, true})
    for (const int resolution : options.full ? std::vector<int>{32, 64, 128, 256} : one)
      add(unoccluded ? "scanline_unoccluded" : "scanline", fmt::format("resolution={} ", resolution),
          {EngineKind::compute,
           {.resolution = resolution, .sampling = Sampling::scanline, .count_blocked = unoccluded}},
          Sampler::fibonacci, unoccluded ? resolution : 0, 32);
  for (const bool unoccluded : {false, true})
    for (const int resolution : options.full ? std::vector<int>{32, 64, 128, 256, 512} : std::vector<int>{32, 64, 128})
      add(unoccluded ? "host_unoccluded" : "host", fmt::format("resolution={} ", resolution),
          {EngineKind::host, {.resolution = resolution, .sampling = Sampling::scanline, .count_blocked = unoccluded}},
          Sampler::fibonacci, unoccluded ? resolution : 0, 8);
  add("graphics", "resolution=128 ", {EngineKind::graphics, {.resolution = 128}}, Sampler::fibonacci, 0, 8);
  add("exact", "", {EngineKind::exact, {}}, Sampler::fibonacci, 0, 8);
  addRivals(device, scene, options, ladders);
  return ladders;
}

std::vector<std::string> rivalNames() {
  return {"rays_random", "rays_sobol", "double_area_random", "double_area_sobol", "hemicube"};
}

LongRun runLong(const Device& device, const Scene& scene, double seconds) {
  const Estimate estimate = Viewpeel(device, scene).runLong(seconds);
  const auto count = static_cast<uint32_t>(scene.polygons.size());
  LongRun run{ExchangeMatrix(count), ExchangeMatrix(count), std::vector<double>(count), 0};
  addUp(estimate.form_factors, scene, run.exchange, run.rest, nullptr, &run);
  return run;
}

}  // namespace viewpeel::bench
