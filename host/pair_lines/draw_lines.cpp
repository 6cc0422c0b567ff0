#include "pair_lines/draw_lines.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "lanes.h"
#include "pair_lines/shared.h"
#include "pair_lines/sobol_points.h"

namespace viewpeel {
namespace {

using glm::dvec3;
using namespace pair_lines_data;  // constants of shaders/pair_lines/pair_lines.h

// Returns the tangent of an angle within (-pi/2, pi/2), to 4e-7 of itself where it is below 1e6. With x the tangent of
// a quarter of the angle, by its series, it is 4 x (1 - x^2) / ((1 - x^2)^2 - 4 x^2).
template <class Floats>
VIEWPEEL_INLINE Floats tangent(const Floats& angle) {
  const Floats a = 0.25f * angle, s = a * a;  // |a| < 0.4
  const Floats x =
      a * (1.0f +
           s * (kTangent3 + s * (kTangent5 + s * (kTangent7 + s * (kTangent9 + s * (kTangent11 + s * kTangent13))))));
  const Floats square = x * x, rest = 1.0f - square, below = rest * rest - 4.0f * square;
  return 4.0f * x * rest * reciprocal(greatest(below, Floats(kLeast)));
}

// Returns the angle of (adjacent, opposite) from the first axis, to 4e-7 (S. Moshier, Cephes, atanf).
//   In: adjacent: above 0    Out: within (-pi/2, pi/2)
template <class Floats>
VIEWPEEL_INLINE Floats arcTangent(const Floats& opposite, const Floats& adjacent) {
  const Floats size = sizeOf(opposite), none{};
  const Floats over_large = size - kLargeTangent * adjacent, over_middle = size - kMiddleTangent * adjacent;
  Floats above = ifBelow(none, over_middle, size - adjacent, size),
         below = ifBelow(none, over_middle, size + adjacent, adjacent);
  above = ifBelow(none, over_large, -adjacent, above);
  below = ifBelow(none, over_large, size, below);
  Floats base = ifBelow(none, over_middle, Floats(kEighthTurn), none);
  base = ifBelow(none, over_large, Floats(kQuarterTurn), base);
  const Floats x = above * reciprocal(below), s = x * x;
  const Floats angle = base + x + x * s * (kArcTangent3 + s * (kArcTangent5 + s * (kArcTangent7 + s * kArcTangent9)));
  return ifBelow(opposite, none, -angle, angle);
}

// Lines are sixteen lines from p to q = p + d. A line is open unless an end lies on a back or q misses the other patch.
template <class Floats>
struct Lines {
  LaneVector<Floats> p, q, d;
  Floats weight;
  Floats open;  // above 0 where the line is open
};

// Moves uniform numbers u so that they are denser in the warp's important bins, and multiplies `stretch` by 1 over
// their density.
template <class Warp, class Floats>
VIEWPEEL_INLINE void warp(const Warp& by, Floats& u, Floats& stretch) {
  Floats warped = u * by.scales[0], scale = by.scales[0];
  for (int bin = 1; bin < Warp::kBins; ++bin) {
    const Floats start = by.starts[bin];
    warped = ifAtMost(start, u, float(bin) / Warp::kBins + (u - start) * by.scales[bin], warped);
    scale = ifAtMost(start, u, Floats(by.scales[bin]), scale);
  }
  u = warped;
  stretch *= scale;
}

// Draws lines from points of one patch to points of the other, eq. (43) of docs/method.md.
template <class Floats>
VIEWPEEL_INLINE Lines<Floats> drawPoints(const LineEnd<float>& first, const LineEnd<float>& second, const Floats* u) {
  Lines<Floats> lines;
  Floats density_p, density_q;
  lines.p = pointOn(first, u[0], u[1], density_p);
  lines.q = pointOn(second, u[2], u[3], density_q);
  lines.d = {lines.q.x - lines.p.x, lines.q.y - lines.p.y, lines.q.z - lines.p.z};
  const Floats out = dot(first.normal, lines.d), in = -dot(second.normal, lines.d), square = dot(lines.d, lines.d);
  const Floats inverse = reciprocal(greatest(square, Floats(kLeastSquare)));
  lines.open = least(out, in);
  lines.weight = (out * inverse) * (in * inverse) * (density_p * density_q);
  return lines;
}

// Draws lines from points of the first patch at random angles to the second one's plane, eq. (45) of docs/method.md.
template <class Rectangle, class Warp, class Floats>
VIEWPEEL_INLINE Lines<Floats> drawAngles(const LineEnd<float>& first, const LineEnd<float>& second,
                                         const Rectangle& rectangle, const Warp* warps, const Floats* u) {
  Lines<Floats> lines;
  Floats at[2] = {u[0], u[1]}, stretch = 1.0f, density_p;
  for (int axis = 0; axis < 2; ++axis) warp(warps[axis], at[axis], stretch);
  lines.p = pointOn(first, at[0], at[1], density_p);
  const Floats over = dot(second.normal, lines.p) - second.offset, height = greatest(over, Floats(kLeast));
  Floats aside[2], turn[2];
  for (int axis = 0; axis < 2; ++axis) {
    const Floats foot = dot(rectangle.axes[axis], lines.p);
    const Floats low = arcTangent<Floats>(rectangle.range[axis][0] - foot, height),
                 high = arcTangent<Floats>(rectangle.range[axis][1] - foot, height);
    turn[axis] = high - low;
    aside[axis] = height * tangent<Floats>(low + u[2 + axis] * turn[axis]);
  }
  const auto towards = [&](int axis) __attribute__((always_inline)) {
    return aside[0] * rectangle.axes[0][axis] + aside[1] * rectangle.axes[1][axis] - height * second.normal[axis];
  };
  lines.d = {towards(0), towards(1), towards(2)};
  lines.q = {lines.p.x + lines.d.x, lines.p.y + lines.d.y, lines.p.z + lines.d.z};
  const Floats out = dot(first.normal, lines.d), inverse = reciprocal(dot(lines.d, lines.d));
  lines.open = least(least(over - kLeast, out), -beyond(second.edges, second.edge_count, lines.q));
  Floats spread = density_p * stretch * (out * reciprocal(height));
  for (int axis = 0; axis < 2; ++axis) spread *= turn[axis] * ((height * height + aside[axis] * aside[axis]) * inverse);
  lines.weight = spread;
  return lines;
}

// Draws lines of length 0, from points of one patch to the same points of the other; both lie in one plane.
template <class Floats>
VIEWPEEL_INLINE Lines<Floats> drawContact(const LineEnd<float>& first, const LineEnd<float>& second, const Floats* u) {
  Lines<Floats> lines;
  lines.p = lines.q = pointOn(first, u[0], u[1], lines.weight);
  lines.d = {};
  lines.open = -beyond(second.edges, second.edge_count, lines.p);
  return lines;
}

// Returns a number for each line: at most 0 where the obstacle blocks it. The line meets the obstacle's plane at p + (t
// / size) d. All terms are multiplied by size > 0; where size is 0 the line runs along the plane and passes.
template <class Floats>
VIEWPEEL_INLINE Floats passing(const Obstacle<float>& by, const Lines<Floats>& lines) {
  if (by.place != BlockerPlace::between)
    return beyond(by.edges, by.edge_count, by.place == BlockerPlace::over_first ? lines.p : lines.q);
  const Floats at_p = dot(by.plane, lines.p) + by.plane[3], slope = dot(by.plane, lines.d);
  const Floats size = sizeOf(slope), t = ifBelow(slope, Floats{}, at_p, -at_p);
  const LaneVector<Floats> x{size * lines.p.x + t * lines.d.x, size * lines.p.y + t * lines.d.y,
                             size * lines.p.z + t * lines.d.z};
  Floats most = greatest(-t, t + kLeastSquare - size);
  for (uint32_t e = 0; e < by.edge_count; ++e) most = greatest(most, dot(by.edges[e], x) + by.edges[e][3] * size);
  return most;
}

using Point = LaneVector<float>;

Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
Point pointOf(const float* v) { return {v[0], v[1], v[2]}; }

// Returns form factors from points to a polygon, by Lambert's formula. Parts behind a point's plane count negative.
template <class Floats>
VIEWPEEL_INLINE Floats pointFormFactors(const LaneVector<Floats>& p, const float* normal, const Point* corners,
                                        uint32_t count) {
  Floats sum{};
  const auto towards = [&](const Point& corner) __attribute__((always_inline)) {
    return LaneVector<Floats>{corner.x - p.x, corner.y - p.y, corner.z - p.z};
  };
  for (uint32_t k = 0; k < count; ++k) {
    const LaneVector<Floats> a = towards(corners[k]), b = towards(corners[k + 1 < count ? k + 1 : 0]);
    const LaneVector<Floats> across{a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
    const Floats square = greatest(dot(across, across), Floats(kLeastSquare)), inverse = inverseRoot(square);
    const Floats sine = square * inverse, cosine = dot(a, b), size = sizeOf(cosine);
    const Floats angle = arcTangent<Floats>(sine, greatest(size, Floats(kLeastSquare)));
    sum += dot(normal, across) * inverse * ifBelow(cosine, Floats{}, kHalfTurn - angle, angle);
  }
  return sizeOf(sum) * kInverseTurn;
}

}  // namespace

static_assert(LineDrawer::kPortionBlocks == pair_lines_data::kPortionBlocks && LineDrawer::kBlockLines == kBlockLanes);

float unitOfWeights(LineWay way, double exchange) {
  return static_cast<float>(way == LineWay::contact ? 1 / exchange : 1 / (std::numbers::pi * exchange));
}

LineDrawer::LineDrawer(const Patch& a, const Patch& b, LineWay way, double exchange,
                       const std::vector<Blocker>& blockers, std::span<const PlacedBlocker> between)
    : way_(way) {
  const bool is_swapped = b.area < a.area;
  const Patch &small = is_swapped ? b : a, &large = is_swapped ? a : b;
  const dvec3 origin = small.middle;
  first_ = makeLineEnd<float>(small, origin, way != LineWay::angles), second_ = makeLineEnd<float>(large, origin, true);
  if (way == LineWay::angles) {
    Point corners[4];
    for (uint32_t k = 0; k < large.corner_count; ++k) corners[k] = pointOf(large.corners[k] - origin);
    frameSecond(corners, large.corner_count);
    warpTowards(corners, large.corner_count, widestVectors());
  }
  unit_ = unitOfWeights(way, exchange);
  obstacles_ = makeObstacles<float>(blockers, between, origin, is_swapped);
}

// Finds the rectangle that lines by angles aim at. It surrounds the part of the second patch in front of the first one.
void LineDrawer::frameSecond(const Point* corners, uint32_t count) {
  Point seen[8], longest{0, 0, 0};
  uint32_t seen_count = 0;
  float longest_square = 0;
  bool is_cut = false;
  for (uint32_t k = 0; k < count; ++k) {
    const Point &p = corners[k], &q = corners[k + 1 < count ? k + 1 : 0], along{q.x - p.x, q.y - p.y, q.z - p.z};
    if (const float square = dot(along, along); square > longest_square) longest = along, longest_square = square;
    const float over_p = dot(first_.normal, p) - first_.offset, over_q = dot(first_.normal, q) - first_.offset;
    if (over_p >= 0) seen[seen_count++] = p;
    else is_cut = true;
    if ((over_p > 0 && over_q < 0) || (over_p < 0 && over_q > 0)) {
      const float at = over_p * reciprocal(greatest(std::abs(over_p - over_q), kLeast)) * (over_p > 0 ? 1.0f : -1.0f);
      seen[seen_count++] = {p.x + at * along.x, p.y + at * along.y, p.z + at * along.z};
    }
  }
  const Point normal = pointOf(second_.normal), fold = cross(pointOf(first_.normal), normal);
  Point axes[2];
  axes[0] = is_cut && dot(fold, fold) >= kParallelSquare ? fold : longest;
  const float inverse = inverseRoot(greatest(dot(axes[0], axes[0]), kLeastSquare));
  axes[0] = {axes[0].x * inverse, axes[0].y * inverse, axes[0].z * inverse};
  axes[1] = cross(normal, axes[0]);
  for (int axis = 0; axis < 2; ++axis) {
    rectangle_.axes[axis][0] = axes[axis].x, rectangle_.axes[axis][1] = axes[axis].y,
    rectangle_.axes[axis][2] = axes[axis].z;
    float low = kFarAway, high = -kFarAway;
    for (uint32_t k = 0; k < seen_count; ++k) {
      const float at = dot(axes[axis], seen[k]);
      low = least(low, at), high = greatest(high, at);
    }
    rectangle_.range[axis][0] = low, rectangle_.range[axis][1] = high;
  }
}

// Makes points of the first patch denser where the form factor to the second patch is larger, along either side.
void LineDrawer::warpTowards(const Point* corners, uint32_t count, Vectors vectors) {
  constexpr int kBins = Warp::kBins;
  static_assert(kLineLanes == 2 * kBins);
  float shares[kBins * kBins];
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
        using Floats = typename Types::Floats;
        for (int row = 0; row < kBins; row += 2) {
          float s[kLineLanes], t[kLineLanes];
          for (int lane = 0; lane < kLineLanes; ++lane)
            s[lane] = (float(row + lane / kBins) + 0.5f) / kBins, t[lane] = (float(lane % kBins) + 0.5f) / kBins;
          Floats density;
          const LaneVector<Floats> p = pointOn(first_, load<Floats>(s), load<Floats>(t), density);
          const Floats over = dot(second_.normal, p) - second_.offset;
          const Floats share = keep<Floats>(over, pointFormFactors(p, first_.normal, corners, count) * density);
          std::memcpy(shares + row * kBins, share.of, sizeof share.of);
        }
      });
  float sums[2][kBins] = {}, all_shares = 0;
  for (int row = 0; row < kBins; ++row)
    for (int column = 0; column < kBins; ++column) {
      const float share = shares[row * kBins + column];
      sums[0][row] += share, sums[1][column] += share;
    }
  for (const float sum : sums[0]) all_shares += sum;
  const bool is_seen = all_shares > kLeastSquare;
  const float part = kUnevenShare * reciprocal(greatest(all_shares, kLeastSquare));
  for (int axis = 0; axis < 2; ++axis) {
    float start = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      const float share = is_seen ? kEvenShare / kBins + part * sums[axis][bin] : 1.0f / kBins;
      warps_[axis].starts[bin] = start;
      warps_[axis].scales[bin] = reciprocal(kBins * share);
      start += share;
    }
  }
}

DrawnLines LineDrawer::draw(const std::array<uint32_t, 4>& scrambles, uint32_t first, uint32_t end,
                            Vectors vectors) const {
  DrawnLines sums;
  runInLanes(
      vectors, [&]<class Types>(Types)
                   __attribute__((always_inline)) { sums = drawAll<Types>(scrambles, first, end); });
  return sums;
}

template <class Types>
[[gnu::always_inline]] inline DrawnLines LineDrawer::drawAll(const std::array<uint32_t, 4>& scrambles, uint32_t first,
                                                             uint32_t end) const {
  using Floats = typename Types::Floats;
  uint32_t digits[4] = {};
  for (int d = 0; d < 4; ++d)
    for (uint32_t gray = first ^ first >> 1, k = 0; gray >> k; ++k)
      if (gray >> k & 1) digits[d] ^= kSobol.of[d][k + 4];
  DrawnLines sums;
  Floats facing{}, weights{}, squares{};
  for (uint32_t block = first; block < end; ++block) {
    Floats u[4];
    for (int d = 0; d < 4; ++d) {
      u[d] = scrambled(load<typename Types::Words>(kSobol.lanes[d]) ^ digits[d], scrambles[d]);
      digits[d] ^= kSobol.of[d][4 + std::countr_zero(block + 1)];
    }
    Lines<Floats> lines = way_ == LineWay::points   ? drawPoints(first_, second_, u)
                          : way_ == LineWay::angles ? drawAngles(first_, second_, rectangle_, warps_, u)
                                                    : drawContact(first_, second_, u);
    const Floats weight = keep(lines.open, least(unit_ * lines.weight, Floats(kMostWeight)));
    weights += weight;
    squares += weight * weight;
    Floats seen = weight;
    for (size_t k = 0; k < obstacles_.size(); ++k) {
      seen = ifAtMost(passing(obstacles_[k], lines), Floats{}, Floats{}, seen);
      if (k % 4 == 3 && !isAnyBelow(Floats{}, seen)) break;
    }
    facing += seen;
    // Only the sums of one portion are in single precision, so their rounding stays small. Sums of portions are added
    // in double precision.
    if ((block + 1) % kPortionBlocks == 0 || block + 1 == end) {
      sums.facing += double(sumOf(facing)), sums.all += double(sumOf(weights)), sums.squares += double(sumOf(squares));
      facing = weights = squares = Floats{};
    }
  }
  sums.lines = uint64_t(kBlockLines) * (end - first);
  return sums;
}

}  // namespace viewpeel
