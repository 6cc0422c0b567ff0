// Buffers, tables and batches of depth peeling grow where they are too small. Neither tuning nor memory changes a
// count.
#include <cstdlib>

#include <gtest/gtest.h>

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

uint64_t totalBlocked(const PairCounts& counts) {
  uint64_t total = 0;
  for (const PairCount& c : counts) total += c.blocked;
  return total;
}

// No count depends on the size of tiles, on the layers kept in a round, or on how contributions are gathered, sorted,
// resumed or stored.
TEST(Peel, NoTuningChangesTheCounts) {
  const auto directions = sampleDirections(Sampler::fibonacci, 9, 11, 0);
  for (const auto& [input, two_sided] :
       {std::pair(ts::roomWithTouchingBoxes(), false), std::pair(ts::triangleSoup(300, 0.6, 5), true)}) {
    const Scene scene = buildScene(input);
    {
      const Ids ids = makeIds(scene, By::polygon, two_sided);
      const PairCounts expected = countPairsOnCpu(scene, ids, directions, 40, true);
      EXPECT_GT(totalBlocked(expected), 1000u);
      std::vector<LatticeOptions> all(1, {.resolution = 40});
      for (uint32_t n : {1u, 2u, 4u, 8u}) {
        all.push_back({.resolution = 40, .tile_width = n});
        all.push_back({.resolution = 40, .tile_rows = n});
        all.push_back({.resolution = 40, .layers_kept = n});
        all.push_back({.resolution = 40, .tile_rows = n, .layers_kept = n + 1, .sort = true});
        all.push_back({.resolution = 40, .most_blocks = n});
        all.push_back({.resolution = 40, .batch_directions = n});
        all.push_back({.resolution = 40, .list_capacity = n});
        all.push_back({.resolution = 40, .counter_budget_bytes = 1, .table_capacity = n});
      }
      for (uint32_t n : {0u, 1u, 6u, 64u}) all.push_back({.resolution = 40, .few_points = n});
      for (uint32_t n : {1u, 2u, 4u, 8u}) {
        all.push_back({.resolution = 40, .tile_width = n, .few_points = 64});
        all.push_back({.resolution = 40, .tile_rows = n, .layers_kept = n, .few_points = 30, .fragment_capacity = n});
        all.push_back({.resolution = 40, .tile_rows = n, .layers_kept = n + 1, .few_points = 6, .sort = true});
        all.push_back({.resolution = 40, .few_points = 20, .most_blocks = n});
        all.push_back({.resolution = 40, .batch_directions = n, .few_points = 64});
      }
      all.push_back({.resolution = 40, .few_points = 64, .memory_budget_bytes = 1});
      all.push_back({.resolution = 40, .aggregate = false});
      all.push_back({.resolution = 40, .memory_budget_bytes = 1});
      for (size_t k = 0; k < all.size(); ++k) {
        EXPECT_EQ(countWith(scene, ids, directions, all[k]), withoutBlocked(expected))
            << input.file << ", two-sided " << two_sided << ", options " << k;
        all[k].count_blocked = true;
        EXPECT_EQ(countWith(scene, ids, directions, all[k]), expected)
            << input.file << ", two-sided " << two_sided << ", options " << k << ", blocked";
      }
    }
  }
}

// A buffer that is too small grows, and the batch is repeated. Every kind of growth happens in this test.
TEST(Peel, BuffersGrowAndRepeat) {
  const Scene scene = buildScene(ts::triangleSoup(300, 0.6, 5));
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 40, 11, 0);
  for (bool blocked : {false, true}) {
    const auto options = [&](LatticeOptions rest) {
      rest.resolution = 40;
      rest.count_blocked = blocked;
      return rest;
    };
    Work work;
    const PairCounts expected = countWith(scene, ids, directions, options({.fragment_capacity = 64}), &work);
    EXPECT_EQ(work.repeats, 0u);
    EXPECT_EQ(countWith(scene, ids, directions, options({.list_capacity = 10}), &work), expected);
    EXPECT_GT(work.repeats, 0u) << "tile lists";
    EXPECT_EQ(countWith(scene, ids, directions, options({.few_points = 64, .fragment_capacity = 1}), &work), expected);
    EXPECT_EQ(work.repeats > 0, !blocked) << "fragments, which blocked pairs do without";
    EXPECT_EQ(countWith(scene, ids, directions, options({.counter_budget_bytes = 1, .table_capacity = 1}), &work),
              expected);
    EXPECT_GT(work.repeats, 0u) << "hash table";
    EXPECT_EQ(countWith(scene, ids, directions, options({.most_blocks = 1}), &work), expected);
    EXPECT_GT(work.resumed, 0u) << "layers";
  }
}

// Directions have weights, and only requested pairs are counted.
TEST(Peel, CountsWhatWasRequested) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  auto directions = sampleDirections(Sampler::fibonacci, 20, 3, 0);
  for (size_t k = 0; k < directions.size(); ++k) directions[k].weight = static_cast<uint32_t>(1 + 3 * k);
  const auto& surfaces = scene.surfaces;
  ASSERT_GE(surfaces.size(), 3u);
  const std::string a = surfaces[0].name, b = surfaces[1].name, c = surfaces[2].name;
  const Question everything, row{.from = {b}}, rows{.from = {b, c}}, pair{.pair = {a, b}}, with_itself{.pair = {a, a}},
      blocker{.blockers = {c}}, row_and_blocker{.from = {a}, .blockers = {c}};
  for (const Question& question : {everything, row, rows, pair, with_itself, blocker, row_and_blocker})
    for (By by : {By::polygon, By::surface})
      for (uint32_t n : {1u, 4u}) {
        Ids ids = makeIds(scene, by, false);
        restrictToQuestion(question, scene, ids);
        const PairCounts expected = countPairsOnCpu(scene, ids, directions, 40, true);
        EXPECT_EQ(countWith(scene, ids, directions, {.resolution = 40, .layers_kept = n}), withoutBlocked(expected));
        EXPECT_EQ(countWith(scene, ids, directions, {.resolution = 40, .count_blocked = true, .layers_kept = n}),
                  expected);
        const PairCounts intervals = countIntervalsOnCpu(scene, ids, directions, 40, true);
        EXPECT_EQ(
            countWith(scene, ids, directions, {.resolution = 40, .sampling = Sampling::scanline, .layers_kept = n}),
            withoutBlocked(intervals));
        EXPECT_EQ(
            countWith(scene, ids, directions,
                      {.resolution = 40, .sampling = Sampling::scanline, .count_blocked = true, .layers_kept = n}),
            intervals);
      }
}

// The hash table of counters is emptied when it is half full, in the middle of a run, so that no batch is repeated.
TEST(Peel, HashTableIsEmptiedWhenHalfFull) {
  const Scene scene = buildScene(ts::triangleSoup(300, 0.6, 5));
  const Ids ids = makeIds(scene, By::polygon, true);
  const auto directions = sampleDirections(Sampler::fibonacci, 300, 11, 0);
  Work work;
  const PairCounts expected = countPairsOnCpu(scene, ids, directions, 24, true);
  EXPECT_EQ(
      countWith(
          scene, ids, directions,
          {.resolution = 24, .batch_directions = 2, .counter_budget_bytes = 1, .few_points = 0, .table_capacity = 4096},
          &work),
      withoutBlocked(expected));
  EXPECT_EQ(work.repeats, 0u);
  EXPECT_EQ(countWith(scene, ids, directions,
                      {.resolution = 24,
                       .count_blocked = true,
                       .batch_directions = 2,
                       .counter_budget_bytes = 1,
                       .table_capacity = 16384},
                      &work),
            expected);
  EXPECT_EQ(work.repeats, 0u);
}

// Batches shrink to the memory that there is. Where not even one direction fits, the error states the size that it
// needs.
TEST(Peel, MemoryIsPlanned) {
  const Scene scene = buildScene(ts::triangleSoup(300, 0.6, 5));
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 9, 11, 0);
  const auto roomy = makeComputeEngine(testDevice(), scene, ids, {.resolution = 40}),
             tight = makeComputeEngine(testDevice(), scene, ids, {.resolution = 40, .memory_budget_bytes = 1});
  EXPECT_NE(roomy->describePlan().find("2 x "), std::string::npos) << roomy->describePlan();
  EXPECT_NE(tight->describePlan().find("1 x 1 directions"), std::string::npos) << tight->describePlan();
  EXPECT_EQ(tight->count(directions), roomy->count(directions));
  try {
    makeComputeEngine(testDevice(), scene, ids, {.resolution = 40, .available_bytes = 1 << 20});
    FAIL() << "accepted";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("300 polygons at resolution 40 need"), std::string::npos) << error.what();
  }
}

// Two batches are in flight. An error of one of them waits until the other has ended.
TEST(Peel, ErrorsWaitForTheOtherBatch) {
  std::vector<double> heights;
  for (int k = 0; k < 1100; ++k) heights.push_back(0.004 * k);
  const Scene scene = buildScene(ts::stackOfSheets(heights));
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 12, 1, 0);
  const auto engine = makeComputeEngine(testDevice(), scene, ids,
                                        {.resolution = 4, .sampling = Sampling::scanline, .batch_directions = 1});
  try {
    engine->count(directions);
    FAIL() << "accepted";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("larger --resolution"), std::string::npos) << error.what();
  }
}

// A callback may end a call between two batches by an exception. The next call starts from nothing, even if short lists
// make the other batch want a repetition.
TEST(Peel, EnginesCountAgainAfterACallbackThrew) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 60, 1, 0);
  const PairCounts expected = makeComputeEngine(testDevice(), scene, ids, {})->count(directions);
  for (const EngineKind kind : {EngineKind::compute, EngineKind::graphics})
    for (int batches : {1, 2, 5}) {
      int left = batches;
      const auto engine =
          enginesOf(kind)(scene, ids, {.batch_directions = 7, .list_capacity = 1, .on_batch = [&](uint64_t) {
                                         if (--left == 0) throw Interrupted{};
                                       }});
      EXPECT_THROW(engine->count(directions), Interrupted);
      EXPECT_EQ(engine->count(directions), expected) << "after " << batches << " batches";
    }
}

TEST(Peel, GraphicsEngineRefusesCountersBeyondTheBudget) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  try {
    makeGraphicsEngine(testDevice(), scene, makeIds(scene, By::polygon, false),
                       {.resolution = 8, .counter_budget_bytes = 1000});
    FAIL() << "accepted";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("--by surface"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace viewpeel
