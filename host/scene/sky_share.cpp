#include "scene/sky_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <boost/random/sobol.hpp>

#include "scene/sight.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr uint32_t kSets = 8, kRays = 8192;  // sets of rays, and rays of a set
constexpr double kLeastSquareOfCosine = Sight::kLeastCosine * Sight::kLeastCosine;
constexpr int kNumbersOfSkyRay = 5;  // of a ray: polygon, two for the place of its start, height and turn
using Shifts = std::array<uint64_t, kNumbersOfSkyRay>;

// Returns which share of blocked rays goes up; 1/2 where no ray is blocked. The rays of a set are even: their numbers
// are Sobol' points.    In: shifts: random digits, which are added to those of the points without carry
double blockedAbove(const Sight& sight, const std::vector<uint32_t>& polygons, const std::vector<double>& area_sums,
                    double n_z, const Shifts& shifts) {
  boost::random::sobol points(kNumbersOfSkyRay);
  uint32_t rays[2] = {0, 0}, blocked[2] = {0, 0};  // down, up
  for (uint32_t k = 0; k < kRays; ++k) {
    double u[kNumbersOfSkyRay];
    for (int d = 0; d < kNumbersOfSkyRay; ++d) u[d] = double((points() ^ shifts[d]) >> 11) * 0x1p-53;
    const uint32_t polygon = polygons[pickBySums(area_sums, u[0] * area_sums.back())];
    const glm::dvec3 point = sight.pointOn(polygon, u[1], u[2]),
                     direction = sight.directionFrom(polygon, true, std::lerp(kLeastSquareOfCosine, 1.0, u[3]), u[4]);
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
  const Sight sight(scene);
  std::vector<SkyShare> shares(polygons.size());
  shareOut(threadCount(), polygons.size(), 1, [&](size_t, size_t k) {
    const std::vector<double> area_sums = sumAreas(scene, polygons[k]);
    const double n_z = frontNormal(scene, scene.polygons[polygons[k].front()]).z, e = environment[k];
    std::mt19937_64 random(k);
    double sum = 0, squares = 0;
    for (uint32_t set = 0; set < kSets && e < 1; ++set) {
      Shifts shifts;
      for (uint64_t& shift : shifts) shift = random();
      const double share = blockedAbove(sight, polygons[k], area_sums, n_z, shifts);
      sum += share, squares += share * share;
    }
    const double mean = sum / kSets, variance = std::max(0.0, squares / kSets - mean * mean) / (kSets - 1);
    const double sky = std::clamp((1 + n_z) / 2 - mean * (1 - e), 0.0, e);
    shares[k] = {sky, e - sky, std::sqrt(variance) * (1 - e)};
  });
  return shares;
}

}  // namespace viewpeel
