// Unoccluded form factors of whole rows are in single precision. They differ from pairs in double precision by no more
// than their stated bound.
#include "unoccluded/row_exchange.h"

#include <gtest/gtest.h>

#include "unoccluded/unoccluded.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

struct Seen {
  size_t pairs = 0, far = 0, cut = 0, near = 0;
};

// Compares whole rows with the sums over pairs of polygons. Returns the number of pairs that each rule computed.
Seen compareRows(const Scene& scene, bool two_sided) {
  const Ids ids = makeIds(scene, By::polygon, two_sided);
  const RowExchange rows(scene, ids);
  UnoccludedExchange exchange(scene);
  std::vector<std::vector<uint32_t>> polygons(ids.count());
  for (uint32_t k = 0; k < ids.of_polygon.size(); ++k) polygons[ids.of_polygon[k]].push_back(k);
  const double unit = scene.scale * scene.scale;
  Seen seen;
  std::vector<BoundedExchange> later;
  for (uint32_t i = 0; i < ids.count(); ++i) {
    later.assign(ids.count() - i - 1, {});
    rows.compute(i, later);
    for (uint32_t j = i + 1; j < ids.count(); ++j) {
      std::vector<SidePair> sides;
      for (uint32_t p : polygons[i])
        for (uint32_t q : polygons[j])
          for (uint32_t side = 0; side < (two_sided ? 4u : 1u); ++side)
            sides.push_back({frontSide(p) + side % 2, frontSide(q) + side / 2});
      std::vector<double> areas(sides.size());
      EXPECT_TRUE(exchange.compute(sides, areas).empty());
      double truth = 0;
      for (double area : areas) truth += area * unit;
      const BoundedExchange& bounded = later[j - i - 1];
      // The tolerance is the bound and the accuracy of the pairs in double precision.
      const double least = double(sides.size()) * kUnoccludedAbsoluteError * std::min(ids.areas[i], ids.areas[j]);
      EXPECT_NEAR(bounded.area, truth, bounded.error + 2 * kUnoccludedRelativeError * truth + least)
          << scene.file << " " << i << " " << j;
      if (!(truth > 0)) continue;
      ++seen.pairs;
      ++(bounded.error < 2 * kUnoccludedRelativeError * truth ? seen.near
         : bounded.error < 0.05 * bounded.area                ? seen.far
                                                              : seen.cut);
    }
  }
  return seen;
}

TEST(RowExchange, BoundsHold) {
  for (const InputScene& input :
       {ts::roomWithTouchingBoxes(), ts::triangleSoup(120, 0.1, 5), ts::triangleSoup(80, 0.6, 6), ts::cubeInCube(0.5),
        ts::perpendicularSquares(), ts::parallelSquares()})
    for (const bool two_sided : {false, true}) {
      const Scene scene = buildScene(input);
      compareRows(scene, two_sided);
    }
}

// Some parts of the floor are far from parts of the wall, some touch them, and the plane of a floating square cuts
// some. So each rule computes some pairs.
TEST(RowExchange, EveryWayIsTaken) {
  InputScene room{"walls in parts", {"floor", "wall", "square"}, {}};
  constexpr int kParts = 12;
  for (int k = 0; k < kParts * kParts; ++k) {
    const int column = k % kParts, row = k / kParts;
    const double edge = 1.0 / kParts, u = edge * column, v = edge * row;
    ts::addFace(room, "floor", ts::parallelogram({u, v, 0}, {edge, 0, 0}, {0, edge, 0}));
    ts::addFace(room, "wall", ts::parallelogram({0, u, v}, {0, edge, 0}, {0, 0, edge}));
  }
  ts::addFace(room, "square", ts::parallelogram({0.8, 0.5, 0.53}, {0.05, 0, 0}, {0, 0.05, 0}));
  const Seen seen = compareRows(buildScene(room), false);
  EXPECT_GT(seen.far, 15'000u);
  EXPECT_GE(seen.cut, size_t(kParts));   // parts of the wall that the square's plane cuts
  EXPECT_GE(seen.near, size_t(kParts));  // parts along the common edge
}

// The exchange area of a face is the sum over its polygons: here an L of two rectangles and a face of eight corners.
TEST(RowExchange, FacesAreSumsOfTheirPolygons) {
  InputScene input{"faces", {"l", "octagon", "square"}, {}};
  ts::addFace(input, "l", {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}});
  std::vector<glm::dvec3> octagon;
  for (int k = 0; k < 8; ++k)
    octagon.push_back({1 + std::cos(-k * 0.7853981633974483), 1 + std::sin(-k * 0.7853981633974483), 5});
  ts::addFace(input, "octagon", octagon);
  ts::addFace(input, "square", ts::parallelogram({3, 0, 1}, {0, 1, 0}, {0, 0, 1}));
  const Scene scene = buildScene(input);
  ASSERT_GT(scene.polygons.size(), scene.faces.size());
  EXPECT_GE(compareRows(scene, false).pairs, 1u);
  EXPECT_EQ(compareRows(scene, true).pairs, 3u);
}

}  // namespace
}  // namespace viewpeel
