// Faces may overlap in one plane and look the same way. Then lines hit only one of them, and the same one from both
// sides. The counts equal the counts of a scene in which the hidden parts are cut away. Peel.AlikeFacesEqualTheCpuTwin
// tests this for engines on a device.
#include <algorithm>
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include "tests/support/cpu_twin.h"
#include "directions/sampler.h"
#include <viewpeel/compute.h>
#include "engines/engine_factory.h"
#include "engines/host_engine.h"
#include "estimator/directed_pairs.h"
#include "reference/exact/exact_engine.h"
#include "scenes/alike_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr int kResolution = 33;

struct Counter {
  const char* name;
  bool is_exact;
  std::function<PairCounts(const Scene&, const Ids&, const std::vector<Direction>&)> count;
};

std::vector<Counter> counters() {
  const auto host = [](Sampling sampling) {
    return [sampling](const Scene& scene, const Ids& ids, const std::vector<Direction>& directions) {
      return makeHostEngine(scene, ids, {.resolution = kResolution, .sampling = sampling})->count(directions);
    };
  };
  const auto twin = [](const Scene& scene, const Ids& ids, const std::vector<Direction>& directions) {
    return countPairsOnCpu(scene, ids, directions, kResolution);
  };
  const auto exact = [](const Scene& scene, const Ids& ids, const std::vector<Direction>& directions) {
    return reference::makeExactEngine(scene, ids)->count(directions);
  };
  return {{"host, lattice", false, host(Sampling::lattice)},
          {"host, scanlines", false, host(Sampling::scanline)},
          {"twin", false, twin},
          {"exact", true, exact}};
}

using CountsByName = std::map<std::pair<std::string, std::string>, uint64_t>;

CountsByName countByName(const Scene& scene, const Counter& counter, const std::vector<Direction>& directions) {
  const Ids ids = makeIds(scene, By::surface, false);
  CountsByName counts;
  for (const PairCount& pair : counter.count(scene, ids, directions)) {
    const std::string to = pair.j == kEnvironment ? "environment" : pair.j == kLeak ? "leak" : ids.names[pair.j];
    counts[std::minmax(ids.names[pair.i], to)] = pair.count;
  }
  return counts;
}

// Returns an empty string where no two counts differ by more than `allowed`, else the first pair that does.
std::string firstDifference(const CountsByName& a, const CountsByName& b, uint64_t allowed) {
  CountsByName both = a;
  both.insert(b.begin(), b.end());
  for (const auto& [pair, any] : both) {
    const auto countIn = [&](const CountsByName& counts) { return counts.count(pair) ? counts.at(pair) : 0; };
    const uint64_t in_a = countIn(a), in_b = countIn(b);
    if (std::max(in_a, in_b) - std::min(in_a, in_b) > allowed)
      return pair.first + " to " + pair.second + ": " + std::to_string(in_a) + " and " + std::to_string(in_b);
  }
  return "";
}

// Lattices count the same points, so no difference is allowed. The exact engine rounds areas to its unit, once for each
// direction and for each of the two polygons of a surface.
uint64_t allowedDifference(const Counter& counter, size_t directions) { return counter.is_exact ? 2 * directions : 0; }

std::vector<Direction> someDirections() { return sampleDirections(Sampler::iid, 12, 7, 0); }
std::vector<Direction> reversed(std::vector<Direction> directions) {
  for (Direction& direction : directions) direction = ts::reversed(direction);
  return directions;
}

// Returns the scene as if the order of coincident polygons were unknown.
Scene withoutRanks(Scene scene) {
  for (Polygon& polygon : scene.polygons) polygon.tie_rank = kContactRank;
  return scene;
}

std::string differenceOfBothWays(const Scene& scene, const Counter& counter) {
  const auto directions = someDirections();
  return firstDifference(countByName(scene, counter, directions), countByName(scene, counter, reversed(directions)),
                         allowedDifference(counter, directions.size()));
}

TEST(Alike, TheSameFaceCountsFromBothSides) {
  for (const ts::AlikeScene& of : ts::alikeScenes())
    for (const InputScene& input : {of.make(false), ts::turnedAndMoved(of.make(false))}) {
      const Scene scene = buildScene(input);
      EXPECT_EQ(scene.coincidences.alike_unordered, 0u) << of.name;
      for (const Counter& counter : counters()) {
        SCOPED_TRACE(of.name + ", " + counter.name);
        if (counter.name == std::string("host, scanlines"))
          continue;  // the scanline of the reversed direction rounds span ends to the other side
        EXPECT_EQ(differenceOfBothWays(scene, counter), "");
        EXPECT_NE(differenceOfBothWays(withoutRanks(scene), counter), "");
      }
    }
}

// A hidden part radiates into the back of the face above it, which counts as leak. In the cut scene this leak is
// absent. All other counts are equal, also where all directions lie in one hemisphere.
TEST(Alike, IsWhatTheCutSceneMeans) {
  const auto difference = [](const Scene& scene, const Scene& cut, const Counter& counter,
                             const std::vector<Direction>& directions) {
    const auto withoutLeak = [&](const Scene& of) {
      CountsByName counts = countByName(of, counter, directions);
      std::erase_if(counts,
                    [](const auto& entry) { return entry.first.first == "leak" || entry.first.second == "leak"; });
      return counts;
    };
    return firstDifference(withoutLeak(scene), withoutLeak(cut), allowedDifference(counter, directions.size()));
  };
  std::vector<Direction> upward = someDirections();
  for (Direction& direction : upward)
    if (direction.u.z < 0) direction = ts::reversed(direction);
  for (const ts::AlikeScene& of : ts::alikeScenes()) {
    const Scene scene = buildScene(of.make(false)), cut = buildScene(of.make(true));
    EXPECT_EQ(scene.warnings.size(), 1u) << of.name;
    EXPECT_TRUE(cut.warnings.empty()) << of.name;
    for (const Counter& counter : counters())
      for (const auto& directions : {upward, reversed(upward)}) {
        SCOPED_TRACE(of.name + ", " + counter.name);
        EXPECT_EQ(difference(scene, cut, counter, directions), "");
      }
    // Negative control: with the other face in front the counts differ.
    Scene other = scene;
    for (Polygon& polygon : other.polygons) polygon.tie_rank = kTieRanks - 1 - polygon.tie_rank;
    EXPECT_NE(difference(other, cut, counters()[0], upward), "") << of.name;
  }
}

// A pair with directions of its own, which lie in one hemisphere, has the count of the cut scene.
TEST(Alike, PairsWithSeparateDirectionsSeeTheSameFace) {
  const auto countOf = [](const Scene& scene, const char* a, const char* b) {
    const Ids ids = makeIds(scene, By::polygon, false);
    const auto idOf = [&](const char* name) {
      return static_cast<uint32_t>(std::find(ids.names.begin(), ids.names.end(), name) - ids.names.begin());
    };
    const auto [i, j] = std::minmax({idOf(a), idOf(b)});
    PairSampler sampler(scene, ids, 3, latticeEngines(EngineKind::host, nullptr));
    DirectedPair pair = sampler.direct(i, j, 64);
    EXPECT_EQ(pair.directions, 64u);
    sampler.prepare({&pair, 1});
    return sampler.count(pair, 0).count;
  };
  size_t noticed = 0;
  for (const ts::AlikeScene& of : ts::alikeScenes()) {
    if (of.name != "floor of two tiles" && of.name != "floor drawn first") continue;
    const Scene scene = buildScene(of.make(false)), cut = buildScene(of.make(true));
    const uint64_t counted = countOf(scene, "first", "roomz1"), meant = countOf(cut, "first", "roomz1");
    EXPECT_GT(meant, 1000u);
    EXPECT_EQ(counted, meant) << of.name;
    noticed += countOf(withoutRanks(scene), "first", "roomz1") != meant;
  }
  EXPECT_EQ(noticed, 1u);  // without ranks the lower index wins, which is wrong in one of the two scenes
}

// The run has eight replicates or a few more, so errors of row sums follow Student's t of seven degrees of freedom.
// With seven rows at most 0.7 % of seeds have a row beyond the quantile of 1e-3. More than 6 of 100 seeds with one have
// a probability below 1e-5. A single row of 7.6 standard errors, as with seed 1, is therefore no fault.
TEST(Alike, RowsOfPairsWithSeparateDirectionsErrAsStated) {
  constexpr double kQuantile = 5.408;
  const Scene scene = buildScene(ts::alikeScenes()[1].make(false));
  Request request;
  request.engine = EngineKind::host;
  request.threads = 1;
  request.pair_lines = false;
  request.unoccluded = true;
  request.goal = Tolerance{2e-3};
  request.amount.directions = 16;
  int beyond = 0, beyond_a_third = 0;
  double squares = 0;
  for (request.seed = 1; request.seed <= 100; ++request.seed) {
    const Result result = computeFormFactors(scene, request);
    EXPECT_GE(result.directed_pairs, 15u);
    EXPECT_GE(result.replicates, 8u);
    double worst = 0;
    for (const Measured& row : result.form_factors.rowSums()) {
      const double z = std::abs(row.value - 1) / row.standard_error;
      worst = std::max(worst, z), squares += z * z;
    }
    beyond += worst > kQuantile, beyond_a_third += worst > kQuantile / 3;
  }
  EXPECT_LE(beyond, 6);
  EXPECT_GT(beyond_a_third, 6);  // negative control: with a third of the stated error more seeds are beyond
  EXPECT_GT(std::sqrt(squares / 700.0), 0.5);  // negative control: errors stated twice as large fail here
}

// More faces lie on each other than there are ranks. Contacts keep their order, and no pair gets directions of its own.
TEST(Alike, HighStacksAreUnordered) {
  const auto stack = [](int count) {
    InputScene s{"stack", {}, {}};
    ts::addWalls(s, 1);
    ts::addTile(s, "floor", 0, 1);
    for (int k = 1; k < count; ++k) ts::addTile(s, "tile" + std::to_string(k), 0.05 * k, 1 - 0.04 * k);
    ts::addSolid(s, "box", {0.4, 0.3, 0}, {0.6, 0.7, 0.4});
    return buildScene(s);
  };
  const auto directionsOf = [](const Scene& scene) {
    const Ids ids = makeIds(scene, By::polygon, false);
    PairSampler sampler(scene, ids, 3, latticeEngines(EngineKind::host, nullptr));
    return sampler.direct(0, 1, 64).directions;
  };
  for (int count : {7, 8}) {  // tiles in the plane of the floor; the bottom of the box comes on top
    const Scene scene = stack(count);
    const bool has_order = count + 1 <= int(kTieRanks);
    EXPECT_EQ(scene.coincidences.alike_unordered > 0, !has_order) << count;
    EXPECT_EQ(directionsOf(scene), has_order ? 64u : 0u) << count;
    EXPECT_EQ(scene.warnings.size(), has_order ? 1u : 2u) << count;
    EXPECT_EQ(scene.coincidences.contacts, static_cast<uint64_t>(count));
    // The box covers all tiles, so that its bottom touches a front and nothing leaks.
    const Counter host = counters()[0];
    uint64_t on_faces = 0, leak = 0;
    for (const auto& [pair, lines] : countByName(scene, host, someDirections())) {
      if (pair.first != "boxz0" && pair.second != "boxz0") continue;
      (pair.first == "leak" || pair.second == "leak" ? leak : on_faces) += lines;
    }
    EXPECT_GT(on_faces, 0u);
    EXPECT_EQ(leak, 0u);
  }
}

// Rounding has made these two planes cross. Which one is in front may depend on the direction, so the pair counts as
// unordered.
TEST(Alike, CrossingPlanesHaveNoOrder) {
  const auto unorderedPairs = [](double lift, double tilt) {
    InputScene s{"crossing", {}, {}};
    ts::addWalls(s, 1);
    ts::addTile(s, "first", 0, 0.6);
    ts::addTile(s, "second", 0.4, 1);
    for (glm::dvec3& corner : s.faces.back().corners) corner.z += lift + tilt * (corner.x - 0.5);
    return buildScene(s).coincidences.alike_unordered;
  };
  EXPECT_EQ(unorderedPairs(0, 0), 0u);
  EXPECT_EQ(unorderedPairs(1e-9, 0), 0u);  // one plane
  EXPECT_EQ(unorderedPairs(0, 1e-6), 1u);
  EXPECT_EQ(unorderedPairs(2e-8, 0), 1u);  // too near for engines to order with certainty
  EXPECT_EQ(unorderedPairs(1e-6, 0), 0u);  // one face lies clearly in front
  EXPECT_EQ(unorderedPairs(1e-6, 1e-6), 0u);
}

}  // namespace
}  // namespace viewpeel
