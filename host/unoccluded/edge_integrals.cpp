#include "unoccluded/edge_integrals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/glm.hpp>

#include "lanes.h"
#include "unoccluded/gauss.h"
#include "unoccluded/lane_math.h"
#include "vectorised.h"

namespace viewpeel {

using namespace unoccluded_data;
using glm::dot, glm::cross, glm::dvec3;

namespace {

constexpr uint32_t kMostPieces = 4;  // pieces of an edge between places where the inner integral is singular
// Roundings in a term of a sum, and in the numbers that it is made of; and as many of them as kernels allow for.
constexpr double kSteps = 8, kStepsOfKernels = 2;
constexpr double kLeast = 1e-290;  // replaces 0 in arguments of logarithms and angles, whose factor is then 0 as well

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

// The inner integral, over the edge q, is that of docs/method.md, eq. (38), with 1 + ln r in place of ln r. The 1 adds
// nothing along closed contours, and saves terms.
void EdgeSum::evaluate() {
  constexpr size_t kLanes = kBlockerLanes;
  static_assert(kMostPoints % kLanes == 0);
  static_assert(std::ranges::all_of(
      kLineRounds, [](const LineRound& round) { return std::ranges::max(round.points) <= kMostPoints; }));
  for (; count % kLanes != 0; ++count) along[count] = rest[count] = distance[count] = weight[count] = 0;
  std::array<double, kLanes> values, sizes;
  runInLanes(
      widestVectors(), [&](auto types) __attribute__((always_inline)) {
        using Doubles = typename decltype(types)::Doubles;
        Doubles value_lanes, size_lanes;
        for (size_t k = 0; k < count; k += kLanes) {
          const auto x = load<Doubles>(&along[k]), y = load<Doubles>(&rest[k]), d = load<Doubles>(&distance[k]),
                     w = load<Doubles>(&weight[k]);
          const Doubles s = d * d, smallest(kLeast);
          const Doubles first = 0.5 * x * logOf(greatest(x * x + s, smallest)),
                        last = 0.5 * y * logOf(greatest(y * y + s, smallest)),
                        turn = d * angleOf(s - y * x + smallest, d * (x + y));
          value_lanes += w * (first + last + turn);
          size_lanes += sizeOf(w) * (sizeOf(first) + sizeOf(last) + turn);  // of the terms, which may cancel
        }
        store(value_lanes, values.data());
        store(size_lanes, sizes.data());
      });
  for (size_t k = 0; k < kLanes; ++k) {
    value += values[k];
    error += kStepsOfKernels * kUnitRounding * sizes[k];
    rounding += (kSteps - kStepsOfKernels) * kUnitRounding * sizes[k];
  }
  count = 0;
}

EdgeRules::EdgeRules() {
  for (size_t round = 0; round < kLineRounds.size(); ++round)
    for (uint32_t k = 0; k < kLineRules; ++k) {
      const int n = static_cast<int>(kLineRounds[round].points[k]);
      Rule& rule = rules_[round][k];
      for (const GaussPoint& point : k == kGradedRule ? gradedPoints(n) : unitPoints(n)) {
        rule.at.push_back(static_cast<double>(point.node));
        rule.weight.push_back(static_cast<double>(point.weight));
      }
    }
}

void EdgeRules::add(Edge p, Edge q, size_t round, EdgeSum& sum) const {
  const double together = dot(p.along, q.along);
  if (dot(p.along, p.along) > dot(q.along, q.along)) std::swap(p, q);
  // The inner integral is analytic up to this distance (`clear`) from the middle of p, in units of half the length of p
  // (shaders/unoccluded/edges.comp).
  const double square_p = dot(p.along, p.along), square_q = dot(q.along, q.along);
  const dvec3 middle = p.start + 0.5 * p.along - q.start,
              off = middle - q.along * std::clamp(dot(middle, q.along) / square_q, 0.0, 1.0);
  const double clear = 2 * std::sqrt(dot(off, off) / square_p);
  const uint32_t which = clear > 12 ? 0 : clear > 3.5 ? 1 : clear > 1.5 ? 2 : kGradedRule;
  if (which == kGradedRule) {
    sum.error += kLineRounds[round].graded_error * std::abs(together);
  } else {
    const double axes = clear + std::sqrt(std::max(clear * clear - 1, 0.0));
    sum.error += 4 / raised(axes * axes, kLineRounds[round].points[which]) * std::abs(together);
  }

  const std::array<double, kMostPieces + 1> cuts = which == kGradedRule
                                                       ? cutsOf(p.start, p.along, q.start, q.along)
                                                       : std::array<double, kMostPieces + 1>{0, 1, 1, 1, 1};
  const Rule& rule = rules_[round][which];
  const size_t points = rule.at.size();
  const double length_q = std::sqrt(square_q);
  const dvec3 direction = q.along / length_q, from = p.start - q.start;
  // The point at the fraction t of p is along_start + t along_slope far along q. Its distance from the line of q is the
  // length of across_start + t across_slope.
  const double along_start = dot(from, direction), along_slope = dot(p.along, direction);
  const dvec3 across_start = cross(from, direction), across_slope = cross(p.along, direction);
  for (size_t piece = 0; piece < kMostPieces; ++piece) {
    const double low = cuts[piece], length = cuts[piece + 1] - low;
    if (!(length > 0)) continue;
    if (sum.count + points > EdgeSum::kMostPoints) sum.evaluate();
    for (size_t k = 0; k < points; ++k) {
      const double t = low + rule.at[k] * length, along = along_start + t * along_slope;
      const dvec3 across = across_start + t * across_slope;
      const size_t next = sum.count + k;
      sum.along[next] = along;
      sum.rest[next] = length_q - along;
      sum.distance[next] = std::sqrt(dot(across, across));
      sum.weight[next] = rule.weight[k] * (length * along_slope);
    }
    sum.count += points;
  }
}

}  // namespace viewpeel
