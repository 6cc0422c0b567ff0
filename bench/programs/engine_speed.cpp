// This bench compares the speed of the compute and the host engine with Embree on the same cores. It interleaves
// rounds, and prints CSV on stdout.
//   engine_speed [--scene NAME] [--resolution PX] [--by polygon|surface] [--rounds N] [--seconds S]
// Methods: `viewpeel` is the compute engine on lattices, `host` the host engine on the same lattices, and
// `host_scanlines` its scanlines. A scanline counts one sample for every lattice point of its length. `embree_lines_*`
// trace and sort the lines of the same lattices. `embree_rays_*` shoot rays from the surfaces.
// A sample is a facing pair on a line, or a ray that ends on a front. Other rays cost time and are not counted. The
// time goes from directions or rays to all counts in the order of pairs. It leaves out the fixed cost of reading and
// emptying the counters, which every round measures. Debian builds Embree with assertions on, so Embree's own release
// build may be faster.
#include <cmath>
#include <functional>
#include <optional>

#include <CLI/CLI.hpp>

#include "directions/sampler.h"
#include "bench/rivals/embree_rivals.h"
#include "engines/compute_engine.h"
#include "engines/host_engine.h"
#include "engines/lattice.h"
#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/support/measure.h"

namespace viewpeel::bench {
namespace {

constexpr uint32_t kMostDirections = 1u << 16;
constexpr uint32_t kSeed = 1;

struct Options {
  int rounds = 3;
  double seconds = 0.25;
  std::vector<std::string> scenes{"room", "room4", "triangles"};
  std::vector<int> resolutions{64, 128, 256, 512};
  By by = By::polygon;
  DeviceOptions device;
};

// Method is one way to count. count(n) counts n directions, or n groups of rays, and returns samples. count(0) has only
// the fixed cost.
struct Method {
  std::string name;
  bool has_directions;
  std::function<uint64_t(uint64_t)> count;
  uint64_t amount = 1;
  std::vector<double> directions_per_second = {}, samples_per_second = {};

  double fixedSeconds() const {
    return secondsOf([&] { count(0); });
  }
  // Returns the samples and the seconds without the fixed cost.
  std::pair<uint64_t, double> run(uint64_t n) const {
    const double fixed_s = fixedSeconds();
    uint64_t samples = 0;
    const double spent_s = secondsOf([&] { samples = count(n); });
    return {samples, std::max(spent_s - fixed_s, 1e-9)};
  }
};

// Chooses the amount of work for least_seconds, and warms up: the first dispatch on a device may compile. A method with
// a fixed cost runs at least as long as this cost, for a small difference of two long times is noise.
void calibrate(Method& method, double least_seconds) {
  const uint64_t most = method.has_directions ? kMostDirections : 1u << 30;
  method.run(1);
  const double seconds = std::max(least_seconds, method.fixedSeconds());
  for (;;) {
    const double spent_s = method.run(method.amount).second;
    if (spent_s >= seconds || method.amount == most) return;
    const double factor = std::clamp(1.2 * seconds / std::max(spent_s, 1e-6), 1.5, 16.0);
    method.amount = std::min<uint64_t>(most, static_cast<uint64_t>(std::ceil(double(method.amount) * factor)));
  }
}

uint64_t facingPairs(const PairCounts& counts) {
  uint64_t sum = 0;
  for (const PairCount& count : counts)
    if (count.j < kEnvironment) sum += count.count;
  return sum;
}

// Returns the sum of |a - b| over all pairs, environment and leak.
uint64_t distance(const PairCounts& a, const PairCounts& b) {
  uint64_t sum = 0;
  size_t at = 0;
  for (const PairCount& count : a) {
    for (; at < b.size() && std::pair(b[at].i, b[at].j) < std::pair(count.i, count.j); ++at) sum += b[at].count;
    const bool both = at < b.size() && b[at].i == count.i && b[at].j == count.j;
    const uint64_t other = both ? b[at++].count : 0;
    sum += std::max(count.count, other) - std::min(count.count, other);
  }
  for (; at < b.size(); ++at) sum += b[at].count;
  return sum;
}

void verify(Engine& engine, EmbreeRivals& embree, std::span<const Direction> directions, int resolution) {
  const PairCounts ours = engine.count(directions);
  embree.countLines(Trace::packets_of_8, directions, resolution);
  const PairCounts theirs = embree.takeCounts();
  const double pairs = double(facingPairs(ours));
  fmt::print(
      "# check over {} directions: facing pairs per direction {:.0f}, Embree/viewpeel {:.6f}, counts that differ "
      "{:.2e} of them\n",
      directions.size(), pairs / double(directions.size()), double(facingPairs(theirs)) / pairs,
      double(distance(ours, theirs)) / pairs);
}

// MeasuredCase is one scene at one resolution, with all methods that can count it.
class MeasuredCase {
 public:
  MeasuredCase(const std::string& name, const Scene& scene, const Ids& ids, EmbreeRivals& embree, const Device& device,
               int resolution)
      : name_(name), polygon_count_(scene.polygons.size()), resolution_(resolution), embree_(embree) {
    addEngine("viewpeel", [&] { return makeComputeEngine(device, scene, ids, {.resolution = resolution}); });
    addEngine("host", [&] { return makeHostEngine(scene, ids, {.resolution = resolution}); });
    addEngine("host_scanlines",
              [&] { return makeHostEngine(scene, ids, {.resolution = resolution, .sampling = Sampling::scanline}); });
    engine_count_ = methods_.size();
    addRivals();
  }
  MeasuredCase(const MeasuredCase&) = delete;

  void measure(const Options& options) {
    for (Method& method : methods_) calibrate(method, options.seconds);
    for (int round = 0; round < options.rounds; ++round)
      for (Method& method : methods_) {
        const auto [samples, spent_s] = method.run(method.amount);
        method.directions_per_second.push_back(double(method.amount) / spent_s);
        method.samples_per_second.push_back(double(samples) / spent_s);
      }
  }

  void print() const {
    double best_lines = 0, best_rays = 0, best_directions = 0;
    for (size_t k = 0; k < methods_.size(); ++k) {
      const Method& method = methods_[k];
      const double samples = samplesOf(method), per_second = median(method.directions_per_second);
      printRow(method.name, method.has_directions ? fmt::format("{:.4g}", per_second) : "", samples);
      if (!method.has_directions) {
        best_rays = std::max(best_rays, samples);
      } else if (k >= engine_count_ && samples > best_lines) {
        best_lines = samples;
        best_directions = per_second;
      }
    }
    printRow("embree_lines_best", fmt::format("{:.4g}", best_directions), best_lines);
    printRow("embree_rays_best", "", best_rays);
    printSpread();
    for (size_t k = 0; k < engine_count_; ++k)
      fmt::print("# {}/Embree: lines {:.2f}, rays {:.2f}\n", methods_[k].name, samplesOf(methods_[k]) / best_lines,
                 samplesOf(methods_[k]) / best_rays);
    std::fflush(stdout);
  }

 private:
  static double samplesOf(const Method& method) { return median(method.samples_per_second); }
  std::span<const Direction> first(uint64_t count) const { return std::span(directions_).first(count); }

  // Adds an engine, and verifies it if it counts lattice points. Prints the reason if it refuses the scene.
  void addEngine(const std::string& method, const std::function<std::unique_ptr<Engine>()>& make) {
    try {
      const std::shared_ptr<Engine> engine = make();
      const double points_each = engine->unitArea() / pointArea(resolution_);  // lattice points that a count stands for
      if (points_each == 1) verify(*engine, embree_, first(4), resolution_);
      methods_.push_back({method, true, [=, this](uint64_t count) {
                            return static_cast<uint64_t>(double(facingPairs(engine->count(first(count)))) *
                                                         points_each);
                          }});
    } catch (const Error& error) {
      if (error.code() != ErrorCode::limit) throw;
      fmt::print("# {} refused: {}\n{},{},{},{},refused,refused,\n", method, error.what(), name_, polygon_count_,
                 resolution_, method);
    }
  }

  void addRivals() {
    const std::pair<Trace, const char*> traces[] = {
        {Trace::single, "single"}, {Trace::packets_of_8, "packets"}, {Trace::streams, "streams"}};
    for (const auto& [trace, suffix] : traces)
      methods_.push_back({fmt::format("embree_lines_{}", suffix), true, [this, trace = trace](uint64_t count) {
                            const uint64_t samples = embree_.countLines(trace, first(count), resolution_);
                            embree_.takeCounts();
                            return samples;
                          }});
    for (const auto& [trace, suffix] : traces)
      methods_.push_back({fmt::format("embree_rays_{}", suffix), false, [this, trace = trace](uint64_t count) {
                            const RayCount counted = embree_.shootRays(trace, 64 * count, seed_++);
                            embree_.takeCounts();
                            rays_ += counted.rays;
                            ray_samples_ += counted.samples;
                            return counted.samples;
                          }});
  }

  void printRow(const std::string& method, const std::string& directions_text, double samples) const {
    fmt::print("{},{},{},{},{},{:.4g},{}\n", name_, polygon_count_, resolution_, method, directions_text, samples,
               engine_count_ ? fmt::format("{:.3f}", samples / samplesOf(methods_.front())) : "");
  }

  void printSpread() const {
    std::string spread;
    for (const Method& method : methods_) {
      const auto [low, high] = std::minmax_element(method.samples_per_second.begin(), method.samples_per_second.end());
      spread += fmt::format(" {} {:.2f}", method.name, *high / *low);
    }
    fmt::print("# fastest over slowest round:{}\n# rays that ended on a front: {:.4f} of all\n", spread,
               double(ray_samples_) / double(rays_));
  }

  std::string name_;
  size_t polygon_count_;
  int resolution_;
  EmbreeRivals& embree_;
  std::vector<Direction> directions_ = sampleDirections(Sampler::iid, kMostDirections, kSeed, 0);
  std::vector<Method> methods_;  // engines come first
  size_t engine_count_ = 0;
  uint64_t seed_ = kSeed, rays_ = 0, ray_samples_ = 0;
};

void measureAll(const Options& options) {
  const Device device(options.device);
  printPlace(device, VIEWPEEL_SOURCE);
  fmt::print(
      "# Embree {}; counters by {}; medians of {} rounds of {} s and more; ratio_to_viewpeel: samples per second, "
      "method / viewpeel\n",
      embreeVersion(), options.by == By::polygon ? "polygon" : "surface", options.rounds, options.seconds);
  fmt::print("scene,polygons,resolution,method,directions_per_second,samples_per_second,ratio_to_viewpeel\n");
  for (const std::string& name : options.scenes) {
    const bool triangles = name == "triangles";
    const Scene scene = buildScene(triangles ? randomTriangles(100'000) : roomWithBoxes(name == "room" ? 1 : 4));
    const Ids ids =
        makeIds(scene, options.by, triangles);  // two-sided where fronts are random, so that every gap counts
    EmbreeRivals embree(scene, ids);
    for (int resolution : options.resolutions) {
      MeasuredCase measured(name, scene, ids, embree, device, resolution);
      measured.measure(options);
      measured.print();
    }
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  bench::Options options;
  std::string by = "polygon";
  CLI::App app("The compute engine beside Embree on the same cores: CSV on stdout");
  app.add_option("--scene", options.scenes)->check(CLI::IsMember({"room", "room4", "triangles"}));
  app.add_option("--resolution", options.resolutions)->check(CLI::Range(1, kMaxResolution));
  app.add_option("--by", by)->check(CLI::IsMember({"polygon", "surface"}));
  app.add_option("--rounds", options.rounds)->check(CLI::PositiveNumber);
  app.add_option("--seconds", options.seconds, "of each measurement, at least")->check(CLI::PositiveNumber);
  app.add_option("--device", options.device.selector);
  CLI11_PARSE(app, argc, argv);
  options.by = by == "polygon" ? By::polygon : By::surface;
  try {
    bench::measureAll(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
