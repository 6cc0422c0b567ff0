#include "facing.h"

#include <gtest/gtest.h>

namespace viewpeel {
namespace {

TEST(Facing, SideIsFrontWhereThePolygonIsTurnedToTheGap) {
  EXPECT_EQ(sideTowardsGap(true, false, true), kSideFront);  // the front looks up and the gap is above
  EXPECT_EQ(sideTowardsGap(true, false, false), kSideBack);
  EXPECT_EQ(sideTowardsGap(false, false, true), kSideBack);
  EXPECT_EQ(sideTowardsGap(false, false, false), kSideFront);
  for (bool front_up : {false, true})
    for (bool above : {false, true}) EXPECT_EQ(sideTowardsGap(front_up, true, above), kSideFront);
}

TEST(Facing, EveryGapIsClassified) {
  EXPECT_EQ(classifyGap(kSideFront, kSideFront), kGapFacingPair);
  EXPECT_EQ(classifyGap(kSideFront, kSideNone), kGapLowerEnvironment);
  EXPECT_EQ(classifyGap(kSideNone, kSideFront), kGapUpperEnvironment);
  EXPECT_EQ(classifyGap(kSideFront, kSideBack), kGapLowerLeak);
  EXPECT_EQ(classifyGap(kSideBack, kSideFront), kGapUpperLeak);
  for (uint lower : {kSideNone, kSideBack})
    for (uint upper : {kSideNone, kSideBack}) EXPECT_EQ(classifyGap(lower, upper), kGapNothing);
}

}  // namespace
}  // namespace viewpeel
