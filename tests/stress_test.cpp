// A quick part of bench/stress, and closed forms where scenes are extreme.
#include "stress.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "compare.h"
#include "reference/contour_integral.h"
#include "reference/exact_engine.h"
#include "reference/rectangles.h"
#include "scenes.h"
#include "test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

class HardScenes : public testing::TestWithParam<stress::Kind> {};

TEST_P(HardScenes, AgreeWithExactAreas) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    const stress::Tally tally = stress::judge(testDevice(), GetParam(), seed);
    EXPECT_LE(tally.worst, 1) << tally.worst_case;
    EXPECT_EQ(tally.unequal, 0u) << "engines differ, seed " << seed;
    EXPECT_EQ(tally.lost_lines, 0u) << "of " << tally.lines << " lines in a closed scene, seed " << seed;
    EXPECT_GT(tally.regions, 20u);
  }
}

TEST_P(HardScenes, OneWrongPolygonIsNoticed) { EXPECT_GT(stress::judge(testDevice(), GetParam(), 2, true).worst, 1); }

INSTANTIATE_TEST_SUITE_P(Kinds, HardScenes, testing::ValuesIn(stress::kKinds), [](const auto& kind) { return stress::nameOf(kind.param); });

InputScene plates(double gap, bool facing) {
  InputScene scene{"plates", {}, {}};
  ts::addFace(scene, "lower", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(scene, "upper", ts::parallelogram({0, 0, gap}, {0, 1, 0}, {1, 0, 0}));
  if (!facing)
    for (InputFace& face : scene.faces) std::reverse(face.corners.begin(), face.corners.end());
  return scene;
}

// Down to 1e-8 of their size, 1.4e-8 of the scene's radius. The environment, 1 - F, is what a gap lets out: it has to be there, and nothing else.
TEST(Stress, GapsBetweenPlates) {
  std::vector<TestRun> runs = withEngines({.lattice = {.resolution = 32}, .estimate = {.directions = 200, .replicates = 8}});
  runs.push_back({.lattice = {.resolution = 32}, .make_engine = makeGraphicsEngine, .estimate = {.directions = 20, .replicates = 8}, .name = "graphics"});
  for (double gap : {1.0, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8})
    for (const TestRun& run : runs) {
      const bool draws = run.make_engine == makeGraphicsEngine;
      if (draws && gap < 0.5 && gap > 2e-7) continue;  // its counts are the other's, see Peel
      SCOPED_TRACE(fmt::format("gap {}, {}", gap, run.name));
      const Estimate facing = estimateScene(plates(gap, true), run), apart = estimateScene(plates(gap, false), run);
      const double truth = reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, gap);
      EXPECT_TRUE(isEstimateOf(facing.form_factors.formFactor(0, 1), truth, facing.replicates, 1e-10));
      EXPECT_EQ(facing.form_factors.formFactor(0, kLeak).value, 0);
      EXPECT_TRUE(isEstimateOf(apart.form_factors.formFactor(0, kEnvironment), 1, apart.replicates));
      EXPECT_EQ(apart.form_factors.formFactor(0, 1).value, 0);
      if (gap > 1e-2 && !draws) {  // below, too few lines pass to tell an error
        EXPECT_TRUE(isEstimateOf(facing.form_factors.formFactor(0, kEnvironment), 1 - truth, facing.replicates, 1e-10));
      }
    }
}

// Polygons nearer to one another than depths can tell, one behind the other, are said to be so.
TEST(Stress, GapsTooNarrowAreReported) {
  EXPECT_TRUE(buildScene(plates(1.5e-8, false)).warnings.empty());
  for (double gap : {6e-9, 1e-9, 1e-11}) {
    const Scene scene = buildScene(plates(gap, false));
    ASSERT_EQ(scene.warnings.size(), 1u) << gap;
    EXPECT_NE(scene.warnings[0].find("upper[1]"), std::string::npos) << scene.warnings[0];
    EXPECT_NE(scene.warnings[0].find("too near to be told apart"), std::string::npos) << scene.warnings[0];
  }
  EXPECT_TRUE(buildScene(plates(0, true)).warnings.empty());
  EXPECT_TRUE(buildScene(ts::roomWithTouchingBoxes()).warnings.empty());
}

// Exact areas, so that a strip 1e-6 wide is met by every direction.
TEST(Stress, SliversHaveTheirClosedForm) {
  for (double width : {1e-3, 1e-6}) {
    InputScene input{"sliver", {}, {}};
    ts::addFace(input, "plate", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    ts::addFace(input, "sliver", ts::parallelogram({0.3, 0, 0.25}, {0, 1, 0}, {width, 0, 0}));
    const Scene scene = buildScene(input);
    const Ids ids = makeIds(scene, By::polygon, false);
    const auto engine = reference::makeExactEngine(scene, ids);
    const Estimate e = estimateFormFactors(*engine, scene, ids, {.directions = 100, .replicates = 16});
    const double truth = reference::parallelRectangles({0.3, 0.3 + width}, {0, 1}, {0, 1}, {0, 1}, 0.25);
    EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(1, 0), truth, e.replicates, 1e-6)) << "width " << width;
    EXPECT_LT(e.form_factors.formFactor(1, 0).standard_error, 0.01);
  }
}

ts::Corners regularPolygon(uint32_t corner_count, double z, bool up) {
  ts::Corners corners;
  for (uint32_t k = 0; k < corner_count; ++k) {
    const double a = (up ? 2 : -2) * 3.14159265358979 * k / corner_count;
    corners.push_back({std::cos(a), std::sin(a), z});
  }
  return corners;
}

// 3 to 64 corners; one of them moved in by 1e-12 to 1e-3, so that the polygon is not convex, or up, so that it is not planar: F moves by no more than that.
TEST(Stress, PolygonsOfManyCorners) {
  for (uint32_t corner_count : {3u, 64u}) {
    const ts::Corners lower = regularPolygon(corner_count, 0, true), upper = regularPolygon(corner_count, 0.7, false);
    const double truth = reference::formFactor(lower, upper);
    for (double moved : {0.0, 1e-12, 1e-3})
      for (int way = 0; way < (moved > 0 && corner_count > 4 ? 2 : 1); ++way) {
        InputScene scene{"polygons", {}, {}};
        ts::Corners dented = lower;
        // Into the chord of its neighbours and beyond: a corner of a polygon of 64 stands out by 0.005.
        if (moved > 0 && corner_count > 4 && way == 0) dented[1] = (dented[0] + dented[2]) / 2.0 * (1 - moved);
        if (moved > 0 && way == 1) dented[1].z += moved;
        ts::addFace(scene, "lower", dented);
        ts::addFace(scene, "upper", upper);
        const double missing = way == 0 && moved > 0 && corner_count > 4 ? glm::length(glm::cross(lower[1] - lower[0], lower[2] - lower[0])) / 2 : 0;
        for (const TestRun& run : withEngines({.lattice = {.resolution = 32}, .estimate = {.directions = 60, .replicates = 8}})) {
          SCOPED_TRACE(fmt::format("{} corners, moved {}, {}", corner_count, moved, run.name));
          const Estimate e = estimateScene(scene, run);
          const double area = e.form_factors.ids().areas[1];
          // A_2 F_21 = A_1 F_12 changes by no more than the area that is missing below, and what a corner raised by `moved` can hide of lines from aside: its two edges, shorter
          // than 2 each, times that.
          EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(1, 0), truth, e.replicates, (missing + 4 * moved) / area + 1e-9));
          EXPECT_EQ(e.form_factors.formFactor(1, kLeak).value, 0);
        }
      }
  }
}

}  // namespace
}  // namespace viewpeel
