// This bench measures how the time of exact areas grows with polygons and cuts, on one core, for random directions. It
// prints CSV on stdout.
//   exact_growth [SCENE]...     built-in offices and triangle soups without arguments
// Up to 1,000 polygons exact sums are affordable, and verify every direction before it is timed.
#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/core.h>
#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "scenes/exact_scenes.h"
#include "reference/exact/exact_pair_areas.h"
#include "stopwatch.h"

namespace viewpeel {
namespace {

using namespace reference;

constexpr int kDirectionCount = 9;

void measure(const std::string& name, const Scene& scene) {
  const auto start_check = Clock::now();
  requireDisjoint(scene);
  const double check_s = secondsSince(start_check);

  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<double> times_s, cuts;
  double largest_error = 0;
  size_t pair_count = 0, open_count = 0;
  for (int k = 0; k < kDirectionCount; ++k) {
    const glm::dvec3 u = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    if (scene.polygons.size() <= 1000) {
      ExactOptions options;
      options.arithmetic = Arithmetic::exact;
      const ExactPairAreas exact = computeExactPairAreas(scene, u, options);
      open_count += exact.open_pairs.size() + exact.open_polygons.size();
    }
    const auto start = Clock::now();
    const ExactPairAreas areas = computeExactPairAreas(scene, u);
    times_s.push_back(secondsSince(start) - check_s);
    cuts.push_back(static_cast<double>(areas.cut_count));
    pair_count += areas.pairs.size();
    for (const PairArea& pair : areas.pairs) largest_error = std::max(largest_error, pair.error);
  }
  std::sort(times_s.begin(), times_s.end());
  std::sort(cuts.begin(), cuts.end());
  fmt::print("{},{},{:.0f},{},{},{:.1e},{:.4f},{:.4f},{:.4f},{:.4f}\n", name, scene.polygons.size(),
             cuts[kDirectionCount / 2], pair_count / kDirectionCount, open_count, largest_error, check_s,
             times_s.front(), times_s[kDirectionCount / 2], times_s.back());
}

}  // namespace
}  // namespace viewpeel

int main(int argument_count, char** arguments) {
  using namespace viewpeel;
  try {
    fmt::print("scene,polygons,median_cuts,pairs,open_sums,largest_error,check_s,fastest_s,median_s,slowest_s\n");
    for (int k = 1; k < argument_count; ++k) measure(arguments[k], loadScene(arguments[k]));
    if (argument_count > 1) return 0;
    for (const auto& [desks, parts] : {std::pair(2u, 1u), {4u, 1u}, {4u, 2u}, {4u, 4u}, {8u, 4u}})
      measure(fmt::format("office {0}x{0} desks / {1}", desks, parts), tests::makeOffice(desks, parts));
    for (const uint32_t count : {600u, 2400u, 10'000u})
      measure(fmt::format("soup {}", count), tests::makeSoup(count, 1));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
