#include "scene/interpenetration.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "scenes/exact_scenes.h"
#include "scenes/named_scenes.h"
#include "reference/exact/exact_pair_areas.h"

namespace viewpeel::tests {
namespace {

using namespace reference;
namespace ts = test_scenes;

// Makes a square in z = 0 and an upright one in y = 0.1. The upright one begins at height `low`, and crosses the other
// from x = -0.1 to 0.3 where `low` is negative.
Scene makeCross(double low) {
  SceneBuilder builder;
  builder.addPolygon("desk", {{-0.4, -0.4, 0}, {0.4, -0.4, 0}, {0.4, 0.4, 0}, {-0.4, 0.4, 0}});
  builder.addPolygon("wall", {{-0.1, 0.1, low}, {0.3, 0.1, low}, {0.3, 0.1, 0.5}, {-0.1, 0.1, 0.5}});
  builder.scene.centre = {10, 20, 30};
  builder.scene.scale = 4;
  return builder.scene;
}

TEST(Interpenetration, CrossingSquaresAreFoundAndPlaced) {
  const std::vector<Interpenetration> found = findInterpenetrations(makeCross(-0.2));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].a, 0u);
  EXPECT_EQ(found[0].b, 1u);
  EXPECT_LT(glm::distance(found[0].place, {10.4, 20.4, 30}), 1e-14);
  EXPECT_NEAR(found[0].length, 0.4, 1e-15);
}

TEST(Interpenetration, RefusalNamesBothAndThePlace) {
  try {
    computeExactPairAreas(makeCross(-0.2), {0, 0, 1});
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_STREQ(error.what(),
                 "test: desk and wall pass through each other at (10.4, 20.4, 30); split them where they meet");
  }
}

TEST(Interpenetration, DepthDecides) {
  EXPECT_TRUE(findInterpenetrations(makeCross(0)).empty());
  EXPECT_TRUE(findInterpenetrations(makeCross(-1e-10)).empty());
  EXPECT_EQ(findInterpenetrations(makeCross(-1e-8)).size(), 1u);
  EXPECT_TRUE(findInterpenetrations(makeCross(-1e-8), 1e-7).empty());
}

TEST(Interpenetration, TouchingIsNone) {
  const glm::dmat3 rotation(2.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3, 2.0 / 3, -1.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3);
  for (const Scene& scene : {makeRoom(), makeCubeInCube(), makeStaircase(), makeStack(), makeTiles(), makeDuplicates(),
                             makeCreases(), makeSoup(100, 3), makeOffice(3, 1), makeCross(0)}) {
    EXPECT_TRUE(findInterpenetrations(scene).empty());
    EXPECT_TRUE(findInterpenetrations(turn(scene, rotation)).empty());
  }
}

// Two pieces of a wall are bent by 9e-9 where they meet, and so share a plane. A triangle touches the corner of the
// smaller piece from behind. Its tip passes the shared plane, but not the piece itself.
TEST(Interpenetration, NeighbourOfAPieceOffItsSharedPlaneIsNone) {
  constexpr double kOff = 9e-9;
  InputScene input{"walls", {}, {}};
  ts::addFace(input, "large", {{-1, 0, -0.6}, {0.6, 0, -0.6}, {0.6, 0, 0.6}});
  ts::addFace(input, "small", {{0.6, 0, -0.6}, {0.8, kOff, 0}, {0.6, 0, 0.6}});
  ts::addFace(input, "behind", {{0.8, kOff, 0}, {0.4, -0.1, 0.2}, {1.2, -0.1, -0.2}});
  const Scene scene = buildScene(input);
  ASSERT_EQ(scene.polygons[0].plane, scene.polygons[1].plane);
  EXPECT_TRUE(findInterpenetrations(scene).empty());
}

TEST(Interpenetration, OverlapOfPlanesOutsideThePolygonsIsNone) {
  SceneBuilder builder;
  builder.addPolygon("one", {{-0.4, -0.4, 0}, {0, -0.4, 0}, {0, 0.4, 0}, {-0.4, 0.4, 0}});
  builder.addPolygon("two", {{0, 0, -0.2}, {0.3, 0, -0.2}, {0.3, 0, 0.2}, {0, 0, 0.2}});  // edges touch in one point
  EXPECT_TRUE(findInterpenetrations(builder.scene).empty());
}

TEST(Interpenetration, EveryPairIsFound) {
  SceneBuilder builder;
  builder.addPolygon("plate", {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}});
  for (int k = 0; k < 9; ++k) {
    const double x = -0.4 + 0.1 * k;
    builder.addPolygon("fin", {{x, -0.2, -0.1}, {x, 0.2, -0.1}, {x, 0, 0.1}});
  }
  const std::vector<Interpenetration> found = findInterpenetrations(builder.scene);
  ASSERT_EQ(found.size(), 9u);
  for (uint32_t k = 0; k < 9; ++k) EXPECT_EQ(found[k].b, k + 1);
}

// Makes a floor, and a wall on it whose lower edge is `depth` below the floor.
InputScene wallInFloor(double depth) {
  InputScene scene{"wall in floor", {}, {}};
  ts::addFace(scene, "floor", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(scene, "wall", ts::parallelogram({0.5, 0.2, -depth}, {0, 0.6, 0}, {0, 0, 1}));
  return scene;
}

std::vector<Interpenetration> crossings(const Scene& scene) { return findInterpenetrations(scene, kCrossingDepth); }

TEST(Interpenetration, CrossingDepthDecidesForScanlines) {
  for (double depth : {0.2, 1e-3, 1e-5}) EXPECT_EQ(crossings(buildScene(wallInFloor(depth))).size(), 1u) << depth;
  for (double depth : {0.0, 1e-9, 1e-7, -1e-3}) EXPECT_TRUE(crossings(buildScene(wallInFloor(depth))).empty()) << depth;
}

TEST(Interpenetration, TheTwoThatCrossAreNamed) {
  const auto found = crossings(buildScene(wallInFloor(0.2)));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(std::pair(found[0].a, found[0].b), std::pair(0u, 1u));
}

TEST(Interpenetration, ScenesThatTouchDoNotCross) {
  EXPECT_TRUE(crossings(buildScene(ts::insideOfCube())).empty());
  EXPECT_TRUE(crossings(buildScene(ts::roomWithTouchingBoxes())).empty());
  EXPECT_TRUE(crossings(loadScene(VIEWPEEL_SCENES "/office.obj")).empty());
  EXPECT_TRUE(crossings(loadScene(VIEWPEEL_SCENES "/street.obj")).empty());
}

}  // namespace
}  // namespace viewpeel::tests
