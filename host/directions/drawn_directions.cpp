#include "directions/drawn_directions.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "directions/frame.h"
#include "directions/random.h"
#include "directions/sampler.h"

namespace viewpeel {
namespace {

// A ShiftedLattice is a lattice of points in the unit square under one random shift, so each point is uniform in the
// square. It is periodic in the coordinate `around` and folded in `outwards`, where t and 1 - t give the same value.
class ShiftedLattice {
 public:
  ShiftedLattice(uint32_t count, Random& random) : count_(count), shift_(random.uniform()), turn_(random.uniform()) {}

  double around(uint32_t k) const { return fraction(turn_ + k * (std::numbers::phi - 1)); }
  double outwards(uint32_t k) const { return 1 - std::abs(2 * ((k + shift_) / count_) - 1); }

 private:
  static double fraction(double x) { return x - std::floor(x); }
  uint32_t count_;
  double shift_, turn_;
};

}  // namespace

DirectionRegion DirectionRegion::hemisphere(const glm::dvec3& pole) {
  DirectionRegion region;
  const Frame frame = frameAbout(pole);
  for (const glm::dvec3& from : {frame.x, frame.y, -frame.x, -frame.y}) region.arcs_.push_back({from, pole});
  region.close();
  return region;
}

// This clips as I. E. Sutherland & G. W. Hodgman, Reentrant polygon clipping, CACM 17(1), 1974. Corners outside by no
// more than rounding are kept.
void DirectionRegion::clip(const glm::dvec3& inner_normal) {
  std::vector<Arc> kept;
  for (size_t k = 0; k < arcs_.size(); ++k) {
    const glm::dvec3 &a = arcs_[k].from, &b = arcs_[(k + 1) % arcs_.size()].from;
    const double height_a = glm::dot(inner_normal, a), height_b = glm::dot(inner_normal, b);
    const bool a_inside = height_a >= -8 * kUnitRounding, b_inside = height_b >= -8 * kUnitRounding;
    if (a_inside) kept.push_back(arcs_[k]);
    if (a_inside == b_inside) continue;
    const double to_b = std::max(0.0, a_inside ? height_a : -height_a),
                 to_a = std::max(0.0, b_inside ? height_b : -height_b);
    kept.push_back({glm::normalize(a * to_a + b * to_b), a_inside ? inner_normal : arcs_[k].inner_normal});
  }
  // The new arc may be half a circle long. It is then cut in two, a quarter of a circle from its start.
  for (size_t k = 0; k < kept.size(); ++k) {
    const glm::dvec3 &a = kept[k].from, &b = kept[(k + 1) % kept.size()].from;
    if (glm::dot(a, b) < 0 && kept[k].inner_normal == inner_normal) {
      kept.insert(kept.begin() + ptrdiff_t(k) + 1, {glm::normalize(glm::cross(inner_normal, a)), inner_normal});
      break;
    }
  }
  arcs_ = std::move(kept);
}

void DirectionRegion::close() {
  if (arcs_.empty()) return;
  centre_ = glm::dvec3(0);
  for (const Arc& arc : arcs_) centre_ += arc.from;
  // The sum of the corners is 0 only for a half sphere, whose centre is the normal of any arc.
  centre_ = glm::length(centre_) > 1e-6 ? glm::normalize(centre_) : arcs_[0].inner_normal;
  double solid_angle = 0;
  for (size_t k = 0; k < arcs_.size(); ++k) {
    Arc& arc = arcs_[k];
    const glm::dvec3 across = glm::cross(arc.inner_normal, centre_);
    const double sine = std::max(0.0, glm::dot(arc.inner_normal, centre_)), cosine = glm::length(across);
    // Where the centre is the circle's pole, all points of the circle are equally near, and any will do. The second
    // line removes the part along the normal that rounding has left.
    arc.along = glm::normalize(cosine > 1e-14 ? across : glm::cross(arc.inner_normal, arc.from));
    arc.along = glm::normalize(arc.along - arc.inner_normal * glm::dot(arc.inner_normal, arc.along));
    arc.foot = glm::cross(arc.along, arc.inner_normal);
    arc.half_tangent = sine / (1 + cosine);
    const auto distanceTo = [&arc](const glm::dvec3& v) {
      return std::atan2(glm::dot(v, arc.along), glm::dot(v, arc.foot));
    };
    const auto areaTo = [&arc](double distance_rad) {
      return 2 * std::atan(arc.half_tangent * std::tan(distance_rad / 2));
    };
    const double first_rad = distanceTo(arc.from), last_rad = distanceTo(arcs_[(k + 1) % arcs_.size()].from);
    arc.first_area = areaTo(first_rad);
    double area = areaTo(last_rad) - arc.first_area;
    if (first_rad > kPi / 4 && last_rad < -kPi / 4) area += 2 * kPi;  // the arc runs past the point opposite the foot
    solid_angle += std::max(0.0, area);
    arc.solid_angle_to_here = solid_angle;
  }
  if (!(solid_angle > 0)) arcs_.clear();
}

bool DirectionRegion::contains(const glm::dvec3& u) const {
  return !arcs_.empty() &&
         std::ranges::all_of(arcs_, [&](const Arc& arc) { return glm::dot(arc.inner_normal, u) >= -kAngleMargin; });
}

glm::dvec3 DirectionRegion::map(double around, double outwards) const {
  assert(!arcs_.empty());
  const double target = around * solidAngle();
  auto arc = std::ranges::upper_bound(arcs_, target, {}, &Arc::solid_angle_to_here);
  if (arc == arcs_.end()) --arc;
  const double before = arc == arcs_.begin() ? 0 : std::prev(arc)->solid_angle_to_here;
  const double area = arc->first_area + (target - before);
  // `half` is half the angle from the foot to the point on the boundary.
  const double half = std::atan2(std::sin(area / 2), arc->half_tangent * std::cos(area / 2));
  const glm::dvec3 edge = std::cos(2 * half) * arc->foot + std::sin(2 * half) * arc->along;
  // Along the arc from the centre to the boundary, 1 - cos(distance) is uniform. It is half the square of the chord.
  const glm::dvec3 out = edge - centre_, tangent = out - centre_ * glm::dot(centre_, out);
  if (!(glm::length(tangent) > 0)) return centre_;
  const double chord_squared = outwards * glm::dot(out, out);
  return glm::normalize(centre_ * (1 - chord_squared / 2) +
                        glm::normalize(tangent) * std::sqrt(chord_squared * std::max(0.0, 1 - chord_squared / 4)));
}

DrawnDirections sampleRegion(const DirectionRegion& region, uint32_t count, uint64_t seed, uint64_t replicate) {
  if (region.isEmpty()) return {{}, {}, 0};
  Random random(seed, replicate);
  const ShiftedLattice lattice(count, random);
  DrawnDirections requested{{}, std::vector<uint32_t>(count, 1), region.solidAngle() / (2 * kPi)};
  requested.directions.reserve(count);
  for (uint32_t k = 0; k < count; ++k)
    requested.directions.push_back(directionAlong(region.map(lattice.around(k), lattice.outwards(k)), random));
  return requested;
}

DrawnDirections sampleEmitter(const Scene& scene, std::span<const uint32_t> emitter, uint32_t count, uint64_t seed,
                              uint64_t replicate) {
  const glm::dvec3 normal = commonFront(scene, emitter);
  if (normal == glm::dvec3(0))
    return {sampleDirections(Sampler::fibonacci, count, seed, replicate), std::vector<uint32_t>(count, 1), 1};
  Random random(seed, replicate);
  const ShiftedLattice lattice(count, random);
  const Frame frame = frameAbout(normal);
  DrawnDirections requested{{}, {}, kEmitterWeightUnit};
  requested.directions.reserve(count);
  requested.weights.reserve(count);
  constexpr double e = kUniformShare;
  for (uint32_t k = 0; k < count; ++k) {
    // The density (11) is drawn by inversion: (1 - e) cos^2 + e cos is uniform in [0, 1].
    const double share = lattice.outwards(k), cosine = 2 * share / (e + std::sqrt(e * e + 4 * (1 - e) * share));
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)), azimuth_rad = 2 * kPi * lattice.around(k);
    const glm::dvec3 across = std::cos(azimuth_rad) * frame.x + std::sin(azimuth_rad) * frame.y;
    requested.directions.push_back(directionAlong(sine * across + cosine * normal, random));
    requested.weights.push_back(
        uint32_t(std::floor(1 / (2 * (1 - e) * cosine + e) / kEmitterWeightUnit + random.uniform())));
  }
  return requested;
}

}  // namespace viewpeel
