// This bench measures the cost of counting blocked pairs beside facing pairs. It prints processor time for a direction
// without and with blocked pairs, as CSV on stdout.
//   blocked_cost [--scene room|room4|triangles|FILE]... [--sampling lattice|scanline]... [--resolution PX]...
//   [--directions N] [--rounds N]
// A round counts the same directions first without and then with blocked pairs. A ratio divides the second time of a
// round by its first. Each time includes reading the counters back, once for each call of Engine::count.
#include <ctime>

#include <CLI/CLI.hpp>

#include "directions/sampler.h"
#include "engines/compute_engine.h"
#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/support/measure.h"

namespace viewpeel::bench {
namespace {

constexpr uint32_t kSeed = 1;

struct Options {
  std::vector<std::string> scenes{"room", "room4", "triangles"}, samplings{"lattice", "scanline"};
  std::vector<int> resolutions{64, 128};
  uint32_t directions = 400;
  int rounds = 5;
  bool verbose = false;
  DeviceOptions device;
};

Scene makeScene(const std::string& name) {
  if (name == "room") return buildScene(roomWithBoxes(1));
  if (name == "room4") return buildScene(roomWithBoxes(4));
  if (name == "triangles") return buildScene(randomTriangles(100'000));
  return loadScene(name);
}

void measure(const std::string& name, const Scene& scene, const std::string& sampling, int resolution,
             const Options& options, const Device& device) {
  const Ids ids = makeIds(scene, By::polygon, name == "triangles");
  const uint32_t count = name == "triangles" ? std::max(1u, options.directions / 10) : options.directions;
  const std::vector<Direction> directions = sampleDirections(Sampler::fibonacci, count, kSeed, 0);
  std::array<std::unique_ptr<Engine>, 2> engines;
  std::array<PairCounts, 2> counts;
  std::array<std::vector<double>, 2> times_s;
  std::vector<double> ratios;
  const auto run = [&](int blocked) {
    const std::clock_t start = std::clock();
    counts[blocked] = engines[blocked]->count(directions);
    return double(std::clock() - start) / CLOCKS_PER_SEC;
  };
  for (int blocked : {0, 1}) {
    engines[blocked] = makeComputeEngine(device, scene, ids,
                                         {.resolution = resolution,
                                          .sampling = sampling == "lattice" ? Sampling::lattice : Sampling::scanline,
                                          .count_blocked = blocked == 1,
                                          .measure_work = options.verbose});
    run(blocked);  // compiles, grows lists, settles the tuning
  }
  uint64_t facing = 0, in_all = 0;
  size_t facing_pairs = 0;
  for (const PairCount& c : counts[1]) {
    if (c.j >= kEnvironment) continue;
    facing += c.count;
    in_all += c.count + c.blocked;
    facing_pairs += c.count > 0;
  }
  for (const PairCount& c : counts[0])
    if (c.j < kEnvironment) facing -= c.count;
  if (facing != 0) throw Error(ErrorCode::check, name + ": facing pairs change where blocked ones are counted");
  for (const PairCount& c : counts[0])
    if (c.j < kEnvironment) facing += c.count;
  for (int round = 0; round < options.rounds; ++round) {
    const double off_s = run(0), on_s = run(1);
    times_s[0].push_back(off_s / count);
    times_s[1].push_back(on_s / count);
    ratios.push_back(on_s / off_s);
  }
  const auto [low, high] = std::minmax_element(ratios.begin(), ratios.end());
  fmt::print("{},{},{},{},{},{:.4g},{:.4g},{:.3f},{:.3f},{:.3f},{:.3g},{},{}\n", name, scene.polygons.size(), sampling,
             resolution, count, 1e3 * median(times_s[0]), 1e3 * median(times_s[1]), median(ratios), *low, *high,
             double(in_all - facing) / double(facing), facing_pairs, counts[1].size());
  if (options.verbose)
    for (const auto& engine : engines)
      for (const auto& [pass, seconds] : engine->work()->pass_seconds)
        fmt::print("# {} {:.4g} ms\n", pass, 1e3 * seconds / double(engine->work()->directions));
  std::fflush(stdout);
}

int run(const Options& options) {
  const Device device(options.device);
  printPlace(device, VIEWPEEL_SOURCE);
  fmt::print(
      "scene,polygons,sampling,resolution,directions,cpu_ms_per_direction,cpu_ms_with_blocked,ratio,least_ratio,"
      "largest_ratio,blocked_per_facing,"
      "facing_pairs,pairs\n");
  for (const std::string& name : options.scenes) {
    const Scene scene = makeScene(name);
    for (const std::string& sampling : options.samplings)
      for (int resolution : options.resolutions) measure(name, scene, sampling, resolution, options, device);
  }
  return 0;
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  viewpeel::bench::Options options;
  CLI::App app("Processor time per direction of the compute engine without and with blocked pairs.");
  app.add_option("--scene", options.scenes, "room, room4, triangles or a file")->allow_extra_args(false);
  app.add_option("--sampling", options.samplings)
      ->check(CLI::IsMember({"lattice", "scanline"}))
      ->allow_extra_args(false);
  app.add_option("--resolution", options.resolutions)->allow_extra_args(false);
  app.add_option("--directions", options.directions, "of the rooms; a tenth of triangles")->check(CLI::PositiveNumber);
  app.add_option("--rounds", options.rounds)->check(CLI::PositiveNumber);
  app.add_flag("--verbose", options.verbose, "time of each pass, too");
  app.add_option("--device", options.device.selector);
  CLI11_PARSE(app, argc, argv);
  try {
    return viewpeel::bench::run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
