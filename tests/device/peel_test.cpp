// Depth peeling has the counts of the CPU twin to the bit, and loses no layer.
#include <cstdlib>

#include <gtest/gtest.h>

#include "scenes/alike_scenes.h"
#include "scenes/coincident_scenes.h"
#include "tests/support/cpu_twin.h"
#include "engines/compute_engine.h"
#include "engines/host_engine.h"
#include "sums/pair_count.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"
#include "tests/support/count_with.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

uint64_t countOf(const PairCounts& counts, uint32_t i, uint32_t j) {
  for (const PairCount& c : counts)
    if (c.i == i && c.j == j) return c.count;
  return 0;
}

void expectTwinAgrees(const InputScene& input, const std::vector<Direction>& directions, CountRun run) {
  const Scene scene = buildScene(input);
  const PairCounts twin =
      countPairsOnCpu(scene, makeIds(scene, run.by, run.two_sided), directions, run.lattice.resolution, true);
  EXPECT_EQ(countPairs(scene, directions, run), withoutBlocked(twin))
      << input.file << ", resolution " << run.lattice.resolution;
  run.lattice.count_blocked = true;
  EXPECT_EQ(countPairs(scene, directions, run), twin)
      << input.file << ", resolution " << run.lattice.resolution << ", blocked";
  EXPECT_FALSE(twin.empty());
}

TEST(Peel, CountsEqualTheCpuTwin) {
  const auto directions = sampleDirections(Sampler::iid, 12, 7, 0);
  for (int resolution : {1, 7, 33, 64}) {
    const CountRun one_sided{.lattice = {.resolution = resolution}},
        two_sided{.lattice = {.resolution = resolution}, .two_sided = true};
    const CountRun by_surface{.lattice = {.resolution = resolution}, .by = By::surface};
    expectTwinAgrees(ts::insideOfCube(), directions, one_sided);
    expectTwinAgrees(ts::cubeInCube(0.4), directions, by_surface);
    expectTwinAgrees(ts::roomWithTouchingBoxes(), directions, one_sided);
    expectTwinAgrees(ts::roomWithTouchingBoxes(), directions, two_sided);
    expectTwinAgrees(ts::triangleSoup(60, 0.5, 3), directions, one_sided);
    expectTwinAgrees(ts::triangleSoup(60, 0.5, 4), directions, two_sided);
  }
}

// Blocks of directions have counters of their own on the device, and may be more than fit at once. With a hash table
// they are counted one after another.
TEST(Peel, BlocksAreCountedApart) {
  const Scene scene = buildScene(ts::triangleSoup(60, 0.5, 3));
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::iid, 3 * 1030, 7, 0);
  for (const bool blocked : {false, true})
    for (const Sampling sampling : {Sampling::lattice, Sampling::scanline})
      for (const uint64_t budget : {uint64_t(0), uint64_t(1)}) {
        const LatticeOptions options{
            .resolution = 5, .sampling = sampling, .count_blocked = blocked, .counter_budget_bytes = budget};
        const auto engine = makeComputeEngine(testDevice(), scene, ids, options);
        const size_t block_count = budget ? 4 : 1030;
        const auto blocks = engine->countBlocks(std::span(directions).first(3 * block_count), 3);
        ASSERT_EQ(blocks.size(), block_count);
        PairCounts sum;
        for (size_t k = 0; k < block_count; ++k) {
          sum = addCounts(sum, blocks[k]);
          if (k % 103 > 1) continue;
          EXPECT_EQ(blocks[k], engine->count(std::span(directions).subspan(3 * k, 3))) << k;
        }
        EXPECT_EQ(sum, engine->count(std::span(directions).first(3 * block_count)));
        EXPECT_NE(blocks[0], blocks[1]);
      }
}

TEST(Peel, CountsEqualTheCpuTwinAlongAxesAndEdges) {
  const std::vector<Direction> directions = ts::alongAxesAndEdges();
  for (int resolution : {8, 32}) {
    expectTwinAgrees(ts::roomWithTouchingBoxes(), directions, {.lattice = {.resolution = resolution}});
    expectTwinAgrees(ts::insideOfCube(), directions, {.lattice = {.resolution = resolution}});
    expectTwinAgrees(ts::stackOfSheets({0, 0, 0, 0.25, 0.25}), directions, {.lattice = {.resolution = resolution}});
  }
}

// These scenes have sheets, contacts and stacks of both, and are also counted with scanlines.
TEST(Peel, CoincidentFacesEqualTheCpuTwin) {
  const auto directions = sampleDirections(Sampler::iid, 6, 11, 0);
  for (const ts::CoincidentScene& of : ts::coincidentScenes()) {
    SCOPED_TRACE(of.name);
    const Scene scene = buildScene(ts::roundedToSingle(ts::turnedAndMoved(of.make(0))));
    const Ids ids = makeIds(scene, By::polygon, false);
    const PairCounts counts = countPairs(scene, directions, {.lattice = {.resolution = 17, .count_blocked = true}});
    EXPECT_EQ(counts, countPairsOnCpu(scene, ids, directions, 17, true));
    const PairCounts twin = countIntervalsOnCpu(scene, ids, directions, 9, true);
    const LatticeOptions scanlines{.resolution = 9, .sampling = Sampling::scanline, .count_blocked = true};
    EXPECT_EQ(makeComputeEngine(testDevice(), scene, ids, scanlines)->count(directions), twin);
    EXPECT_EQ(makeHostEngine(scene, ids, scanlines)->count(directions), twin);
    // In a closed scene every line that leaves a front ends on a front.
    if (!of.is_closed) continue;
    for (const PairCount& pair : counts) EXPECT_LT(pair.j, kEnvironment) << pair.i;
  }
}

// Of faces that overlap and look the same way, the same one counts along lines of either sign.
// tests/unit/alike_test.cpp tests which one.
TEST(Peel, AlikeFacesEqualTheCpuTwin) {
  const auto directions = sampleDirections(Sampler::iid, 6, 11, 0);
  std::vector<Direction> other_way = directions;
  for (Direction& direction : other_way) direction = ts::reversed(direction);
  for (const ts::AlikeScene& of : ts::alikeScenes()) {
    SCOPED_TRACE(of.name);
    const Scene scene = buildScene(of.make(false));
    const Ids ids = makeIds(scene, By::polygon, false);
    const CountRun run{.lattice = {.resolution = 17, .count_blocked = true}};
    const PairCounts counts = countPairs(scene, directions, run);
    EXPECT_EQ(counts, countPairsOnCpu(scene, ids, directions, 17, true));
    EXPECT_EQ(counts, countPairs(scene, other_way, run));
    Scene by_index = scene;
    for (Polygon& polygon : by_index.polygons) polygon.tie_rank = kContactRank;
    EXPECT_NE(countPairs(by_index, directions, run), countPairs(by_index, other_way, run));
    const LatticeOptions scanlines{.resolution = 9, .sampling = Sampling::scanline, .count_blocked = true};
    for (const auto& along : {directions, other_way})
      EXPECT_EQ(makeComputeEngine(testDevice(), scene, ids, scanlines)->count(along),
                countIntervalsOnCpu(scene, ids, along, 9, true));
  }
}

TEST(Peel, TwinComparisonFailsOnOneWrongCount) {
  const Scene scene = buildScene(ts::insideOfCube());
  const auto directions = sampleDirections(Sampler::iid, 3, 7, 0);
  PairCounts wrong = countPairs(scene, directions, {.lattice = {.resolution = 16}});
  ++wrong[2].count;
  EXPECT_NE(wrong, countPairsOnCpu(scene, makeIds(scene, By::polygon, false), directions, 16));
}

// Every line through a stack of 100 sheets meets all of them, whatever their distance, also 0.
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
      through += c.count * (c.j < kEnvironment ? 2 : 1);  // every line meets each of 100 fronts once
    }
    uint64_t lines = 0;
    for (int y = -10; y <= 10; ++y)
      for (int x = -10; x <= 10; ++x) {
        const glm::dvec2 at = (glm::dvec2(x, y) - up.offset) / 8.0 * scene.scale;
        lines += std::max(std::abs(at.x), std::abs(at.y)) < 0.5;
      }
    EXPECT_EQ(through, 100 * lines) << "gap " << gap;
    if (gap > 1e-6) {
      EXPECT_EQ(facing, 50 * lines);
    } else {
      EXPECT_EQ(scene.warnings.size(), 1u);  // so many coincident faces have no order
    }
  }
}

// A lattice point on a shared edge belongs to exactly one side, so that the tiles of a square have the counts of the
// square.
TEST(Peel, SharedEdgeCoveredOnce) {
  InputScene tiles{"tiles", {}, {}};
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) ts::addFace(tiles, "tiles", ts::parallelogram({x, y, 0}, {1, 0, 0}, {0, 1, 0}));
  InputScene whole{"whole", {}, {}};
  ts::addFace(whole, "whole", ts::parallelogram({0, 0, 0}, {8, 0, 0}, {0, 8, 0}));
  std::vector<Direction> directions = sampleDirections(Sampler::iid, 40, 5, 0);
  // Along this direction lattice points lie on edges and corners of tiles. The scene's diameter is 8 sqrt(2), so 1 / h
  // = 8 / sqrt(2) makes a tile one spacing wide.
  directions.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0}});
  for (int resolution : {12, 64}) {
    const PairCounts a =
        countPairs(buildScene(tiles), directions, {.lattice = {.resolution = resolution}, .by = By::surface});
    const PairCounts b =
        countPairs(buildScene(whole), directions, {.lattice = {.resolution = resolution}, .by = By::surface});
    EXPECT_EQ(a, b);
    EXPECT_EQ(countOf(a, 0, kLeak), 0u);
  }
}

// Two boxes that touch face each other in the contact, and nothing leaks.
TEST(Peel, TouchingSolidsDoNotLeak) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const PairCounts counts = countPairs(scene, sampleDirections(Sampler::fibonacci, 500, 9, 0),
                                       {.lattice = {.resolution = 64}, .by = By::surface});
  for (const PairCount& c : counts) {
    EXPECT_NE(c.j, kLeak) << scene.surfaces[c.i].name << " leaks " << c.count;
    EXPECT_NE(c.j, kEnvironment) << scene.surfaces[c.i].name << " sees the environment " << c.count;
  }
}

TEST(Peel, BackOfAPolygonIsLeak) {
  // Both plates look up. The lower one sees the back of the upper one, which sees the environment.
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
    EXPECT_EQ(countPairs(scene, directions, {.lattice = {.resolution = 40, .batch_directions = batch}}), expected)
        << "batch " << batch;
}

// Lists that are too small for a batch grow, whatever their first size is, and no line counts twice.
TEST(Peel, TileListsGrowAndLoseNothing) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const auto directions = sampleDirections(Sampler::fibonacci, 30, 11, 0);
  const PairCounts expected = countPairs(scene, directions, {.lattice = {.resolution = 40}});
  for (uint32_t capacity : {4u, 100u, 2000u})
    EXPECT_EQ(countPairs(scene, directions, {.lattice = {.resolution = 40, .list_capacity = capacity}}), expected)
        << "capacity " << capacity;
}

// Software devices end loops after 65,535 turns. A polygon over tens of thousands of tiles is therefore binned in
// parts.
TEST(Peel, LargePolygonsOnFineLattices) {
  const Scene scene = buildScene(ts::insideOfCube());
  const auto directions = sampleDirections(Sampler::iid, 1, 4, 0);
  for (const PairCount& c : countPairs(scene, directions, {.lattice = {.resolution = 2000}}))
    EXPECT_LT(c.j, kEnvironment) << c.i << ": " << c.count;
}

constexpr uint32_t kFewBlocks = 1000;  // of polygons that an invocation goes through, as on software devices

// One invocation does not go through thousands of layers over a tile, so that further dispatches take the rest.
TEST(Peel, ThousandsOfLayersTakeMoreDispatches) {
  std::vector<double> heights;
  for (int k = 0; k < 3000; ++k) heights.push_back(1e-3 * k);
  const Scene scene = buildScene(ts::stackOfSheets(heights));
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::vector<Direction> up = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.6}}};
  const PairCounts expected = countPairsOnCpu(scene, ids, up, 4);
  EXPECT_EQ(makeHostEngine(scene, ids, {.resolution = 4})->count(up), expected);
  Work work;
  for (uint32_t few_points : {0u, 64u}) {  // with lists, and with fragments of lattice points
    LatticeOptions options{.resolution = 4, .few_points = few_points, .most_blocks = kFewBlocks};
    EXPECT_EQ(countWith(scene, ids, up, options, &work), expected);
    EXPECT_GT(work.resumed, 0u) << few_points;
    options.layers_kept = 8, options.sort = true;
    EXPECT_EQ(countWith(scene, ids, up, options, &work), expected);
  }
}

// 1,000 layers lie over one another, so that blocked pairs are many. A task of the pass that counts them, a Meeting of
// shaders/shared.h, has more layers than one invocation may go through. A tile has more tasks than a workgroup takes.
TEST(Peel, HundredsOfLayersMeet) {
  std::vector<double> heights;
  for (int k = 0; k < 1000; k += 2) heights.insert(heights.end(), 2, 1e-3 * k);  // two sheets at each height
  const Scene scene = buildScene(ts::stackOfSheets(heights));
  const std::vector<Direction> up = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.6}}};
  for (bool two_sided : {false, true}) {
    const Ids ids = makeIds(scene, By::polygon, two_sided);
    const PairCounts expected = countPairsOnCpu(scene, ids, up, 4, true);
    EXPECT_EQ(countWith(scene, ids, up, {.resolution = 4, .count_blocked = true}), expected);
    EXPECT_EQ(makeGraphicsEngine(testDevice(), scene, ids, {.resolution = 4, .count_blocked = true})->count(up),
              expected);
    EXPECT_EQ(makeHostEngine(scene, ids, {.resolution = 4, .count_blocked = true})->count(up), expected);
    const LatticeOptions scanlines{
        .resolution = 4, .sampling = Sampling::scanline, .count_blocked = true, .most_blocks = kFewBlocks};
    const PairCounts intervals = countIntervalsOnCpu(scene, ids, up, 4, true);
    Work work;
    EXPECT_EQ(countWith(scene, ids, up, scanlines, &work), intervals);
    EXPECT_EQ(makeHostEngine(scene, ids, scanlines)->count(up), intervals);
    EXPECT_GT(work.resumed, 0u);
  }
}

TEST(Peel, IntervalsEqualTheCpuTwin) {
  const auto directions = sampleDirections(Sampler::iid, 6, 7, 0);
  for (int resolution : {1, 7, 33, 64})
    for (const InputScene& input : {ts::insideOfCube(), ts::roomWithTouchingBoxes(), ts::triangleSoup(60, 0.5, 3)}) {
      const Scene scene = buildScene(input);
      for (bool two_sided : {false, true}) {
        const Ids ids = makeIds(scene, By::polygon, two_sided);
        const PairCounts expected = countIntervalsOnCpu(scene, ids, directions, resolution, true);
        EXPECT_FALSE(expected.empty());
        for (uint32_t n : {1u, 3u, 8u})
          for (bool blocked : {false, true})
            EXPECT_EQ(countWith(scene, ids, directions,
                                {.resolution = resolution,
                                 .sampling = Sampling::scanline,
                                 .count_blocked = blocked,
                                 .tile_rows = n,
                                 .layers_kept = n,
                                 .most_blocks = 2 * n}),
                      blocked ? expected : withoutBlocked(expected))
                << input.file << ", resolution " << resolution << ", two-sided " << two_sided << ", blocked "
                << blocked;
      }
    }
}

}  // namespace
}  // namespace viewpeel
