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

struct Vector {
  Floats x, y, z;
};

VIEWPEEL_INLINE Floats dot(const float* n, const Vector& v) { return n[0] * v.x + n[1] * v.y + n[2] * v.z; }

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
  return __builtin_convertvector((Flags)(x >> 8), Floats) * 0x1p-24f;
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
  const Flags is_large = size > 2.414213562f, is_middle = (size > 0.4142135624f) & ~is_large;
  Floats x = is_large ? -1.0f / size : size;
  x = is_middle ? (size - 1.0f) / (size + 1.0f) : x;
  constexpr float quarter = std::numbers::pi_v<float> / 4;
  const Floats base = is_large ? all(2 * quarter) : is_middle ? all(quarter) : Floats{};
  const Floats s = x * x;
  const Floats angle =
      base + x +
      x * s * (-3.33329491539e-1f + s * (1.99777106478e-1f + s * (-1.38776856032e-1f + s * 8.05374449538e-2f)));
  return tangent < 0.0f ? -angle : angle;
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

LineDrawer::End LineDrawer::endOf(const Patch& patch, const dvec3& origin, bool folds_triangles) {
  End end{};
  end.is_triangle = patch.corner_count == 3 && folds_triangles;
  // Without folding a triangle's last corner is its first one again: a square with one collapsed side.
  const dvec3* const c = patch.corners;
  const dvec3 last = patch.corner_count == 3 ? c[0] : c[3];
  const dvec3 side_a = c[1] - c[0], side_b = (end.is_triangle ? c[2] : last) - c[0],
              twist = end.is_triangle ? dvec3(0) : c[0] - c[1] + c[2] - last;
  toFloats(c[0] - origin, end.corner);
  toFloats(side_a, end.side_a), toFloats(side_b, end.side_b), toFloats(twist, end.twist);
  const dvec3 across = glm::normalize(glm::cross(c[1] - c[0], c[2] - c[0]));
  end.density[0] = static_cast<float>(glm::dot(across, glm::cross(side_a, side_b)) / (end.is_triangle ? 2 : 1));
  end.density[1] = static_cast<float>(glm::dot(across, glm::cross(side_a, twist)));
  end.density[2] = static_cast<float>(glm::dot(across, glm::cross(twist, side_b)));
  toFloats(patch.normal, end.normal);
  end.offset = static_cast<float>(patch.offset - glm::dot(patch.normal, origin));
  end.edge_count = patch.corner_count;
  for (uint32_t e = 0; e < patch.corner_count; ++e) {
    toFloats(patch.edge_normals[e], end.edges[e]);
    end.edges[e][3] = static_cast<float>(glm::dot(patch.edge_normals[e], origin) - patch.edge_offsets[e]);
  }
  return end;
}

LineDrawer::LineDrawer(const Patch& a, const Patch& b, LineWay way, double exchange,
                       const std::vector<Blocker>& blockers, std::span<const PlacedBlocker> between)
    : way_(way) {
  const bool is_swapped = b.area < a.area;
  const Patch &small = is_swapped ? b : a, &large = is_swapped ? a : b;
  const dvec3 origin = small.middle;
  first_ = endOf(small, origin, way != LineWay::angles), second_ = endOf(large, origin, true);
  if (way == LineWay::angles) {
    frameSecond(small, large);
    warpTowards(small, large);
  }
  unit_ = static_cast<float>(way == LineWay::contact ? 1 / exchange : 1 / (std::numbers::pi * exchange));
  for (const PlacedBlocker& placed : between) {
    const Blocker& blocker = blockers[placed.blocker];
    Obstacle& obstacle = obstacles_.emplace_back();
    obstacle.place = placed.place == BlockerPlace::between                      ? BlockerPlace::between
                     : (placed.place == BlockerPlace::over_first) != is_swapped ? BlockerPlace::over_first
                                                                                : BlockerPlace::over_second;
    obstacle.edge_count = blocker.corner_count;
    toFloats(blocker.normal, obstacle.plane);
    obstacle.plane[3] = static_cast<float>(glm::dot(blocker.normal, origin) - blocker.offset);
    for (uint32_t e = 0; e < blocker.corner_count; ++e) {
      toFloats(blocker.edge_normals[e], obstacle.edges[e]);
      obstacle.edges[e][3] = static_cast<float>(glm::dot(blocker.edge_normals[e], origin) - blocker.edge_offsets[e]);
    }
  }
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
    toFloats(axes[axis], second_.axes[axis]);
    double low = INFINITY, high = -INFINITY;
    for (uint32_t k = 0; k < count; ++k) {
      low = std::min(low, glm::dot(axes[axis], seen[k] - small.middle));
      high = std::max(high, glm::dot(axes[axis], seen[k] - small.middle));
    }
    second_.range[axis][0] = static_cast<float>(low), second_.range[axis][1] = static_cast<float>(high);
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
  const auto pointOn = [](const End& of, Floats s, Floats t, Floats& density) __attribute__((always_inline)) {
    if (of.is_triangle) {
      // The square folded onto the triangle, area for area (E. Heitz, A low-distortion map between triangle and square,
      // 2019).
      const Flags is_upper = t > s;
      const Floats half_s = 0.5f * s, half_t = 0.5f * t;
      s = is_upper ? half_s : s - half_t;
      t = is_upper ? t - half_s : half_t;
    }
    const Floats st = s * t;
    density = of.density[0] + of.density[1] * s + of.density[2] * t;
    return Vector{of.corner[0] + of.side_a[0] * s + of.side_b[0] * t + of.twist[0] * st,
                  of.corner[1] + of.side_a[1] * s + of.side_b[1] * t + of.twist[1] * st,
                  of.corner[2] + of.side_a[2] * s + of.side_b[2] * t + of.twist[2] * st};
  };
  const auto isInside = [](const float(*edges)[4], uint32_t count, const Vector& at) __attribute__((always_inline)) {
    Flags is_inside = Flags{} == 0;
    for (uint32_t e = 0; e < count; ++e) is_inside &= dot(edges[e], at) + edges[e][3] <= 0.0f;
    return is_inside;
  };

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
    Floats density_p, density_q, weight, stretch = all(1.0f);
    if (way_ == LineWay::angles)
      for (int axis = 0; axis < 2; ++axis) {
        Floats warped = u[axis] * warps_[axis].scales[0], scale = all(warps_[axis].scales[0]);
        for (int bin = 1; bin < Warp::kBins; ++bin) {
          const Flags is_beyond = u[axis] >= warps_[axis].starts[bin];
          warped = is_beyond
                       ? float(bin) / Warp::kBins + (u[axis] - warps_[axis].starts[bin]) * warps_[axis].scales[bin]
                       : warped;
          scale = is_beyond ? all(warps_[axis].scales[bin]) : scale;
        }
        u[axis] = warped;
        stretch *= scale;
      }
    const Vector p = pointOn(first_, u[0], u[1], density_p);
    Vector d{}, q = p;
    Flags is_open;
    if (way_ == LineWay::points) {
      q = pointOn(second_, u[2], u[3], density_q);
      d = {q.x - p.x, q.y - p.y, q.z - p.z};
      const Floats out = dot(first_.normal, d), in = -dot(second_.normal, d);
      const Floats square = d.x * d.x + d.y * d.y + d.z * d.z;
      is_open = (out > 0.0f) & (in > 0.0f);
      weight = unit_ * (out * in) / (square * square) * (density_p * density_q);
    } else if (way_ == LineWay::angles) {
      const Floats height = dot(second_.normal, p) - second_.offset;
      Floats foot[2], aside[2], spread = unit_ * density_p * stretch;
      for (int axis = 0; axis < 2; ++axis) {
        foot[axis] = dot(second_.axes[axis], p);
        const Floats low = arcTangent((second_.range[axis][0] - foot[axis]) / height),
                     high = arcTangent((second_.range[axis][1] - foot[axis]) / height);
        aside[axis] = height * tangent(low + u[2 + axis] * (high - low));
        spread *= (high - low) * (height * height + aside[axis] * aside[axis]) / height;
      }
      const auto towards = [&](int axis) __attribute__((always_inline)) {
        return aside[0] * second_.axes[0][axis] + aside[1] * second_.axes[1][axis] - height * second_.normal[axis];
      };
      d = {towards(0), towards(1), towards(2)};
      q = {p.x + d.x, p.y + d.y, p.z + d.z};
      const Floats out = dot(first_.normal, d), square = d.x * d.x + d.y * d.y + d.z * d.z;
      is_open = (height > 0.0f) & (out > 0.0f) & isInside(second_.edges, second_.edge_count, q);
      weight = spread * (out * height) / (square * square);
    } else {
      is_open = isInside(second_.edges, second_.edge_count, p);
      weight = unit_ * density_p;
    }
    weight = keep(is_open, weight);
    weights += weight;
    squares += weight * weight;
    for (const Obstacle& obstacle : obstacles_) {
      if (obstacle.place == BlockerPlace::between) {
        const Floats at_p = dot(obstacle.plane, p) + obstacle.plane[3], slope = dot(obstacle.plane, d);
        const Floats t = at_p / -slope;
        const Vector x{p.x + t * d.x, p.y + t * d.y, p.z + t * d.z};
        is_open &= ~((t > 0.0f) & (t < 1.0f) & isInside(obstacle.edges, obstacle.edge_count, x));
      } else {
        is_open &= ~isInside(obstacle.edges, obstacle.edge_count, obstacle.place == BlockerPlace::over_first ? p : q);
      }
      if (!isAny(is_open)) break;
    }
    facing += keep(is_open, weight);
    if ((block & 63) == 63 || block + 1 == end) {
      sums.facing += sumOf(facing), sums.all += sumOf(weights), sums.squares += sumOf(squares);
      facing = weights = squares = Floats{};
    }
  }
  sums.lines = uint64_t(kBlockLines) * (end - first);
  return sums;
}

}  // namespace viewpeel
