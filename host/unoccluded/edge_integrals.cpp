#include "unoccluded/edge_integrals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/glm.hpp>

#include "unoccluded/gauss.h"

namespace viewpeel {

using namespace unoccluded_data;
using glm::dot, glm::cross, glm::dvec3;

namespace {

constexpr uint32_t kMostPieces = 4;  // pieces of an edge between places where the inner integral is singular
constexpr double kLeast = 1e-290;    // replaces 0 in arguments of logarithms and angles, whose factor is then 0 as well

// Returns the inner integral of docs/method.md, eq. (38), over the edge q, for one point of p. The integrand is
// 1 + ln r in place of ln r, which saves terms: the 1 adds up to nothing around a polygon.
//   In: from: the point less the start of q; direction: unit vector along q
//   Out: magnitude: raised to the sum of the sizes of its terms, which may cancel
double innerIntegral(const dvec3& from, const dvec3& direction, double length_q, double& magnitude) {
  const double along = dot(from, direction), rest = length_q - along;
  const dvec3 across = cross(from, direction);
  const double square = dot(across, across), d = std::sqrt(square);
  const double first = 0.5 * along * std::log(std::max(along * along + square, kLeast)),
               last = 0.5 * rest * std::log(std::max(rest * rest + square, kLeast));
  const double turn = d * std::atan2(d * length_q, square - rest * along + kLeast);
  magnitude = std::max(magnitude, std::abs(first) + std::abs(last) + turn);
  return first + last + turn;
}

// Returns the ends of the pieces of p, as fractions of p: 0, the places where the inner integral over q is singular or
// nearly so, and 1. See cutsOf in shaders/unoccluded/line.comp.
std::array<double, kMostPieces + 1> cutsOf(const dvec3& p_start, const dvec3& p_along, const dvec3& q_start,
                                           const dvec3& q_along) {
  const dvec3 from = q_start - p_start, across = cross(p_along, q_along);
  const double per_p = 1 / dot(p_along, p_along), first = dot(from, p_along) * per_p,
               last = first + dot(q_along, p_along) * per_p;
  double nearest = 0;
  if (const double sine = dot(across, across); sine > 0) {
    const double foot = dot(cross(from, p_along), across) / sine;
    nearest = foot > 0 && foot < 1 ? dot(cross(from, q_along), across) / sine : 0;
  }
  std::array<double, kMostPieces + 1> cuts{0, std::clamp(first, 0.0, 1.0), std::clamp(last, 0.0, 1.0),
                                           std::clamp(nearest, 0.0, 1.0), 1};
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

// Returns x^n.
double raised(double x, uint32_t n) {
  double power = 1;
  for (; n > 0; n /= 2, x *= x)
    if (n % 2 == 1) power *= x;
  return power;
}

}  // namespace

bool areParallel(const dvec3& p, const dvec3& q) {
  constexpr double kSine = 8 * kUnitRounding;
  const dvec3 across = cross(p, q);
  return dot(across, across) <= kSine * kSine * dot(p, p) * dot(q, q);
}

// The integral is the second difference of K, K'' = 1 + ln r, h being the distance of the two lines:
//   K(x) = (x^2 - h^2) / 4 ln(x^2 + h^2) - x^2 / 4 + h x atan(x / h)
double integrateParallel(const Edge& p, const Edge& q, double& error) {
  constexpr double kSteps = 8;  // roundings in a term, and in the numbers that it is made of
  const double length = glm::length(p.along);
  const dvec3 direction = p.along / length, from = q.start - p.start, across = cross(from, direction);
  const double first = dot(from, direction), last = first + dot(q.along, direction);
  const double square = dot(across, across), h = std::sqrt(square);
  double sum = 0;
  const auto add = [&](double x, double sign) {
    const double radius = x * x + square, logarithm = 0.25 * std::log(std::max(radius, kLeast)),
                 turn = h > 0 ? h * x * std::atan(x / h) : 0;
    sum += sign * ((x * x - square) * logarithm - 0.25 * x * x + turn);
    error += kSteps * kUnitRounding * (radius * (std::abs(logarithm) + 1) + std::abs(turn));
  };
  add(last, 1);
  add(first, -1);
  add(last - length, -1);
  add(first - length, 1);
  return sum;
}

EdgeRules::EdgeRules() {
  for (size_t round = 0; round < kLineRounds.size(); ++round)
    for (uint32_t rule = 0; rule < kLineRules; ++rule) {
      const int n = static_cast<int>(kLineRounds[round].points[rule]);
      for (const GaussPoint& point : rule == kGradedRule ? gradedPoints(n) : unitPoints(n))
        points_[round][rule].push_back({static_cast<double>(point.node), static_cast<double>(point.weight)});
    }
}

double EdgeRules::integrate(Edge p, Edge q, size_t round, double& error) const {
  const double together = dot(p.along, q.along);
  if (dot(p.along, p.along) > dot(q.along, q.along)) std::swap(p, q);
  // The inner integral is analytic up to this distance (`clear`) from the middle of p, in units of half the length of p
  // (shaders/unoccluded/edges.comp).
  const double square_p = dot(p.along, p.along), square_q = dot(q.along, q.along);
  const dvec3 middle = p.start + 0.5 * p.along - q.start,
              off = middle - q.along * std::clamp(dot(middle, q.along) / square_q, 0.0, 1.0);
  const double clear = 2 * std::sqrt(dot(off, off) / square_p);
  const uint32_t rule = clear > 12 ? 0 : clear > 3.5 ? 1 : clear > 1.5 ? 2 : kGradedRule;
  if (rule == kGradedRule) {
    error += kLineRounds[round].graded_error * std::abs(together);
  } else {
    const double axes = clear + std::sqrt(std::max(clear * clear - 1, 0.0));
    error += 4 / raised(axes * axes, kLineRounds[round].points[rule]) * std::abs(together);
  }

  const std::array<double, kMostPieces + 1> cuts = rule == kGradedRule
                                                       ? cutsOf(p.start, p.along, q.start, q.along)
                                                       : std::array<double, kMostPieces + 1>{0, 1, 1, 1, 1};
  const double length_q = glm::length(q.along);
  const dvec3 direction = q.along / length_q, from = p.start - q.start;
  double sum = 0, greatest = 0;
  for (size_t piece = 0; piece < kMostPieces; ++piece) {
    const double low = cuts[piece], length = cuts[piece + 1] - low;
    if (!(length > 0)) continue;
    double part = 0;
    for (const Point& point : points_[round][rule])
      part += point.weight * innerIntegral(from + (low + point.at * length) * p.along, direction, length_q, greatest);
    sum += length * part;
  }
  const double factor = dot(p.along, direction);
  error += kUnitRounding * std::abs(factor) * greatest;
  return factor * sum;
}

}  // namespace viewpeel
