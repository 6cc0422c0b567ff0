// Depth peeling: bit-exact against the CPU twin, and what it must never lose.
#include <cstdlib>

#include <gtest/gtest.h>

#include "cpu_twin.h"
#include "scenes.h"
#include "test_device.h"

namespace viewpeel {

namespace {

namespace ts = test_scenes;

uint64_t countOf(const PairCounts& counts, uint32_t i, uint32_t j) {
  for (const PairCount& c : counts)
    if (c.i == i && c.j == j) return c.count;
  return 0;
}

void expectTwinAgrees(const InputScene& input, const std::vector<Direction>& directions, const CountRun& run) {
  const Scene scene = buildScene(input);
  const PairCounts device = countPairs(scene, directions, run);
  const PairCounts twin = countPairsOnCpu(scene, makeIds(scene, run.by, run.two_sided), directions, run.lattice.resolution);
  EXPECT_EQ(device, twin) << input.file << ", resolution " << run.lattice.resolution;
  EXPECT_FALSE(twin.empty());
}

TEST(Peel, CountsAreThoseOfTheCpuTwin) {
  const auto directions = sampleDirections(Sampler::iid, 12, 7, 0);
  for (int resolution : {1, 7, 33, 64}) {
    const CountRun one_sided{.lattice = {.resolution = resolution}}, two_sided{.lattice = {.resolution = resolution}, .two_sided = true};
    const CountRun by_surface{.lattice = {.resolution = resolution}, .by = By::surface};
    expectTwinAgrees(ts::insideOfCube(), directions, one_sided);
    expectTwinAgrees(ts::cubeInCube(0.4), directions, by_surface);
    expectTwinAgrees(ts::roomWithTouchingBoxes(), directions, one_sided);
    expectTwinAgrees(ts::roomWithTouchingBoxes(), directions, two_sided);
    expectTwinAgrees(ts::triangleSoup(60, 0.5, 3), directions, one_sided);
    expectTwinAgrees(ts::triangleSoup(60, 0.5, 4), directions, two_sided);
  }
}

// Along the axes polygons are edge-on, depths tie and lattice points fall on edges.
TEST(Peel, CountsAreThoseOfTheCpuTwinAlongAxesAndEdges) {
  std::vector<Direction> directions;
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0})
      for (double offset : {0.0, 0.5}) {
        glm::dvec3 u(0), x(0);
        u[axis] = sign;
        x[(axis + 1) % 3] = 1;
        directions.push_back({x, glm::cross(u, x), u, {offset, offset}});
      }
  const glm::dvec3 u = glm::normalize(glm::dvec3(1, 1, 0)), x(0, 0, 1);
  directions.push_back({x, glm::cross(u, x), u, {0, 0}});
  for (int resolution : {8, 32}) {
    expectTwinAgrees(ts::roomWithTouchingBoxes(), directions, {.lattice = {.resolution = resolution}});
    expectTwinAgrees(ts::insideOfCube(), directions, {.lattice = {.resolution = resolution}});
    expectTwinAgrees(ts::stackOfSheets({0, 0, 0, 0.25, 0.25}), directions, {.lattice = {.resolution = resolution}});
  }
}

TEST(Peel, TwinComparisonFailsOnOneWrongCount) {
  const Scene scene = buildScene(ts::insideOfCube());
  const auto directions = sampleDirections(Sampler::iid, 3, 7, 0);
  PairCounts wrong = countPairs(scene, directions, {.lattice = {.resolution = 16}});
  ++wrong[2].count;
  EXPECT_NE(wrong, countPairsOnCpu(scene, makeIds(scene, By::polygon, false), directions, 16));
}

// Every line through a stack of 100 sheets at nearly one height meets all of them, whatever their distance, 0 included.
TEST(Peel, KeepsEveryLayerOfAStackOfSheets) {
  for (double gap : {1e-3, 1e-9, 0.0}) {
    std::vector<double> heights;
    for (int k = 0; k < 100; ++k) heights.push_back(gap * k);
    const Scene scene = buildScene(ts::stackOfSheets(heights));
    const Direction up{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.6}};
    const PairCounts counts = countPairs(scene, {up}, {.lattice = {.resolution = 16}});
    uint64_t facing = 0, through = 0;
    for (const PairCount& c : counts) {
      if (c.j < kEnvironment) facing += c.count;
      through += c.count * (c.j < kEnvironment ? 2 : 1);  // of 100 fronts each is met once by every line
    }
    uint64_t lines = 0;
    for (int y = -10; y <= 10; ++y)
      for (int x = -10; x <= 10; ++x) {
        const glm::dvec2 at = (glm::dvec2(x, y) - up.offset) / 8.0 * scene.scale;
        lines += std::max(std::abs(at.x), std::abs(at.y)) < 0.5;
      }
    EXPECT_EQ(through, 100 * lines) << "gap " << gap;
    // At no gap all that face up come first, then all that face down: the last of the former and the first of the latter face each other.
    if (gap != 1e-9) {
      EXPECT_EQ(facing, (gap == 0 ? 1 : 50) * lines);
    }
  }
}

// Lattice points on shared edges belong to exactly one side: tiles of a square are covered as the square is.
TEST(Peel, SharedEdgeCoveredOnce) {
  InputScene tiles{"tiles", {}, {}};
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) ts::addFace(tiles, "tiles", ts::parallelogram({x, y, 0}, {1, 0, 0}, {0, 1, 0}));
  InputScene whole{"whole", {}, {}};
  ts::addFace(whole, "whole", ts::parallelogram({0, 0, 0}, {8, 0, 0}, {0, 8, 0}));
  std::vector<Direction> directions = sampleDirections(Sampler::iid, 40, 5, 0);
  // Here the lattice lies on the tiles' edges and corners: the window is 8 sqrt(2) wide, so 1 / h = 8 / sqrt(2) makes a tile one step.
  directions.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0}});
  for (int resolution : {12, 64}) {
    const PairCounts a = countPairs(buildScene(tiles), directions, {.lattice = {.resolution = resolution}, .by = By::surface});
    const PairCounts b = countPairs(buildScene(whole), directions, {.lattice = {.resolution = resolution}, .by = By::surface});
    EXPECT_EQ(a, b);
    EXPECT_EQ(countOf(a, 0, kLeak), 0u);
  }
}

// Two blocks that touch face each other over the contact and nowhere leak.
TEST(Peel, TouchingSolidsDoNotLeak) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const PairCounts counts = countPairs(scene, sampleDirections(Sampler::fibonacci, 500, 9, 0), {.lattice = {.resolution = 64}, .by = By::surface});
  for (const PairCount& c : counts) {
    EXPECT_NE(c.j, kLeak) << scene.surfaces[c.i].name << " leaks " << c.count;
    EXPECT_NE(c.j, kEnvironment) << scene.surfaces[c.i].name << " sees the environment " << c.count;
  }
}

TEST(Peel, BackOfAPolygonIsLeak) {
  // Both face up: the lower one looks at the back of the upper one, which sees the environment.
  InputScene input{"flipped", {}, {}};
  ts::addFace(input, "lower", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "upper", ts::parallelogram({0, 0, 1}, {1, 0, 0}, {0, 1, 0}));
  const Direction up{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.6}};
  const PairCounts counts = countPairs(buildScene(input), {up}, {.lattice = {.resolution = 16}});
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(countOf(counts, 0, kLeak), countOf(counts, 1, kEnvironment));
  const PairCounts two_sided = countPairs(buildScene(input), {up}, {.lattice = {.resolution = 16}, .two_sided = true});
  EXPECT_EQ(countOf(two_sided, 0, 1), countOf(counts, 0, kLeak));
  EXPECT_EQ(countOf(two_sided, 0, kEnvironment), countOf(counts, 0, kLeak));
  EXPECT_EQ(countOf(two_sided, 0, kLeak), 0u);
}

TEST(Peel, BatchSizeNeverChangesTheCounts) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const auto directions = sampleDirections(Sampler::fibonacci, 50, 11, 0);
  const PairCounts expected = countPairs(scene, directions, {.lattice = {.resolution = 40}});
  for (uint32_t batch : {1u, 3u, 50u, 64u})
    EXPECT_EQ(countPairs(scene, directions, {.lattice = {.resolution = 40, .batch_directions = batch}}), expected) << "batch " << batch;
}

// Lists that are too small for a batch grow, whatever they started with, and nothing is counted twice.
TEST(Peel, TileListsGrowAndLoseNothing) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const auto directions = sampleDirections(Sampler::fibonacci, 30, 11, 0);
  const PairCounts expected = countPairs(scene, directions, {.lattice = {.resolution = 40}});
  for (uint32_t capacity : {4u, 100u, 2000u})
    EXPECT_EQ(countPairs(scene, directions, {.lattice = {.resolution = 40, .list_capacity = capacity}}), expected) << "capacity " << capacity;
}

// Software devices end loops after 65,535 iterations: a polygon over tens of thousands of tiles is binned in parts.
TEST(Peel, LargePolygonsOnFineLattices) {
  const Scene scene = buildScene(ts::insideOfCube());
  const auto directions = sampleDirections(Sampler::iid, 1, 4, 0);
  for (const PairCount& c : countPairs(scene, directions, {.lattice = {.resolution = 2000}})) EXPECT_LT(c.j, kEnvironment) << c.i << ": " << c.count;
}

// Thousands of layers over one tile are counted right or refused, never cut short.
TEST(Peel, ThousandsOfLayersAreRightOrRefused) {
  std::vector<double> heights;
  for (int k = 0; k < 3000; ++k) heights.push_back(1e-3 * k);
  const Scene scene = buildScene(ts::stackOfSheets(heights));
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::vector<Direction> up = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.6}}};
  try {
    EXPECT_EQ(makeComputeEngine(testDevice(), scene, ids, {.resolution = 4})->count(up), countPairsOnCpu(scene, ids, up, 4));
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("--engine graphics"), std::string::npos) << error.what();
  }
}

TEST(Peel, RefusesCountersBeyondTheBudget) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  try {
    countPairs(scene, {}, {.lattice = {.resolution = 8, .counter_budget_bytes = 1000}});
    FAIL() << "accepted";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("--by surface"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace viewpeel
