// Two convex polygons that see each other: the double contour integral, and the paper's own estimator.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <glm/glm.hpp>

#include "reference/closed_forms.h"

namespace viewpeel::reference {
namespace {

constexpr double kPi = std::numbers::pi;

glm::dvec3 normalOf(std::span<const glm::dvec3> polygon) {
  glm::dvec3 sum(0);
  for (size_t k = 1; k + 1 < polygon.size(); ++k) sum += glm::cross(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]);
  return glm::normalize(sum);
}

// Each clipped to the front half space of the other.
struct FacingPair {
  Loop a, b;
  FacingPair(std::span<const glm::dvec3> full_a, std::span<const glm::dvec3> full_b) {
    const glm::dvec3 na = normalOf(full_a), nb = normalOf(full_b);
    b = clip(full_b, na, glm::dot(na, full_a[0]));
    a = clip(full_a, nb, glm::dot(nb, full_b[0]));
  }
  bool isEmpty() const { return a.empty() || b.empty(); }
};

// Integral of ln(r / unit) along the segment from q in unit direction d over `length`, r the distance from x.
double integrateLog(const glm::dvec3& x, const glm::dvec3& q, const glm::dvec3& d, double length, double unit) {
  const glm::dvec3 from = x - q;
  const double along = glm::dot(from, d);
  const double height = glm::length(glm::cross(from, d));
  const auto primitive = [&](double t) {
    const double r2 = height * height + t * t;
    return (r2 > 0 ? t / 2 * std::log(r2 / (unit * unit)) : 0) - t + (height > 0 ? height * std::atan(t / height) : 0);
  };
  return primitive(length - along) - primitive(-along);
}

// The outer integral, cut where the integrand is nearly singular: at the points next to the ends of the inner segment, so that tanh-sinh nodes
// crowd there.
double integrateEdgePair(const glm::dvec3& p, const glm::dvec3& dp, double lp, const glm::dvec3& q, const glm::dvec3& dq, double lq, double unit) {
  static boost::math::quadrature::tanh_sinh<double> quadrature(12);
  std::vector<double> cuts = {0, lp};
  for (const glm::dvec3& end : {q, q + dq * lq}) {
    const double at = glm::dot(end - p, dp);
    if (at > 1e-12 * lp && at < lp * (1 - 1e-12)) cuts.push_back(at);
  }
  std::sort(cuts.begin(), cuts.end());
  double sum = 0;
  for (size_t k = 0; k + 1 < cuts.size(); ++k) {
    if (cuts[k + 1] - cuts[k] < 1e-14 * lp) continue;
    const double from = cuts[k], to = cuts[k + 1];
    sum += quadrature.integrate([&](double s) { return integrateLog(p + dp * s, q, dq, lq, unit); }, from, to, 1e-13);
  }
  return sum;
}

}  // namespace

double polygonToPolygon(std::span<const glm::dvec3> full_a, std::span<const glm::dvec3> full_b) {
  const FacingPair pair(full_a, full_b);
  if (pair.isEmpty()) return 0;
  // ln r may be shifted by any constant, since both contours are closed: distances near 1 keep the sum from cancelling.
  glm::dvec3 ca(0), cb(0);
  for (const glm::dvec3& corner : pair.a) ca += corner / double(pair.a.size());
  for (const glm::dvec3& corner : pair.b) cb += corner / double(pair.b.size());
  const double unit = std::max(glm::length(ca - cb), 1e-300);
  double sum = 0;
  for (size_t i = 0; i < pair.a.size(); ++i)
    for (size_t j = 0; j < pair.b.size(); ++j) {
      const glm::dvec3 &p = pair.a[i], &q = pair.b[j];
      const glm::dvec3 ep = pair.a[(i + 1) % pair.a.size()] - p, eq = pair.b[(j + 1) % pair.b.size()] - q;
      const double lp = glm::length(ep), lq = glm::length(eq);
      if (lp == 0 || lq == 0) continue;
      const double cosine = glm::dot(ep, eq) / (lp * lq);
      if (std::abs(cosine) < 1e-16) continue;
      sum += cosine * integrateEdgePair(p, ep / lp, lp, q, eq / lq, lq, unit);
    }
  return std::max(0.0, sum / (2 * kPi * areaOf(full_a)));
}

Estimated estimateByProjection(std::span<const glm::dvec3> full_a, std::span<const glm::dvec3> full_b, uint64_t direction_count, uint64_t seed) {
  const FacingPair pair(full_a, full_b);
  if (pair.isEmpty()) return {0, 0};
  const glm::dvec3 na = normalOf(full_a), nb = normalOf(full_b);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  double sum = 0, squares = 0;
  for (uint64_t k = 0; k < direction_count; ++k) {
    const double z = 2 * uniform(random) - 1, azimuth_rad = 2 * kPi * uniform(random), r = std::sqrt(1 - z * z);
    const glm::dvec3 u(r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), z);
    if (glm::dot(na, u) * glm::dot(nb, u) >= 0) continue;  // a line that leaves one front does not meet the other's
    const auto project = [&](const glm::dvec3& p) { return p - glm::dot(p, u) * u; };
    Loop common;
    for (const glm::dvec3& corner : pair.a) common.push_back(project(corner));
    glm::dvec3 inside(0);
    for (const glm::dvec3& corner : pair.b) inside += project(corner) / double(pair.b.size());
    for (size_t j = 0; j < pair.b.size() && !common.empty(); ++j) {
      const glm::dvec3 p = project(pair.b[j]), q = project(pair.b[(j + 1) % pair.b.size()]);
      glm::dvec3 inward = glm::cross(u, q - p);
      if (glm::dot(inward, inside - p) < 0) inward = -inward;
      common = clip(common, inward, glm::dot(inward, p));
    }
    const double zeta = common.empty() ? 0 : 2 * areaOf(common) / areaOf(full_a);
    sum += zeta;
    squares += zeta * zeta;
  }
  const double n = double(direction_count), mean = sum / n;
  return {mean, std::sqrt((squares / n - mean * mean) / (n - 1))};
}

}  // namespace viewpeel::reference
