// Polygons that pass through each other are found; polygons that touch, and closed scenes as users draw them, are not.
#include "scene/crossings.h"

#include <gtest/gtest.h>

#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

// A floor, and a wall on it whose lower edge is `depth` below the floor.
InputScene wallInFloor(double depth) {
  InputScene scene{"wall in floor", {}, {}};
  ts::addFace(scene, "floor", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(scene, "wall", ts::parallelogram({0.5, 0.2, -depth}, {0, 0.6, 0}, {0, 0, 1}));
  return scene;
}

TEST(Crossings, DepthDecides) {
  for (double depth : {0.2, 1e-3, 1e-5}) EXPECT_TRUE(findCrossing(buildScene(wallInFloor(depth)))) << depth;
  for (double depth : {0.0, 1e-9, 1e-7, -1e-3}) EXPECT_FALSE(findCrossing(buildScene(wallInFloor(depth)))) << depth;
}

TEST(Crossings, TheTwoAreNamed) {
  const auto found = findCrossing(buildScene(wallInFloor(0.2)));
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, std::pair(0u, 1u));
}

TEST(Crossings, TouchingIsNone) {
  EXPECT_FALSE(findCrossing(buildScene(ts::insideOfCube())));
  EXPECT_FALSE(findCrossing(buildScene(ts::roomWithTouchingBoxes())));
  EXPECT_FALSE(findCrossing(loadScene(VIEWPEEL_SCENES "/office.obj")));
  EXPECT_FALSE(findCrossing(loadScene(VIEWPEEL_SCENES "/street.obj")));
}

}  // namespace
}  // namespace viewpeel
