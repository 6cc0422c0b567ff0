#include "reference/exact/projected_estimate.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "reference/exact/convex_polygon.h"

namespace viewpeel::reference {
namespace {

struct PlanePoint {
  double x = 0, y = 0;
};

// A HalfPlane is where value(x, y) = a x + b y + c >= 0.
struct HalfPlane {
  double a = 0, b = 0, c = 0;
  double at(const PlanePoint& p) const { return a * p.x + b * p.y + c; }
};

using PlanePolygon = std::vector<PlanePoint>;

PlanePolygon clipped(const PlanePolygon& polygon, const HalfPlane& side) {
  PlanePolygon kept;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const PlanePoint &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const double at_p = side.at(p), at_q = side.at(q);
    if (at_p >= 0) kept.push_back(p);
    if ((at_p >= 0) != (at_q >= 0)) {
      const double s = at_p / (at_p - at_q);
      kept.push_back({p.x + s * (q.x - p.x), p.y + s * (q.y - p.y)});
    }
  }
  return kept;
}

double signedArea(const PlanePolygon& polygon) {
  double sum = 0;
  for (size_t k = 2; k < polygon.size(); ++k)
    sum += (polygon[k - 1].x - polygon[0].x) * (polygon[k].y - polygon[0].y) -
           (polygon[k].x - polygon[0].x) * (polygon[k - 1].y - polygon[0].y);
  return sum / 2;
}

struct Frame {
  glm::dvec3 x_axis, y_axis, u;
};

glm::dvec3 randomDirection(std::mt19937_64& bits) {
  const auto uniform = [&bits] { return (double)(bits() >> 11) * 0x1p-53; };
  const double z = 2 * uniform() - 1, angle_rad = 2 * std::numbers::pi * uniform(),
               ring = std::sqrt(std::fmax(0.0, 1 - z * z));
  return {ring * std::cos(angle_rad), ring * std::sin(angle_rad), z};
}

// Returns a frame by Duff et al., Building an orthonormal basis, revisited, JCGT 2017.
Frame frameAlong(const glm::dvec3& u) {
  const double sign = std::copysign(1.0, u.z), a = -1 / (sign + u.z), b = u.x * u.y * a;
  return {{1 + sign * u.x * u.x * a, sign * b, -sign * u.x}, {b, sign + u.y * u.y * a, -u.y}, u};
}

PlanePolygon project(const std::vector<glm::dvec3>& corners, const Frame& frame) {
  PlanePolygon projected;
  for (const glm::dvec3& corner : corners)
    projected.push_back({glm::dot(corner, frame.x_axis), glm::dot(corner, frame.y_axis)});
  return projected;
}

// Returns the depth along u of the point above (x, y) of the plane through `point`.
HalfPlane depthOver(const glm::dvec3& normal, const glm::dvec3& point, const Frame& frame) {
  const double slope = glm::dot(normal, frame.u);
  return {-glm::dot(normal, frame.x_axis) / slope, -glm::dot(normal, frame.y_axis) / slope,
          glm::dot(normal, point) / slope};
}

}  // namespace

ProjectedPair::ProjectedPair(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
  const UnitFrame unit_frame = toUnitFrame({a, b});
  const auto flatten = [](const ConvexPolygon& polygon) {
    return FlatPolygon{{polygon.begin(), polygon.end()}, frontOf(polygon).normal};
  };
  a_ = flatten(unit_frame.polygons[0]);
  b_ = flatten(unit_frame.polygons[1]);
  area_ = (double)area(unit_frame.polygons[0]);
}

double ProjectedPair::zeta(const glm::dvec3& u) const {
  // u and -u are one direction: take the end that leaves a's front.
  const Frame frame = frameAlong(glm::dot(a_.normal, u) < 0 ? -u : u);
  if (!(glm::dot(a_.normal, frame.u) > 0 && glm::dot(b_.normal, frame.u) < 0)) return 0;
  PlanePolygon common = project(a_.corners, frame);
  const PlanePolygon other = project(b_.corners, frame);
  // b is seen from its front against u, so its corners run clockwise in the plane of (x_axis, y_axis), which u looks
  // out of.
  for (size_t k = 0; k < other.size() && !common.empty(); ++k) {
    const PlanePoint &p = other[k], &q = other[(k + 1) % other.size()];
    common = clipped(common, {q.y - p.y, p.x - q.x, p.y * q.x - p.x * q.y});
  }
  const HalfPlane depth_a = depthOver(a_.normal, a_.corners[0], frame),
                  depth_b = depthOver(b_.normal, b_.corners[0], frame);
  return 2 * signedArea(clipped(common, {depth_b.a - depth_a.a, depth_b.b - depth_a.b, depth_b.c - depth_a.c})) / area_;
}

ProjectedEstimate estimateFormFactor(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b,
                                     uint64_t direction_count, uint64_t seed) {
  if (direction_count < 2) throw Error(ErrorCode::bad_input, "a standard error needs 2 directions or more");
  const ProjectedPair pair(a, b);
  std::mt19937_64 bits(seed);
  double mean = 0, squares = 0;  // Welford's running sums
  for (uint64_t n = 1; n <= direction_count; ++n) {
    const double term = pair.zeta(randomDirection(bits));
    const double difference = term - mean;
    mean += difference / (double)n;
    squares += difference * (term - mean);
  }
  const double count = (double)direction_count;
  return {mean, std::sqrt(squares / (count - 1) / count)};
}

}  // namespace viewpeel::reference
