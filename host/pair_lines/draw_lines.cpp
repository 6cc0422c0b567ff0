#include "pair_lines/draw_lines.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "pair_lines/lanes.h"

namespace viewpeel {
namespace {

using glm::dvec3;

// Bits of Sobol' points, the first binary digit lowest: of each dimension, for every bit of a point's number in Gray's
// order. Primitive polynomials and first numbers: Joe & Kuo, new-joe-kuo-6.21201, dimensions 1 to 4.
class SobolBits {
 public:
  static constexpr int kBits = 32, kDimensions = 4;

  constexpr SobolBits() {
    constexpr uint32_t degree[] = {0, 1, 2, 3}, coefficients[] = {0, 0, 1, 1};
    constexpr uint32_t first[][3] = {{1, 0, 0}, {1, 0, 0}, {1, 3, 0}, {1, 3, 1}};
    for (int d = 0; d < kDimensions; ++d) {
      uint32_t numbers[kBits] = {};
      for (uint32_t k = 0; k < kBits; ++k) {
        const uint32_t s = degree[d];
        if (s == 0) numbers[k] = 1u << (31 - k);
        else if (k < s) numbers[k] = first[d][k] << (31 - k);
        else {
          numbers[k] = numbers[k - s] ^ (numbers[k - s] >> s);
          for (uint32_t m = 1; m < s; ++m)
            if (coefficients[d] >> (s - 1 - m) & 1) numbers[k] ^= numbers[k - m];
        }
      }
      for (int k = 0; k < kBits; ++k)
        for (int bit = 0; bit < kBits; ++bit) of[d][k] |= (numbers[k] >> bit & 1) << (31 - bit);
    }
    // Of the points of one block, by lane.
    for (int d = 0; d < kDimensions; ++d)
      for (uint32_t lane = 0; lane < kLineLanes; ++lane)
        for (int k = 0; k < 4; ++k)
          if (lane >> k & 1) lanes[d][lane] ^= of[d][k];
  }

  uint32_t of[kDimensions][kBits] = {};
  uint32_t lanes[kDimensions][kLineLanes] = {};
};
constexpr SobolBits kSobol;
static_assert(1 << 4 == kLineLanes);

using Vector = LaneVector<Floats>;

// Owen's scrambling by a hash (B. Burley, Practical hash-based Owen scrambling, JCGT 9(4), 2020; constants of N.
// Vegdahl, Building a better LK hash, 2021), and the numbers in [0, 1) that the digits make.
VIEWPEEL_INLINE Floats scrambled(Words digits, uint32_t seed) {
  Words x = digits ^ (digits * all(0x3d20adeau));
  x += all(seed);
  x *= all(seed >> 16 | 1u);
  x ^= x * all(0x05526c56u);
  x ^= x * all(0x53a22864u);
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  x = (x >> 16) | (x << 16);
  return __builtin_convertvector((Integers)(x >> 8), Floats) * 0x1p-24f;
}

// The tangent of an angle within (-pi/2, pi/2), to 4e-7 of itself: of half the angle, by its series, and then doubled.
VIEWPEEL_INLINE Floats tangent(const Floats& angle) {
  const Floats x = 0.25f * angle, s = x * x;  // |x| < 0.4
  const Floats quarter =
      x * (1.0f +
           s * (1 / 3.f + s * (2 / 15.f + s * (17 / 315.f +
                                               s * (62 / 2835.f + s * (1382 / 155925.f + s * (21844 / 6081075.f)))))));
  const Floats half = 2.0f * quarter / (1.0f - quarter * quarter);
  return 2.0f * half / (1.0f - half * half);
}

// The angle of a tangent, to 3e-7 (S. Moshier, Cephes, atanf).
VIEWPEEL_INLINE Floats arcTangent(const Floats& tangent) {
  const Floats size = tangent < 0.0f ? -tangent : tangent;
  constexpr float large = 2.414213562f, middle = 0.4142135624f, quarter = std::numbers::pi_v<float> / 4;
  Floats x = size > middle ? (size - 1.0f) / (size + 1.0f) : size;
  x = size > large ? -1.0f / size : x;
  Floats base = size > middle ? all(quarter) : Floats{};
  base = size > large ? all(2 * quarter) : base;
  const Floats s = x * x;
  const Floats angle =
      base + x +
      x * s * (-3.33329491539e-1f + s * (1.99777106478e-1f + s * (-1.38776856032e-1f + s * 8.05374449538e-2f)));
  return tangent < 0.0f ? -angle : angle;
}

// Sixteen lines from p to q = p + d. Lines that are not open start or end on a back, or miss the other patch.
struct Lines {
  Vector p, q, d;
  Floats weight;
  Floats open;  // above 0 where it is
};

// Moves u to where the warp is dense; stretch: multiplied by the density that is lost.
template <class Warp>
VIEWPEEL_INLINE void warp(const Warp& by, Floats& u, Floats& stretch) {
  Floats warped = u * by.scales[0], scale = all(by.scales[0]);
  for (int bin = 1; bin < Warp::kBins; ++bin) {
    warped = u >= by.starts[bin] ? float(bin) / Warp::kBins + (u - by.starts[bin]) * by.scales[bin] : warped;
    scale = u >= by.starts[bin] ? all(by.scales[bin]) : scale;
  }
  u = warped;
  stretch *= scale;
}

// Lines from points to points: eq. (43) of docs/method.md.
VIEWPEEL_INLINE Lines drawPoints(const LineEnd<float>& first, const LineEnd<float>& second, const Floats* u) {
  Lines lines;
  Floats density_p, density_q;
  lines.p = pointOn(first, u[0], u[1], density_p);
  lines.q = pointOn(second, u[2], u[3], density_q);
  lines.d = {lines.q.x - lines.p.x, lines.q.y - lines.p.y, lines.q.z - lines.p.z};
  const Floats out = dot(first.normal, lines.d), in = -dot(second.normal, lines.d), square = dot(lines.d, lines.d);
  lines.open = least(out, in);
  lines.weight = (out * in) / (square * square) * (density_p * density_q);
  return lines;
}

// Lines from points by angles: eq. (45).
template <class Rectangle, class Warp>
VIEWPEEL_INLINE Lines drawAngles(const LineEnd<float>& first, const LineEnd<float>& second, const Rectangle& rectangle,
                                 const Warp* warps, const Floats* u) {
  Lines lines;
  Floats at[2] = {u[0], u[1]}, stretch = all(1.0f), density_p;
  for (int axis = 0; axis < 2; ++axis) warp(warps[axis], at[axis], stretch);
  lines.p = pointOn(first, at[0], at[1], density_p);
  const Floats height = dot(second.normal, lines.p) - second.offset;
  Floats aside[2], spread = density_p * stretch;
  for (int axis = 0; axis < 2; ++axis) {
    const Floats foot = dot(rectangle.axes[axis], lines.p);
    const Floats low = arcTangent((rectangle.range[axis][0] - foot) / height),
                 high = arcTangent((rectangle.range[axis][1] - foot) / height);
    aside[axis] = height * tangent(low + u[2 + axis] * (high - low));
    spread *= (high - low) * (height * height + aside[axis] * aside[axis]) / height;
  }
  const auto towards = [&](int axis) __attribute__((always_inline)) {
    return aside[0] * rectangle.axes[0][axis] + aside[1] * rectangle.axes[1][axis] - height * second.normal[axis];
  };
  lines.d = {towards(0), towards(1), towards(2)};
  lines.q = {lines.p.x + lines.d.x, lines.p.y + lines.d.y, lines.p.z + lines.d.z};
  const Floats out = dot(first.normal, lines.d), square = dot(lines.d, lines.d);
  lines.open = least(least(height, out), -beyond(second.edges, second.edge_count, lines.q));
  lines.weight = spread * (out * height) / (square * square);
  return lines;
}

// Lines of no length, between patches of one plane.
VIEWPEEL_INLINE Lines drawContact(const LineEnd<float>& first, const LineEnd<float>& second, const Floats* u) {
  Lines lines;
  lines.p = lines.q = pointOn(first, u[0], u[1], lines.weight);
  lines.d = Vector{};
  lines.open = -beyond(second.edges, second.edge_count, lines.p);
  return lines;
}

// Returns numbers of at most 0 where a line is blocked. Lines along the blocker's plane pass it.
VIEWPEEL_INLINE Floats passing(const Obstacle<float>& by, const Lines& lines) {
  if (by.place != BlockerPlace::between)
    return beyond(by.edges, by.edge_count, by.place == BlockerPlace::over_first ? lines.p : lines.q);
  const Floats at_p = dot(by.plane, lines.p) + by.plane[3], slope = dot(by.plane, lines.d);
  const Floats t = at_p / -slope;
  const Vector x{lines.p.x + t * lines.d.x, lines.p.y + t * lines.d.y, lines.p.z + t * lines.d.z};
  return greatest(greatest(-t, t - 1.0f), beyond(by.edges, by.edge_count, x));
}

void toFloats(const dvec3& v, float* to) {
  for (int axis = 0; axis < 3; ++axis) to[axis] = static_cast<float>(v[axis]);
}

// Of unit length.
dvec3 longestEdge(const Patch& patch) {
  dvec3 longest(0);
  for (uint32_t k = 0; k < patch.corner_count; ++k) {
    const dvec3 edge = patch.corners[(k + 1) % patch.corner_count] - patch.corners[k];
    if (glm::dot(edge, edge) > glm::dot(longest, longest)) longest = edge;
  }
  return glm::normalize(longest);
}

// From a point to a patch, by Lambert's formula; what lies behind the point's plane counts less than 0.
double pointFormFactor(const dvec3& p, const dvec3& normal, const Patch& patch) {
  double sum = 0;
  for (uint32_t k = 0; k < patch.corner_count; ++k) {
    const dvec3 a = patch.corners[k] - p, b = patch.corners[(k + 1) % patch.corner_count] - p,
                across = glm::cross(a, b);
    const double sine = glm::length(across);
    if (sine > 0) sum += glm::dot(normal, across) / sine * std::atan2(sine, glm::dot(a, b));
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

}  // namespace

LineDrawer::LineDrawer(const Patch& a, const Patch& b, LineWay way, double exchange,
                       const std::vector<Blocker>& blockers, std::span<const PlacedBlocker> between)
    : way_(way) {
  const bool is_swapped = b.area < a.area;
  const Patch &small = is_swapped ? b : a, &large = is_swapped ? a : b;
  const dvec3 origin = small.middle;
  first_ = makeLineEnd<float>(small, origin, way != LineWay::angles), second_ = makeLineEnd<float>(large, origin, true);
  if (way == LineWay::angles) {
    frameSecond(small, large);
    warpTowards(small, large);
  }
  unit_ = static_cast<float>(way == LineWay::contact ? 1 / exchange : 1 / (std::numbers::pi * exchange));
  obstacles_ = makeObstacles<float>(blockers, between, origin, is_swapped);
}

// Sets the rectangle of the second patch that angles go to: around what the first patch has in front of it.
void LineDrawer::frameSecond(const Patch& small, const Patch& large) {
  dvec3 seen[8];
  uint32_t count = 0;
  for (uint32_t k = 0; k < large.corner_count; ++k) {
    const dvec3 &p = large.corners[k], &q = large.corners[(k + 1) % large.corner_count];
    const double height_p = glm::dot(small.normal, p) - small.offset,
                 height_q = glm::dot(small.normal, q) - small.offset;
    if (height_p >= 0) seen[count++] = p;
    if ((height_p > 0 && height_q < 0) || (height_p < 0 && height_q > 0))
      seen[count++] = p + height_p / (height_p - height_q) * (q - p);
  }
  const dvec3 along = glm::cross(small.normal, large.normal);
  dvec3 axes[2];
  axes[0] = count == large.corner_count || glm::length(along) < 1e-6 ? longestEdge(large) : glm::normalize(along);
  axes[1] = glm::cross(large.normal, axes[0]);
  for (int axis = 0; axis < 2; ++axis) {
    toFloats(axes[axis], rectangle_.axes[axis]);
    double low = INFINITY, high = -INFINITY;
    for (uint32_t k = 0; k < count; ++k) {
      low = std::min(low, glm::dot(axes[axis], seen[k] - small.middle));
      high = std::max(high, glm::dot(axes[axis], seen[k] - small.middle));
    }
    rectangle_.range[axis][0] = static_cast<float>(low), rectangle_.range[axis][1] = static_cast<float>(high);
  }
}

// Makes points of the first patch denser where the form factor from them is larger, along either coordinate.
void LineDrawer::warpTowards(const Patch& small, const Patch& large) {
  constexpr int kBins = Warp::kBins;
  double sums[2][kBins] = {}, all = 0;
  for (int row = 0; row < kBins; ++row)
    for (int column = 0; column < kBins; ++column) {
      const double s = (row + 0.5) / kBins, t = (column + 0.5) / kBins;
      const dvec3* c = small.corners;
      const dvec3 last = small.corner_count == 3 ? c[0] : c[3];
      const dvec3 p = (1 - s) * ((1 - t) * c[0] + t * last) + s * ((1 - t) * c[1] + t * c[2]);
      const double density = first_.density[0] + s * first_.density[1] + t * first_.density[2];
      if (glm::dot(large.normal, p) <= large.offset) continue;
      const double share = pointFormFactor(p, small.normal, large) * density;
      sums[0][row] += share, sums[1][column] += share, all += share;
    }
  constexpr double kEven = 0.15;  // of the points stay evenly spread
  for (int axis = 0; axis < 2; ++axis) {
    double start = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      const double share = all > 0 ? kEven / kBins + (1 - kEven) * sums[axis][bin] / all : 1.0 / kBins;
      warps_[axis].starts[bin] = static_cast<float>(start);
      warps_[axis].scales[bin] = static_cast<float>(1 / (kBins * share));
      start += share;
    }
  }
}

DrawnLines LineDrawer::draw(const std::array<uint32_t, 4>& scrambles, uint32_t first, uint32_t end,
                            Vectors vectors) const {
  DrawnLines sums;
  runVectorised(
      vectors, [&]() __attribute__((always_inline)) { sums = drawAll(scrambles, first, end); });
  return sums;
}

[[gnu::always_inline]] inline DrawnLines LineDrawer::drawAll(const std::array<uint32_t, 4>& scrambles, uint32_t first,
                                                             uint32_t end) const {
  uint32_t digits[4] = {};
  for (int d = 0; d < 4; ++d)
    for (uint32_t gray = first ^ first >> 1, k = 0; gray >> k; ++k)
      if (gray >> k & 1) digits[d] ^= kSobol.of[d][k + 4];
  DrawnLines sums;
  Floats facing{}, weights{}, squares{};
  for (uint32_t block = first; block < end; ++block) {
    Floats u[4];
    for (int d = 0; d < 4; ++d) {
      u[d] = scrambled(load<Words>(kSobol.lanes[d]) ^ all(digits[d]), scrambles[d]);
      digits[d] ^= kSobol.of[d][4 + std::countr_zero(block + 1)];
    }
    Lines lines = way_ == LineWay::points   ? drawPoints(first_, second_, u)
                  : way_ == LineWay::angles ? drawAngles(first_, second_, rectangle_, warps_, u)
                                            : drawContact(first_, second_, u);
    const Floats weight = keep(lines.open, unit_ * lines.weight);
    weights += weight;
    squares += weight * weight;
    Floats seen = weight;
    for (size_t k = 0; k < obstacles_.size(); ++k) {
      seen = passing(obstacles_[k], lines) <= 0.0f ? Floats{} : seen;
      if (k % 4 == 3 && !isAny(seen)) break;
    }
    facing += seen;
    // Sums of single precision stay short.
    if ((block & 63) == 63 || block + 1 == end) {
      sums.facing += sumOf(facing), sums.all += sumOf(weights), sums.squares += sumOf(squares);
      facing = weights = squares = Floats{};
    }
  }
  sums.lines = uint64_t(kBlockLines) * (end - first);
  return sums;
}

}  // namespace viewpeel
