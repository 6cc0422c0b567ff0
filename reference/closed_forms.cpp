#include "reference/closed_forms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

namespace viewpeel::reference {
namespace {

constexpr double kPi = std::numbers::pi;

// x ln(y) with its limit 0 at y = 0, where every use has x vanish too.
double xlog(double x, double y) { return y > 0 ? x * std::log(y) : 0; }

// The sum over the corners of both rectangles with the signs of a repeated integral.
template <class G>
double alternatingSum(Span x1, Span y1, Span x2, Span y2, G g) {
  double sum = 0;
  const double x[2] = {x1.low, x1.high}, y[2] = {y1.low, y1.high}, xi[2] = {x2.low, x2.high}, eta[2] = {y2.low, y2.high};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k)
        for (int l = 0; l < 2; ++l) sum += ((i + j + k + l) % 2 ? -1 : 1) * g(x[i], y[j], xi[k], eta[l]);
  return sum;
}

}  // namespace

double parallelRectangles(Span x1, Span y1, Span x2, Span y2, double z) {
  const auto g = [z](double x, double y, double xi, double eta) {
    const double u = x - xi, v = y - eta, p = std::hypot(u, z), q = std::hypot(v, z);
    return (v * p * std::atan(v / p) + u * q * std::atan(u / q) - z * z / 2 * std::log(u * u + v * v + z * z)) / (2 * kPi);
  };
  return alternatingSum(x1, y1, x2, y2, g) / ((x1.high - x1.low) * (y1.high - y1.low));
}

double perpendicularRectangles(Span x1, Span y, Span x2, Span z) {
  const auto g = [](double x, double yy, double xi, double zz) {
    const double c = std::hypot(yy, zz), u = x - xi, s = u * u;
    const double arc = c > 0 ? u * c * std::atan(u / c) : 0;
    return (arc + xlog((s - c * c) / 4, s + c * c)) / (2 * kPi);
  };
  return alternatingSum(x1, y, x2, z, g) / ((x1.high - x1.low) * (y.high - y.low));
}

double coaxialDiscs(double r1, double r2, double h) {
  const double a = r1 / h, b = r2 / h, x = 1 + (1 + b * b) / (a * a);
  // (x - sqrt(x^2 - 4 (b/a)^2)) / 2 without cancellation
  const double ratio = b / a;
  return 2 * ratio * ratio / (x + std::sqrt(x * x - 4 * ratio * ratio));
}

double areaOf(std::span<const glm::dvec3> polygon) {
  glm::dvec3 sum(0);
  for (size_t k = 1; k + 1 < polygon.size(); ++k) sum += glm::cross(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]);
  return glm::length(sum) / 2;
}

Loop clip(std::span<const glm::dvec3> polygon, const glm::dvec3& normal, double offset) {
  Loop kept;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const glm::dvec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const double hp = glm::dot(normal, p) - offset, hq = glm::dot(normal, q) - offset;
    if (hp >= 0) kept.push_back(p);
    if ((hp > 0 && hq < 0) || (hp < 0 && hq > 0)) kept.push_back(p + (q - p) * (hp / (hp - hq)));
  }
  return kept.size() >= 3 ? kept : Loop{};
}

double pointToPolygon(const glm::dvec3& p, const glm::dvec3& n, std::span<const glm::dvec3> polygon) {
  const Loop visible = clip(polygon, n, glm::dot(n, p));
  double sum = 0;
  for (size_t k = 0; k < visible.size(); ++k) {
    const glm::dvec3 a = visible[k] - p, b = visible[(k + 1) % visible.size()] - p, c = glm::cross(b, a);
    const double length = glm::length(c);
    if (length > 0) sum += std::atan2(length, glm::dot(a, b)) * glm::dot(n, c) / length;
  }
  return std::max(0.0, sum / (2 * kPi));
}

}  // namespace viewpeel::reference
