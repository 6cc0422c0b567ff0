#include "reference/exact/convex_polygon.h"

#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "tests/support/reference_shapes.h"

namespace viewpeel::reference {
namespace {

using test::Corners;

ConvexPolygon square() { return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}; }

TEST(Clip, HalvesASquare) {
  EXPECT_NEAR((double)area(clip(square(), {{1, 0, 0}, 0.25L}, 0)), 0.75, 1e-18);
  EXPECT_NEAR((double)area(clip(square(), {{-1, 0, 0}, -0.25L}, 0)), 0.25, 1e-18);
}

TEST(Clip, KeepsWhatLiesOnTheBoundary) {
  EXPECT_EQ(clip(square(), {{1, 0, 0}, 0}, 0).size(), 4u);
  EXPECT_EQ(clip(square(), {{1, 0, 0}, 1e-17L}, 1e-16L).size(), 4u);
  EXPECT_TRUE(clip(square(), {{1, 0, 0}, 1}, 1e-16L).empty());  // only an edge is left
  EXPECT_TRUE(clip({}, {{1, 0, 0}, 0}, 0).empty());
}

TEST(Clip, RandomPartsAddUp) {
  test::Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const test::Pair pair = test::randomPair(random);
    const ConvexPolygon polygon(pair.a.begin(), pair.a.end());
    const Vec3 normal(random.direction());
    const HalfSpace side{normal, random.uniform(-0.3, 0.3)};
    const long double parts = area(clip(polygon, side, 0)) + area(clip(polygon, {-normal, -side.offset}, 0));
    // New corners are rounded along their edge only, which moves area from one part to the other.
    EXPECT_NEAR((double)parts, (double)area(polygon), 1e-17) << "trial " << trial;
  }
}

TEST(FacingParts, ClipsToBothFronts) {
  const ConvexPolygon wall{
      {0.5L, 0, -1}, {0.5L, 0, 1}, {0.5L, 1, 1}, {0.5L, 1, -1}};  // looks along -x, crosses the square
  const FacingParts parts = facingParts(square(), wall, 1e-16L);
  EXPECT_NEAR((double)area(parts.a), 0.5, 1e-18);
  EXPECT_NEAR((double)area(parts.b), 1, 1e-18);
}

TEST(FacingParts, EmptyBehindAndWithinThePlane) {
  const ConvexPolygon beside{{2, 0, 0}, {3, 0, 0}, {3, 1, 0}}, above_looking_up{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  EXPECT_TRUE(facingParts(square(), beside, 1e-16L).a.empty());
  EXPECT_TRUE(facingParts(square(), above_looking_up, 1e-16L).a.empty());
}

TEST(ToUnitFrame, FitsTheBallAndKeepsShape) {
  const Corners corners = test::moved(test::rectangle({0, 0, 0}, {3, 0, 0}, {0, 4, 0}), 1, {1e6, 0, 0});
  const UnitFrame frame = toUnitFrame({corners});
  EXPECT_NEAR((double)area(frame.polygons[0]), 12 / 6.25, 1e-18);
  for (const Vec3& corner : frame.polygons[0]) EXPECT_LE((double)glm::length(corner), 1 + 1e-18);
  EXPECT_GE((double)frame.rounding, 1e6 / 2.5 * 0x1p-53);
}

TEST(ToUnitFrame, RefusesBadPolygons) {
  const double nan = std::nan("");
  const Corners bad[] = {
      {{0, 0, 0}, {1, 0, 0}},                                                         // two corners
      {{0, 0, 0}, {1, 0, 0}, {0, nan, 0}},                                            // not a number
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}},                                              // no area
      {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}},                                              // no area
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 1e-3}, {0, 1, 0}},                                // not planar
      {{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}},                               // not convex
      {{1, 0, 0}, {-0.8, 0.6, 0}, {0.3, -0.95, 0}, {0.3, 0.95, 0}, {-0.8, -0.6, 0}},  // crosses itself
  };
  for (const Corners& corners : bad) try {
      toUnitFrame({corners});
      ADD_FAILURE() << "accepted polygon " << &corners - bad;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
    }
}

}  // namespace
}  // namespace viewpeel::reference
