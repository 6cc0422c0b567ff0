#include "directions/drawn_directions.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "directions/random.h"
#include "directions/sampler.h"

namespace viewpeel {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kUnitRounding = std::numeric_limits<double>::epsilon();
constexpr double kAngleMargin = 0x1p-46;  // rad: above the rounding of unit vectors and their products
constexpr double kOpenCone = 0.02;  // cosine from the axis below which a cone of directions counts as a half sphere
constexpr size_t kMostDifferences = 1u << 20;

using Corners = std::vector<glm::dvec3>;

struct Frame {
  glm::dvec3 x, y;
};

// Returns a frame with x, y, along right-handed.
Frame frameAbout(const glm::dvec3& along) {
  const glm::dvec3 helper = std::abs(along.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, along));
  return {x, glm::cross(along, x)};
}

// --- the pair's region
// ------------------------------------------------------------------------------------------------

struct Plate {
  Corners corners;
  Corners given;  // before clipping
  glm::dvec3 front{0};
};

Plate plateOf(const Scene& scene, uint32_t polygon_index, const glm::dvec3& origin) {
  const Polygon& polygon = scene.polygons[polygon_index];
  Plate plate;
  for (uint32_t k = 0; k < polygon.corner_count; ++k)
    plate.corners.push_back(scene.corners[polygon.first_corner + k] - origin);
  plate.given = plate.corners;
  plate.front = scene.planes[polygon.plane].normal * (polygon.front_along_plane_normal ? 1.0 : -1.0);
  return plate;
}

double extentOf(const Plate& plate) {
  double extent = 0;
  for (const glm::dvec3& corner : plate.corners) extent = std::max(extent, glm::length(corner));
  return extent;
}

// Returns how far the corners are off the plane of the first.
double roughnessOf(const Plate& plate) {
  double roughness = 0;
  for (const glm::dvec3& corner : plate.corners)
    roughness = std::max(roughness, std::abs(glm::dot(plate.front, corner - plate.corners[0])));
  return roughness;
}

// Returns the part of `corners` in front of the plate's plane; corners within `slack` of it stay as they are. Empty
// where none is further in front.
Corners clipToFront(const Corners& corners, const Plate& plate, double slack) {
  const auto heightOf = [&](const glm::dvec3& corner) { return glm::dot(plate.front, corner - plate.corners[0]); };
  Corners kept;
  bool any = false;
  for (size_t k = 0; k < corners.size(); ++k) {
    const glm::dvec3 &a = corners[k], &b = corners[(k + 1) % corners.size()];
    const double height_a = heightOf(a), height_b = heightOf(b);
    any |= height_a > slack;
    if (height_a >= -slack) kept.push_back(a);
    if ((height_a > slack && height_b < -slack) || (height_a < -slack && height_b > slack))
      kept.push_back(a + (b - a) * (height_a / (height_a - height_b)));
  }
  if (!any) kept.clear();
  return kept;
}

// Returns whether polygons of one plane overlap by more than `slack`: no edge of one has all of the other outside
// (separating axes).
bool overlapInPlane(const Plate& a, const Plate& b, double slack) {
  for (const auto& [one, other] : {std::pair(&a, &b), std::pair(&b, &a)})
    for (size_t k = 0; k < one->corners.size(); ++k) {
      const glm::dvec3 start = one->corners[k], edge = one->corners[(k + 1) % one->corners.size()] - start;
      if (!(glm::length(edge) > 0)) continue;
      const glm::dvec3 inwards = glm::normalize(glm::cross(one->front, edge));
      if (std::ranges::all_of(other->corners,
                              [&](const glm::dvec3& corner) { return glm::dot(inwards, corner - start) <= slack; }))
        return false;
    }
  return true;
}

// A SeenPair is the part of two convex polygons that enters a region: the corners that fronts of the other see, and a
// bound on their movement by rounding.
struct SeenPair {
  Plate a, b;
  double slack = 0;
  bool in_contact = false;  // one plane, facing, overlapping
  bool isEmpty() const { return a.corners.empty() || b.corners.empty(); }
};

SeenPair clipPair(const Scene& scene, uint32_t a_index, uint32_t b_index, bool two_sided) {
  const glm::dvec3 origin = scene.corners[scene.polygons[a_index].first_corner];
  SeenPair seen{plateOf(scene, a_index, origin), plateOf(scene, b_index, origin)};
  const Plate a = seen.a, b = seen.b;
  const double roughness = std::max(roughnessOf(a), roughnessOf(b));
  seen.slack = 16 * kUnitRounding * std::max(extentOf(a), extentOf(b)) + 2 * roughness;

  const double slack = seen.slack;
  const auto isFlat = [slack](const Corners& corners, const Plate& plate) {
    return std::ranges::all_of(corners, [&](const glm::dvec3& corner) {
      return std::abs(glm::dot(plate.front, corner - plate.corners[0])) <= slack;
    });
  };
  const bool one_plane =
      scene.polygons[a_index].plane == scene.polygons[b_index].plane || (isFlat(a.corners, b) && isFlat(b.corners, a));
  if (one_plane) {
    seen.in_contact = (two_sided || glm::dot(a.front, b.front) < 0) && a_index != b_index &&
                      overlapInPlane(a, b, slack - 2 * roughness);
    if (!seen.in_contact) seen.a.corners.clear();
  } else if (!two_sided) {
    seen.a.corners = clipToFront(a.corners, b, slack);
    seen.b.corners = clipToFront(b.corners, a, slack);
  }
  return seen;
}

// Appends normals of planes that separate the two plates, one for every edge of `near`. The plane is turned about the
// edge from near's own plane, away from near, until it touches `far`. So near lies on one side of it and far on the
// other, and the normal points towards far. An edge whose plane rounding makes doubtful is left out.
void appendSeparatingNormals(const Plate& near, const Plate& far, double slack, std::vector<glm::dvec3>& normals) {
  for (size_t k = 0; k < near.corners.size(); ++k) {
    const glm::dvec3 start = near.corners[k], edge = near.corners[(k + 1) % near.corners.size()] - start;
    if (glm::length(edge) <= 4 * slack) continue;
    const glm::dvec3 inwards = glm::normalize(glm::cross(near.front, edge));
    double angle_rad = kPi;
    for (const glm::dvec3& corner : far.corners) {
      const double in = glm::dot(inwards, corner - start), up = std::max(0.0, glm::dot(near.front, corner - start));
      const double distance = std::hypot(in, up);
      // A corner on the line of the edge does not limit the plane's turn.
      if (distance > slack) angle_rad = std::min(angle_rad, std::atan2(up, in) - 2 * slack / distance - kAngleMargin);
    }
    if (angle_rad <= 0) continue;
    const glm::dvec3 normal = glm::normalize(std::cos(angle_rad) * near.front - std::sin(angle_rad) * inwards);
    const bool separates =
        std::ranges::all_of(near.corners,
                            [&](const glm::dvec3& c) { return glm::dot(normal, c - start) <= 2 * slack; }) &&
        std::ranges::all_of(far.corners,
                            [&](const glm::dvec3& c) { return glm::dot(normal, c - start) >= -2 * slack; });
    if (separates) normals.push_back(normal);
  }
}

struct Difference {
  glm::dvec3 d;  // unit length
  double error_rad = 0;
};

// Returns whether a corner made by clipping is too close to another one for the direction between them to mean
// anything.
bool appendDifferences(const Plate& a, const Plate& b, double slack, std::vector<Difference>& differences) {
  const auto errorOf = [slack](const Plate& plate, const glm::dvec3& corner) {
    return std::ranges::find(plate.given, corner) == plate.given.end() ? slack : 0;
  };
  bool in_doubt = false;
  for (const glm::dvec3& p : a.corners)
    for (const glm::dvec3& q : b.corners) {
      const double length = glm::length(q - p), error = errorOf(a, p) + errorOf(b, q);
      if (length <= 0x1p10 * error) in_doubt = true;
      else if (length > 0) differences.push_back({(q - p) / length, error / length});
    }
  return in_doubt;
}

// Returns the axis of a narrow cone around all differences: steps towards the furthest (M. Badoiu & K. L. Clarkson,
// Smaller core-sets for balls, 2003).
glm::dvec3 axisOf(const std::vector<Difference>& differences) {
  glm::dvec3 axis = differences[0].d;
  for (int step = 0; step < 256; ++step) {
    const auto furthest = std::ranges::min_element(
        differences, {}, [&axis](const Difference& difference) { return glm::dot(axis, difference.d); });
    const glm::dvec3 next = axis + (furthest->d - axis) / (step + 2.0);
    if (!(glm::length(next) > kOpenCone)) break;
    axis = glm::normalize(next);
  }
  return axis;
}

DirectionRegion regionOfConvexPair(const SeenPair& seen) {
  std::vector<glm::dvec3> from_a, from_b;
  appendSeparatingNormals(seen.a, seen.b, seen.slack, from_a);
  appendSeparatingNormals(seen.b, seen.a, seen.slack, from_b);
  DirectionRegion region = DirectionRegion::hemisphere(seen.a.front);
  region.clip(-seen.b.front);
  for (const glm::dvec3& normal : from_a) region.clip(normal);
  for (const glm::dvec3& normal : from_b) region.clip(-normal);
  region.close();
  return region;
}

// Counter-clockwise, without its last point (A. M. Andrew's monotone chains, 1979).
std::vector<glm::dvec2> hullOf(std::vector<glm::dvec2> points) {
  std::ranges::sort(points,
                    [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<glm::dvec2> hull;
  for (int chain = 0; chain < 2; ++chain) {
    const size_t first = hull.size();
    for (const glm::dvec2& point : points) {
      while (hull.size() >= first + 2) {
        const glm::dvec2 a = hull.back() - hull[hull.size() - 2], b = point - hull[hull.size() - 2];
        if (a.x * b.y - a.y * b.x > 0) break;
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
    std::ranges::reverse(points);
  }
  return hull;
}

// Returns the convex hull of directions that fit in a half sphere about the axis, through its central projection on the
// plane dot(axis, x) = 1. A direction enters as the corners of a square around it, of its error and a margin.
DirectionRegion hullRegion(const std::vector<Difference>& differences, const glm::dvec3& axis) {
  const Frame frame = frameAbout(axis);
  std::vector<glm::dvec2> points;
  for (const Difference& difference : differences) {
    const glm::dvec2 point =
        glm::dvec2(glm::dot(difference.d, frame.x), glm::dot(difference.d, frame.y)) / glm::dot(difference.d, axis);
    const double margin = (0x1p-40 + difference.error_rad) * (1 + glm::dot(point, point));
    for (double x : {-margin, margin})
      for (double y : {-margin, margin}) points.push_back(point + glm::dvec2(x, y));
  }
  const std::vector<glm::dvec2> hull = hullOf(std::move(points));
  const auto lift = [&](const glm::dvec2& point) { return axis + point.x * frame.x + point.y * frame.y; };
  DirectionRegion region = DirectionRegion::hemisphere(axis);
  for (size_t k = 0; k < hull.size(); ++k) {
    const glm::dvec3 from = lift(hull[k]), step = lift(hull[(k + 1) % hull.size()]) - from;
    region.clip(glm::normalize(glm::cross(from, step)));
  }
  region.close();
  return region;
}

// Returns the one front normal of all polygons, or zero.
glm::dvec3 commonFront(const Scene& scene, std::span<const uint32_t> polygons) {
  const glm::dvec3 front = plateOf(scene, polygons[0], glm::dvec3(0)).front;
  for (uint32_t polygon : polygons)
    if (glm::length(plateOf(scene, polygon, glm::dvec3(0)).front - front) > 1e-12) return glm::dvec3(0);
  return front;
}

// Returns the corners of the bounding box.
Plate boxAround(const Scene& scene, std::span<const uint32_t> polygons) {
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (uint32_t polygon : polygons)
    for (const glm::dvec3& corner : plateOf(scene, polygon, glm::dvec3(0)).corners) {
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  Plate box;
  for (double x : {low.x, high.x})
    for (double y : {low.y, high.y})
      for (double z : {low.z, high.z}) box.corners.emplace_back(x, y, z);
  box.given = box.corners;
  return box;
}

size_t cornerCount(const Scene& scene, std::span<const uint32_t> polygons) {
  size_t count = 0;
  for (uint32_t polygon : polygons) count += scene.polygons[polygon].corner_count;
  return count;
}

// --- samplers
// ---------------------------------------------------------------------------------------------------------

// A ShiftedLattice has points of the unit square, each uniform in it: a lattice under one random shift, periodic in
// `around`, folded (t and 1 - t alike) in `outwards`.
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

// Clips the cone of the region: Sutherland & Hodgman, Reentrant polygon clipping, 1974. Corners outside by no more than
// rounding stay.
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
  // The new arc may be half a circle long: cut it a quarter from its start.
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
  // Only the vertices of a half sphere have no mean direction.
  centre_ = glm::length(centre_) > 1e-6 ? glm::normalize(centre_) : arcs_[0].inner_normal;
  double solid_angle = 0;
  for (size_t k = 0; k < arcs_.size(); ++k) {
    Arc& arc = arcs_[k];
    const glm::dvec3 across = glm::cross(arc.inner_normal, centre_);
    const double sine = std::max(0.0, glm::dot(arc.inner_normal, centre_)), cosine = glm::length(across);
    // At the circle's pole any point is nearest. Elsewhere the first product's rounding is taken out again.
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
    if (first_rad > kPi / 4 && last_rad < -kPi / 4) area += 2 * kPi;  // past the point opposite the foot
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
  const double half =
      std::atan2(std::sin(area / 2), arc->half_tangent * std::cos(area / 2));  // of the way from the foot
  const glm::dvec3 edge = std::cos(2 * half) * arc->foot + std::sin(2 * half) * arc->along;
  // 1 - cos of the distance from the centre, half its chord squared, is uniform.
  const glm::dvec3 out = edge - centre_, tangent = out - centre_ * glm::dot(centre_, out);
  if (!(glm::length(tangent) > 0)) return centre_;
  const double chord_squared = outwards * glm::dot(out, out);
  return glm::normalize(centre_ * (1 - chord_squared / 2) +
                        glm::normalize(tangent) * std::sqrt(chord_squared * std::max(0.0, 1 - chord_squared / 4)));
}

DirectionRegion findPairRegion(const Scene& scene, std::span<const uint32_t> a, std::span<const uint32_t> b,
                               bool two_sided) {
  if (a.empty() || b.empty()) return {};
  std::vector<Difference> differences;
  bool is_open = false;  // the differences do not decide about the cone
  if (cornerCount(scene, a) * cornerCount(scene, b) > kMostDifferences) {
    const Plate box_a = boxAround(scene, a), box_b = boxAround(scene, b);
    is_open = appendDifferences(box_a, box_b, 0, differences) || differences.empty();
  } else {
    for (uint32_t a_index : a)
      for (uint32_t b_index : b) {
        const SeenPair seen = clipPair(scene, a_index, b_index, two_sided);
        if (seen.isEmpty()) continue;
        if (!two_sided && !seen.in_contact && a.size() == 1 && b.size() == 1) return regionOfConvexPair(seen);
        is_open |= seen.in_contact || appendDifferences(seen.a, seen.b, seen.slack, differences);
      }
    if (differences.empty() && !is_open) return {};
  }

  if (!is_open) {
    const glm::dvec3 axis = axisOf(differences);
    if (std::ranges::all_of(differences,
                            [&](const Difference& difference) { return glm::dot(axis, difference.d) > kOpenCone; }))
      return hullRegion(differences, axis);
  }
  const glm::dvec3 zero(0), front_a = commonFront(scene, a), front_b = commonFront(scene, b);
  if (two_sided || (front_a == zero && front_b == zero)) return DirectionRegion::hemisphere({0, 0, 1});
  if (front_a == zero || front_b == zero || glm::dot(front_a, front_b) < -1 + 1e-12)
    return DirectionRegion::hemisphere(front_a == zero ? -front_b : front_a);
  DirectionRegion region = DirectionRegion::hemisphere(front_a);
  region.clip(-front_b);
  region.close();
  return region;
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
    // (1 - e) cos^2 + e cos is uniform.
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
