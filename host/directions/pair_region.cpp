// findPairRegion finds the directions along which a line can leave a front of one polygon and arrive at a front of
// another.
#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "directions/drawn_directions.h"
#include "directions/frame.h"

namespace viewpeel {
namespace {

// A cone of directions counts as a half sphere if the cosine between its axis and any of them is at most this number.
constexpr double kOpenCone = 0.02;
constexpr size_t kMostDifferences = 1u << 20;  // surfaces with more pairs of corners are replaced by bounding boxes

using Corners = std::vector<glm::dvec3>;

// A Plate is a polygon about an origin near it, or a part of the polygon.
struct Plate {
  Corners corners;
  Corners given;        // the polygon's corners before clipping
  glm::dvec3 front{0};  // unit normal of the front
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

// Returns how far the corners are off the plane through the first corner.
double roughnessOf(const Plate& plate) {
  double roughness = 0;
  for (const glm::dvec3& corner : plate.corners)
    roughness = std::max(roughness, std::abs(glm::dot(plate.front, corner - plate.corners[0])));
  return roughness;
}

// Returns the corners of the part of a polygon in front of the plate's plane. Corners within `slack` of the plane are
// kept. It returns none where no corner is farther in front than `slack`.
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

// Returns whether two polygons of one plane overlap by more than `slack`. They do unless, for some edge of one, all of
// the other lies outside (separating axes).
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

// A SeenPair holds the parts of two convex polygons that the front of the other can see.
struct SeenPair {
  Plate a, b;
  double slack = 0;         // rounding may have moved corners by this much
  bool in_contact = false;  // whether the polygons lie in one plane, face each other and overlap
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

// Appends normals of planes that separate the two plates, one for every edge of `near`. The plane of `near` is turned
// about the edge, away from `near`, until it touches `far`. Then `near` lies on one side of it and `far` on the other,
// to which the normal points. Edges for which rounding makes this doubtful are left out.
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

// A Difference is the direction from a corner of one plate to a corner of the other.
struct Difference {
  glm::dvec3 d;  // unit length
  double error_rad = 0;
};

// Appends the differences of all corners of `b` and `a`. Returns whether a corner made by clipping is so near to a
// corner of the other plate that rounding leaves the direction between them open.
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

// Returns the axis of a narrow cone around all differences, found by steps towards the farthest of them (M. Badoiu & K.
// L. Clarkson, Smaller core-sets for balls, 2003).
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

// Returns the corners of the convex hull, counter-clockwise, each once (A. M. Andrew's monotone chains, 1979).
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

// Returns the convex hull of directions that fit in a half sphere about the axis. It is found in their central
// projection on the plane dot(axis, x) = 1. Each direction is replaced by the corners of a square around it, as wide as
// its error and a margin.
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

// Returns the eight corners of the bounding box of polygons.
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

}  // namespace

glm::dvec3 commonFront(const Scene& scene, std::span<const uint32_t> polygons) {
  const glm::dvec3 front = plateOf(scene, polygons[0], glm::dvec3(0)).front;
  for (uint32_t polygon : polygons)
    if (glm::length(plateOf(scene, polygon, glm::dvec3(0)).front - front) > 1e-12) return glm::dvec3(0);
  return front;
}

DirectionRegion findPairRegion(const Scene& scene, std::span<const uint32_t> a, std::span<const uint32_t> b,
                               bool two_sided) {
  if (a.empty() || b.empty()) return {};
  std::vector<Difference> differences;
  bool is_open = false;  // whether the differences leave it open how wide the cone is
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

}  // namespace viewpeel
