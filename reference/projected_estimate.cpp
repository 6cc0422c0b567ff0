#include "reference/projected_estimate.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "error.h"
#include "reference/convex_polygon.h"

namespace viewpeel::reference {
namespace {

struct PlanePoint {
  double x = 0, y = 0;
};

// Where value(x, y) = a x + b y + c >= 0.
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

// u is uniform on the sphere; the axes follow from it (Duff et al., Building an orthonormal basis, revisited, JCGT 2017).
Frame randomFrame(std::mt19937_64& bits) {
  const auto uniform = [&bits] { return (double)(bits() >> 11) * 0x1p-53; };
  const double z = 2 * uniform() - 1, angle_rad = 2 * std::numbers::pi * uniform(), ring = std::sqrt(std::fmax(0.0, 1 - z * z));
  const glm::dvec3 u(ring * std::cos(angle_rad), ring * std::sin(angle_rad), z);
  const double sign = std::copysign(1.0, z), a = -1 / (sign + z), b = u.x * u.y * a;
  return {{1 + sign * u.x * u.x * a, sign * b, -sign * u.x}, {b, sign + u.y * u.y * a, -u.y}, u};
}

struct FlatPolygon {
  std::vector<glm::dvec3> corners;
  glm::dvec3 normal{0};

  explicit FlatPolygon(const ConvexPolygon& polygon) : corners(polygon.begin(), polygon.end()), normal(frontOf(polygon).normal) {}

  PlanePolygon along(const Frame& frame) const {
    PlanePolygon projected;
    for (const glm::dvec3& corner : corners) projected.push_back({glm::dot(corner, frame.x_axis), glm::dot(corner, frame.y_axis)});
    return projected;
  }

  // Depth along u of the plane's point above (x, y).
  HalfPlane depthOver(const Frame& frame) const {
    const double slope = glm::dot(normal, frame.u);
    return {-glm::dot(normal, frame.x_axis) / slope, -glm::dot(normal, frame.y_axis) / slope, glm::dot(normal, corners[0]) / slope};
  }
};

// The area of the lines along u that leave a's front and then meet b's front.
double commonArea(const FlatPolygon& a, const FlatPolygon& b, const Frame& frame) {
  PlanePolygon common = a.along(frame);
  const PlanePolygon other = b.along(frame);
  // b is seen from its front against u, so its corners run clockwise in the plane of (x_axis, y_axis), which u looks out of.
  for (size_t k = 0; k < other.size() && !common.empty(); ++k) {
    const PlanePoint &p = other[k], &q = other[(k + 1) % other.size()];
    common = clipped(common, {q.y - p.y, p.x - q.x, p.y * q.x - p.x * q.y});
  }
  const HalfPlane depth_a = a.depthOver(frame), depth_b = b.depthOver(frame);
  return signedArea(clipped(common, {depth_b.a - depth_a.a, depth_b.b - depth_a.b, depth_b.c - depth_a.c}));
}

}  // namespace

ProjectedEstimate estimateFormFactor(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b, uint64_t direction_count,
                                     uint64_t seed) {
  if (direction_count < 2) throw Error(ErrorCode::bad_input, "a standard error needs 2 directions or more");
  const UnitFrame unit_frame = toUnitFrame({a, b});
  const FlatPolygon flat_a(unit_frame.polygons[0]), flat_b(unit_frame.polygons[1]);
  const double area_a = (double)area(unit_frame.polygons[0]);
  std::mt19937_64 bits(seed);
  double mean = 0, squares = 0;  // Welford's running sums
  for (uint64_t n = 1; n <= direction_count; ++n) {
    Frame frame = randomFrame(bits);
    // u and -u are one direction: take the end that leaves a's front. The mirrored frame stays right-handed.
    if (glm::dot(flat_a.normal, frame.u) < 0) frame = {frame.y_axis, frame.x_axis, -frame.u};
    double term = 0;
    if (glm::dot(flat_a.normal, frame.u) > 0 && glm::dot(flat_b.normal, frame.u) < 0) term = 2 * commonArea(flat_a, flat_b, frame) / area_a;
    const double difference = term - mean;
    mean += difference / (double)n;
    squares += difference * (term - mean);
  }
  const double count = (double)direction_count;
  return {mean, std::sqrt(squares / (count - 1) / count)};
}

}  // namespace viewpeel::reference
