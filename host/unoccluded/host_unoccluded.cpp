#include "unoccluded/host_unoccluded.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <glm/glm.hpp>

#include "threads.h"
#include "unoccluded/edge_integrals.h"
#include "unoccluded/far_rules.h"
#include "unoccluded/front_parts.h"
#include "unoccluded/shared.h"
#include "vectorised.h"

namespace viewpeel {

using namespace unoccluded_data;
using glm::dot, glm::cross;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr size_t kChunk = 256;  // pairs that a thread takes at once

double leastOf(const std::array<double, 4>& v) { return std::min(std::min(v[0], v[1]), std::min(v[2], v[3])); }
double greatestOf(const std::array<double, 4>& v) { return std::max(std::max(v[0], v[1]), std::max(v[2], v[3])); }

// Returns the depths of the four corners of `shape` over the plane of `plane`.
//   In: normal: the unit normal of the side that spans the plane
std::array<double, 4> depthsOf(const ShapeData& shape, const ShapeData& plane, const dvec3& normal) {
  std::array<double, 4> depths;
  for (size_t k = 0; k < 4; ++k) depths[k] = dot(normal, shape.corners[k] - plane.corners[0]);
  return depths;
}

// Returns how far a depth over the plane of a shape may be off, because the shape's corners are rounded.
//   In: distance: from the shape's middle
double depthRounding(const ShapeData& plane, double distance) { return kFrontRounding + plane.tilt * distance; }

// Returns the largest |slope| / value that a bilinear function on the square has at the middle of an edge, at most 1.
//   In: at: its values at the corners, where the sum of two neighbours is not negative
float slopeOf(const std::array<double, 4>& at) {
  float slope = 0;
  for (size_t k = 0; k < 4; ++k) {
    const auto difference = static_cast<float>(std::abs(at[k] - at[(k + 1) % 4])),
               sum = static_cast<float>(at[k] + at[(k + 1) % 4]);
    slope = std::max(slope, difference >= sum ? (difference > 0 ? 1.0f : 0.0f) : difference / sum);
  }
  return slope;
}

// Coordinates holds the terms of the bound (37) that a polygon's two coordinates share, as in
// shaders/unoccluded/classify.comp.
struct Coordinates {
  float t, square, power;  // t, t^2 and, for a rule of n points, t^(2n - 2)
  float slopes, product;   // s + j and s j
  float factor;            // 2 (1 + t)^4 / (1 - s j / 3)
};

Coordinates coordinatesOf(const ShapeData& shape, double distance, double other_radius, float slope) {
  Coordinates c;
  c.t = static_cast<float>(shape.reach) /
        static_cast<float>(std::max(distance - shape.reach - other_radius, shape.reach));
  c.square = c.power = c.t * c.t;
  const auto skew = static_cast<float>(shape.skew), stretch = (1 + c.t) * (1 + c.t);
  c.slopes = slope + skew;
  c.product = slope * skew;
  c.factor = 2 * stretch * stretch / (1 - c.product / 3);
  return c;
}

float errorOf(const FarBound& rule, const Coordinates& c) {
  const float rest = rule.tail * c.square,
              series = rule.even * c.square + rule.odd * c.slopes * c.t + rule.skew * c.product;
  return rest < 0.5f ? c.factor * c.power * series * (1 + 2 * rest) : 1.0f;
}

// A Patch is a polygon as polynomials of the coordinates u and v of the square, see ShapeData.
struct Patch {
  Stretch along;                  // position
  std::array<double, 4> depth;    // depth over the other polygon's plane: coefficients of 1, u, v and u v
  std::array<double, 3> density;  // area per du dv: coefficients of 1, u and v
};

Patch patchOf(const ShapeData& shape, const std::array<double, 4>& d) {
  return {stretchOf(shape),
          {0.25 * (d[0] + d[1] + d[2] + d[3]), 0.25 * (d[1] + d[2] - d[0] - d[3]), 0.25 * (d[2] + d[3] - d[0] - d[1]),
           0.25 * (d[0] + d[2] - d[1] - d[3])},
          {shape.density, shape.density_u, shape.density_v}};
}

// Returns whether every edge of one polygon is parallel or perpendicular to every edge of the other.
bool haveClosedForms(const ShapeData& a, const ShapeData& b) {
  for (size_t k = 0; k < 4; ++k)
    for (size_t m = 0; m < 4; ++m) {
      const dvec3 p = a.corners[(k + 1) % 4] - a.corners[k], q = b.corners[(m + 1) % 4] - b.corners[m];
      if (dot(p, q) != 0 && !areParallel(p, q)) return false;
    }
  return true;
}

void addWork(const UnoccludedWork& part, UnoccludedWork& sum) {
  sum.unseen_pairs += part.unseen_pairs;
  for (size_t rule = 0; rule < part.far_pairs.size(); ++rule) sum.far_pairs[rule] += part.far_pairs[rule];
  sum.cut_pairs += part.cut_pairs;
  sum.near_pairs += part.near_pairs;
  sum.again_pairs += part.again_pairs;
  sum.line_integrals += part.line_integrals;
}

}  // namespace

// Sides are the two sides of a pair, the one with the lower number first, so that (i, j) and (j, i) have the same
// result.
struct HostUnoccluded::Sides {
  const ShapeData &a, &b;
  dvec3 normal_a, normal_b;                           // unit normals of the sides
  uint32_t plane_a, plane_b, tie_rank_a, tie_rank_b;  // ShapeData::plane and tie_rank, of the sides
  bool is_flipped;                                    // exactly one of the sides is a back
  double distance;                                    // between the mean corners
  Depths depths_a, depths_b;                          // depths of each polygon's corners over the other's plane
  double rounding_a, rounding_b;                      // errors of these depths by rounding

  // Returns whether the sides lie in one plane, face to face, as the faces of touching solids do.
  bool areTouching() const { return (plane_a ^ plane_b) == 1 && tie_rank_a + tie_rank_b < kLastTieRank; }
};

HostUnoccluded::HostUnoccluded(const Scene& scene, size_t thread_count)
    : threads_(thread_count ? thread_count : threadCount()), shapes_(makeShapes(scene)) {
  for (uint32_t rule = 0; rule < kFarRules; ++rule) {
    const int n = static_cast<int>(kFewestFarPoints + rule);
    bounds_[rule] = farBound(n);
    for (const GaussPoint& point : gaussPoints(n))
      far_points_[rule].push_back({static_cast<double>(point.node), static_cast<double>(point.weight)});
  }
}

HostUnoccluded::Sides HostUnoccluded::sidesOf(const SidePair& pair) const {
  const uint32_t first = std::min(pair.i, pair.j), second = std::max(pair.i, pair.j);
  const ShapeData &a = shapes_[first / 2], &b = shapes_[second / 2];
  const auto rankOf = [](const ShapeData& shape, uint32_t side) {
    return side % 2 ? kLastTieRank - shape.tie_rank : shape.tie_rank;
  };
  Sides sides{a,
              b,
              first % 2 ? -a.normal : a.normal,
              second % 2 ? -b.normal : b.normal,
              a.plane ^ (first % 2),
              b.plane ^ (second % 2),
              rankOf(a, first),
              rankOf(b, second),
              (first ^ second) % 2 == 1,
              0,
              {},
              {},
              0,
              0};
  sides.distance = glm::length(meanCorner(b) - meanCorner(a));
  sides.depths_a = depthsOf(a, b, sides.normal_b);
  sides.depths_b = depthsOf(b, a, sides.normal_a);
  sides.rounding_a = depthRounding(b, sides.distance + a.radius);
  sides.rounding_b = depthRounding(a, sides.distance + b.radius);
  return sides;
}

// Returns a bound on the relative rounding of a far pair: of its sums, and of corners in areas, distance and depths.
double HostUnoccluded::roundingOf(const Sides& sides) {
  constexpr double kSteps = 64;
  const auto meanOf = [](const Depths& depths) { return 0.25 * (depths[0] + depths[1] + depths[2] + depths[3]); };
  return kUnitRounding * (kSteps + 8 * sides.a.radius / sides.a.area + 8 * sides.b.radius / sides.b.area +
                          8 / sides.distance + 4 / meanOf(sides.depths_a) + 4 / meanOf(sides.depths_b));
}

// Returns how a pair is integrated: the number of its product rule, kNearList where it is integrated along its
// contours, or `unseen`. The kernels would put it into the list of the same number.
//   Out: far_error: a bound on the relative error of a far pair, of the rule and of rounding
uint32_t HostUnoccluded::classify(const Sides& sides, double& far_error) const {
  const ShapeData &a = sides.a, &b = sides.b;
  bool is_seen = greatestOf(sides.depths_a) > sides.rounding_a && greatestOf(sides.depths_b) > sides.rounding_b;
  if (sides.plane_a >> 1 == sides.plane_b >> 1)
    is_seen = sides.areTouching() && sides.distance < a.radius + b.radius && &a != &b;
  if (!is_seen) return unseen;
  if (leastOf(sides.depths_a) <= 0 || leastOf(sides.depths_b) <= 0 || sides.areTouching()) return kNearList;
  return chooseRule(sides, far_error);
}

// Returns the number of the first product rule whose bound is small enough, or kNearList where there is none.
//   In: sides: neither reaches behind the other's plane    Out: far_error: as from classify
uint32_t HostUnoccluded::chooseRule(const Sides& sides, double& far_error) const {
  const ShapeData &a = sides.a, &b = sides.b;
  Coordinates over_a = coordinatesOf(a, sides.distance, b.radius, slopeOf(sides.depths_a)),
              over_b = coordinatesOf(b, sides.distance, a.radius, slopeOf(sides.depths_b));
  for (uint32_t rule = 0; rule < kFarRules; ++rule) {
    const float error = errorOf(bounds_[rule], over_a) + errorOf(bounds_[rule], over_b);
    if (error <= kFarError) {
      far_error = double(error) + roundingOf(sides);
      return rule;
    }
    over_a.power *= over_a.square;
    over_b.power *= over_b.square;
  }
  return kNearList;
}

// Returns the exchange area by a product Gauss rule: docs/method.md, eq. (35).
double HostUnoccluded::integrateFar(const Sides& sides, uint32_t rule) const {
  // Points of b fill whole vectors: after the last point come copies of the first, whose sums are not used.
  constexpr size_t kLanes = 8, kMostPoints = (kMostFar * kMostFar + kLanes - 1) / kLanes * kLanes;
  struct Points {
    std::array<double, kMostPoints> x, y, z, weight;
  };
  const std::vector<Point>& points = far_points_[rule];
  const size_t count = points.size() * points.size(), padded = (count + kLanes - 1) / kLanes * kLanes;
  const auto fill = [&](const Patch& patch, const dvec3& middle, Points& all) {
    size_t k = 0;
    for (const Point& u : points)
      for (const Point& v : points) {
        const dvec3 at =
            middle + u.at * patch.along.along_u + v.at * (patch.along.along_v + u.at * patch.along.along_uv);
        const double density = patch.density[0] + patch.density[1] * u.at + patch.density[2] * v.at;
        const double depth =
            patch.depth[0] + patch.depth[1] * u.at + patch.depth[2] * v.at + patch.depth[3] * (u.at * v.at);
        all.x[k] = at.x;
        all.y[k] = at.y;
        all.z[k] = at.z;
        all.weight[k++] = u.weight * v.weight * density * depth;
      }
  };
  Points over_a, over_b;
  fill(patchOf(sides.a, sides.depths_a), dvec3(0), over_a);
  fill(patchOf(sides.b, sides.depths_b), meanCorner(sides.b) - meanCorner(sides.a), over_b);
  for (size_t m = count; m < padded; ++m)
    over_b.x[m] = over_b.x[0], over_b.y[m] = over_b.y[0], over_b.z[m] = over_b.z[0];
  std::array<double, kMostPoints> sums{};  // by point of b
  runVectorised(
      widestVectors(), [&]() __attribute__((always_inline)) {
        const double *x = over_b.x.data(), *y = over_b.y.data(), *z = over_b.z.data();
        double* sum = sums.data();
        for (size_t k = 0; k < count; ++k) {
          const double from_x = over_a.x[k], from_y = over_a.y[k], from_z = over_a.z[k], weight = over_a.weight[k];
          VIEWPEEL_INDEPENDENT
          for (size_t m = 0; m < padded; ++m) {
            const double dx = x[m] - from_x, dy = y[m] - from_y, dz = z[m] - from_z,
                         square = dx * dx + dy * dy + dz * dz;
            sum[m] += weight / (square * square);
          }
        }
      });
  double sum = 0;
  for (size_t m = 0; m < count; ++m) sum += over_b.weight[m] * sums[m];
  return sum / kPi;
}

// Returns how much the rounding of a's corners changes the exchange area. It moves the contour of a. Of what a point
// of this contour emits, b takes at most all, and at most its area over pi r^2 if it is no nearer than r.
double HostUnoccluded::errorOfCorners(const ShapeData& a, const ShapeData& b) {
  const dvec3 middle = meanCorner(b);
  double square = INFINITY;
  for (size_t k = 0; k < std::size(a.corners); ++k) {
    const dvec3 along = a.corners[(k + 1) % std::size(a.corners)] - a.corners[k], to_middle = middle - a.corners[k];
    const double length_square = dot(along, along),
                 at = length_square > 0 ? std::clamp(dot(to_middle, along) / length_square, 0.0, 1.0) : 0;
    const dvec3 apart = to_middle - at * along;
    square = std::min(square, dot(apart, apart));
  }
  const double least = std::max(0.0, std::sqrt(square) - b.radius);
  return 8 * kUnitRounding * a.radius * std::min(1.0, b.area / (kPi * least * least));
}

// Returns the exchange area by product rules over the parts of the sides in front of each other's planes. It returns
// nothing where the sides are too near for these rules, or have closed forms.
std::optional<HostUnoccluded::Found> HostUnoccluded::integrateCut(const Sides& sides) const {
  constexpr double kNear = 2;  // in radii; nearer sides rarely have a rule
  if (sides.areTouching() || sides.distance < kNear * (sides.a.radius + sides.b.radius)) return std::nullopt;
  if (haveClosedForms(sides.a, sides.b)) return std::nullopt;
  const FrontParts of_a = frontPartsOf(sides.a, sides.depths_a, sides.rounding_a),
                   of_b = frontPartsOf(sides.b, sides.depths_b, sides.rounding_b);
  Found found;
  for (size_t k = 0; k < of_a.count; ++k)
    for (size_t m = 0; m < of_b.count; ++m) {
      const FrontPart &a = of_a.parts[k], &b = of_b.parts[m];
      const Sides parts{a.shape,          b.shape,
                        sides.normal_a,   sides.normal_b,
                        sides.plane_a,    sides.plane_b,
                        sides.tie_rank_a, sides.tie_rank_b,
                        sides.is_flipped, glm::length(meanCorner(b.shape) - meanCorner(a.shape)),
                        a.depths,         b.depths,
                        sides.rounding_a, sides.rounding_b};
      double error = 0;
      const uint32_t rule = chooseRule(parts, error);
      if (rule == kNearList) return std::nullopt;
      const double area = integrateFar(parts, rule);
      found.area += area, found.error += error * area;
    }
  if (!(found.error <= kUnoccludedRelativeError * found.area)) return std::nullopt;
  return found;
}

// Returns the exchange area by integrals along the contours of the two parts in front of each other's planes:
//   A_i F_ij = 1 / (2 pi) oint_i oint_j ln r ds . dt.
//   Out: error, further_rounding: as error and rounding of EdgeSum, without rounding of corners; work: raised
double HostUnoccluded::integrateNear(const Sides& sides, size_t round, Lines lines, double& error,
                                     double& further_rounding, UnoccludedWork& work) const {
  const dvec3 origin = meanCorner(sides.a);
  // In this unit the logarithms of closed forms are small, so that little cancels.
  const double unit = lines == Lines::by_rules ? 1 : sides.distance + sides.a.radius + sides.b.radius;
  const auto frontEdges = [&](const ShapeData& shape, const Depths& depths, double rounding) {
    constexpr Depths kWhole{1, 1, 1, 1};  // for touching sides, so that nothing is cut off
    const FrontCorners front = frontCornersOf(shape, sides.areTouching() ? kWhole : depths, rounding);
    std::array<Edge, std::tuple_size_v<decltype(front.corners)>> edges;
    for (size_t k = 0; k < front.count; ++k) {
      const dvec3 start = (front.corners[k].at - origin) / unit,
                  end = (front.corners[(k + 1) % front.count].at - origin) / unit;
      edges[k] = {start, end - start};
    }
    return edges;
  };
  const auto edges_a = frontEdges(sides.a, sides.depths_a, sides.rounding_a);
  const auto edges_b = frontEdges(sides.b, sides.depths_b, sides.rounding_b);
  EdgeSum sum;
  for (const Edge& p : edges_a)
    for (const Edge& q : edges_b) {
      if (dot(p.along, q.along) == 0) continue;
      if (lines == Lines::parallel_closed && areParallel(p.along, q.along))
        sum.value += integrateParallel(p, q, sum.error);
      else edge_rules_.add(p, q, round, sum);
      ++work.line_integrals;
    }
  sum.evaluate();
  error = unit * unit * sum.error / (2 * kPi), further_rounding = unit * unit * sum.rounding / (2 * kPi);
  return (sides.is_flipped ? -sum.value : sum.value) * unit * unit / (2 * kPi);
}

HostUnoccluded::Found HostUnoccluded::find(const SidePair& pair, UnoccludedWork& work) const {
  return find(pair, Lines::by_rules, work);
}

HostUnoccluded::Found HostUnoccluded::findClosely(const SidePair& pair, UnoccludedWork& work) const {
  const Found found = find(pair, Lines::parallel_closed, work);
  // Slivers exchange less than the rounding of the closed forms' large terms, so that rules are better for them.
  if (found.error <= kUnoccludedRelativeError * found.area) return found;
  return find(pair, Lines::by_rules, work);
}

HostUnoccluded::Found HostUnoccluded::find(const SidePair& pair, Lines lines, UnoccludedWork& work) const {
  const Sides sides = sidesOf(pair);
  double far_error = 0;
  const uint32_t way = classify(sides, far_error);
  if (way == unseen) {
    ++work.unseen_pairs;
    return {};
  }
  if (way != kNearList) {
    ++work.far_pairs[way];
    const double area = integrateFar(sides, way);
    return {area, far_error * area};
  }
  if (lines == Lines::parallel_closed)
    if (const std::optional<Found> cut = integrateCut(sides)) {
      ++work.cut_pairs;
      return *cut;
    }
  ++work.near_pairs;
  const double least = kUnoccludedAbsoluteError * std::min(sides.a.area, sides.b.area);
  Found found;
  double further_rounding = 0;
  for (size_t round = 0; round < kLineRounds.size(); ++round) {
    work.again_pairs += round > 0;
    found.area = integrateNear(sides, round, lines, found.error, further_rounding, work);
    found.is_reached = found.error <= std::max(least, kUnoccludedRelativeError * found.area);
    // Polygons of one plane that do not overlap exchange nothing.
    if (sides.areTouching() && found.area <= least) found.area = 0;
    found.area = std::max(found.area, 0.0);
    if (found.is_reached) break;
  }
  // More points of a rule would not reduce these errors, so is_reached is decided without them.
  found.error += further_rounding + errorOfCorners(sides.a, sides.b) + errorOfCorners(sides.b, sides.a);
  return found;
}

std::vector<UnreachedPair> HostUnoccluded::compute(std::span<const SidePair> pairs, std::span<double> areas) {
  std::vector<UnoccludedWork> works(threads_);
  std::vector<std::vector<UnreachedPair>> unreached(threads_);
  shareOut(threads_, pairs.size(), kChunk, [&](size_t thread, size_t k) {
    const Found found = find(pairs[k], works[thread]);
    areas[k] = found.area;
    if (!found.is_reached) unreached[thread].push_back({k, found.error});
  });
  std::vector<UnreachedPair> all;
  for (size_t thread = 0; thread < threads_; ++thread) {
    addWork(works[thread], work_);
    all.insert(all.end(), unreached[thread].begin(), unreached[thread].end());
  }
  work_.pairs += pairs.size();
  std::sort(all.begin(), all.end(), [](const UnreachedPair& a, const UnreachedPair& b) { return a.pair < b.pair; });
  return all;
}

}  // namespace viewpeel
