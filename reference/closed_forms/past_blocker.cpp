#include "reference/closed_forms/past_blocker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "reference/exact/convex_polygon.h"

namespace viewpeel::reference {
namespace {

constexpr size_t kMaxTriangles = 200'000;
constexpr long double kTiny = 1e-17L;  // lengths in the unit ball below this are rounding

// Returns, by Lambert's formula, the form factor from the point x with the given normal to a polygon seen
// counter-clockwise from x.
long double pointFormFactor(const Vec3& x, const Vec3& normal, const ConvexPolygon& polygon) {
  long double sum = 0;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 r = polygon[k] - x, s = polygon[(k + 1) % polygon.size()] - x, c = glm::cross(r, s);
    const long double sine = glm::length(c);
    if (sine > 0) sum -= std::atan2(sine, glm::dot(r, s)) * glm::dot(normal, c) / sine;
  }
  return sum / (2 * std::numbers::pi_v<long double>);
}

// Returns the part of b that the blocker hides from x. The blocker lies in front of b's plane and of the plane of a, so
// every line from x through it meets it before b.
ConvexPolygon hiddenPart(const Vec3& x, const ConvexPolygon& b, const ConvexPolygon& blocker,
                         const HalfSpace& blocker_front) {
  const long double depth = blocker_front.depth(x);
  if (std::abs(depth) <= kTiny) return {};
  ConvexPolygon hidden = b;
  for (size_t k = 0; k < blocker.size() && !hidden.empty(); ++k) {
    const Vec3 p = blocker[k] - x, q = blocker[(k + 1) % blocker.size()] - x;
    const Vec3 inward = depth > 0 ? glm::cross(q, p) : glm::cross(p, q);
    const long double length = glm::length(inward);
    if (length > 0) hidden = clip(hidden, {inward / length, glm::dot(inward, x) / length}, 0);
  }
  return hidden;
}

// Adds the planes through an edge of one polygon and a corner of the other.
void addEdgeCornerPlanes(const ConvexPolygon& with_edges, const ConvexPolygon& with_corners,
                         std::vector<HalfSpace>& planes) {
  for (size_t k = 0; k < with_edges.size(); ++k)
    for (const Vec3& corner : with_corners) {
      const Vec3& p = with_edges[k];
      const Vec3 normal = glm::cross(with_edges[(k + 1) % with_edges.size()] - p, corner - p);
      const long double length = glm::length(normal);
      if (length > kTiny) planes.push_back({normal / length, glm::dot(normal, p) / length});
    }
}

// Adds cuts under edges that hang at a small height over a. Near the foot of such an edge f changes within its height,
// which a rule with points further apart does not see. Cuts along the foot, at distances that grow from the height on,
// make it visible.
void addCutsUnderLowEdges(const ConvexPolygon& polygon, const HalfSpace& front_a, std::vector<HalfSpace>& planes) {
  // Edges higher than kLow need no cuts. Below kNegligible the part of a near the foot is too small to matter.
  constexpr long double kLow = 1e-2L, kNegligible = 1e-9L, kGrowth = 8;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const long double height = std::max(front_a.depth(p), front_a.depth(q));
    const Vec3 across = glm::cross(front_a.normal, q - p);
    const long double length = glm::length(across);
    if (height > kLow || height < kNegligible || length <= kTiny) continue;
    const Vec3 normal = across / length;
    const long double foot = glm::dot(normal, p);
    planes.push_back({normal, foot});
    for (long double distance = height; distance < kLow * kGrowth; distance *= kGrowth)
      for (long double side : {-1, 1}) planes.push_back({normal, foot + side * distance});
  }
}

struct Triangle {
  Vec3 p, q, r;
  long double value = 0, error = 0;
  bool operator<(const Triangle& other) const { return error < other.error; }
};

struct View {
  Vec3 normal{0};  // of a
  ConvexPolygon b, blocker;
  HalfSpace blocker_front;

  long double at(const Vec3& x) const {
    const long double open = pointFormFactor(x, normal, b);
    return blocker.empty() ? open : open - pointFormFactor(x, normal, hiddenPart(x, b, blocker, blocker_front));
  }

  Triangle integrate(const Vec3& p, const Vec3& q, const Vec3& r) const {
    Triangle triangle{p, q, r};
    const long double fine = rule(p, q, r, gaussRule(5));
    triangle.value = fine;
    triangle.error = std::abs(fine - rule(p, q, r, gaussRule(3)));
    return triangle;
  }

  long double rule(const Vec3& p, const Vec3& q, const Vec3& r, const GaussRule& gauss) const {
    long double sum = 0;
    for (size_t i = 0; i < gauss.nodes.size(); ++i)
      for (size_t j = 0; j < gauss.nodes.size(); ++j) {
        const long double s = gauss.nodes[i], t = gauss.nodes[j];
        sum += gauss.weights[i] * gauss.weights[j] * s * at(p + s * ((1 - t) * (q - p) + t * (r - p)));
      }
    return sum * glm::length(glm::cross(q - p, r - p));
  }
};

std::vector<ConvexPolygon> cut(const ConvexPolygon& polygon, const std::vector<HalfSpace>& planes) {
  std::vector<ConvexPolygon> pieces{polygon};
  for (const HalfSpace& plane : planes) {
    std::vector<ConvexPolygon> next;
    for (const ConvexPolygon& piece : pieces)
      for (const HalfSpace& side : {plane, HalfSpace{-plane.normal, -plane.offset}}) {
        // A piece wholly within kTiny of the plane is kept once, whole.
        const bool inside =
            std::any_of(piece.begin(), piece.end(), [&](const Vec3& x) { return side.depth(x) > kTiny; });
        if (!inside) continue;
        ConvexPolygon part = clip(piece, side, kTiny);
        if (!part.empty()) next.push_back(std::move(part));
      }
    pieces = std::move(next);
  }
  return pieces;
}

}  // namespace

Approximation formFactorPastBlocker(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b,
                                    std::span<const glm::dvec3> blocker) {
  const UnitFrame frame = toUnitFrame({a, b, blocker});
  const ConvexPolygon &whole_a = frame.polygons[0], &whole_b = frame.polygons[1];
  const FacingParts parts = facingParts(whole_a, whole_b, frame.rounding);
  if (parts.a.empty()) return {};

  const HalfSpace front_a = frontOf(whole_a), front_b = frontOf(whole_b);
  View view{front_a.normal, parts.b, clip(clip(frame.polygons[2], front_b, frame.rounding), front_a, frame.rounding),
            frontOf(frame.polygons[2])};
  if (std::none_of(view.blocker.begin(), view.blocker.end(),
                   [&](const Vec3& x) { return front_a.depth(x) > frame.rounding; }))
    view.blocker.clear();
  std::vector<HalfSpace> planes;
  addCutsUnderLowEdges(view.b, front_a, planes);
  addCutsUnderLowEdges(view.blocker, front_a, planes);
  if (!view.blocker.empty()) {
    planes.push_back(view.blocker_front);
    addEdgeCornerPlanes(view.blocker, view.b, planes);
    addEdgeCornerPlanes(view.b, view.blocker, planes);
    // The plane of a itself, where the blocker or b touches a, cuts nothing.
    std::erase_if(
        planes, [&](const HalfSpace& plane) { return glm::length(glm::cross(plane.normal, front_a.normal)) <= kTiny; });
  }

  const long double total_area = area(whole_a);
  long double error = 0, kept_area = 0;
  std::vector<Triangle> triangles;  // a heap, the worst first
  const auto add = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    triangles.push_back(view.integrate(p, q, r));
    error += triangles.back().error;
    std::push_heap(triangles.begin(), triangles.end());
  };
  for (const ConvexPolygon& piece : cut(parts.a, planes)) {
    kept_area += area(piece);
    for (size_t k = 2; k < piece.size(); ++k) add(piece[0], piece[k - 1], piece[k]);
  }
  const long double lost = std::abs(area(parts.a) - kept_area), target = kPastBlockerError / 2 * total_area;
  while (error + lost > target && triangles.size() < kMaxTriangles) {
    std::pop_heap(triangles.begin(), triangles.end());
    Triangle worst = triangles.back();
    triangles.pop_back();
    error -= worst.error;
    // The longest edge, pq, is halved.
    const auto length = [](const Vec3& x, const Vec3& y) { return glm::length(y - x); };
    for (int turn = 0; turn < 2; ++turn)
      if (length(worst.q, worst.r) > length(worst.p, worst.q) || length(worst.r, worst.p) > length(worst.p, worst.q))
        worst = {worst.q, worst.r, worst.p};
    const Vec3 middle = (worst.p + worst.q) / 2.0L;
    add(worst.p, middle, worst.r);
    add(middle, worst.q, worst.r);
  }

  long double value = 0;
  error = lost;
  for (const Triangle& triangle : triangles) {
    value += triangle.value;
    error += triangle.error;
  }
  const Approximation result{(double)std::max(value / total_area, 0.0L), (double)(error / total_area)};
  if (!(result.error <= kPastBlockerError))
    throw Error(ErrorCode::limit,
                fmt::format("form factor {} past a blocker is only good to {:.1e}: split the larger or thinner polygon",
                            result.value, result.error));
  return result;
}

}  // namespace viewpeel::reference
