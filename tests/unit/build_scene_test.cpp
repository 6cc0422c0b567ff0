// These tests check buildScene(): it splits faces into convex polygons, drops faces without area, scales to the unit
// ball, and groups planes.
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

InputScene oneFace(const ts::Corners& corners) {
  InputScene scene{"one face", {}, {}};
  ts::addFace(scene, "face", corners);
  return scene;
}

double areaOf(const ts::Corners& corners) {
  glm::dvec3 sum(0);
  for (size_t k = 0; k < corners.size(); ++k) sum += glm::cross(corners[k], corners[(k + 1) % corners.size()]);
  return glm::length(sum) / 2;
}

// Expects that the face is split into convex planar polygons, at most `most_pieces`, with the face's area and front.
void expectSplitsWell(const ts::Corners& corners, size_t most_pieces) {
  const Scene scene = buildScene(oneFace(corners));
  EXPECT_LE(scene.polygons.size(), most_pieces);
  EXPECT_EQ(scene.faces.size(), 1u);
  double area = 0;
  for (const Polygon& polygon : scene.polygons) {
    EXPECT_EQ(polygon.face, 0u);
    area += polygon.area * scene.scale * scene.scale;
    const Plane& plane = scene.planes[polygon.plane];
    const glm::dvec3 front = polygon.front_along_plane_normal ? plane.normal : -plane.normal;
    const uint32_t m = polygon.corner_count;
    for (uint32_t k = 0; k < m; ++k) {
      const glm::dvec3 a = scene.corners[polygon.first_corner + k],
                       b = scene.corners[polygon.first_corner + (k + 1) % m],
                       c = scene.corners[polygon.first_corner + (k + 2) % m];
      EXPECT_GE(glm::dot(glm::cross(b - a, c - b), front), -1e-15);  // rounding of products of lengths up to 2
      EXPECT_NEAR(glm::dot(a, plane.normal), plane.offset, 1e-7);    // kPlanarTolerance
    }
  }
  EXPECT_NEAR(area, areaOf(corners), 1e-13 * areaOf(corners));
}

TEST(BuildScene, ConvexFacesBecomeTrianglesAndQuadrilaterals) {
  for (int m : {3, 4, 5, 64}) {
    ts::Corners ring;
    for (int k = 0; k < m; ++k)
      ring.push_back({std::cos(2 * std::numbers::pi * k / m), std::sin(2 * std::numbers::pi * k / m), 0.3});
    expectSplitsWell(ring, static_cast<size_t>((m - 1) / 2));
  }
  expectSplitsWell({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}, 2);  // a corner in the middle of an edge
}

TEST(BuildScene, NonConvexFacesAreCutIntoFewConvexOnes) {
  expectSplitsWell({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, 2);  // L
  ts::Corners comb{{0, 0, 0}, {9, 0, 0}};
  for (int k = 4; k >= 0; --k) {
    comb.push_back({2 * k + 1, 3, 0});
    comb.push_back({2 * k, 3, 0});
    if (k) comb.push_back({2 * k, 1, 0});
    if (k) comb.push_back({2 * k - 1, 1, 0});
  }
  expectSplitsWell(comb, 16);
  ts::Corners star;
  for (int k = 0; k < 10; ++k) {
    const double r = k % 2 ? 0.4 : 1, a = std::numbers::pi * k / 5;
    star.push_back({r * std::cos(a), 0, r * std::sin(a)});
  }
  expectSplitsWell(star, 8);
  ts::Corners spiral;
  for (int k = 0; k <= 40; ++k)
    spiral.push_back({(1 + 0.1 * k) * std::cos(0.4 * k), (1 + 0.1 * k) * std::sin(0.4 * k), 1});
  for (int k = 40; k >= 0; --k)
    spiral.push_back({(1.3 + 0.1 * k) * std::cos(0.4 * k), (1.3 + 0.1 * k) * std::sin(0.4 * k), 1});
  expectSplitsWell(spiral, 80);
  // The outline reaches the square hole along a bridge that it follows both ways.
  expectSplitsWell(
      {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0}, {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}},
      8);
}

// Stars are simple polygons and far from convex. Faces of many corners are split within seconds or refused. An ear of a
// comb is found only by a search through many corners.
TEST(BuildScene, FacesOfManyCornersAreSplitOrRefused) {
  const auto star = [](int m) {
    ts::Corners corners;
    for (int k = 0; k < m; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / m, radius = 1 + 0.3 * std::sin(7 * angle_rad);
      corners.push_back({radius * std::cos(angle_rad), radius * std::sin(angle_rad), 0});
    }
    return corners;
  };
  const auto comb = [](int teeth) {
    ts::Corners corners = {{double(teeth), 0, 0}, {double(teeth), -1, 0}, {0, -1, 0}};
    for (int k = 0; k < teeth; ++k) {
      corners.push_back({k, 0, 0});
      corners.push_back({k + 0.2, 50.0 + k % 7, 0});
    }
    return corners;
  };
  const auto expectTooMany = [](const ts::Corners& corners) {
    try {
      buildScene(oneFace(corners));
      FAIL() << "not refused";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("corners, too many"), std::string::npos) << error.what();
    }
  };
  expectSplitsWell(star(2'000), 1'998);
  expectTooMany(star(100'000));
  expectTooMany(comb(9'000));
}

TEST(BuildScene, RandomSimplePolygonsSplitWell) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> radius(0.1, 1);
  for (int trial = 0; trial < 300; ++trial) {
    const int m = 4 + trial % 20;
    ts::Corners corners;
    for (int k = 0; k < m; ++k) {
      const double r = radius(random), a = 2 * std::numbers::pi * k / m;
      corners.push_back({r * std::cos(a), r * std::sin(a) * 0.8, r * std::sin(a) * 0.6});
    }
    expectSplitsWell(corners, m - 2);
  }
}

TEST(BuildScene, NonPlanarFaceBecomesTriangles) {
  const Scene scene = buildScene(oneFace({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}}));
  ASSERT_EQ(scene.polygons.size(), 2u);
  EXPECT_EQ(scene.faces.size(), 1u);
  EXPECT_EQ(scene.polygons[0].corner_count, 3u);
}

TEST(BuildScene, FaceThatCrossesItselfIsRefused) {
  InputScene bow_tie = oneFace({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 1, 0}});
  bow_tie.faces[0].line = 12;
  try {
    buildScene(bow_tie);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("one face:12: "), 0u) << error.what();
  }
}

TEST(BuildScene, DegenerateFacesAreDroppedWithOneCountedWarningEach) {
  InputScene input = ts::parallelSquares();
  for (double z : {0.1, 0.2, 0.3}) ts::addFace(input, "line", {{0, 0, z}, {1, 1, z}, {2, 2, z}});
  ts::addFace(input, "repeated", {{0, 0, 0.5}, {0, 0, 0.5}, {1, 0, 0.5}});
  const Scene scene = buildScene(input);
  EXPECT_EQ(scene.polygons.size(), 2u);
  EXPECT_EQ(scene.surfaces.size(), 2u);  // surfaces without polygons are removed
  ASSERT_EQ(scene.warnings.size(), 2u);
  EXPECT_NE(scene.warnings[0].find("1 face dropped: fewer than three"), std::string::npos) << scene.warnings[0];
  EXPECT_NE(scene.warnings[1].find("3 faces"), std::string::npos) << scene.warnings[1];
}

// A polygon of area 5e-13 beside polygons of area 1 is kept: a small area is no reason to drop a polygon.
TEST(BuildScene, TinyPolygonsAreKept) {
  InputScene input = ts::parallelSquares();
  ts::addFace(input, "tiny", {{0.5, 0.5, 0.5}, {0.500001, 0.5, 0.5}, {0.5, 0.500001, 0.5}});
  const Scene scene = buildScene(input);
  ASSERT_EQ(scene.polygons.size(), 3u);
  EXPECT_NEAR(scene.polygons[2].area * scene.scale * scene.scale, 5e-13,
              5e-13 * 1e-9);  // corners are rounded by 1e-16, a side is 1e-6 long
}

// A face is no wider than the rounding of its coordinates: at 1e6 these are multiples of 1.2e-10. Near the origin the
// same face has an area.
TEST(BuildScene, FacesNarrowerThanRoundingAreDropped) {
  for (const double offset : {0.0, 1e6}) {
    InputScene input = ts::parallelSquares();
    ts::addFace(input, "sliver", {{0, 0, 0.5}, {1, 0, 0.5}, {0.5, 1.2e-10, 0.5}});
    const Scene scene = buildScene(ts::transformed(input, glm::dmat3(1), 1, glm::dvec3(offset)));
    EXPECT_EQ(scene.polygons.size(), offset > 0 ? 2u : 3u) << offset;
  }
}

TEST(BuildScene, EveryCornerLiesInTheUnitBall) {
  for (const InputScene& input : {ts::cubeInCube(0.3), ts::triangleSoup(100, 0.3, 1)}) {
    const Scene scene = buildScene(input);
    double largest = 0;
    for (const glm::dvec3& corner : scene.corners) largest = std::max(largest, glm::length(corner));
    EXPECT_LE(largest, 1);
    EXPECT_GT(largest, 1 - 1e-14);
    const glm::dvec3 back = scene.centre + scene.scale * scene.corners[0];
    EXPECT_LT(glm::length(back - input.faces[0].corners[0]), 1e-15 * 4);
  }
}

// The normalised scene does not depend on units or place. Coordinates of size L have rounding errors of L 2^-53.
TEST(BuildScene, ScaleAndOffsetVanish) {
  const InputScene input = ts::cubeInCube(0.3);
  const Scene expected = buildScene(input);
  for (const auto& [scale, offset] :
       {std::pair(1e-6, 0.0), std::pair(1e6, 0.0), std::pair(1.0, 1e6), std::pair(1e-6, 1.0)}) {
    const Scene scene = buildScene(ts::transformed(input, glm::dmat3(1), scale, glm::dvec3(offset)));
    const double bound = 8 * 0x1p-53 * (1 + std::abs(offset) / scale);
    for (size_t k = 0; k < scene.corners.size(); ++k)
      EXPECT_LT(glm::length(scene.corners[k] - expected.corners[k]), bound);
  }
}

TEST(BuildScene, CoplanarPolygonsShareAPlaneWhicheverWayTheyFace) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  // There are horizontal planes at heights 0, 1, 1.5, 2, 3. Upright ones are at x = 0, 0.5, 0.75, 1.5, 2, 3, 4 and y =
  // 0, 0.5, 0.75, 1.5, 1.75, 2, 3, 4.
  EXPECT_EQ(scene.planes.size(), 5u + 7u + 8u);
  for (const Polygon& polygon : scene.polygons) {
    const Plane& plane = scene.planes[polygon.plane];
    const glm::dvec3 a = scene.corners[polygon.first_corner], b = scene.corners[polygon.first_corner + 1],
                     c = scene.corners[polygon.first_corner + 2];
    EXPECT_EQ(glm::dot(glm::cross(b - a, c - b), plane.normal) > 0, polygon.front_along_plane_normal);
  }
}

// Coplanar faces share a plane however the scene is turned, and faces 1e-7 apart do not.
TEST(BuildScene, PlanesAreFoundAtAnyAngle) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angle(0, 6.28);
  const InputScene input = ts::stackOfSheets({0, 0, 1e-7, 0.3, 0.3});
  for (int trial = 0; trial < 50; ++trial) {
    const double a = angle(random), b = angle(random);
    const glm::dmat3 turn = glm::dmat3(std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1) *
                            glm::dmat3(1, 0, 0, 0, std::cos(b), std::sin(b), 0, -std::sin(b), std::cos(b));
    EXPECT_EQ(buildScene(ts::transformed(input, turn, 3, {1, 2, 3})).planes.size(), 3u);
  }
}

TEST(BuildScene, ClosedAndOpenScenesDiffer) {
  EXPECT_TRUE(isClosed(buildScene(ts::insideOfCube())));
  EXPECT_TRUE(isClosed(buildScene(ts::roomWithTouchingBoxes())));  // closed although it has T-junctions
  InputScene open = ts::roomWithTouchingBoxes();
  open.faces.erase(open.faces.begin() + 3);
  EXPECT_FALSE(isClosed(buildScene(open)));
  InputScene flipped = ts::insideOfCube();
  std::reverse(flipped.faces[2].corners.begin(), flipped.faces[2].corners.end());
  EXPECT_FALSE(isClosed(buildScene(flipped)));
}

TEST(BuildScene, NonFiniteCoordinatesAreRefused) {
  for (double bad : {std::nan(""), HUGE_VAL}) {
    InputScene input = ts::parallelSquares();
    input.faces[1].corners[2].y = bad;
    EXPECT_THROW(buildScene(input), Error);
  }
}

}  // namespace
}  // namespace viewpeel
