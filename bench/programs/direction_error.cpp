// This bench measures how the error of a form factor falls with the number N of directions, for each sampler. Scenes
// are two squares with closed forms. CSV on stdout has the rms error over independent replicates of N directions, with
// exact areas along each direction and with lattice points. Comments have the exponent a of rms ~ N^-a by least
// squares, with its standard error.
//   direction_error [--scene facing|edge|distant]... [--sampler S]... [--directions N]... [--replicates K]
//                   [--resolution PX]... [--lattice-directions N]... [--lattice-replicates K] [--device D]
// The fit takes every N at which kFewestSeen directions or more see the pair in the mean. With fewer, every sampler is
// as good as independent directions.
#include <cmath>
#include <map>

#include <CLI/CLI.hpp>

#include "directions/sampler.h"
#include "engines/compute_engine.h"
#include <viewpeel/error.h>
#include "bench/support/measure.h"
#include "reference/closed_forms/contour_integral.h"
#include "reference/exact/projected_estimate.h"
#include "scenes/named_scenes.h"

namespace viewpeel::bench {
namespace {

constexpr double kFewestSeen = 16;
const std::map<std::string, InputScene> kScenes{{"facing", test_scenes::parallelSquares()},
                                                {"edge", test_scenes::perpendicularSquares()},
                                                {"distant", test_scenes::stackOfSheets({0, 4})}};
const std::map<std::string, Sampler> kSamplers(kSamplerNames.begin(), kSamplerNames.end());

struct Options {
  std::vector<std::string> scenes{"facing", "edge", "distant"}, samplers{"iid", "jittered", "sobol", "fibonacci"};
  std::vector<int> resolutions{64};
  std::vector<uint32_t> directions{16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384},
      lattice_directions{16, 32, 64, 128, 256, 512, 1024};
  uint32_t replicates = 200, lattice_replicates = 50;
  DeviceOptions device;
};

// Spread describes the errors of replicates of N directions each.
struct Spread {
  uint32_t directions = 0;
  double rms = 0, rms_standard_error = 0;
  double bias = 0;  // mean error over its standard error
};

Spread spreadOf(uint32_t directions, const std::vector<double>& errors) {
  const auto count = double(errors.size());
  double sum = 0, squares = 0, fourths = 0;
  for (double e : errors) sum += e, squares += e * e, fourths += e * e * e * e;
  Spread spread{.directions = directions, .rms = std::sqrt(squares / count)};
  spread.rms_standard_error =
      std::sqrt((fourths / count - squares / count * squares / count) / count) / (2 * spread.rms);
  spread.bias = sum / std::sqrt(squares - sum * sum / count);
  return spread;
}

void printRow(const std::string& key, uint32_t replicates, const Spread& spread) {
  fmt::print("{},{},{},{:.4g},{:.2g},{:.2f}\n", key, spread.directions, replicates, spread.rms,
             spread.rms_standard_error, spread.bias);
  std::fflush(stdout);
}

// Measures and fits one sampler. error(directions, replicate) returns the error of one replicate. It takes the number
// of directions as seed too, so that the points of a fit are independent.
template <class Error>
void measure(const std::string& key, const std::vector<uint32_t>& direction_counts, uint32_t replicates,
             double seen_share, Error error) {
  std::vector<double> x, y;
  for (uint32_t directions : direction_counts) {
    std::vector<double> errors;
    for (uint32_t replicate = 0; replicate < replicates; ++replicate) errors.push_back(error(directions, replicate));
    const Spread spread = spreadOf(directions, errors);
    printRow(key, replicates, spread);
    if (directions * seen_share < kFewestSeen) continue;
    x.push_back(directions);
    y.push_back(spread.rms);
  }
  if (x.size() < 3) return;
  const PowerLaw law = fitPowerLaw(x, y);
  fmt::print("# {}: rms ~ N^{:.3f}, standard error {:.3f}, N from {:.0f} to {:.0f}; rms {:.2e} at 400\n", key,
             law.exponent, law.standard_error, x.front(), x.back(), law.at(400));
  std::fflush(stdout);
}

void measureScene(const std::string& name, const Device* device, const Options& options) {
  const InputScene& input = kScenes.at(name);
  const std::vector<glm::dvec3>&a = input.faces[0].corners, &b = input.faces[1].corners;
  const double truth = reference::formFactor(a, b);
  const reference::ProjectedPair pair(a, b);
  double seen_share = 0;
  const uint32_t tries = 1u << 16;
  for (const Direction& d : sampleDirections(Sampler::fibonacci, tries, 0, 0))
    seen_share += (pair.zeta(d.u) > 0) / double(tries);
  fmt::print("# {}: form factor {:.10f}; {:.3g} % of all directions see it\n", name, truth, 100 * seen_share);
  for (const std::string& sampler : options.samplers)
    measure(fmt::format("{},exact,{}", name, sampler), options.directions, options.replicates, seen_share,
            [&](uint32_t directions, uint64_t replicate) {
              double sum = 0;
              for (const Direction& d : sampleDirections(kSamplers.at(sampler), directions, directions, replicate))
                sum += pair.zeta(d.u);
              return sum / directions - truth;
            });
  if (!device) return;
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  for (int resolution : options.resolutions) {
    const auto engine = makeComputeEngine(*device, scene, ids, {.resolution = resolution});
    const double factor_of_count = 2 * engine->unitArea() / scene.polygons[0].area;
    for (const std::string& sampler : options.samplers)
      measure(fmt::format("{},{},{}", name, resolution, sampler), options.lattice_directions,
              options.lattice_replicates, seen_share, [&](uint32_t directions, uint64_t replicate) {
                const PairCounts counts =
                    engine->count(sampleDirections(kSamplers.at(sampler), directions, directions, replicate));
                double sum = 0;
                for (const PairCount& c : counts)
                  if (c.i == 0 && c.j == 1) sum = double(c.count);
                return sum * factor_of_count / directions - truth;
              });
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  using namespace viewpeel::bench;
  CLI::App app("Error against the number of directions, for each sampler", "direction_error");
  Options options;
  app.add_option("--scene", options.scenes, "facing, edge, distant")
      ->check(CLI::IsMember(kScenes))
      ->capture_default_str();
  app.add_option("--sampler", options.samplers, "iid, jittered, sobol, fibonacci")
      ->check(CLI::IsMember(kSamplers))
      ->capture_default_str();
  app.add_option("--directions", options.directions, "N with exact areas")->capture_default_str();
  app.add_option("--replicates", options.replicates, "Replicates of each N with exact areas")->capture_default_str();
  app.add_option("--resolution", options.resolutions, "Lattice spacings across the scene; 0: exact areas only")
      ->capture_default_str();
  app.add_option("--lattice-directions", options.lattice_directions, "N with lattice points")->capture_default_str();
  app.add_option("--lattice-replicates", options.lattice_replicates, "Replicates of each N with lattice points")
      ->capture_default_str();
  app.add_option("--device", options.device.selector, "As for viewpeel");
  CLI11_PARSE(app, argc, argv);
  try {
    const Device device(options.device);
    printPlace(device, VIEWPEEL_SOURCE);
    fmt::print("scene,areas,sampler,directions,replicates,rms_error,rms_standard_error,mean_in_standard_errors\n");
    for (const std::string& scene : options.scenes)
      measureScene(scene, options.resolutions == std::vector{0} ? nullptr : &device, options);
  } catch (const Error& error) {
    fmt::print(stderr, "direction_error: {}\n", error.what());
    return 1;
  }
}
