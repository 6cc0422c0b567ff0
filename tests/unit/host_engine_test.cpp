// The host engine has the counts of the CPU twin to the bit, for any number of threads and both kinds of counters.
// Other tests compare it with the other engines.
#include <gtest/gtest.h>

#include "tests/support/test_device.h"
#include "tests/support/cpu_twin.h"
#include "directions/sampler.h"
#include "engines/host_engine.h"
#include <viewpeel/error.h>
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

PairCounts countWith(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions,
                     const LatticeOptions& options) {
  return makeHostEngine(scene, ids, options)->count(directions);
}

std::vector<InputScene> scenes() {
  return {ts::insideOfCube(), ts::cubeInCube(0.4), ts::roomWithTouchingBoxes(), ts::triangleSoup(60, 0.5, 3),
          ts::triangleSoup(200, 0.05, 4)};
}

TEST(HostEngine, CountsEqualTheCpuTwin) {
  std::vector<Direction> directions = sampleDirections(Sampler::iid, 6, 7, 0);
  for (const Direction& direction : ts::alongAxesAndEdges()) directions.push_back(direction);
  directions.back().weight = 3;
  for (const InputScene& input : scenes()) {
    const Scene scene = buildScene(input);
    for (const bool two_sided : {false, true})
      for (const By by : {By::polygon, By::surface}) {
        const Ids ids = makeIds(scene, by, two_sided);
        for (const int resolution : {1, 7, 40}) {
          const PairCounts points = countPairsOnCpu(scene, ids, directions, resolution, true),
                           intervals = countIntervalsOnCpu(scene, ids, directions, resolution, true);
          EXPECT_EQ(countWith(scene, ids, directions, {.resolution = resolution, .count_blocked = true}), points)
              << input.file << " " << resolution;
          EXPECT_EQ(countWith(scene, ids, directions, {.resolution = resolution}), withoutBlocked(points))
              << input.file << " " << resolution;
          EXPECT_EQ(countWith(scene, ids, directions,
                              {.resolution = resolution, .sampling = Sampling::scanline, .count_blocked = true}),
                    intervals)
              << input.file << " " << resolution;
          EXPECT_EQ(countWith(scene, ids, directions, {.resolution = resolution, .sampling = Sampling::scanline}),
                    withoutBlocked(intervals))
              << input.file << " " << resolution;
          EXPECT_FALSE(intervals.empty());
        }
      }
  }
}

TEST(HostEngine, RolesAndWindowsCountAsInTheTwin) {
  const auto directions = sampleDirections(Sampler::iid, 8, 7, 0);
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const std::string first = scene.surfaces.front().name, last = scene.surfaces.back().name;
  for (const Question& question :
       {Question{.from = {last}}, Question{.pair = {first, last}}, Question{.blockers = {first}}}) {
    Ids ids = makeIds(scene, By::surface, false);
    restrictToQuestion(question, scene, ids);
    for (const bool blocked : {false, true}) {
      const PairCounts expected = countPairsOnCpu(scene, ids, directions, 33, true);
      EXPECT_EQ(countWith(scene, ids, directions, {.resolution = 33, .count_blocked = blocked}),
                blocked ? expected : withoutBlocked(expected));
      const PairCounts intervals = countIntervalsOnCpu(scene, ids, directions, 33, true);
      EXPECT_EQ(countWith(scene, ids, directions,
                          {.resolution = 33, .sampling = Sampling::scanline, .count_blocked = blocked}),
                blocked ? intervals : withoutBlocked(intervals));
    }
  }
  // A window lies around the last surface, the only one that emits. Lines outside the window do not count.
  Ids ids = makeIds(scene, By::polygon, false);
  ids.roles.assign(scene.polygons.size(), kReceives);
  Window window{glm::dvec3(0), 0};
  std::vector<glm::dvec3> corners;
  for (size_t k = scene.polygons.size() - 2; k < scene.polygons.size(); ++k) {
    ids.roles[k] = kEmits | kReceives;
    for (uint32_t c = 0; c < scene.polygons[k].corner_count; ++c)
      corners.push_back(scene.corners[scene.polygons[k].first_corner + c]);
  }
  for (const glm::dvec3& corner : corners) window.centre += corner / double(corners.size());
  for (const glm::dvec3& corner : corners)
    window.radius = std::max(window.radius, glm::distance(corner, window.centre) + 1e-9);
  ASSERT_LT(window.radius, 0.7);
  for (const int resolution : {33, 200}) {
    const PairCounts expected = countPairsOnCpu(scene, ids, directions, resolution, true, Fault::none, window);
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(countWith(scene, ids, directions, {.resolution = resolution, .window = window, .count_blocked = true}),
              expected);
  }
}

// Threads take directions as they become free. Counters are a dense array, or a hash table that starts too small for
// all pairs and grows. Neither changes a count.
TEST(HostEngine, NeitherThreadsNorCountersChangeTheCounts) {
  const Scene scene = buildScene(ts::triangleSoup(1000, 0.3, 5));
  const Ids ids = makeIds(scene, By::polygon, true);
  const auto directions = sampleDirections(Sampler::fibonacci, 300, 11, 0);
  for (const Sampling sampling : {Sampling::lattice, Sampling::scanline})
    for (const bool blocked : {false, true}) {
      const LatticeOptions one{.resolution = 20, .sampling = sampling, .count_blocked = blocked, .thread_count = 1};
      const PairCounts expected = countWith(scene, ids, directions, one);
      EXPECT_GT(expected.size(), size_t(1) << 15) << "too few pairs for the table to grow from 2^16 places";
      for (const uint32_t threads : {1u, 2u, 7u})
        for (const uint64_t budget : {uint64_t(0), uint64_t(1)}) {
          LatticeOptions options = one;
          options.thread_count = threads;
          options.counter_budget_bytes = budget;
          const auto engine = makeHostEngine(scene, ids, options);
          EXPECT_EQ(engine->count(directions), expected) << threads << " threads, budget " << budget;
          EXPECT_EQ(engine->count(directions), expected) << "again";
        }
    }
}

TEST(HostEngine, BlocksAreCountedApart) {
  const Scene scene = buildScene(ts::triangleSoup(60, 0.5, 3));
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::iid, 60, 7, 0);
  for (const uint64_t budget : {uint64_t(0), uint64_t(1)}) {
    const auto engine = makeHostEngine(
        scene, ids,
        {.resolution = 9, .sampling = Sampling::scanline, .counter_budget_bytes = budget, .thread_count = 3});
    const auto blocks = engine->countBlocks(directions, 3);
    ASSERT_EQ(blocks.size(), 20u);
    for (size_t k = 0; k < blocks.size(); ++k)
      EXPECT_EQ(blocks[k], engine->count(std::span(directions).subspan(3 * k, 3))) << k;
  }
}

// An exception from on_batch ends the call. The next call counts as if the first one had not been.
TEST(HostEngine, AStoppedCallLeavesNothingBehind) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  // The other thread must not finish alone while the first one waits for a processor, so there are many directions.
  constexpr uint32_t kDirections = 20'000;
  const auto directions = sampleDirections(Sampler::fibonacci, kDirections, 11, 0);
  for (const uint64_t budget : {uint64_t(0), uint64_t(1)}) {
    bool stops = true;
    uint64_t reported = 0;
    const auto engine = makeHostEngine(
        scene, ids,
        {.resolution = 16, .counter_budget_bytes = budget, .thread_count = 2, .on_batch = [&](uint64_t done) {
           reported = done;
           if (stops) throw Error(ErrorCode::limit, "enough");
         }});
    EXPECT_THROW(engine->count(directions), Error);
    EXPECT_LT(reported, kDirections);
    stops = false;
    EXPECT_EQ(engine->count(directions), countWith(scene, ids, directions, {.resolution = 16}));
    EXPECT_EQ(reported, kDirections);
  }
}

TEST(HostEngine, RefusesWhatDoesNotFit) {
  const Scene scene = buildScene(ts::triangleSoup(1000, 0.3, 5));
  const Ids ids = makeIds(scene, By::polygon, true);
  EXPECT_THROW(makeHostEngine(scene, ids, {.available_bytes = 100'000}), Error);
  const auto engine = makeHostEngine(scene, ids, {.counter_budget_bytes = 1, .available_bytes = 5'000'000});
  EXPECT_THROW(engine->count(sampleDirections(Sampler::fibonacci, 2000, 11, 0)), Error) << "a table of all pairs";
  EXPECT_THROW(makeHostEngine(scene, ids, {.resolution = 0}), Error);
}

}  // namespace
}  // namespace viewpeel
