#include "engines/outlines.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "engines/lattice.h"
#include "hash.h"
#include <viewpeel/scene.h>

namespace viewpeel {
namespace {

constexpr double kInfinite = HUGE_VAL;

// Returns floor(x) for |x| < 2^31. All steps but the last are on doubles, because vector instructions need operands of
// one width.
[[gnu::always_inline]] inline int32_t floorOf(double x) {
  const auto whole = static_cast<double>(static_cast<int32_t>(x));
  return static_cast<int32_t>(whole - (whole > x ? 1.0 : 0.0));
}

[[gnu::always_inline]] inline int32_t ceilOf(double x) {
  const auto whole = static_cast<double>(static_cast<int32_t>(x));
  return static_cast<int32_t>(whole + (whole < x ? 1.0 : 0.0));
}

// Returns ceil(value / 2^bits) for |value| < 2^25 and bits <= 24.
[[gnu::always_inline]] inline int32_t shiftUpward(int32_t value, int bits) { return (value + (1 << bits) - 1) >> bits; }

}  // namespace

SweepScene::SweepScene(const Scene& scene, const Ids& ids)
    : two_sided(ids.two_sided), all_count(ids.roles.empty()), counts_environment(ids.counts_environment) {
  // This open-addressing hash table holds the places, in x, y and z, of the corners found so far.
  std::vector<uint32_t> places(std::bit_ceil(2 * scene.corners.size() + 1), UINT32_MAX);
  const auto placeOf = [&](const glm::dvec3& corner) {
    Hash hash;
    for (const double c : {corner.x, corner.y, corner.z}) hash.add(c);
    for (size_t at = hash.value() & (places.size() - 1);; at = (at + 1) & (places.size() - 1)) {
      uint32_t& place = places[at];
      if (place == UINT32_MAX) {
        place = static_cast<uint32_t>(x.size());
        x.push_back(corner.x);
        y.push_back(corner.y);
        z.push_back(corner.z);
      }
      if (x[place] == corner.x && y[place] == corner.y && z[place] == corner.z) return place;
    }
  };
  // Planes are numbered in the order in which polygons first use them, so that a pass over the polygons reads them one
  // after the other.
  std::vector<uint32_t> number_of(scene.planes.size(), UINT32_MAX);
  const auto numberOf = [&](uint32_t plane_index) {
    uint32_t& number = number_of[plane_index];
    if (number != UINT32_MAX) return number;
    const Plane& plane = scene.planes[plane_index];
    number = static_cast<uint32_t>(offset.size());
    normal_x.push_back(plane.normal.x);
    normal_y.push_back(plane.normal.y);
    normal_z.push_back(plane.normal.z);
    offset.push_back(plane.offset);
    return number;
  };
  std::vector<uint32_t> order(scene.polygons.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_partition(order.begin(), order.end(), [&](uint32_t k) { return (ids.rolesOf(k) & kEmits) != 0; });
  polygons.reserve(order.size());
  for (const uint32_t k : order) {
    const viewpeel::Polygon& polygon = scene.polygons[k];
    polygons.push_back({k, numberOf(polygon.plane), ids.of_polygon[k], ids.rolesOf(k), polygon.tie_rank});
    for (uint32_t c = 0; c < 4; ++c)
      corners[c].push_back(placeOf(scene.corners[polygon.first_corner + std::min(c, polygon.corner_count - 1)]));
  }
}

Outlines::Outlines(const SweepScene& scene, int fraction_bits, int column_bits, int reach, Vectors vectors)
    : scene_(scene),
      fraction_bits_(fraction_bits),
      column_bits_(column_bits),
      reach_(reach),
      vectors_(vectors),
      snapped_x_(scene.x.size()),
      snapped_y_(scene.x.size()),
      height_(scene.x.size()) {}

void Outlines::project(const Direction& direction, const glm::dvec2& origin, double per_spacing) {
  const double fixed_one = double(1 << fraction_bits_);
  const size_t count = scene_.x.size();
  const double *const x = scene_.x.data(), *const y = scene_.y.data(), *const z = scene_.z.data();
  int32_t* const __restrict snapped_x = snapped_x_.data(), * const __restrict snapped_y = snapped_y_.data();
  double* const __restrict height = height_.data();
  runVectorised(
      vectors_, [&]() __attribute__((always_inline)) {
        const glm::dvec3 x_axis = direction.x_axis, y_axis = direction.y_axis,
                         u = direction.u;  // copies, which the stores below cannot change
        const double from_x = origin.x, from_y = origin.y, to_spacings = per_spacing, to_fixed = fixed_one;
        VIEWPEEL_INDEPENDENT
        for (size_t k = 0; k < count; ++k) {
          snapped_x[k] = floorOf((dotInOrder(x[k], y[k], z[k], x_axis) * to_spacings + from_x) * to_fixed + 0.5);
          snapped_y[k] = floorOf((dotInOrder(x[k], y[k], z[k], y_axis) * to_spacings + from_y) * to_fixed + 0.5);
          height[k] = dotInOrder(x[k], y[k], z[k], u);
        }
      });
}

void Outlines::find(size_t first) {
  first_ = first;
  const size_t count = std::min(kBlock, scene_.polygons.size() - first);
  findRows(count);
  outline_count_ = 0;
  for (uint32_t k = 0; k < count; ++k) {
    reaching_[outline_count_] = k;
    outline_count_ += polygon_first_row_[k] <= polygon_last_row_[k];
  }
  findEdges();
  next_outline_ = 0;
  next_row_ = INT32_MIN;
}

std::array<const uint32_t*, 4> Outlines::cornersOfBlock() const {
  return {&scene_.corners[0][first_], &scene_.corners[1][first_], &scene_.corners[2][first_],
          &scene_.corners[3][first_]};
}

// Finds the rows that each polygon of the block may reach. Many small polygons lie between two rows and reach none.
void Outlines::findRows(size_t count) {
  const std::array<const uint32_t*, 4> corners = cornersOfBlock();
  const int32_t* const y = snapped_y_.data();
  int32_t* const __restrict first_row = polygon_first_row_.data(), * const __restrict last_row =
                                                                       polygon_last_row_.data();
  const int bits = fraction_bits_, reach = reach_;
  runVectorised(
      vectors_, [&]() __attribute__((always_inline)) {
        VIEWPEEL_INDEPENDENT
        for (size_t k = 0; k < count; ++k) {
          const int32_t y0 = y[corners[0][k]], y1 = y[corners[1][k]], y2 = y[corners[2][k]], y3 = y[corners[3][k]];
          first_row[k] = std::max(shiftUpward(std::min(std::min(y0, y1), std::min(y2, y3)), bits), -reach);
          last_row[k] = std::min(std::max(std::max(y0, y1), std::max(y2, y3)) >> bits, reach - 1);
        }
      });
}

// Finds the edges of the block's outlines, a X + b y 2^column_bits + c >= 0 with the top-left rule, as in
// geometry.glsl. All numbers are below 2^53, so doubles hold them. An edge along a row bounds the rows: where the
// polygon is above it, rows begin with the edge's own; where it is below, they end with the row before.
void Outlines::findEdges() {
  const std::array<const uint32_t*, 4> corners = cornersOfBlock();
  const int32_t *const snapped_x = snapped_x_.data(), *const snapped_y = snapped_y_.data();
  const int32_t *const polygon_first_row = polygon_first_row_.data(), *const polygon_last_row =
                                                                          polygon_last_row_.data();
  const uint32_t* const reaching = reaching_.data();
  int32_t* const __restrict first_row = first_row_.data();
  int32_t* const __restrict last_row = last_row_.data();
  int32_t* const __restrict front_up = front_up_.data();
  double* const __restrict row_0 = row_0_.data();
  double* const __restrict per_row = per_row_.data();
  double* const __restrict inverse = inverse_.data();
  const size_t count = outline_count_;
  const int bits = fraction_bits_, cut_bits = fraction_bits_ - column_bits_;
  const double finest = 1.0 / double(1 << cut_bits), row_columns = double(1 << column_bits_);
  runVectorised(
      vectors_, [&]() __attribute__((always_inline)) {
        VIEWPEEL_INDEPENDENT
        for (size_t k = 0; k < count; ++k) {
          const uint32_t polygon = reaching[k];
          const uint32_t c0 = corners[0][polygon], c1 = corners[1][polygon], c2 = corners[2][polygon],
                         c3 = corners[3][polygon];
          const int32_t x[4] = {snapped_x[c0], snapped_x[c1], snapped_x[c2], snapped_x[c3]};
          const int32_t y[4] = {snapped_y[c0], snapped_y[c1], snapped_y[c2], snapped_y[c3]};
          const double px[4] = {double(x[0]), double(x[1]), double(x[2]), double(x[3])},
                       py[4] = {double(y[0]), double(y[1]), double(y[2]), double(y[3])};
          const int32_t first_column = shiftUpward(std::min(std::min(x[0], x[1]), std::min(x[2], x[3])), cut_bits);
          const int32_t last_column = std::max(std::max(x[0], x[1]), std::max(x[2], x[3])) >> cut_bits;
          // The sum is rounded, but rounding neither makes it 0 nor changes its sign.
          const auto twiceAreaOf = [&](size_t b, size_t c) {
            return (px[b] - px[0]) * (py[c] - py[0]) - (py[b] - py[0]) * (px[c] - px[0]);
          };
          const double twice_area = twiceAreaOf(1, 2) + twiceAreaOf(2, 3);
          const double orientation = twice_area > 0 ? 1.0 : -1.0;
          int32_t first = polygon_first_row[polygon], last = polygon_last_row[polygon];
#pragma GCC unroll 4
          for (size_t e = 0; e < 4; ++e) {
            const size_t next = (e + 1) & 3;
            const double along_x = (px[next] - px[e]) * orientation, along_y = (py[next] - py[e]) * orientation,
                         size = std::abs(along_y);
            const double a = -along_y, b = along_x;
            const double excludes_points = along_y < 0 ? 1.0 : along_y > 0 ? 0.0 : along_x < 0 ? 1.0 : 0.0;
            const double c = std::floor((-(a * px[e] + b * py[e]) - excludes_points) * finest);
            const int32_t row_from = shiftUpward(y[e], bits);
            first = ((size == 0) & (b > 0)) ? std::max(first, row_from) : first;
            last = ((size == 0) & (b < 0)) ? std::min(last, row_from - 1) : last;
            // A column X is beyond an edge on the polygon's right, where a < 0, if a X + b y 2^column_bits + c < 0. All
            // numbers are whole, so the sum is at most -1 there. Hence cut() adds 1: |a| X >= row_0 + per_row y.
            row_0[e * kBlock + k] = a > 0 ? c : c + 1.0;
            per_row[e * kBlock + k] = b * row_columns;
            inverse[e * kBlock + k] = (a > 0 ? -1.0 : a < 0 ? 1.0 : 0.0) / std::max(size, 1.0);
          }
          const bool covers = (twice_area != 0) & (first_column <= last_column);
          first_row[k] = first;
          last_row[k] = covers ? last : first - 1;
          front_up[k] = twice_area > 0;
        }
      });
}

// Finds where the edges cross the rows. An edge on the polygon's left crosses at the first column inside, one on its
// right at the first column beyond. Either is the least X with X >= v inverse, so X = ceil(v inverse). Here v = row_0 +
// per_row y is exact in doubles, and inverse is -1 / |a| or 1 / |a|. Crossings within the window have |X| <= 2^23, so
// the product is off by less than 2^-28. The exact quotient is whole or at least 2^-26 from whole numbers, because |a|
// < 2^26. So the product less 2^-27 rounds up to the same number.
Outlines::Cuts Outlines::cut() {
  size_t count = 0;
  for (; next_outline_ < outline_count_ && count < kCuts; ++next_outline_) {
    const int32_t first_row = std::max(first_row_[next_outline_], next_row_);
    const int32_t last_row = std::min(last_row_[next_outline_], first_row + static_cast<int32_t>(kCuts - count) - 1);
    // Most outlines have few rows. Four rows are always written, without a branch, and only the outline's own are kept.
    for (int32_t k = 0; k < kFewRows; ++k) {
      cut_outlines_[count + k] = static_cast<uint32_t>(next_outline_);
      cut_rows_[count + k] = first_row + k;
    }
    for (int32_t row = first_row + kFewRows; row <= last_row; ++row) {
      cut_outlines_[count + row - first_row] = static_cast<uint32_t>(next_outline_);
      cut_rows_[count + row - first_row] = row;
    }
    count += std::max(last_row - first_row + 1, 0);
    if (last_row < last_row_[next_outline_]) {
      next_row_ = last_row + 1;
      break;
    }
    next_row_ = INT32_MIN;
  }
  const double *const row_0 = row_0_.data(), *const per_row = per_row_.data(), *const inverse = inverse_.data();
  const uint32_t* const outlines = cut_outlines_.data();
  const int32_t* const rows = cut_rows_.data();
  int32_t* const __restrict lows = cut_low_.data(), * const __restrict highs = cut_high_.data();
  const double border = double(reach_ << column_bits_);
  runVectorised(
      vectors_, [&]() __attribute__((always_inline)) {
        VIEWPEEL_INDEPENDENT
        for (size_t k = 0; k < count; ++k) {
          const uint32_t outline = outlines[k];
          const double y = double(rows[k]);
          double low = -border, high = border;
#pragma GCC unroll 4
          for (size_t e = 0; e < 4; ++e) {
            const double its_inverse = inverse[e * kBlock + outline];
            const double crossing =
                (row_0[e * kBlock + outline] + per_row[e * kBlock + outline] * y) * its_inverse - 0x1p-27;
            low = std::max(low, its_inverse < 0 ? crossing : -kInfinite);
            high = std::min(high, its_inverse > 0 ? crossing : kInfinite);
          }
          lows[k] = ceilOf(std::min(low, border));
          highs[k] = ceilOf(std::max(high, -border));
        }
      });
  return {count, cut_outlines_, cut_rows_, cut_low_, cut_high_};
}

}  // namespace viewpeel
