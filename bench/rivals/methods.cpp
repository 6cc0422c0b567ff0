#include "bench/rivals/methods.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/compute.h>

#include "bench/rivals/embree_rays.h"
#include "engines/engine_factory.h"
#include "estimator/find_prior.h"
#include <viewpeel/error.h>
#include "bench/rivals/hemicube.h"
#include "bench/support/measure.h"
#include "reference/exact/exact_engine.h"
#include "bench/rivals/view3d.h"

namespace viewpeel::bench {
namespace {

constexpr uint32_t kReplicates = 8;  // the program's default
constexpr uint32_t kProfileDirections = 64, kProfileRepeats = 5;
constexpr size_t kManyPolygons = 5000;       // beyond which hemicubes and View3D take minutes even once
constexpr uint64_t kLongRunSeed = 1u << 20;  // no run of a ladder has it

template <class Run>
RunTime timeOf(Run run) {
  const auto cpuSeconds = [](int who) {
    rusage usage;
    ::getrusage(who, &usage);
    return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  };
  const double cpu_s = cpuSeconds(RUSAGE_SELF), host_s = cpuSeconds(RUSAGE_THREAD);
  const double seconds = secondsOf(run);
  return {seconds, cpuSeconds(RUSAGE_SELF) - cpu_s, cpuSeconds(RUSAGE_THREAD) - host_s};
}

// Each rung has `factor` times the amount of the one before.
std::vector<Ladder::Rung> climb(double first, double factor, double last) {
  std::vector<Ladder::Rung> rungs;
  for (double amount = first; amount <= last * 1.001; amount *= factor) rungs.push_back({amount, amount});
  return rungs;
}

void addUp(const FormFactors& form_factors, const Scene& scene, ExchangeMatrix& exchange,
           ExchangeMatrix* standard_errors, double* rms) {
  const double unit = 1 / (scene.scale * scene.scale);
  double squares = 0;
  for (const FormFactors::Entry& entry : form_factors.entries()) {
    if (entry.j >= kEnvironment || entry.i == entry.j) continue;
    exchange.at(entry.i, entry.j) = entry.exchange_area.value * unit;
    const double error = entry.exchange_area.standard_error * unit, area_i = scene.polygons[entry.i].area,
                 area_j = scene.polygons[entry.j].area;
    if (standard_errors) standard_errors->at(entry.i, entry.j) = error;
    squares += error * error * (1 / (area_i * area_i) + 1 / (area_j * area_j));
  }
  const double n = exchange.count();
  if (rms) *rms = std::sqrt(squares / (n * (n - 1)));
}

Outcome outcomeOf(const Estimate& estimate, const Scene& scene, RunTime time) {
  Outcome outcome{ExchangeMatrix(static_cast<uint32_t>(scene.polygons.size())), 0.0, time, {}};
  addUp(estimate.form_factors, scene, outcome.exchange, nullptr, &*outcome.standard_error);
  return outcome;
}

// The first call compiles and tunes; the next compiles the tuned kernels.
void warmUp(Engine& engine) {
  for (uint64_t replicate = 0; replicate < 2; ++replicate)
    engine.count(sampleDirections(Sampler::fibonacci, 16, 5, replicate));
}

// viewpeel's own methods, all by polygon.
class Viewpeel {
 public:
  Viewpeel(const Device& device, const Scene& scene)
      : device_(device), scene_(scene), ids_(makeIds(scene, By::polygon, false)) {}

  // Whose work is measured by the engine that a runner makes for it.
  struct Engines {
    EngineKind kind = EngineKind::compute;
    LatticeOptions lattice;
  };

  // Amounts are directions of a replicate. unoccluded: the lattice's resolution with them, 0 without.
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
    // The device has a queue of its own: once a queue has drawn, lavapipe takes the times of its dispatches a pass
    // late.
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

  // Runs as the program does by default, plan and all. Amounts are tolerances.
  Runner planned() const {
    Runner runner;
    runner.run = [this](double amount, uint64_t seed) {
      FormFactorRun run = runOf({.goal = Tolerance{amount}, .seed = seed});
      std::optional<Result> result;
      const RunTime time = timeOf([&] { result = finish(run); });
      Outcome outcome = outcomeOf(*result, scene_, time);
      outcome.chosen = fmt::format("directions={} resolution={} lattices={}", result->plan.directions,
                                   result->plan.lattices[0].resolution, windowsOf(result->plan));
      return outcome;
    };
    return runner;
  }

  Result runLong(double seconds) const {
    FormFactorRun run = runOf({.goal = Seconds{seconds}, .seed = kLongRunSeed});
    return finish(run);
  }

 private:
  // Opens the device, which a run's time leaves out.
  FormFactorRun runOf(Request request) const {
    request.device.selector = std::to_string(device_.description().index);
    request.engine = on_host_ ? EngineKind::host : EngineKind::compute;
    return FormFactorRun(scene_, request);
  }

  static Result finish(FormFactorRun& run) {
    while (!run.isDone()) run.step();
    return run.result();
  }

  static size_t windowsOf(const PlanSummary& plan) {
    size_t windows = 0;
    for (const LatticeSummary& lattice : plan.lattices) windows += lattice.windows;
    return windows;
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
    // It takes the least of a few: other work that takes a core for a moment would fill one pass or another.
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

// Returns the form of tracing that is fastest on a small share of the work.
template <class Run>
std::pair<Trace, std::string> fastestTrace(Run run) {
  std::pair<Trace, std::string> best;
  double least_s = INFINITY;
  for (const auto& [trace, name] : {std::pair(Trace::packets_of_8, "packets"), std::pair(Trace::streams, "streams"),
                                    std::pair(Trace::single, "single")}) {
    run(trace);
    double trace_s = INFINITY;
    for (int k = 0; k < 3; ++k) trace_s = std::min(trace_s, secondsOf([&, tried = trace] { run(tried); }));
    if (trace_s < least_s) least_s = trace_s, best = {trace, std::string("trace=") + name};
  }
  return best;
}

void addRivals(const Device& device, const Scene& scene, const MethodOptions& options, std::vector<Ladder>& ladders) {
  const double pairs = 0.5 * double(scene.polygons.size()) * (double(scene.polygons.size()) - 1);
  for (const auto& [points, name] : {std::pair(Points::random, "random"), std::pair(Points::sobol, "sobol")}) {
    const bool stated = points == Points::random;
    ladders.push_back({fmt::format("rays_{}", name), "", "rays_per_polygon", false, climb(64, 4, 1u << 30),
                       [&scene, points = points, stated] {
                         Runner runner;
                         std::shared_ptr<EmbreeRays> embree;
                         runner.setup_seconds = secondsOf([&] { embree = std::make_shared<EmbreeRays>(scene); });
                         const uint64_t few = std::clamp<uint64_t>(200'000 / scene.polygons.size(), 64, 1u << 16);
                         const auto [trace, chosen] =
                             fastestTrace([&](Trace form) { embree->shoot(form, points, few, 1); });
                         runner.chosen = chosen;
                         runner.run = [embree, &scene, points, stated, trace = trace](double amount, uint64_t seed) {
                           RayCounts counts;
                           const RunTime time = timeOf(
                               [&] { counts = embree->shoot(trace, points, static_cast<uint64_t>(amount), seed); });
                           RayEstimate estimate = estimateFromRays(counts, scene);
                           return Outcome{std::move(estimate.exchange),
                                          stated ? std::optional(estimate.rms_standard_error) : std::nullopt,
                                          time,
                                          {}};
                         };
                         return runner;
                       }});
    ladders.push_back(
        {fmt::format("double_area_{}", name), "", "samples_per_pair", false, climb(pairs < 1e6 ? 4 : 1, 4, 1u << 28),
         [&scene, pairs, points = points, stated] {
           Runner runner;
           std::shared_ptr<EmbreeRays> embree;
           runner.setup_seconds = secondsOf([&] { embree = std::make_shared<EmbreeRays>(scene); });
           const auto few = static_cast<uint32_t>(std::clamp(1e5 / pairs, 1.0, 1e5));
           const auto [trace, chosen] = fastestTrace([&](Trace form) { embree->integrate(form, points, few, 1); });
           runner.chosen = chosen;
           runner.run = [embree, points, stated, trace = trace](double amount, uint64_t seed) {
             RayEstimate estimate;
             const RunTime time =
                 timeOf([&] { estimate = embree->integrate(trace, points, static_cast<uint32_t>(amount), seed); });
             return Outcome{std::move(estimate.exchange),
                            stated && amount > 1 ? std::optional(estimate.rms_standard_error) : std::nullopt,
                            time,
                            {}};
           };
           return runner;
         }});
  }
  const std::vector<uint32_t> all{32, 64, 128, 256, 512}, some{32, 128};
  for (const uint32_t resolution : options.full&& scene.polygons.size() < kManyPolygons ? all : some)
    ladders.push_back({"hemicube", fmt::format("resolution={} ", resolution), "points_per_polygon", true,
                       climb(1, 4, 1u << 16), [&device, &scene, resolution] {
                         Runner runner;
                         std::shared_ptr<Hemicube> hemicube;
                         runner.setup_seconds = secondsOf([&] {
                           hemicube = std::make_shared<Hemicube>(device, scene, resolution);
                           hemicube->lookOnce();  // compiles
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
  std::vector<Ladder::Rung> rungs;  // time about doubles from one eps to the next
  for (int k = 2; k <= 9; ++k) rungs.push_back({std::pow(10.0, -k), std::pow(2.0, k)});
  ladders.push_back({"view3d", "", "eps", false, rungs, [&scene, options] {
                       if (scene.polygons.size() >= kManyPolygons)
                         throw Error(ErrorCode::limit,
                                     "View3D takes a quarter of an hour or more at every eps; choose a smaller scene");
                       Runner runner;
                       runner.run = [&scene, options](double amount, uint64_t) {
                         View3dRun run = runView3d(options.view3d, scene, amount, options.work_directory);
                         for (double& value : run.exchange.values()) value /= scene.scale * scene.scale;
                         return Outcome{std::move(run.exchange), std::nullopt, {run.seconds, run.seconds, 0}, {}};
                       };
                       return runner;
                     }});
}

}  // namespace

std::vector<Ladder> makeLadders(const Device& device, const Scene& scene, const MethodOptions& options) {
  const auto viewpeel = std::make_shared<Viewpeel>(device, scene);
  std::vector<Ladder> ladders;
  const auto add = [&](const std::string& method, const std::string& parameters, const Viewpeel::Engines& engines,
                       Sampler sampler, int unoccluded, double first) {
    ladders.push_back({method, parameters, "directions", method != "exact" && !method.starts_with("host"),
                       climb(first, 4, 1u << 22), [=] { return viewpeel->runner(engines, sampler, unoccluded); }});
  };
  std::vector<Ladder::Rung> tolerances;  // the lattice's error falls as the square root of time
  for (const double tolerance : {3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5})
    tolerances.push_back({tolerance, 1 / tolerance});
  ladders.push_back({"planned", "", "tolerance", true, tolerances, [viewpeel] { return viewpeel->planned(); }});
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
  LongRun run{ExchangeMatrix(count), ExchangeMatrix(count)};
  addUp(estimate.form_factors, scene, run.exchange, &run.standard_errors, nullptr);
  return run;
}

}  // namespace viewpeel::bench
