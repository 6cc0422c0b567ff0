// These tests count the work of a run, and show that a scene costs no more than it needs.
#include <gtest/gtest.h>

#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

Work workOf(const InputScene& input, const std::vector<Direction>& directions, const LatticeOptions& lattice,
            const Question& question = {}) {
  const Scene scene = buildScene(input);
  Ids ids = makeIds(scene, By::polygon, false);
  restrictToQuestion(question, scene, ids);
  LatticeOptions options = lattice;
  options.measure_work = true;
  const auto engine = makeComputeEngine(testDevice(), scene, ids, options);
  engine->count(directions);
  return *engine->work();
}

const std::vector<Direction> kUp = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.6}}};

TEST(Work, OneRoundWhereNoLineMeetsMoreThanIsKept) {
  const auto directions = sampleDirections(Sampler::fibonacci, 50, 3, 0);
  for (uint32_t layers : {2u, 4u}) {
    const Work work = workOf(ts::insideOfCube(), directions, {.resolution = 64, .layers_kept = layers});
    EXPECT_EQ(work.rounds, work.active_tiles) << layers << " layers kept";
    EXPECT_EQ(work.fragments, 2 * work.gaps);  // every line meets two walls that face each other
    EXPECT_EQ(work.directions, 50u);
    EXPECT_GT(work.memory_bytes, 0u);
    EXPECT_EQ(work.pass_seconds.size(), 9u);
  }
}

TEST(Work, EmptyTilesAreNotPeeled) {
  InputScene corners{"two far squares", {}, {}};
  ts::addFace(corners, "a", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(corners, "b", ts::parallelogram({40, 40, 5}, {0, 1, 0}, {1, 0, 0}));
  const Work work = workOf(corners, kUp, {.resolution = 256});
  EXPECT_GE(work.active_tiles, 2u);
  EXPECT_LE(work.active_tiles, 8u);  // a square is four spacings wide and lies on two tiles or fewer either way
  EXPECT_GT(work.tiles, 1000u);
}

TEST(Work, EdgeOnPolygonsEnterNoTile) {
  const auto along = kUp;
  const Work floor_and_wall = workOf(ts::perpendicularSquares(), along, {.resolution = 64});
  const Work cube = workOf(ts::insideOfCube(), along, {.resolution = 64});
  // Four faces of a cube are edge-on along an axis. Two layers are at every point, and all entries are of these two
  // faces.
  EXPECT_EQ(cube.list_entries, 2 * cube.active_tiles);
  EXPECT_EQ(floor_and_wall.list_entries, floor_and_wall.active_tiles);
}

// A question about one box or one pair restricts the tiles to the places where its polygons are. The factors of 2 and 4
// are coarse checks and not derived.
TEST(Work, OnlyTheWindowOfWhatWasRequested) {
  const auto directions = sampleDirections(Sampler::fibonacci, 30, 3, 0);
  const InputScene room = ts::roomWithTouchingBoxes();
  const LatticeOptions lattice{.resolution = 128};
  const Work all = workOf(room, directions, lattice);
  const Work row = workOf(room, directions, lattice, {.from = {"upper box"}});
  const Work pair = workOf(room, directions, lattice, {.pair = {"upper box", "floor[16]"}});
  EXPECT_LT(row.active_tiles, all.active_tiles / 2);
  EXPECT_LT(pair.active_tiles, row.active_tiles);  // a tile needs both polygons
  EXPECT_LT(row.gaps, all.gaps / 4);
  EXPECT_LT(pair.gaps, row.gaps / 4);
  EXPECT_GT(pair.gaps, 0u);
}

TEST(Work, NothingIsPeeledBehindTheLastPolygonThatMatters) {
  std::vector<double> heights;
  for (int k = 0; k < 100; ++k) heights.push_back(0.01 * k);
  const InputScene sheets = ts::stackOfSheets(heights);
  const Scene scene = buildScene(sheets);
  const std::string first = faceName(scene, 0), second = faceName(scene, 1), last = faceName(scene, 99);
  const LatticeOptions lattice{.resolution = 16, .layers_kept = 4};
  const Work all = workOf(sheets, kUp, lattice);
  EXPECT_GE(all.rounds, 25 * all.active_tiles);
  const Work front = workOf(sheets, kUp, lattice, {.from = {first}});
  EXPECT_LE(front.rounds, 2 * front.active_tiles);
  const Work pair = workOf(sheets, kUp, lattice, {.pair = {first, second}});
  EXPECT_EQ(pair.rounds, pair.active_tiles);
  const Work back = workOf(sheets, kUp, lattice, {.from = {last}});
  EXPECT_GE(back.rounds, 25 * back.active_tiles);
}

// Work is counted once, even if a batch was repeated or lists were sorted.
TEST(Work, IsCountedOnce) {
  const InputScene soup = ts::triangleSoup(300, 0.6, 5);
  const auto directions = sampleDirections(Sampler::fibonacci, 20, 3, 0);
  const Work plain = workOf(soup, directions, {.resolution = 40, .tile_rows = 8, .layers_kept = 4});
  const Work sorted = workOf(soup, directions, {.resolution = 40, .tile_rows = 8, .layers_kept = 4, .sort = true});
  const Work repeated =
      workOf(soup, directions,
             {.resolution = 40, .counter_budget_bytes = 1, .tile_rows = 8, .layers_kept = 4, .table_capacity = 1});
  const Work resumed = workOf(soup, directions, {.resolution = 40, .tile_rows = 8, .layers_kept = 4, .most_blocks = 5});
  EXPECT_GT(repeated.repeats, 0u);
  EXPECT_GT(resumed.resumed, 0u);
  for (const Work& work : {sorted, repeated, resumed}) {
    EXPECT_EQ(work.directions, 20u);
    EXPECT_EQ(work.fragments, plain.fragments);
    EXPECT_EQ(work.gaps, plain.gaps);
    EXPECT_EQ(work.active_tiles, plain.active_tiles);
  }
}

// Small polygons are tested only for the lattice points in their boxes, and polygons between lattice points for none.
// Large polygons are tested as before.
TEST(Work, SmallPolygonsAreNotTestedAllOverTheirTiles) {
  const auto directions = sampleDirections(Sampler::fibonacci, 12, 3, 0);
  const InputScene soup = ts::triangleSoup(4000, 0.05, 5), room = ts::roomWithTouchingBoxes();
  const Work lists = workOf(soup, directions, {.resolution = 40, .tile_rows = 8, .layers_kept = 4, .few_points = 0});
  const Work fragments = workOf(soup, directions, {.resolution = 40, .tile_rows = 8, .layers_kept = 4});
  EXPECT_EQ(fragments.list_entries, 0u);
  EXPECT_LT(fragments.tests, lists.tests / 10);
  EXPECT_GT(lists.fragments, 1000u);
  EXPECT_EQ(fragments.fragments, lists.fragments);
  EXPECT_EQ(fragments.gaps, lists.gaps);
  const auto entries = [&](const LatticeOptions& options) { return workOf(room, directions, options).list_entries; };
  EXPECT_EQ(entries({.resolution = 256}), entries({.resolution = 256, .few_points = 0}))
      << "large polygons are left to lists";
}

// Separate passes count blocked pairs, and do not change the work of other passes.
TEST(Work, BlockedPairsAreCountedApart) {
  const auto directions = sampleDirections(Sampler::fibonacci, 20, 3, 0);
  const Work without = workOf(ts::roomWithTouchingBoxes(), directions, {.resolution = 40, .few_points = 0});
  const Work with = workOf(ts::roomWithTouchingBoxes(), directions, {.resolution = 40, .count_blocked = true});
  EXPECT_EQ(without.pass_seconds.size(), 9u);
  EXPECT_EQ(with.pass_seconds.size(), 11u);
  EXPECT_EQ(with.tests, without.tests);
  EXPECT_EQ(with.gaps, without.gaps);
  EXPECT_GT(with.memory_bytes, without.memory_bytes);
}

TEST(Work, LongListsAndManyLayersChangeTheTuningAfterATrial) {
  const Scene scene = buildScene(ts::triangleSoup(4000, 0.3, 5));
  const Ids ids = makeIds(scene, By::polygon, true);
  const auto directions = sampleDirections(Sampler::fibonacci, 12, 3, 0);
  const auto tuned = makeComputeEngine(testDevice(), scene, ids, {.resolution = 48});
  const auto fixed = makeComputeEngine(testDevice(), scene, ids, {.resolution = 48, .tile_rows = 8, .layers_kept = 4});
  const std::string before = tuned->describePlan();
  EXPECT_EQ(tuned->count(directions), fixed->count(directions));
  EXPECT_NE(tuned->describePlan(), before);
  EXPECT_NE(tuned->describePlan().find("8 layers a round"), std::string::npos) << tuned->describePlan();
}

}  // namespace
}  // namespace viewpeel
