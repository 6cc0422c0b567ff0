// These tests run a small part of bench/stress, and compare extreme scenes with closed forms.
#include "scenes/stress.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/compare.h"
#include <viewpeel/error.h>
#include "engines/lattice.h"
#include "engines/size_groups.h"
#include "reference/closed_forms/contour_integral.h"
#include "reference/exact/exact_engine.h"
#include "reference/closed_forms/rectangles.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

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

INSTANTIATE_TEST_SUITE_P(Kinds, HardScenes, testing::ValuesIn(stress::kKinds),
                         [](const auto& kind) { return stress::nameOf(kind.param); });

// The graphics engine can order two coincident polygons, but would count more of them in a wrong order, so it refuses.
TEST(Stress, GraphicsEngineRefusesThreeCoincidentPolygons) {
  InputScene input{"three", {}, {}};
  for (bool up : {true, false, true}) {
    ts::Corners corners = ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    if (!up) std::reverse(corners.begin(), corners.end());
    ts::addFace(input, "face", corners);
  }
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  EXPECT_THROW(makeGraphicsEngine(testDevice(), scene, ids, {.resolution = 16}), Error);
}

InputScene plates(double gap, bool facing) {
  InputScene scene{"plates", {}, {}};
  ts::addFace(scene, "lower", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(scene, "upper", ts::parallelogram({0, 0, gap}, {0, 1, 0}, {1, 0, 0}));
  if (!facing)
    for (InputFace& face : scene.faces) std::reverse(face.corners.begin(), face.corners.end());
  return scene;
}

// Gaps between two plates go down to 1e-8 of their size, 1.4e-8 of the scene's radius. The environment gets the
// radiation that leaves through the gap, 1 - F, and no more.
TEST(Stress, GapsBetweenPlates) {
  std::vector<TestRun> runs =
      withEngines({.lattice = {.resolution = 32}, .estimate = {.directions = 200, .replicates = 8}});
  runs.push_back({.lattice = {.resolution = 32},
                  .engine = EngineKind::graphics,
                  .estimate = {.directions = 20, .replicates = 8},
                  .name = "graphics"});
  for (double gap : {1.0, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8})
    for (const TestRun& run : runs) {
      const bool draws = run.engine == EngineKind::graphics;
      // The graphics engine is slow. Its counts equal the other engines' (peel_test.cpp), so three gaps do.
      if (draws && gap < 0.5 && gap > 2e-7) continue;
      SCOPED_TRACE(fmt::format("gap {}, {}", gap, run.name));
      const Estimate facing = estimateScene(plates(gap, true), run), apart = estimateScene(plates(gap, false), run);
      const double truth = reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, gap);
      EXPECT_TRUE(isEstimateOf(facing.form_factors.formFactor(0, 1), truth, facing.replicates, 1e-10));
      EXPECT_EQ(facing.form_factors.formFactor(0, kLeak).value, 0);
      EXPECT_TRUE(isEstimateOf(apart.form_factors.formFactor(0, kEnvironment), 1, apart.replicates));
      EXPECT_EQ(apart.form_factors.formFactor(0, 1).value, 0);
      if (gap > 1e-2 && !draws) {  // through narrower gaps too few lines pass for an error
        EXPECT_TRUE(isEstimateOf(facing.form_factors.formFactor(0, kEnvironment), 1 - truth, facing.replicates, 1e-10));
      }
    }
}

// Two plates alone in space keep their order, also where the gap is narrower than depths resolve.
TEST(Stress, GapsTooNarrowForDepths) {
  for (double gap : {6e-9, 1e-9, 1e-11})
    for (const TestRun& run :
         withEngines({.lattice = {.resolution = 32}, .estimate = {.directions = 50, .replicates = 4}})) {
      SCOPED_TRACE(fmt::format("gap {}, {}", gap, run.name));
      const Estimate facing = estimateScene(plates(gap, true), run), apart = estimateScene(plates(gap, false), run);
      EXPECT_TRUE(isEstimateOf(facing.form_factors.formFactor(0, 1), 1, facing.replicates, 1e-10));
      // The allowance is for lines that leave between the edges, and for corners snapped to 2^-24.
      EXPECT_LE(facing.form_factors.formFactor(0, kEnvironment).value, 4 * gap + 8 * 0x1p-24);
      EXPECT_TRUE(isEstimateOf(apart.form_factors.formFactor(0, kEnvironment), 1, apart.replicates));
      EXPECT_EQ(apart.form_factors.formFactor(0, 1).value, 0);
    }
}

// The exact engine meets a strip of width 1e-6 along every direction, so the estimate has the closed form.
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

// Returns seven pairs of equal squares that face each other, an edge length apart, with areas from 1 to 1e-12.
constexpr int kSizes = 7;
InputScene pairsOfAllSizes() {
  InputScene scene{"pairs of all sizes", {}, {}};
  double x = 0;
  for (int k = 0; k < kSizes; ++k) {
    const double edge = std::pow(10.0, -k);
    ts::addFace(scene, fmt::format("low{}", k), ts::parallelogram({x, 0.3, 0.2}, {edge, 0, 0}, {0, edge, 0}));
    ts::addFace(scene, fmt::format("high{}", k), ts::parallelogram({x, 0.3, 0.2 + edge}, {0, edge, 0}, {edge, 0, 0}));
    x += edge + 0.05;
  }
  return scene;
}

// Windows are up to 2^20 spacings fine, and the smallest squares are half a spacing wide there. Lattice points are
// used, for scanlines have at most 2^14 rows, so that chooseSampling() leaves them out with such small polygons.
TEST(Stress, AreasFromOneToATrillionth) {
  const Scene scene = buildScene(pairsOfAllSizes());
  const Ids ids = makeIds(scene, By::polygon, false);
  ASSERT_EQ(chooseSampling(scene, ids, true), Sampling::lattice);
  std::vector<double> needed;
  for (const Polygon& polygon : scene.polygons) needed.push_back(16 / std::sqrt(polygon.area));
  const auto groups = groupBySize(scene, needed, 16);
  ASSERT_EQ(groups.back().resolution, kMaxWindowResolution);
  constexpr double kTruth = 0.199824895698;  // Howell, C-11
  const EstimateOptions options{.directions = 400, .replicates = 16};
  for (const EngineKind kind : {EngineKind::compute, EngineKind::host}) {
    SCOPED_TRACE(kind == EngineKind::host ? "host" : "compute");
    const Estimate e =
        estimateFormFactors(*makeGroupedEngine(enginesOf(kind), scene, ids, {}, groups), scene, ids, options);
    for (uint32_t k = 0; k < kSizes; ++k) {
      const Measured f = e.form_factors.formFactor(2 * k, 2 * k + 1);
      EXPECT_TRUE(isEstimateOf(f, kTruth, e.replicates)) << k;
      // Independent directions have Var F <= v(F) = 4/3 (1 - (1 - F)^3/2) - F^2 (Pellegrini 1997), and lattice points
      // add 2 h^2 F / A. The standard error from 16 replicates is twice the true one in 2 of 10^7 cases (chi-squared of
      // 15 degrees of freedom above 60).
      int resolution = 0;
      for (const SizeGroup& group : groups)
        if (std::ranges::count(group.polygons, 2 * k)) resolution = group.resolution;
      const double spread = 4 / 3.0 * (1 - std::pow(1 - kTruth, 1.5)) - kTruth * kTruth,
                   lattice = 2 * pointArea(resolution) * kTruth / scene.polygons[2 * k].area;
      EXPECT_LT(f.standard_error, 2 * std::sqrt((spread + lattice) / options.directions / options.replicates)) << k;
      EXPECT_TRUE(isEstimateOf(e.form_factors.rowSums()[2 * k], 1, e.replicates)) << k;
      EXPECT_EQ(e.form_factors.formFactor(2 * k, kLeak).value, 0) << k;
    }
  }
}

// All engines count the line through the middle of a square of 1e-6 of the scene's size, and no line beside it. This
// includes the graphics engine, which has no windows.
TEST(Stress, ALineThroughASpeckMeetsIt) {
  const Scene scene = buildScene(pairsOfAllSizes());
  const Ids ids = makeIds(scene, By::polygon, false);
  constexpr int kResolution = 509;
  std::vector<std::unique_ptr<Engine>> engines;
  for (const EngineKind kind : {EngineKind::compute, EngineKind::graphics, EngineKind::host})
    engines.push_back(enginesOf(kind)(scene, ids, {.resolution = kResolution}));
  for (uint32_t k = 0; k < kSizes; ++k) {
    const Polygon &low = scene.polygons[2 * k], &high = scene.polygons[2 * k + 1];
    const glm::dvec3 middle = (scene.corners[low.first_corner] + scene.corners[low.first_corner + 2] +
                               scene.corners[high.first_corner] + scene.corners[high.first_corner + 2]) /
                              4.0;
    // The direction lies 0.1 rad from the normals, so that the two plates overlap by nine tenths.
    const glm::dvec3 u(std::sin(0.1), 0, std::cos(0.1)), x = glm::normalize(glm::dvec3(0.3, 1, -0.3 * std::tan(0.1))),
                                                         y = glm::cross(u, x);
    const auto through = [&](double spacings_beside) {
      const auto offset = [&](const glm::dvec3& axis) {
        const double at = spacings_beside - glm::dot(middle, axis) * kResolution / 2;
        return at - std::floor(at);
      };
      return Direction{x, y, u, {offset(x), offset(y)}};
    };
    const auto countOf = [&](const Direction& direction) {
      std::vector<uint64_t> counts(engines.size(), 0);
      for (size_t e = 0; e < engines.size(); ++e)
        for (const PairCount& pair : engines[e]->count({&direction, 1}))
          if (pair.i == 2 * k && pair.j == 2 * k + 1) counts[e] = pair.count;
      EXPECT_TRUE(std::ranges::count(counts, counts[0]) == 3)
          << k << ": compute " << counts[0] << ", graphics " << counts[1] << ", host " << counts[2];
      return counts[0];
    };
    const double across = std::sqrt(low.area) * kResolution / 2;  // width of the square in spacings
    if (across > 0.5) {
      // A convex region of area A and perimeter P, in spacings, has between A - P / 2 and A + P / 2 + 1 lattice points
      // (Nosarzewska 1948). Snapping may add one.
      EXPECT_NEAR(double(countOf(through(0))), (1 - std::tan(0.1)) * std::cos(0.1) * across * across, 2 * across + 2)
          << k;
    } else {
      EXPECT_EQ(countOf(through(0)), 1u) << k;
      EXPECT_EQ(countOf(through(0.5)), 0u) << k;
    }
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

// Returns two polygons face to face. One corner of the lower one is moved: in, beyond the chord of its neighbours, so
// that the polygon is not convex, or up, so that it is not planar.
enum class Way { in, up };
InputScene polygonsFaceToFace(uint32_t corner_count, double moved, Way way) {
  ts::Corners lower = regularPolygon(corner_count, 0, true);
  // A corner of a polygon of 64 corners stands out by 0.005 beyond the chord.
  if (moved > 0 && way == Way::in) lower[1] = (lower[0] + lower[2]) / 2.0 * (1 - moved);
  if (moved > 0 && way == Way::up) lower[1].z += moved;
  InputScene scene{"polygons", {}, {}};
  ts::addFace(scene, "lower", lower);
  ts::addFace(scene, "upper", regularPolygon(corner_count, 0.7, false));
  return scene;
}

// Polygons have 3 or 64 corners. A corner is moved in or up by 1e-12 or 1e-3, and F changes by no more than the bound
// below.
TEST(Stress, PolygonsOfManyCorners) {
  for (uint32_t corner_count : {3u, 64u}) {
    const ts::Corners lower = regularPolygon(corner_count, 0, true), upper = regularPolygon(corner_count, 0.7, false);
    const double truth = reference::formFactor(lower, upper);
    for (double moved : {0.0, 1e-12, 1e-3})
      for (const Way way : {Way::in, Way::up}) {
        if (moved == 0 ? way == Way::up : corner_count == 3)
          continue;  // this is the same scene again, or a triangle that stays convex and planar
        const InputScene scene = polygonsFaceToFace(corner_count, moved, way);
        const double missing =
            way == Way::in && moved > 0 ? glm::length(glm::cross(lower[1] - lower[0], lower[2] - lower[0])) / 2 : 0;
        for (const TestRun& run :
             withEngines({.lattice = {.resolution = 32}, .estimate = {.directions = 60, .replicates = 8}})) {
          SCOPED_TRACE(fmt::format("{} corners, moved {}, {}", corner_count, moved, run.name));
          const Estimate e = estimateScene(scene, run);
          const double area = e.form_factors.ids().areas[1];
          // A_2 F_21 = A_1 F_12 changes by no more than two areas. One is missing from the lower polygon. The other is
          // `moved` times the two edges of a raised corner, each shorter than 2, which may hide lines.
          EXPECT_TRUE(
              isEstimateOf(e.form_factors.formFactor(1, 0), truth, e.replicates, (missing + 4 * moved) / area + 1e-9));
          EXPECT_EQ(e.form_factors.formFactor(1, kLeak).value, 0);
        }
      }
  }
}

// The graphics engine has the counts of compute and host engine, whose estimates other tests check. Directions are the
// axes, which are poles of the maps of directions, the nearest doubles beside them, and random ones.
TEST(Stress, GraphicsCountsAsTheOthers) {
  std::vector<Direction> directions = sampleDirections(Sampler::iid, 8, 5, 0);
  for (const glm::dvec3& pole : {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0)})
    for (const double beside : {0.0, 1e-16, 1e-8})
      for (const Direction& direction : sampleLattices(pole + beside * glm::dvec3(0.6, 0.5, 0.4), 1, 7))
        directions.push_back(direction);
  std::vector<InputScene> scenes;
  for (const double gap : {1.0, 1e-2, 1e-4, 1e-6, 1e-8}) scenes.push_back(plates(gap, true));
  const glm::dmat3 turn(0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1);
  for (const auto& [scale, offset] : {std::pair(1.0, 1e8), {1e-12, 0.0}, {1e12, 0.0}})
    scenes.push_back(ts::transformed(ts::cubeInCube(0.5), turn, scale, glm::dvec3(offset)));
  for (const double moved : {1e-12, 1e-3})
    for (const Way way : {Way::in, Way::up}) scenes.push_back(polygonsFaceToFace(64, moved, way));
  for (size_t k = 0; k < scenes.size(); ++k) {
    SCOPED_TRACE(fmt::format("scene {}, {}", k, scenes[k].file));
    const PairCounts counts = countPairs(buildScene(scenes[k]), directions, {.lattice = {.resolution = 24}});
    EXPECT_TRUE(
        std::ranges::any_of(counts, [](const PairCount& count) { return count.j < kEnvironment && count.count > 0; }));
  }
}

}  // namespace
}  // namespace viewpeel
