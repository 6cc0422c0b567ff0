#include "engines/outlines.h"

#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include <viewpeel/scene.h>

namespace viewpeel {
namespace {

constexpr int kReach = 20;  // rows and columns on either side of the origin
constexpr int kFractionBits = 12;
constexpr int32_t kOne = 1 << kFractionBits;

using Columns = std::pair<int32_t, int32_t>;                  // [first, second)
using Covered = std::map<std::pair<uint32_t, int>, Columns>;  // columns by polygon and row

struct Snapped {
  int32_t x, y;
};

int64_t divideDown(int64_t value, int64_t by) { return value >= 0 ? value / by : -((-value + by - 1) / by); }

// Returns the columns X of row y where a X 2^cut_bits + b y 2^fraction_bits + c >= 0 for all edges, in integers. A
// point on an edge is inside where this is a right or a lower edge.
Covered coveredByEdges(const std::vector<std::vector<Snapped>>& polygons, int column_bits) {
  Covered covered;
  const int32_t column = kOne >> column_bits, border = kReach << column_bits;
  for (uint32_t p = 0; p < polygons.size(); ++p) {
    std::vector<Snapped> corners = polygons[p];
    int64_t twice_area = 0;
    for (size_t k = 0; k < corners.size(); ++k) {
      const Snapped &a = corners[k], &b = corners[(k + 1) % corners.size()];
      twice_area += int64_t(a.x) * b.y - int64_t(b.x) * a.y;
    }
    if (twice_area == 0) continue;
    if (twice_area < 0) std::reverse(corners.begin(), corners.end());
    for (int y = -kReach; y < kReach; ++y) {
      int64_t low = -border, high = border;
      for (size_t k = 0; k < corners.size(); ++k) {
        const Snapped &from = corners[k], &to = corners[(k + 1) % corners.size()];
        const int64_t a = from.y - int64_t(to.y), b = to.x - int64_t(from.x);
        if (a == 0 && b == 0) continue;
        const bool is_right = a < 0, is_lower = a == 0 && b > 0;  // corners run counter-clockwise, so right edges go up
        const int64_t rest = b * y * kOne - (a * from.x + b * from.y) - (is_right || is_lower ? 0 : 1);
        const int64_t step = std::abs(a) * column;
        if (a > 0) low = std::max(low, -divideDown(rest, step));
        if (a < 0) high = std::min(high, divideDown(rest, step) + 1);
        if (a == 0 && rest < 0) high = low;
      }
      if (low < high) covered[{p, y}] = {static_cast<int32_t>(low), static_cast<int32_t>(high)};
    }
  }
  return covered;
}

// Returns the columns that Outlines finds, along +z on a lattice of spacing 1.
Covered coveredByOutlines(const std::vector<std::vector<Snapped>>& polygons, int column_bits, Vectors vectors) {
  Scene scene;
  Ids ids;
  scene.planes.push_back({{0, 0, 1}, 0});
  for (const std::vector<Snapped>& corners : polygons) {
    scene.polygons.push_back(
        {static_cast<uint32_t>(scene.corners.size()), static_cast<uint32_t>(corners.size()), 0, 0, true, 1});
    for (const Snapped& corner : corners)
      scene.corners.push_back({double(corner.x) / kOne, double(corner.y) / kOne, 0});
    ids.of_polygon.push_back(0);
  }
  const SweepScene sweep_scene(scene, ids);
  Outlines outlines(sweep_scene, kFractionBits, column_bits, kReach, vectors);
  outlines.project({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0}}, {0, 0}, 1.0);
  Covered covered;
  for (size_t first = 0; first < polygons.size(); first += Outlines::kBlock) {
    outlines.find(first);
    for (Outlines::Cuts cuts = outlines.cut(); cuts.count; cuts = outlines.cut())
      for (size_t k = 0; k < cuts.count; ++k)
        if (cuts.low[k] < cuts.high[k])
          covered[{outlines.polygonOf(cuts.outlines[k]), cuts.rows[k]}] = {cuts.low[k], cuts.high[k]};
  }
  return covered;
}

// Returns random triangles and parallelograms of either orientation. Some reach beyond the border, some lie between
// rows, some are slivers. Corners may lie on rows and columns or coincide, and edges may lie along rows.
std::vector<std::vector<Snapped>> drawPolygons(uint64_t seed, size_t count) {
  std::mt19937_64 random(seed);
  const auto draw = [&](int32_t size) {
    return static_cast<int32_t>(random() % static_cast<uint64_t>(2 * size + 1)) - size;
  };
  std::vector<std::vector<Snapped>> polygons;
  while (polygons.size() < count) {
    const int32_t size = std::array{8, kOne / 4, 2 * kOne, 8 * kOne, 24 * kOne}[random() % 5],
                  place = std::max(24 * kOne - size, 1);
    const int32_t grain = std::array{1, 1, kOne / 4, kOne}[random() % 4];
    const auto drawCorner = [&](int32_t within) {
      return Snapped{draw(within) / grain * grain, (random() % 4 == 0 ? 0 : draw(within)) / grain * grain};
    };
    const Snapped at = drawCorner(place), along = drawCorner(size),
                  across = random() % 4 == 0 ? Snapped{along.x / 2, along.y / 2 + 1} : drawCorner(size);
    const auto corner = [&](int s, int t) {
      return Snapped{at.x + s * along.x + t * across.x, at.y + s * along.y + t * across.y};
    };
    if (random() % 2) polygons.push_back({corner(0, 0), corner(1, 0), corner(0, 1)});
    else polygons.push_back({corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
  }
  return polygons;
}

TEST(Outlines, CutsMatchTheEdges) {
  for (const int column_bits : {0, 10})
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      const auto polygons = drawPolygons(seed, 1000 + 100 * seed);  // a number that leaves the last block unfilled
      const Covered expected = coveredByEdges(polygons, column_bits);
      ASSERT_GT(expected.size(), 3000u);
      for (const Vectors vectors : {Vectors::plain, Vectors::avx2, Vectors::avx512}) {
        if (vectors > widestVectors()) continue;
        const Covered found = coveredByOutlines(polygons, column_bits, vectors);
        EXPECT_TRUE(found == expected) << found.size() << " rows of polygons, not " << expected.size()
                                       << "; column bits " << column_bits << ", seed " << seed << ", vectors "
                                       << static_cast<int>(vectors);
      }
    }
}

// Negative control: a right edge ends in a lattice point. If its corner moves by one bit, other points are covered.
TEST(Outlines, OneBitLessIsNoticed) {
  std::vector<std::vector<Snapped>> polygons = {{{-kOne, -kOne}, {kOne, -kOne}, {kOne, kOne}}};
  const Covered expected = coveredByEdges(polygons, 0);
  polygons[0][1].x -= 1;
  EXPECT_TRUE(coveredByOutlines(polygons, 0, Vectors::plain) != expected);
}

}  // namespace
}  // namespace viewpeel
