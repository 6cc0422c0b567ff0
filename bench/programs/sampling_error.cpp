// This bench compares the errors of lattice points and of scanlines at equal time, for each engine. CSV on
// stdout has the rms error of single replicates of rotated Fibonacci directions, over all ordered pairs of
// polygons. Comments have, for each engine and sampling, the exponent a of rms ~ T^-a and the time to given
// errors. T is the number of lattice points or scanlines, with the best split between directions and spacing for
// each T.
//   sampling_error [--scene plates|cube|office|room4]... [--resolution PX]... [--directions N]... [--repeats K]
//     [--reference N] [--engine compute|host]...
// The reference of plates, and of the inside of a cube of 96 patches, is the closed form by contour integrals. For
// scenes with occlusion it is a long run with scanlines, whose own error is printed.
#include <cmath>
#include <map>

#include <CLI/CLI.hpp>

#include "directions/sampler.h"
#include "engines/compute_engine.h"
#include "engines/host_engine.h"
#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/support/measure.h"
#include "reference/closed_forms/contour_integral.h"

namespace viewpeel::bench {
namespace {

struct Options {
  std::vector<std::string> scenes{"plates", "cube", "office", "room4"}, engines{"compute", "host"};
  std::vector<int> resolutions{16, 32, 64, 128, 256};
  std::vector<uint32_t> directions{50, 200, 800};
  uint32_t repeats = 4, reference = 20'000;
  DeviceOptions device;
};

using Factors = std::map<std::pair<uint32_t, uint32_t>, double>;  // nonzero F_ij by (i, j), i != j

struct Reference {
  Factors factors;
  double rms_error = 0;  // rms over all ordered pairs
};

struct Run {
  double samples, seconds, rms;
};

Scene makeScene(const std::string& name) {
  if (name == "cube") return buildScene(cubeOfPatches(4));
  if (name == "room4") return buildScene(roomWithBoxes(4));
  return loadScene(VIEWPEEL_SOURCE "/scenes/" + name + ".obj");
}

Factors factorsOf(const PairCounts& counts, const Ids& ids, double measure_area) {
  Factors factors;
  for (const PairCount& c : counts) {
    if (c.j >= kEnvironment || c.i == c.j) continue;
    factors[{c.i, c.j}] = 2 * double(c.count) * measure_area / ids.areas[c.i];
    factors[{c.j, c.i}] = 2 * double(c.count) * measure_area / ids.areas[c.j];
  }
  return factors;
}

double sumOfSquares(const Factors& a, const Factors& b) {
  double sum = 0;
  auto at = b.begin();
  for (const auto& [key, value] : a) {
    while (at != b.end() && at->first < key) sum += at->second * at->second, ++at;
    const double other = at != b.end() && at->first == key ? (at++)->second : 0;
    sum += (value - other) * (value - other);
  }
  for (; at != b.end(); ++at) sum += at->second * at->second;
  return sum;
}

double measureArea(const Engine& engine, const Scene& scene, uint32_t directions) {
  return engine.unitArea() * scene.scale * scene.scale / directions;
}

// Returns closed forms where nothing blocks a line. Elsewhere returns the mean of two long runs, with half their
// difference as its error.
Reference makeReference(const std::string& name, const Scene& scene, const Ids& ids, uint32_t directions) {
  Reference reference;
  const double pairs = double(ids.count()) * (ids.count() - 1);
  if (name == "plates" || name == "cube") {
    std::vector<std::vector<glm::dvec3>> corners;
    for (const Polygon& p : scene.polygons)
      corners.emplace_back(scene.corners.begin() + p.first_corner,
                           scene.corners.begin() + p.first_corner + p.corner_count);
    for (uint32_t i = 0; i < corners.size(); ++i)
      for (uint32_t j = 0; j < corners.size(); ++j)
        if (i != j) reference.factors[{i, j}] = reference::formFactor(corners[i], corners[j]);
    return reference;
  }
  Factors halves[2];
  for (uint64_t half = 0; half < 2; ++half) {
    const auto engine = makeHostEngine(scene, ids, {.resolution = 256, .sampling = Sampling::scanline});
    halves[half] = factorsOf(engine->count(sampleDirections(Sampler::fibonacci, directions / 2, 77, half)), ids,
                             measureArea(*engine, scene, directions / 2));
  }
  reference.rms_error = std::sqrt(sumOfSquares(halves[0], halves[1]) / pairs) / 2;
  for (const Factors& half : halves)
    for (const auto& [key, value] : half) reference.factors[key] += value / 2;
  return reference;
}

// Fits a power law to the runs that no other run beats in both `cost` and error.
PowerLaw fitEnvelope(std::vector<Run> runs, double Run::*cost) {
  std::sort(runs.begin(), runs.end(), [&](const Run& a, const Run& b) { return a.*cost < b.*cost; });
  std::vector<double> costs, errors;
  for (const Run& run : runs)
    if (errors.empty() || run.rms < errors.back()) costs.push_back(run.*cost), errors.push_back(run.rms);
  return fitPowerLaw(costs, errors);
}

void measureSampling(const std::string& name, const std::string& kind, Sampling sampling, const Device& device,
                     const Scene& scene, const Ids& ids, const Reference& reference, const Options& options) {
  const char* word = sampling == Sampling::lattice ? "lattice" : "scanline";
  const double pairs = double(ids.count()) * (ids.count() - 1);
  std::vector<Run> runs;
  for (int resolution : options.resolutions) {
    const LatticeOptions lattice{.resolution = resolution, .sampling = sampling};
    const auto engine =
        kind == "host" ? makeHostEngine(scene, ids, lattice) : makeComputeEngine(device, scene, ids, lattice);
    engine->count(sampleDirections(Sampler::fibonacci, 64, 5, 0));  // compiles and tunes
    const double fixed = secondsOf([&] { engine->count({}); });     // reading of counters, once for each replicate
    for (uint32_t directions : options.directions) {
      double squares = 0, seconds = 0;
      for (uint32_t repeat = 0; repeat < options.repeats; ++repeat) {
        const std::vector<Direction> set = sampleDirections(Sampler::fibonacci, directions, 1, repeat);
        PairCounts counts;
        seconds += secondsOf([&] { counts = engine->count(set); }) - fixed;
        squares +=
            sumOfSquares(factorsOf(counts, ids, measureArea(*engine, scene, directions)), reference.factors) / pairs;
      }
      const double rms =
          std::sqrt(std::max(0.0, squares / options.repeats - reference.rms_error * reference.rms_error));
      const double samples = double(directions) * resolution * (sampling == Sampling::lattice ? resolution : 1);
      fmt::print("{},{},{},{},{},{},{:.4g},{:.4g}\n", name, ids.count(), kind, word, resolution, directions, rms,
                 seconds / options.repeats);
      std::fflush(stdout);
      if (rms > 3 * reference.rms_error) runs.push_back({samples, seconds / options.repeats, rms});
    }
  }
  if (runs.size() < 4) return;
  const PowerLaw in_samples = fitEnvelope(runs, &Run::samples), in_seconds = fitEnvelope(runs, &Run::seconds);
  const auto secondsTo = [&](double rms) {
    return std::exp((std::log(rms) - in_seconds.intercept) / in_seconds.exponent);
  };
  fmt::print(
      "# {} {} {}: rms ~ T^{:.2f} in samples, ~ t^{:.2f} in seconds; to 1e-3 {:.2g} s, to 1e-4 {:.2g} s, to 1e-5 "
      "{:.2g} s, along that line\n",
      name, kind, word, in_samples.exponent, in_seconds.exponent, secondsTo(1e-3), secondsTo(1e-4), secondsTo(1e-5));
}

void measureScene(const std::string& name, const Device& device, const Options& options) {
  const Scene scene = makeScene(name);
  const Ids ids = makeIds(scene, By::polygon, false);
  const Reference reference = makeReference(name, scene, ids, options.reference);
  fmt::print("# {}: {} polygons; rms error of the reference {:.1e}\n", name, ids.count(), reference.rms_error);
  for (const std::string& kind : options.engines)
    for (Sampling sampling : {Sampling::lattice, Sampling::scanline})
      measureSampling(name, kind, sampling, device, scene, ids, reference, options);
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  using namespace viewpeel::bench;
  CLI::App app("Error of lattice points and scanlines against time", "sampling_error");
  Options options;
  app.add_option("--scene", options.scenes, "plates, cube, office, room4")->capture_default_str();
  app.add_option("--resolution", options.resolutions, "Spacings across the scene")->capture_default_str();
  app.add_option("--directions", options.directions, "Directions of a replicate")->capture_default_str();
  app.add_option("--repeats", options.repeats, "Replicates to take the mean of")->capture_default_str();
  app.add_option("--reference", options.reference, "Directions of the reference where there is no closed form")
      ->capture_default_str();
  app.add_option("--engine", options.engines, "compute, host")
      ->check(CLI::IsMember({"compute", "host"}))
      ->capture_default_str();
  app.add_option("--device", options.device.selector, "As for viewpeel");
  CLI11_PARSE(app, argc, argv);
  try {
    const Device device(options.device);
    printPlace(device, VIEWPEEL_SOURCE);
    fmt::print("scene,polygons,engine,sampling,resolution,directions,rms_error,seconds\n");
    for (const std::string& scene : options.scenes) measureScene(scene, device, options);
  } catch (const Error& error) {
    fmt::print(stderr, "sampling_error: {}\n", error.what());
    return 1;
  }
}
