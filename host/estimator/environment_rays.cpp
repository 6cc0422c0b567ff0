#include "estimator/environment_rays.h"

#include <cmath>

#include <boost/random/sobol.hpp>
#include <glm/glm.hpp>

#include "directions/random.h"
#include "directions/replicates.h"

namespace viewpeel {
namespace {

// The numbers of these replicates follow those of the common directions of measureEnvironment().
constexpr uint64_t kFirstReplicate = kEnvironmentReplicates.first + (uint64_t(1) << 20), kReplicatesOfRow = 16;

}  // namespace

EnvironmentRays::EnvironmentRays(const Scene& scene, const Ids& ids, const glm::dvec3& up, uint64_t seed)
    : sight_(scene), up_(up), seed_(seed), two_sided_(ids.two_sided), polygons_(ids.count()) {
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) polygons_[ids.of_polygon[k]].push_back(k);
  for (const std::vector<uint32_t>& of_row : polygons_) area_sums_.push_back(sumAreas(scene, of_row));
}

void EnvironmentRays::prepare(uint32_t rays) {
  if (rays <= points_.size()) return;
  boost::random::sobol sequence(kDimensions);
  points_.resize(rays);
  for (auto& point : points_)
    for (double& x : point) x = double(sequence()) / (double(boost::random::sobol::max()) + 1);
}

EnvironmentRays::Shares EnvironmentRays::cast(uint32_t row, uint32_t rays, uint32_t replicate) const {
  Random random(seed_, kFirstReplicate + kReplicatesOfRow * row + replicate);
  std::array<double, kDimensions> shift{};
  for (double& x : shift) x = random.uniform();
  uint64_t up = 0, down = 0;
  for (uint32_t ray = 0; ray < rays; ++ray) {
    std::array<double, kDimensions> x = points_[ray];
    for (uint32_t k = 0; k < kDimensions; ++k) x[k] = x[k] + shift[k] < 1 ? x[k] + shift[k] : x[k] + shift[k] - 1;
    bool from_front = true;
    if (two_sided_) {
      from_front = x[4] < 0.5;
      x[4] = from_front ? 2 * x[4] : 2 * x[4] - 1;
    }
    const std::vector<double>& sums = area_sums_[row];
    const uint32_t polygon = polygons_[row][pickBySums(sums, x[4] * sums.back())];
    const glm::dvec3 direction = sight_.directionFrom(polygon, from_front, x[2], x[3]);
    if (sight_.look(polygon, sight_.pointOn(polygon, x[0], x[1]), direction).polygon != Sight::kNothing) continue;
    ++(glm::dot(direction, up_) > 0 ? up : down);
  }
  return {double(up) / rays, double(down) / rays};
}

}  // namespace viewpeel
