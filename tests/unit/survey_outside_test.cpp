// What leaves a scene or ends on backs is found where common directions hardly meet a polygon.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>
#include <viewpeel/compute.h>
#include "estimator/plan_lines.h"
#include "estimator/survey_outside.h"
#include "reference/closed_forms/rectangles.h"
#include "scenes/named_scenes.h"
#include "tests/support/same_bits.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kSize = 0.1, kApart = 0.05;  // of a pair of squares
const double kOfSquares = reference::parallelRectangles({0, kSize}, {0, kSize}, {0, kSize}, {0, kSize}, kApart);

// Returns pairs of squares, "low 0" under "high 0" and so on, all kilometres apart.
//   In: faces: whether they face each other; else both look upwards, and the low one sees the other's back
InputScene farAwayPairs(bool faces) {
  InputScene input;
  for (int k = 0; k < 20; ++k) {
    const double x = 1000.0 * k, y = 1000.0 * (k * k % 7);
    const glm::dvec3 right(kSize, 0, 0), back(0, kSize, 0);
    ts::addFace(input, "low " + std::to_string(k), ts::parallelogram({x, y, 0}, right, back));
    ts::addFace(
        input, "high " + std::to_string(k),
        faces ? ts::parallelogram({x, y, kApart}, back, right) : ts::parallelogram({x, y, kApart}, right, back));
  }
  return input;
}

OutsideShares survey(const InputScene& input) {
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeRayEngine(scene, ids, {.thread_count = 2});
  return surveyOutside(*engine, scene, ids, 64, 1024, 1);
}

TEST(SurveyOutside, FindsNothingInClosedScenes) {
  for (const InputScene& input : {ts::insideOfCube(), ts::cubeInCube(0.4), ts::roomWithTouchingBoxes()}) {
    EXPECT_EQ(survey(input).largest_environment, 0) << input.file;
    EXPECT_EQ(survey(input).largest_leak, 0) << input.file;
    EXPECT_FALSE(survey(input).has_outside) << input.file;
  }
}

TEST(SurveyOutside, MeasuresTheLargestShares) {
  // Shares of 64 and of 1,024 independent rays have these standard errors; the rows' largest is off by six at most.
  const double error_of_64 = std::sqrt(kOfSquares * (1 - kOfSquares) / 64), error_of_1024 = error_of_64 / 4;
  const OutsideShares open = survey(farAwayPairs(true)), leaking = survey(farAwayPairs(false));
  EXPECT_NEAR(open.largest_environment, 1 - kOfSquares, 6 * error_of_64);
  EXPECT_EQ(open.largest_leak, 0);
  EXPECT_EQ(leaking.largest_environment, 1);  // of the high squares
  EXPECT_NEAR(leaking.largest_leak, kOfSquares, 6 * error_of_1024);
}

// More rows leak than get further rays. One of them leaks far more than the others.
TEST(SurveyOutside, OfManyLeakingRowsFindsTheLargestShare) {
  constexpr double kNear = 0.001;
  InputScene input;
  for (int k = 0; k < 700; ++k) {
    const glm::dvec3 corner(k % 30, k / 30, 0), right(kSize, 0, 0), back(0, kSize, 0);
    ts::addFace(input, "low " + std::to_string(k), ts::parallelogram(corner, right, back));
    ts::addFace(input, "high " + std::to_string(k),
                ts::parallelogram(corner + glm::dvec3(0, 0, k == 555 ? kNear : kApart), right, back));
  }
  const double largest = reference::parallelRectangles({0, kSize}, {0, kSize}, {0, kSize}, {0, kSize}, kNear);
  const double error_of_1024 = std::sqrt(largest * (1 - largest) / 1024);
  EXPECT_NEAR(survey(input).largest_leak, largest, 6 * error_of_1024);
}

// Returns a parallelogram cut into side x side tiles, row by row.
std::vector<ts::Corners> tilesOf(const glm::dvec3& corner, const glm::dvec3& right, const glm::dvec3& up,
                                 uint32_t side) {
  const glm::dvec3 of_right = right / double(side), of_up = up / double(side);
  std::vector<ts::Corners> tiles;
  for (uint32_t k = 0; k < side * side; ++k)
    tiles.push_back(
        ts::parallelogram(corner + double(k % side) * of_right + double(k / side) * of_up, of_right, of_up));
  return tiles;
}

constexpr uint32_t kTilesOfWall = 16;

// Returns a cube of 16 x 16 tiles a wall, seen from inside. One tile is missing, a hole of 1 / 1,536 of the area.
InputScene cubeWithHole() {
  InputScene input = ts::insideOfCube();
  const std::vector<InputFace> walls = std::exchange(input.faces, {});
  for (const InputFace& wall : walls) {
    const glm::dvec3 corner = wall.corners[0];
    for (const ts::Corners& tile : tilesOf(corner, wall.corners[1] - corner, wall.corners[3] - corner, kTilesOfWall))
      input.faces.push_back({tile, wall.surface});
  }
  input.faces.erase(input.faces.begin() + kTilesOfWall * kTilesOfWall / 2 + kTilesOfWall / 2);
  return input;
}

// A tile sends 0.05 of its 64 rays through the hole on average, so that no tile has three, but all have about 60.
TEST(SurveyOutside, FindsASmallOpening) {
  const OutsideShares shares = survey(cubeWithHole());
  EXPECT_EQ(shares.largest_environment, 0);
  EXPECT_TRUE(shares.has_outside);
}

// Where all pairs have lines, rays find that the scene is open. Nothing blocks a pair here, so that each row's
// environment is exact. By reciprocity all rows together send as much through the hole as it would send to them.
//   Error: unoccluded form factors of a row err by less than 1e-6 (docs/method.md, section 11)
TEST(SurveyOutside, RaysSeeWhatLeavesBesideLinesOfAllPairs) {
  const Scene scene = buildScene(cubeWithHole());
  Request request;
  request.by = By::polygon, request.pair_lines = true, request.promise = false;
  request.goal = Tolerance{1e-2};
  const Result result = computeFormFactors(scene, request);
  ASSERT_TRUE(result.plan.pair_lines);
  EXPECT_EQ(result.plan.pair_lines->least_form_factor, 0);
  EXPECT_TRUE(result.plan.pair_lines->has_rays);
  EXPECT_EQ(result.directions, 32 * result.replicates);
  EXPECT_EQ(result.unmet_bound, INFINITY);  // no pair is left to the rays
  const FormFactors& found = result.form_factors;
  double through_hole = 0;
  for (uint32_t i = 0; i < found.ids().count(); ++i) {
    through_hole += found.exchangeArea(i, kEnvironment).value;
    EXPECT_EQ(found.formFactor(i, kLeak).value, 0) << i;
    EXPECT_NEAR(found.rowSums()[i].value, 1, 1e-6) << i;  // tiles beside the hole do not see it
  }
  EXPECT_NEAR(through_hole, 1.0 / (kTilesOfWall * kTilesOfWall), 1e-6);
}

// No line of a common direction meets these squares. Rows still add up to 1, by the environment that is left.
TEST(SurveyOutside, RowsOfFarAwayPartsHaveTheirEnvironment) {
  const Scene scene = buildScene(farAwayPairs(true));
  for (const bool promise : {false, true})
    for (const By by : {By::polygon, By::surface}) {
      Request request;
      request.by = by, request.promise = promise;
      request.goal = Tolerance{1e-2};
      const FormFactors found = computeFormFactors(scene, request).form_factors;
      for (uint32_t i = 0; i < found.ids().count(); ++i) {
        EXPECT_NEAR(found.formFactor(i, kEnvironment).value, 1 - kOfSquares, 1e-8);
        EXPECT_NEAR(found.rowSums()[i].value, 1, 1e-12);
      }
      EXPECT_EQ(found.hasIntervals(), promise);
    }
}

// A promise has no room for leaks, and an estimate has lines that end on backs, whatever the seed.
TEST(SurveyOutside, LeaksOfFarAwayPartsHaveLines) {
  const Scene scene = buildScene(farAwayPairs(false));
  for (const uint64_t seed : {1, 2, 3}) {
    Request request;
    request.by = By::polygon, request.seed = seed;
    request.goal = Tolerance{1e-2};
    const FormFactors found = computeFormFactors(scene, request).form_factors;
    EXPECT_FALSE(found.hasIntervals());
    for (uint32_t i = 0; i < found.ids().count(); ++i) {
      const double leak = found.ids().names[i].starts_with("low") ? kOfSquares : 0;
      EXPECT_NEAR(found.formFactor(i, kLeak).value, leak, 1e-2) << found.ids().names[i];
      EXPECT_NEAR(found.formFactor(i, kEnvironment).value, 1 - leak, 1e-2) << found.ids().names[i];
    }
  }
}

constexpr double kPlateTolerance = 1e-2;  // each face then has 768 rays that decide whether it leaks
constexpr uint32_t kTiles = 12;

// Returns a floor of tiles under a plate that shows its back to them.
InputScene floorUnderPlate() {
  InputScene input;
  for (uint32_t k = 0; k < kTiles * kTiles; ++k)
    ts::addFace(input, "floor", ts::parallelogram({double(k % kTiles), double(k / kTiles), 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "plate", ts::parallelogram({0, 0, 0.5}, {2, 0, 0}, {0, 2, 0}));
  return input;
}

double leakOfTile(uint32_t tile) {
  const double x = tile % kTiles, y = tile / kTiles;
  return reference::parallelRectangles({x, x + 1}, {y, y + 1}, {0, 2}, {0, 2}, 0.5);
}

Request requestOfPlate(By by, uint64_t seed) {
  Request request;
  request.by = by, request.seed = seed;
  request.goal = Tolerance{kPlateTolerance};
  return request;
}

TEST(SurveyOutside, FindsTheRowsThatLeak) {
  constexpr uint32_t kRays = 768;
  const Scene scene = buildScene(floorUnderPlate());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeRayEngine(scene, ids, {.thread_count = 2});
  for (const uint64_t seed : {1, 2, 3}) {
    const std::vector<bool> leaking = findLeakingRows(*engine, scene, ids, kRays, seed);
    ASSERT_EQ(leaking.size(), kTiles * kTiles + 1);
    EXPECT_FALSE(leaking[kTiles * kTiles]) << "the plate";
    // A row that leaks the share of 20 rays is missed with probability 2e-9.
    for (uint32_t k = 0; k < kTiles * kTiles; ++k) EXPECT_TRUE(leaking[k] || leakOfTile(k) < 20.0 / kRays) << k;
    EXPECT_LT(std::ranges::count(leaking, true), kTiles * kTiles / 2);
  }
}

// Tiles that leak have lines to the plate's back, so that what they leak is exact: nothing is in between. What other
// tiles leak is 0 or what common directions saw, with one ray's share as the standard error. Of n rays none ends on the
// back of the plate with probability exp(-n leak), so that the leak is more than 12 shares once in 160,000 tiles.
TEST(SurveyOutside, OnlyRowsThatLeakHaveLinesToBacks) {
  constexpr double kShare = 1.0 / 768;
  const Scene scene = buildScene(floorUnderPlate());
  for (const uint64_t seed : {1, 2, 3}) {
    const FormFactors found = computeFormFactors(scene, requestOfPlate(By::polygon, seed)).form_factors;
    uint32_t exact = 0, by_rays = 0;
    for (uint32_t k = 0; k < kTiles * kTiles; ++k) {
      const Measured environment = found.formFactor(k, kEnvironment), leak = found.formFactor(k, kLeak);
      EXPECT_NEAR(environment.value + leak.value, 1, 1e-12) << k;
      if (environment.standard_error < 1e-8) {
        EXPECT_NEAR(leak.value, leakOfTile(k), 1e-8) << k;
        ++exact;
      } else {
        EXPECT_NEAR(environment.standard_error, kShare, 1e-8) << k;
        EXPECT_NEAR(environment.value, 1 - leakOfTile(k), 12 * kShare) << k;
        ++by_rays;
      }
    }
    EXPECT_GT(exact, 4u);
    EXPECT_GT(by_rays, kTiles * kTiles / 2);
  }
}

// Where the time is the goal, no tolerance says how many rays are enough, and all rows have lines to backs.
TEST(SurveyOutside, ATimedRunHasLinesToAllBacks) {
  Request request = requestOfPlate(By::polygon, 1);
  request.goal = Seconds{20};  // it ends sooner, for all of its pairs are clear
  const FormFactors found = computeFormFactors(buildScene(floorUnderPlate()), request).form_factors;
  for (uint32_t k = 0; k < kTiles * kTiles; ++k) {
    EXPECT_NEAR(found.formFactor(k, kLeak).value, leakOfTile(k), 1e-8) << k;
    EXPECT_LT(found.formFactor(k, kEnvironment).standard_error, 1e-8) << k;
  }
}

// A surface leaks as all its faces do together.
TEST(SurveyOutside, AllFacesOfALeakingSurfaceHaveLinesToBacks) {
  double leak = 0;
  for (uint32_t k = 0; k < kTiles * kTiles; ++k) leak += leakOfTile(k) / (kTiles * kTiles);
  const FormFactors found =
      computeFormFactors(buildScene(floorUnderPlate()), requestOfPlate(By::surface, 1)).form_factors;
  EXPECT_NEAR(found.formFactor(0, kLeak).value, leak, 1e-8);
  EXPECT_NEAR(found.formFactor(0, kEnvironment).value, 1 - leak, 1e-8);
  EXPECT_LT(found.formFactor(0, kEnvironment).standard_error, 1e-8);
}

// Returns a box without a lid, of 8 x 8 tiles a wall, seen from inside. One wall has a square hole. Behind the hole
// stands a plate that shows its back. The tile that faces the hole leaks most: at most the hole's area over pi, which
// is 8e-4 by default. The plate has cuts x cuts tiles.
InputScene boxWithLeak(double hole = 0.05, int cuts = 1) {
  const double low = 0.5 - hole / 2, high = 0.5 + hole / 2;
  InputScene input;
  const auto add = [&](const glm::dvec3& corner, const glm::dvec3& right, const glm::dvec3& up) {
    for (const ts::Corners& tile : tilesOf(corner, right, up, 8))
      ts::addFace(input, "tile " + std::to_string(input.faces.size()), tile);
  };
  const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  add({0, 0, 0}, x, y), add({0, 0, 0}, y, z), add({0, 0, 0}, z, x), add({0, 1, 0}, x, z);
  const auto addPart = [&](double y_low, double y_high, double z_low, double z_high) {
    ts::addFace(input, "part " + std::to_string(input.faces.size()),
                ts::parallelogram({1, y_low, z_low}, (z_high - z_low) * z, (y_high - y_low) * y));
  };
  addPart(0, low, 0, 1), addPart(high, 1, 0, 1), addPart(low, high, 0, low), addPart(low, high, high, 1);
  for (const ts::Corners& tile : tilesOf({1.2, -2, -2}, 5.0 * y, 3.0 * z, cuts)) ts::addFace(input, "plate", tile);
  return input;
}

// What leaks less than the tolerance is left to rays. One of a row's first 256 rays that ends on a back would stand for
// a leak of 0.004 +- 0.004. Such rows get further rays until leak and environment are within the goal.
TEST(SurveyOutside, SmallLeaksReachTheGoal) {
  constexpr double kTolerance = 2e-3, kMostLeak = 8e-4;
  constexpr uint64_t kPlanned = 8;  // replicates
  const Scene scene = buildScene(boxWithLeak());
  for (const auto& [by, seed] : {std::pair(By::polygon, 1), {By::polygon, 2}, {By::surface, 1}, {By::surface, 2}}) {
    Request request;
    request.by = by, request.seed = static_cast<uint64_t>(seed);
    request.goal = Tolerance{kTolerance};
    request.promise = false;
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.plan.pair_lines);
    EXPECT_EQ(result.plan.pair_lines->least_form_factor, 0);
    EXPECT_TRUE(result.goal_reached);
    EXPECT_GT(result.replicates, kPlanned);
    EXPECT_LE(result.largest_standard_error, kTolerance / errorsInRowGoal(result.form_factors.ids().count()));
    uint32_t leaking = 0;
    for (uint32_t k = 0; k < result.form_factors.ids().count(); ++k) {
      const Measured leak = result.form_factors.formFactor(k, kLeak);
      EXPECT_LE(leak.value, kMostLeak + kTolerance) << k;
      leaking += leak.value > 0;
      EXPECT_NEAR(result.form_factors.rowSums()[k].value, 1, 1e-12) << k;
    }
    EXPECT_GT(leaking, 0u);
  }
}

// As above, but a speck makes the scene too uneven for rays, so common directions say what leaks. Most lines pass by a
// small hole. Where the first 64 directions have no line through it, and later ones have one, this line stands for a
// leak of 4e-3 +- 4e-3. Then further directions follow, and a run that ends short of its goal says so. So many exposed
// backs have no lines of their own.
TEST(SurveyOutside, LeaksAlongDirectionsReachTheGoalOrTheRunSaysSo) {
  constexpr double kSpeck = 1e-6, kTolerance = 2e-3;
  InputScene input = boxWithLeak(0.01, 20);
  ts::addFace(input, "speck", ts::parallelogram({0.5, 0.5, 0.9}, {kSpeck, 0, 0}, {0, kSpeck, 0}));
  const Scene scene = buildScene(input);
  ASSERT_FALSE(suitsRays(scene));
  int went_on = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    Request request;
    request.seed = seed;
    request.goal = Tolerance{kTolerance};
    request.promise = false;
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.plan.pair_lines);
    const bool is_within = result.largest_standard_error <= kTolerance / errorsInRowGoal(scene.faces.size());
    EXPECT_TRUE(is_within || !result.goal_reached) << seed;
    went_on += result.replicates > 16;
  }
  EXPECT_GT(went_on, 0);
}

// Runs a request whole and, from a checkpoint after `steps` steps, resumed, and expects the same bits.
void expectSameWhenResumed(const Scene& scene, const Request& request, int steps) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "leaking_rows.h5";
  FormFactorRun whole(scene, request);
  whole.makePlan();
  for (int k = 0; k < steps; ++k) whole.step();
  ASSERT_FALSE(whole.isDone());
  whole.writeCheckpoint(file);
  while (!whole.isDone()) whole.step();
  FormFactorRun second(scene, request);
  second.resumeFrom(file);
  second.makePlan();
  while (!second.isDone()) second.step();
  expectSameBits(second.result().form_factors, whole.result().form_factors);
  std::filesystem::remove(file);
}

// A run that is resumed has lines to the same backs, by the checkpoint, though it casts no rays.
TEST(SurveyOutside, AResumedRunHasLinesToTheSameBacks) {
  expectSameWhenResumed(buildScene(floorUnderPlate()), requestOfPlate(By::polygon, 1), 1);
}

// The eighth step is the last planned one, and further rays follow.
TEST(SurveyOutside, AResumedRunHasTheSameFurtherRays) {
  Request request;
  request.promise = false;
  request.goal = Tolerance{2e-3};
  for (const By by : {By::polygon, By::surface})
    for (const int steps : {1, 8}) {
      request.by = by;
      expectSameWhenResumed(buildScene(boxWithLeak()), request, steps);
    }
}

}  // namespace
}  // namespace viewpeel
