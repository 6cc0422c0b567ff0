#include "scene/bridge_holes.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "scene/split_face.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

using reference::test::Random;
using Ring = std::vector<glm::dvec3>;

double areaOf(const Ring& ring) { return twiceVectorArea(ring).z / 2; }

// Returns whether a point lies within a ring of the plane z = 0, by the number of edges that a ray crosses.
bool isWithin(const Ring& ring, const glm::dvec3& p) {
  bool within = false;
  for (size_t k = 0; k < ring.size(); ++k) {
    const glm::dvec3 &a = ring[k], &b = ring[(k + 1) % ring.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) within = !within;
  }
  return within;
}

// Cuts a face with holes into convex pieces. Returns the corners of each piece.
std::vector<Ring> piecesOf(const std::vector<Ring>& rings, size_t holes_outside = 0) {
  const BridgedFace bridged = bridgeHoles(rings);
  EXPECT_EQ(bridged.holes_outside, holes_outside);
  const std::optional<Pieces> split = splitFace(bridged.corners);
  std::vector<Ring> pieces;
  if (!split) return pieces;
  for (const std::vector<uint32_t>& piece : *split) {
    Ring& ring = pieces.emplace_back();
    for (uint32_t corner : piece) ring.push_back(bridged.corners[corner]);
  }
  return pieces;
}

// Expects that the pieces tile the face: none is turned over, their areas add up to the face's, and of points spread
// over the bounding box each lies in one piece if it lies in the face, else in none.
void expectTiles(const std::vector<Ring>& rings, const std::vector<Ring>& pieces) {
  double left = 0, sum = 0, all = 0;
  for (const Ring& ring : rings) {
    left += (&ring == &rings.front() ? 1 : -1) * std::abs(areaOf(ring));
    all += std::abs(areaOf(ring));
  }
  for (const Ring& piece : pieces) {
    EXPECT_GE(areaOf(piece), 0);
    sum += areaOf(piece);
  }
  // Each area is a sum of products with a few roundings; a piece has no more of them than the face has corners.
  EXPECT_NEAR(sum, left, 1e-12 * all);
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const glm::dvec3& corner : rings.front()) low = glm::min(low, corner), high = glm::max(high, corner);
  Random random(1);
  for (int k = 0; k < 300; ++k) {
    const glm::dvec3 p(random.uniform(low.x, high.x), random.uniform(low.y, high.y), 0);
    bool is_in_face = isWithin(rings.front(), p);
    for (size_t hole = 1; hole < rings.size(); ++hole) is_in_face &= !isWithin(rings[hole], p);
    EXPECT_EQ(std::ranges::count_if(pieces, [&](const Ring& piece) { return isWithin(piece, p); }), is_in_face);
  }
}

Ring rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}};
}

Ring turnedBy(double angle, Ring ring) {
  for (glm::dvec3& p : ring)
    p = {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle), 0};
  return ring;
}

TEST(BridgeHoles, WallWithWindows) {
  const std::vector<Ring> wall{rectangle(0, 0, 10, 3), rectangle(1, 1, 2, 2), rectangle(4, 1, 5, 2),
                               rectangle(7, 1, 9, 2)};
  const std::vector<Ring> pieces = piecesOf(wall);
  expectTiles(wall, pieces);
  EXPECT_LE(pieces.size(), 14u);  // 22 corners with bridges have 20 triangles, and some of them are merged
}

TEST(BridgeHoles, HolesMayRunEitherWayRound) {
  std::vector<Ring> wall{rectangle(0, 0, 4, 4), rectangle(1, 1, 3, 3)};
  const std::vector<Ring> one = piecesOf(wall);
  std::ranges::reverse(wall[1]);
  expectTiles(wall, piecesOf(wall));
  EXPECT_EQ(one.size(), piecesOf(wall).size());
}

TEST(BridgeHoles, TouchTheOuterRingOrOneAnotherAtACorner) {
  const Ring diamond{{1, 2, 0}, {2, 1, 0}, {3, 2, 0}, {2, 3, 0}};
  expectTiles({rectangle(0, 0, 3, 4), diamond}, piecesOf({rectangle(0, 0, 3, 4), diamond}));
  const Ring next{{3, 2, 0}, {4, 1, 0}, {5, 2, 0}, {4, 3, 0}};
  const std::vector<Ring> chain{rectangle(0, 0, 6, 4), diamond, next};
  expectTiles(chain, piecesOf(chain));
  const std::vector<Ring> turned{turnedBy(0.3, rectangle(0, 0, 3, 4)), turnedBy(0.3, diamond)};
  expectTiles(turned, piecesOf(turned));
}

TEST(BridgeHoles, OneAboveAnotherAtTheSamePlace) {
  const std::vector<Ring> tower{rectangle(0, 0, 3, 20), rectangle(1, 1, 2, 2), rectangle(1, 4, 2, 5),
                                rectangle(1, 7, 2, 8), rectangle(1, 10, 2, 11)};
  expectTiles(tower, piecesOf(tower));
}

TEST(BridgeHoles, RepeatedCornersAndHolesWithoutAnAreaDoNotCount) {
  const std::vector<Ring> wall{rectangle(0, 0, 4, 4), rectangle(1, 1, 2, 2)};
  std::vector<Ring> careless = wall;
  careless[0].push_back(careless[0].front());
  careless[1].insert(careless[1].begin() + 2, careless[1][1]);
  careless.push_back({{3, 3, 0}, {3, 3, 0}, {3, 3, 0}});
  careless.push_back({{3, 1, 0}, {3, 2, 0}});
  careless.push_back({});
  EXPECT_EQ(bridgeHoles(careless).corners, bridgeHoles(wall).corners);
}

TEST(BridgeHoles, AHoleOutsideIsLeftOut) {
  const std::vector<Ring> wall{rectangle(0, 0, 4, 4), rectangle(1, 1, 2, 2)};
  std::vector<Ring> with_another = wall;
  with_another.push_back(rectangle(6, 1, 7, 2));
  expectTiles(wall, piecesOf(with_another, 1));
}

// A square with two notches has a star-shaped hole in each cell of a grid. The whole is turned by any angle.
TEST(BridgeHoles, RandomFaces) {
  Random random(7);
  const auto star = [&](double x, double y, double most, int corners) {
    Ring ring;
    const double first = random.uniform(0, 6);
    for (int k = 0; k < corners; ++k) {
      const double angle = first + 2 * 3.14159265358979 * k / corners, radius = most * random.uniform(0.2, 1);
      ring.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle), 0});
    }
    return ring;
  };
  for (int trial = 0; trial < 200; ++trial) {
    const int side = 1 + trial % 4;
    const double width = 2.0 * side, notch = random.uniform(0, 0.9);
    // Between the grid and the sides of the square is a margin of 1, and the notches are less deep.
    std::vector<Ring> rings{{{-1, -1, 0},
                             {width + 1, -1, 0},
                             {width + 1 - notch, width / 3, 0},
                             {width + 1, width + 1, 0},
                             {width / 2, width + 1 - notch, 0},
                             {-1, width + 1, 0}}};
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j)
        rings.push_back(star(2 * i + 1, 2 * j + 1, 0.99, 3 + static_cast<int>(random.uniform(0, 9))));
    const double angle = random.uniform(0, 6);
    for (Ring& ring : rings) ring = turnedBy(angle, ring);
    SCOPED_TRACE(trial);
    expectTiles(rings, piecesOf(rings));
  }
}

TEST(BridgeHoles, ManyHolesTakeNoMinutes) {
  std::vector<Ring> rings{rectangle(0, 0, 60, 60)};
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) rings.push_back(rectangle(2 * i + 0.5, 2 * j + 0.5, 2 * i + 1.5, 2 * j + 1.5));
  expectTiles(rings, piecesOf(rings));
}

}  // namespace
}  // namespace viewpeel
