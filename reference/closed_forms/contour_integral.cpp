#include "reference/closed_forms/contour_integral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "reference/exact/convex_polygon.h"
#include "reference/closed_forms/quadrature.h"

namespace viewpeel::reference {
namespace {

// This is the rounding of one value of the inner integral: its terms are at most 2 in the unit ball, and cancel.
constexpr long double kNoise = 4 * std::numeric_limits<long double>::epsilon();

struct Edge {
  Vec3 start, direction;  // unit length
  long double length = 0;

  long double along(const Vec3& x) const { return glm::dot(x - start, direction); }
};

std::vector<Edge> edgesOf(const ConvexPolygon& polygon) {
  std::vector<Edge> edges;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 step = polygon[(k + 1) % polygon.size()] - polygon[k];
    const long double length = glm::length(step);
    if (length > 0) edges.push_back({polygon[k], step / length, length});
  }
  return edges;
}

// Returns the integral over 0..v of ln hypot(t, d) dt, less v.
long double logIntegral(long double v, long double d) {
  const long double r2 = v * v + d * d;
  return r2 > 0 ? v / 2 * std::log(r2) + d * std::atan2(v, d) : 0;
}

// Returns the integral over the edge of ln |x - y| dy.
long double logIntegral(const Vec3& x, const Edge& edge) {
  const long double v = edge.along(x), d = glm::length(glm::cross(x - edge.start, edge.direction));
  return logIntegral(edge.length - v, d) + logIntegral(v, d) - edge.length;
}

// Returns places to cut p. The inner integral over q, as a function of the place on p, is singular only at complex
// places. They lie above q's ends seen along p, and above the place where the two lines are nearest. With cuts at their
// real parts, halving closes in on them fast.
std::vector<long double> cutsOf(const Edge& p, const Edge& q) {
  std::vector<long double> cuts{0, p.length};
  const auto add = [&](long double s) {
    if (s > 0 && s < p.length) cuts.push_back(s);
  };
  add(p.along(q.start));
  add(p.along(q.start + q.length * q.direction));
  const long double cosine = glm::dot(p.direction, q.direction), sine2 = 1 - cosine * cosine;
  if (sine2 > 0) add((p.along(q.start) - cosine * glm::dot(q.start - p.start, q.direction)) / sine2);
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

// Returns pi A F and its error.
LineIntegral contourIntegral(const ConvexPolygon& a, const ConvexPolygon& b, long double tolerance) {
  const std::vector<Edge> edges_a = edgesOf(a), edges_b = edgesOf(b);
  const long double share = tolerance / (long double)(edges_a.size() * edges_b.size());
  LineIntegral total;
  for (const Edge& p : edges_a)
    for (const Edge& q : edges_b) {
      const long double cosine = glm::dot(p.direction, q.direction);
      if (cosine == 0) continue;
      const auto inner = [&](long double s) { return logIntegral(p.start + s * p.direction, q); };
      const std::vector<long double> cuts = cutsOf(p, q);
      for (size_t k = 1; k < cuts.size(); ++k) {
        const LineIntegral part = integrate(inner, cuts[k - 1], cuts[k], share / std::abs(cosine), kNoise);
        total.value += cosine / 2 * part.value;
        total.error += std::abs(cosine) / 2 * part.error;
      }
    }
  return total;
}

struct WeightedPoint {
  Vec3 x;
  long double weight = 0;  // area
};

// Returns the product rule on the fan of triangles about corner 0, collapsed at this corner.
std::vector<WeightedPoint> areaRule(const ConvexPolygon& polygon, int n) {
  const GaussRule& rule = gaussRule(n);
  std::vector<WeightedPoint> points;
  for (size_t k = 2; k < polygon.size(); ++k) {
    const Vec3 u = polygon[k - 1] - polygon[0], v = polygon[k] - polygon[0];
    const long double twice_area = glm::length(glm::cross(u, v));
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const long double s = rule.nodes[i], t = rule.nodes[j];
        points.push_back({polygon[0] + s * ((1 - t) * u + t * v), twice_area * s * rule.weights[i] * rule.weights[j]});
      }
  }
  return points;
}

// Returns pi A F by the rule of n^4 points per pair of triangles.
long double areaIntegral(const ConvexPolygon& a, const ConvexPolygon& b, const HalfSpace& front_a,
                         const HalfSpace& front_b, int n) {
  const std::vector<WeightedPoint> points_a = areaRule(a, n), points_b = areaRule(b, n);
  long double sum = 0;
  for (const WeightedPoint& p : points_a)
    for (const WeightedPoint& q : points_b) {
      const Vec3 d = q.x - p.x;
      const long double r2 = glm::dot(d, d);
      sum -= p.weight * q.weight * glm::dot(front_a.normal, d) * glm::dot(front_b.normal, d) / (r2 * r2);
    }
  return sum;
}

long double radius(const ConvexPolygon& polygon) {
  long double largest = 0;
  for (const Vec3& corner : polygon) largest = std::max(largest, glm::length(corner - meanCorner(polygon)));
  return largest;
}

bool areFar(const ConvexPolygon& a, const ConvexPolygon& b) {
  return glm::length(meanCorner(b) - meanCorner(a)) > kFarDistance * (radius(a) + radius(b));
}

}  // namespace

double formFactor(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
  const UnitFrame frame = toUnitFrame({a, b});
  const ConvexPolygon &whole_a = frame.polygons[0], &whole_b = frame.polygons[1];
  const FacingParts parts = facingParts(whole_a, whole_b, frame.rounding);
  if (parts.a.empty()) return 0;
  const long double pi_area = std::numbers::pi_v<long double> * area(whole_a);
  long double error = 0, bound = kContourError, form_factor = 0;
  if (areFar(parts.a, parts.b)) {
    const HalfSpace front_a = frontOf(whole_a), front_b = frontOf(whole_b);
    const long double coarse = areaIntegral(parts.a, parts.b, front_a, front_b, 6) / pi_area;
    form_factor = areaIntegral(parts.a, parts.b, front_a, front_b, 8) / pi_area;
    error = std::abs(form_factor - coarse);
    bound = std::min(bound, std::max(kFarRelativeError * form_factor, 1e-30L));
  } else {
    const LineIntegral sum = contourIntegral(parts.a, parts.b, 0.1L * kContourError * pi_area);
    form_factor = sum.value / pi_area;
    error = sum.error / pi_area;
  }
  if (!(error <= bound))
    throw Error(ErrorCode::limit,
                fmt::format("form factor {} is only good to {:.1e}: split the larger or thinner polygon",
                            (double)form_factor, (double)error));
  return (double)std::max(form_factor, 0.0L);
}

}  // namespace viewpeel::reference
