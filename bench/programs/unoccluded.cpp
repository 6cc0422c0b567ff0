// This bench measures speed and accuracy of the exchange areas of all pairs of a scene's polygons. It prints CSV on
// stdout.
//   unoccluded [--refine N] [--triangles N] [--drawn PAIRS] [--checked PAIRS] [--chunk PAIRS] [--near PAIRS]
//     [--device D]
//
// Pairs are the fronts of a room with boxes, or of N random triangles. The bench computes all pairs, or with --drawn a
// given number of random ones, in calls of about a million. It compares a random sample with the reference. cpu_seconds
// exclude time in which other work has the cores.
#include <sys/resource.h>

#include <cmath>
#include <random>

#include <CLI/CLI.hpp>

#include "unoccluded/unoccluded.h"
#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/support/measure.h"
#include "reference/closed_forms/contour_integral.h"

namespace viewpeel::bench {
namespace {

constexpr size_t kPairsPerCall = 1u << 20;
constexpr uint64_t kSeed = 61;

struct Options {
  uint32_t refine = 4, triangles = 0, checked = 300;
  uint64_t drawn = 0;
  UnoccludedOptions exchange;
  DeviceOptions device;
};

double processSeconds() {
  rusage usage;
  ::getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

double residentMiB() {
  rusage usage;
  ::getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

// Calls use(pairs) with all pairs i < j of fronts, some at a time.
template <class Use>
void forAllPairs(uint32_t polygon_count, Use use) {
  std::vector<SidePair> pairs;
  for (uint32_t i = 0; i < polygon_count; ++i)
    for (uint32_t j = i + 1; j < polygon_count; ++j) {
      pairs.push_back({frontSide(i), frontSide(j)});
      if (pairs.size() == kPairsPerCall) {
        use(pairs);
        pairs.clear();
      }
    }
  if (!pairs.empty()) use(pairs);
}

// Calls use(pairs) with pair_count random pairs of fronts, some at a time.
template <class Use>
void forDrawnPairs(uint32_t polygon_count, uint64_t pair_count, Use use) {
  std::mt19937_64 random(kSeed + 1);
  for (uint64_t left = pair_count; left > 0;) {
    std::vector<SidePair> pairs(std::min<uint64_t>(left, kPairsPerCall));
    for (SidePair& pair : pairs)
      pair = {frontSide(uint32_t(random() % polygon_count)), frontSide(uint32_t(random() % polygon_count))};
    use(pairs);
    left -= pairs.size();
  }
}

std::vector<glm::dvec3> cornersOf(const Scene& scene, uint32_t polygon_index) {
  const Polygon& polygon = scene.polygons[polygon_index];
  return {scene.corners.begin() + polygon.first_corner,
          scene.corners.begin() + polygon.first_corner + polygon.corner_count};
}

// Sample has random pairs and their exchange areas.
struct Sample {
  std::vector<SidePair> pairs;
  std::vector<double> areas;
};

void check(const Scene& scene, const Sample& sample) {
  double worst = 0, relative = 0;
  uint64_t unsettled = 0;
  for (size_t k = 0; k < sample.pairs.size(); ++k) {
    uint32_t i = sample.pairs[k].i / 2, j = sample.pairs[k].j / 2;
    if (scene.polygons[i].area > scene.polygons[j].area) std::swap(i, j);
    try {
      const double truth = reference::formFactor(cornersOf(scene, i), cornersOf(scene, j)),
                   error = std::abs(sample.areas[k] / scene.polygons[i].area - truth);
      worst = std::max(worst, error / std::max(kUnoccludedRelativeError * truth, kUnoccludedAbsoluteError));
      if (truth > 0) relative = std::max(relative, error / truth);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::limit) throw;
      ++unsettled;
    }
  }
  fmt::print("# {} pairs against the reference ({} beyond it): at most {:.2g} of the error allowed, {:.1e} relative\n",
             sample.pairs.size(), unsettled, worst, relative);
}

// Prints the cost of each pass. cpu_s is divided in proportion to the times on the device, which themselves include
// waiting for other work.
void printClasses(const UnoccludedWork& work, double cpu_s) {
  double all_s = 0, near_s = 0;
  fmt::print("pass,pairs,device_seconds,cpu_ns_per_pair\n");
  for (const auto& [pass, pass_s] : work.pass_seconds) all_s += pass_s;
  const auto print = [&](const std::string& pass, uint64_t pairs, double pass_s) {
    fmt::print("{},{},{:.2f},{:.0f}\n", pass, pairs, pass_s, pairs ? 1e9 * cpu_s * pass_s / all_s / double(pairs) : 0);
  };
  for (const auto& [pass, pass_s] : work.pass_seconds) {
    if (pass == "classify") print(pass, work.pairs, pass_s);
    else if (pass.starts_with("far ")) print(pass, work.far_pairs[size_t(pass.back() - '2')], pass_s);
    else near_s += pass_s;
  }
  print("near", work.near_pairs, near_s);
}

void measure(const Options& options) {
  const Device device(options.device);
  printPlace(device, VIEWPEEL_SOURCE);
  const Scene scene =
      buildScene(options.triangles ? randomTriangles(options.triangles) : roomWithBoxes(options.refine));
  const auto polygon_count = static_cast<uint32_t>(scene.polygons.size());
  const double resident_before = residentMiB();
  std::unique_ptr<UnoccludedExchange> exchange;
  const double set_up_s = secondsOf([&] {
    exchange = std::make_unique<UnoccludedExchange>(device, scene, options.exchange);
    std::vector<double> area(1);
    exchange->compute(std::vector<SidePair>{{frontSide(0), frontSide(polygon_count - 1)}}, area);
  });

  std::mt19937_64 random(kSeed);
  const double pair_count = options.drawn ? double(options.drawn) : 0.5 * polygon_count * (polygon_count - 1.0),
               share = options.checked / pair_count;
  Sample sample;
  std::vector<double> areas(kPairsPerCall);
  double seconds = 0;
  uint64_t unreached = 0;
  const double before_s = processSeconds();
  const auto use = [&](const std::vector<SidePair>& pairs) {
    const std::span<double> found = std::span(areas).first(pairs.size());
    seconds += secondsOf([&] { unreached += exchange->compute(pairs, found).size(); });
    std::binomial_distribution<size_t> draws(pairs.size(), share);
    for (size_t left = draws(random); left > 0; --left) {
      const size_t k = std::uniform_int_distribution<size_t>(0, pairs.size() - 1)(random);
      sample.pairs.push_back(pairs[k]);
      sample.areas.push_back(found[k]);
    }
  };
  if (options.drawn) forDrawnPairs(polygon_count, options.drawn, use);
  else forAllPairs(polygon_count, use);
  const double cpu_s = processSeconds() - before_s;
  const UnoccludedWork& work = exchange->work();
  fmt::print(
      "polygons,pairs,unseen,near,again,line_integrals,unreached,seconds,cpu_seconds,pairs_per_second,set_up_seconds,"
      "resident_mib,added_mib\n");
  fmt::print("{},{},{},{},{},{},{},{:.2f},{:.2f},{:.3g},{:.2f},{:.0f},{:.0f}\n", polygon_count, work.pairs,
             work.unseen_pairs, work.near_pairs, work.again_pairs, work.line_integrals, unreached, seconds, cpu_s,
             double(work.pairs) / seconds, set_up_s, residentMiB(), residentMiB() - resident_before);
  printClasses(work, cpu_s);
  check(scene, sample);
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  bench::Options options;
  CLI::App app("Exchange areas of all pairs of a scene: CSV on stdout");
  app.add_option("--refine", options.refine, "of the room, as in make_scene: 4 for 9,984 quads")
      ->check(CLI::PositiveNumber);
  app.add_option("--triangles", options.triangles, "random ones, in place of the room")->check(CLI::PositiveNumber);
  app.add_option("--drawn", options.drawn, "pairs drawn at random, in place of all");
  app.add_option("--checked", options.checked, "pairs to compare with the reference, about");
  app.add_option("--chunk", options.exchange.chunk_pairs)->check(CLI::PositiveNumber);
  app.add_option("--near", options.exchange.near_pairs)->check(CLI::PositiveNumber);
  app.add_option("--device", options.device.selector);
  CLI11_PARSE(app, argc, argv);
  try {
    bench::measure(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
