// This bench measures how the compute engine's time for a direction grows with polygons and with lattice points. It
// prints CSV on stdout, and fitted exponents in comments.
//   growth [--series polygons|points]... [--most-polygons N] [--most-resolution PX] [--by polygon|surface]... [--rounds
//   N] [--seconds S]
// The series `polygons` has cities: the same streets over larger and larger ground, on one lattice. The series `points`
// has one room on finer and finer lattices. The fixed cost is the time of a call without directions. It is measured in
// every round, taken off the time for a direction, and printed beside it.
#include <cmath>
#include <map>
#include <span>

#include <CLI/CLI.hpp>

#include "directions/sampler.h"
#include "engines/compute_engine.h"
#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/support/measure.h"

namespace viewpeel::bench {
namespace {

constexpr uint32_t kMostDirections = 1u << 14;
constexpr uint32_t kSeed = 1;
const std::map<std::string, By> kBy{{"polygon", By::polygon}, {"surface", By::surface}};

struct Options {
  std::vector<std::string> series{"polygons", "points"}, by{"surface", "polygon"};
  uint32_t most_polygons = 1'000'000, refine = 1;
  int resolution = 256, most_resolution = 1024, rounds = 3;
  double seconds = 0.5;
  DeviceOptions device;
};

struct Point {
  double x, seconds;
};

double fitExponent(std::span<const Point> points) {
  std::vector<double> x, seconds;
  for (const Point& p : points) x.push_back(p.x), seconds.push_back(p.seconds);
  return fitPowerLaw(x, seconds).exponent;
}

void printExponents(const std::string& what, const std::vector<Point>& points) {
  if (points.size() < 2) return;
  // Sizes only approximate the sizes in the options, and grow in steps. So the exponent over the last decade begins at
  // the last size that is at least 8 times smaller than the largest.
  auto decade = points.end() - 1;
  while (decade != points.begin() && decade->x * 8 > points.back().x) --decade;
  const std::span<const Point> last(decade, points.end());
  fmt::print("# {}: time grows as x^{:.2f} from {:.0f} to {:.0f}", what, fitExponent(points), points.front().x,
             points.back().x);
  if (last.size() > 1)
    fmt::print(", as x^{:.2f} over the last decade or so, from {:.0f}", fitExponent(last), last.front().x);
  fmt::print("\n");
  std::fflush(stdout);
}

// Measures the scene and adds the result to `points`, unless the engine refuses it.
void measure(const std::string& series, const std::string& by, const Scene& scene, const Device& device, int resolution,
             const Options& options, double x, std::vector<Point>& points) {
  const Ids ids = makeIds(scene, kBy.at(by), false);
  const std::string row = fmt::format("{},{},{},{},{}", series, by, scene.polygons.size(), ids.count(), resolution);
  try {
    const std::unique_ptr<Engine> engine = makeComputeEngine(device, scene, ids, {.resolution = resolution});
    const std::vector<Direction> directions = sampleDirections(Sampler::iid, kMostDirections, kSeed, 0);
    const auto secondsFor = [&](uint32_t count) {
      return secondsOf([&] { engine->count(std::span(directions).first(count)); });
    };
    secondsFor(1);  // the first dispatch may compile, and lists may grow
    const double fixed_first_s = secondsFor(0),
                 seconds = std::max(options.seconds, fixed_first_s);  // small differences of long times are noise
    uint32_t count = 1;
    for (;;) {
      const double spent_s = secondsFor(count) - fixed_first_s;
      if (spent_s >= seconds || count == kMostDirections) break;
      count = std::min(
          kMostDirections,
          static_cast<uint32_t>(std::ceil(count * std::clamp(1.2 * seconds / std::max(spent_s, 1e-6), 1.5, 16.0))));
    }
    std::vector<double> fixed_s, times_s;
    uint64_t pair_count = 0, samples = 0;
    for (int round = 0; round < options.rounds; ++round) {
      fixed_s.push_back(secondsFor(0));
      PairCounts counts;
      const double spent_s = secondsOf([&] { counts = engine->count(std::span(directions).first(count)); });
      times_s.push_back(std::max(spent_s - fixed_s.back(), 1e-9) / count);
      pair_count = counts.size();
      samples = 0;
      for (const PairCount& pair : counts) samples += pair.count;
    }
    const auto [low, high] = std::minmax_element(times_s.begin(), times_s.end());
    const double time_s = median(times_s);
    fmt::print("{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.0f},{}\n", row, count, 1e3 * time_s, 1e3 * *low, 1e3 * *high,
               1e3 * median(fixed_s), double(samples) / count, pair_count);
    points.push_back({x, time_s});
  } catch (const Error& error) {
    if (error.code() != ErrorCode::limit) throw;
    fmt::print("# refused: {}\n{},,refused,,,,,\n", error.what(), row);
  }
  std::fflush(stdout);
}

void measureAll(const Options& options) {
  const Device device(options.device);
  printPlace(device, VIEWPEEL_SOURCE);
  fmt::print("# medians of {} rounds of {} s and more\n", options.rounds, options.seconds);
  fmt::print(
      "series,by,polygons,ids,resolution,directions,time_ms,fastest_ms,slowest_ms,fixed_ms,counts_per_direction,"
      "pairs\n");
  for (const std::string& series : options.series) {
    std::map<std::string, std::vector<Point>> points;
    if (series == "polygons") {
      for (int step = 0;; ++step) {
        const auto n = static_cast<uint32_t>(std::lround(1000 * std::pow(10, step / 2.0)));
        if (n > options.most_polygons) break;
        const Scene scene = buildScene(city(n));
        for (const std::string& by : options.by)
          measure(series, by, scene, device, options.resolution, options, double(scene.polygons.size()), points[by]);
      }
    } else {
      const Scene scene = buildScene(roomWithBoxes(options.refine));
      for (int resolution = 32; resolution <= options.most_resolution; resolution *= 2)
        for (const std::string& by : options.by)
          measure(series, by, scene, device, resolution, options, double(resolution) * resolution, points[by]);
    }
    for (const auto& [by, measured] : points) printExponents(fmt::format("{} by {}", series, by), measured);
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  bench::Options options;
  CLI::App app("How the compute engine's time per direction grows: CSV on stdout");
  app.add_option("--series", options.series)->check(CLI::IsMember({"polygons", "points"}));
  app.add_option("--by", options.by)->check(CLI::IsMember({"polygon", "surface"}));
  app.add_option("--most-polygons", options.most_polygons)->check(CLI::Range(1000u, 10'000'000u));
  app.add_option("--most-resolution", options.most_resolution)->check(CLI::Range(32, kMaxResolution));
  app.add_option("--resolution", options.resolution, "of the cities' lattice")->check(CLI::Range(1, kMaxResolution));
  app.add_option("--refine", options.refine, "of the room, as in make_scene")->check(CLI::PositiveNumber);
  app.add_option("--rounds", options.rounds)->check(CLI::PositiveNumber);
  app.add_option("--seconds", options.seconds, "of each measurement, at least")->check(CLI::PositiveNumber);
  app.add_option("--device", options.device.selector);
  CLI11_PARSE(app, argc, argv);
  try {
    bench::measureAll(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
