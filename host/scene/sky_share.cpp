#include "scene/sky_share.h"

#include <algorithm>
#include <cmath>

#include "scene/sight.h"

namespace viewpeel {
namespace {

constexpr uint32_t kSets = 8, kRays = 8192;  // sets of rays, and rays of a set

// Returns which share of blocked rays goes up; 1/2 where no ray is blocked.
double blockedAbove(Sight& sight, const std::vector<uint32_t>& polygons, const std::vector<double>& area_sums,
                    double n_z) {
  uint32_t rays[2] = {0, 0}, blocked[2] = {0, 0};  // down, up
  for (uint32_t k = 0; k < kRays; ++k) {
    const uint32_t polygon = polygons[pickBySums(area_sums, sight.uniform() * area_sums.back())];
    const glm::dvec3 point = sight.pointOn(polygon), direction = sight.directionFrom(polygon, true);
    const bool is_up = direction.z > 0;
    ++rays[is_up];
    blocked[is_up] += sight.look(polygon, point, direction).polygon != Sight::kNothing;
  }
  const auto part = [&](bool up) { return rays[up] ? (1 + (up ? n_z : -n_z)) / 2 * blocked[up] / rays[up] : 0.0; };
  return part(false) + part(true) > 0 ? part(true) / (part(false) + part(true)) : 0.5;
}

}  // namespace

std::vector<SkyShare> divideEnvironment(const Scene& scene, const std::vector<std::vector<uint32_t>>& polygons,
                                        const std::vector<double>& environment) {
  Sight sight(scene);
  std::vector<SkyShare> shares;
  for (size_t k = 0; k < polygons.size(); ++k) {
    const std::vector<double> area_sums = sumAreas(scene, polygons[k]);
    const double n_z = frontNormal(scene, scene.polygons[polygons[k].front()]).z;
    double sum = 0, squares = 0;
    for (uint32_t set = 0; set < kSets; ++set) {
      const double share = blockedAbove(sight, polygons[k], area_sums, n_z);
      sum += share, squares += share * share;
    }
    const double mean = sum / kSets, variance = std::max(0.0, squares / kSets - mean * mean) / (kSets - 1);
    const double e = environment[k], sky = std::clamp((1 + n_z) / 2 - mean * (1 - e), 0.0, e);
    shares.push_back({sky, e - sky, std::sqrt(variance) * (1 - e)});
  }
  return shares;
}

}  // namespace viewpeel
