// Polygons of very different sizes get lattices as fine as they need, and every pair is counted once.
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/cpu_twin.h"
#include "engines/compute_engine.h"
#include "engines/size_groups.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

// Squares with edges from 1 to 1e-4 lie at different places above a large one. They face it, and all but the first face
// a partner of their size.
InputScene squaresOfAllSizes() {
  InputScene scene{"squares of all sizes", {}, {}};
  ts::addFace(scene, "floor", {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
  double x = 0.1;
  for (int k = 0; k < 5; ++k) {
    const double edge = std::pow(10.0, -k), z = 0.5 + 0.1 * k;
    const std::string name = fmt::format("k{}", k);
    ts::addFace(scene, name + "_down",
                {{x, 0.5, z}, {x, 0.5 + edge, z}, {x + edge, 0.5 + edge, z}, {x + edge, 0.5, z}});
    if (k > 0)  // the partner below looks up at it, one edge length away
      ts::addFace(
          scene, name + "_up",
          {{x, 0.5, z - edge}, {x + edge, 0.5, z - edge}, {x + edge, 0.5 + edge, z - edge}, {x, 0.5 + edge, z - edge}});
    x += edge + 0.15;
  }
  return scene;
}

std::vector<double> neededFor(const Scene& scene, double spacings) {
  std::vector<double> needed;
  for (const Polygon& polygon : scene.polygons) needed.push_back(2 * spacings / std::sqrt(polygon.area));
  return needed;
}

TEST(SizeGroups, EveryPolygonIsInOneWindowThatHoldsIt) {
  for (const InputScene& input : {squaresOfAllSizes(), ts::triangleSoup(200, 0.3, 5), ts::roomWithTouchingBoxes()}) {
    const Scene scene = buildScene(input);
    const std::vector<double> needed = neededFor(scene, 8);
    const auto groups = groupBySize(scene, needed, 16);
    EXPECT_EQ(groups[0].resolution, 16);
    EXPECT_EQ(groups[0].window.radius, 1);
    std::set<uint32_t> seen;
    int before = 0;
    for (const SizeGroup& group : groups) {
      EXPECT_GE(group.resolution, before);
      before = group.resolution;
      for (uint32_t k : group.polygons) {
        EXPECT_TRUE(seen.insert(k).second);
        const Polygon& polygon = scene.polygons[k];
        double radius = 0;
        for (uint32_t c = 0; c < polygon.corner_count; ++c) {
          const glm::dvec3& corner = scene.corners[polygon.first_corner + c];
          EXPECT_LE(glm::length(corner - group.window.centre), group.window.radius + 1e-12);
          radius = std::max(radius, glm::length(corner - scene.corners[polygon.first_corner]));
        }
        // A polygon gets the resolution that it needs, unless a window four times as fine would be too large.
        const bool fits = group.resolution >= needed[k] || radius * group.resolution * 4 > kMostWindowPoints / 2.0;
        EXPECT_TRUE(fits) << group.resolution << " " << needed[k];
      }
    }
    EXPECT_EQ(seen.size(), scene.polygons.size());
  }
}

// Specks all over the scene would need a window each. They share fewer, coarser windows.
TEST(SizeGroups, WindowsAreFew) {
  InputScene input{"specks", {}, {}};
  ts::addFace(input, "floor", {{0, 0, 0}, {20, 0, 0}, {20, 20, 0}, {0, 20, 0}});
  for (int k = 0; k < 400; ++k) {
    const int column = k % 20, row = k / 20;
    const double x = column + 0.5, y = row + 0.5, d = 1e-3;
    ts::addFace(input, "specks", {{x, y, 1}, {x, y + d, 1}, {x + d, y + d, 1}, {x + d, y, 1}});
  }
  const Scene scene = buildScene(input);
  const auto groups = groupBySize(scene, neededFor(scene, 8), 16);
  EXPECT_GT(groups.size(), 1u);
  EXPECT_LE(groups.size(), 33u);
  size_t polygons = 0;
  for (const SizeGroup& group : groups) polygons += group.polygons.size();
  EXPECT_EQ(polygons, scene.polygons.size());
}

// Counts in a window equal the CPU twin's, for the polygons of its group.
TEST(SizeGroups, CountsEqualTheCpuTwin) {
  const auto directions = sampleDirections(Sampler::iid, 6, 11, 0);
  for (By by : {By::polygon, By::surface})
    for (const InputScene& input : {squaresOfAllSizes(), ts::triangleSoup(60, 0.5, 3)}) {
      const Scene scene = buildScene(input);
      Ids ids = makeIds(scene, by, false);
      const auto groups = groupBySize(scene, neededFor(scene, 2), 8);
      ASSERT_GT(groups.size(), 1u);
      const int finest = groups.back().resolution;
      std::map<std::pair<uint32_t, uint32_t>, uint64_t> expected;
      for (size_t g = 0; g < groups.size(); ++g) {
        ids.roles.assign(scene.polygons.size(), 0);
        for (size_t earlier = 0; earlier <= g; ++earlier)
          for (uint32_t k : groups[earlier].polygons) ids.roles[k] = earlier == g ? kEmits | kReceives : kReceives;
        const uint64_t weight = uint64_t(finest / groups[g].resolution) * uint64_t(finest / groups[g].resolution);
        for (const PairCount& c :
             countPairsOnCpu(scene, ids, directions, groups[g].resolution, false, Fault::none, groups[g].window))
          expected[{c.i, c.j}] += weight * c.count;
      }
      PairCounts twin;
      for (const auto& [pair, count] : expected) twin.push_back({pair.first, pair.second, count});
      const auto engine =
          makeGroupedEngine(enginesOf(EngineKind::compute), scene, makeIds(scene, by, false), {}, groups);
      EXPECT_EQ(engine->count(directions), twin);
      const size_t half = directions.size() / 2;
      const auto halves = engine->countBlocks(directions, half);
      ASSERT_EQ(halves.size(), 2u);
      for (size_t k = 0; k < 2; ++k) EXPECT_EQ(halves[k], engine->count(std::span(directions).subspan(k * half, half)));
    }
}

// The lattice of a window is a part of the whole scene's lattice, point by point. Both snap alike here, for coordinates
// stay below 512 spacings.
TEST(SizeGroups, WindowsAreOnOneLattice) {
  const Scene scene = buildScene(squaresOfAllSizes());
  Ids ids = makeIds(scene, By::polygon, false);
  ids.roles.assign(scene.polygons.size(), kReceives);
  const auto id = static_cast<uint32_t>(std::find(ids.names.begin(), ids.names.end(), "k1_down") - ids.names.begin());
  ids.roles[id] = kEmits | kReceives;
  const glm::dvec3 corner = scene.corners[scene.polygons[id].first_corner];
  const auto whole = makeComputeEngine(testDevice(), scene, ids, {.resolution = 512});
  for (const Window& window : {Window{corner, 0.2}, Window{0.9 * corner, 0.3}}) {
    ASSERT_LT(glm::length(corner - window.centre) + 0.1 / scene.scale * 1.5, window.radius);
    const auto part = makeComputeEngine(testDevice(), scene, ids, {.resolution = 512, .window = window});
    const auto directions = sampleDirections(Sampler::iid, 30, 12, 0);
    for (const Direction& direction : directions)
      EXPECT_EQ(part->count(std::span(&direction, 1)), whole->count(std::span(&direction, 1)));
    for (const int resolution : {512, 8000})
      for (const Sampling sampling : {Sampling::lattice, Sampling::scanline}) {
        const LatticeOptions options{
            .resolution = resolution, .sampling = sampling, .window = window, .count_blocked = true};
        EXPECT_EQ(makeHostEngine(scene, ids, options)->count(directions),
                  makeComputeEngine(testDevice(), scene, ids, options)->count(directions))
            << resolution;
      }
  }
}

// Strips leave most tiles of a fine window empty, and the compute engine skips these row by row. One of the strips is a
// sliver of a triangle.
TEST(SizeGroups, EmptyTilesOfAWindowHideNothing) {
  InputScene input{"strips over a square", {}, {}};
  ts::addFace(input, "square", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  ts::addFace(input, "strip", ts::parallelogram({0, 0.5, 0.5}, {1e-4, 2e-4, 0}, {1, 0.1, 0}));
  ts::addFace(input, "sliver", {{0.1, 0.2, 0.3}, {0.9, 0.7, 0.5}, {0.9, 0.7001, 0.5}});
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto groups = groupBySize(scene, {16, 4096, 4096}, 16);
  ASSERT_EQ(groups.back().resolution, 4096);
  const auto directions = sampleDirections(Sampler::iid, 24, 5, 0);
  for (const bool count_blocked : {false, true})
    for (const Sampling sampling : {Sampling::lattice, Sampling::scanline}) {
      const LatticeOptions options{.sampling = sampling, .count_blocked = count_blocked};
      const auto countWith = [&](EngineKind kind) {
        return makeGroupedEngine(enginesOf(kind), scene, ids, options, groups)->count(directions);
      };
      const PairCounts counts = countWith(EngineKind::compute);
      EXPECT_EQ(counts, countWith(EngineKind::host)) << count_blocked;
      EXPECT_TRUE(std::any_of(counts.begin(), counts.end(),
                              [](const PairCount& pair) { return pair.i == 1 && pair.count > 0; }));
    }
}

// Equal needs give one group of all polygons, and the engine of one group counts like the plain engine.
TEST(SizeGroups, OneGroupIsTheWholeMatrix) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 20, 3, 0);
  const auto whole = groupAsOne(scene, 33),
             equal = groupBySize(scene, std::vector<double>(scene.polygons.size(), 1), 33);
  ASSERT_EQ(whole.size(), 1u);
  ASSERT_EQ(equal.size(), 1u);
  EXPECT_EQ(whole[0].resolution, equal[0].resolution);
  EXPECT_EQ(whole[0].window.radius, equal[0].window.radius);
  EXPECT_EQ(whole[0].polygons, equal[0].polygons);
  const auto engine = makeGroupedEngine(enginesOf(EngineKind::compute), scene, ids, {}, whole);
  EXPECT_EQ(engine->count(directions), countPairs(scene, directions, {.lattice = {.resolution = 33}}));
  EXPECT_EQ(engine->unitArea(), 4.0 / (33 * 33));
}

// Areas range from 1 to 1e-8, and pairs of equal squares are an edge length apart. All form factors are within five
// standard errors, which are no larger for small squares than for large ones.
TEST(SizeGroups, SmallPolygonsHaveTheirClosedForms) {
  const Scene scene = buildScene(squaresOfAllSizes());
  const Ids ids = makeIds(scene, By::polygon, false);
  for (const TestRun& run : withEngines()) {
    SCOPED_TRACE(run.name);
    const auto engine =
        makeGroupedEngine(enginesOf(run.engine), scene, ids, run.lattice,
                          groupBySize(scene, neededFor(scene, 8), 16, maxWindowResolution(run.lattice.sampling)));
    const Estimate estimate = estimateFormFactors(*engine, scene, ids, {.directions = 300, .replicates = 16});
    const auto indexOf = [&](const std::string& name) {
      return static_cast<uint32_t>(std::find(ids.names.begin(), ids.names.end(), name) - ids.names.begin());
    };
    for (int k = 1; k < 5; ++k) {
      const std::string name = fmt::format("k{}", k);
      const Measured f = estimate.form_factors.formFactor(indexOf(name + "_up"), indexOf(name + "_down"));
      // Two equal squares are an edge length apart (Howell, C-11).
      EXPECT_NEAR(f.value, 0.199824895698, 5 * f.standard_error) << name;
      // The error is about the same for every size: below 2e-3, which is a check of the groups and no derived bound.
      // Scanlines have at most 2^14 rows, some 15 times too few for the smallest squares. Where rows seldom meet a
      // square, the variance grows with their spacing: 15 times the variance is 4 times the error.
      EXPECT_LT(f.standard_error, run.lattice.sampling == Sampling::scanline && k == 4 ? 8e-3 : 2e-3) << name;
      EXPECT_EQ(estimate.form_factors.exchangeArea(indexOf(name + "_up"), indexOf(name + "_down")).value,
                estimate.form_factors.exchangeArea(indexOf(name + "_down"), indexOf(name + "_up")).value);
    }
    // Every row sums to 1.
    for (uint32_t k = 0; k < ids.count(); ++k)
      EXPECT_NEAR(estimate.form_factors.rowSums()[k].value, 1,
                  6 * estimate.form_factors.rowSums()[k].standard_error + 1e-12)
          << ids.names[k];
  }
}

}  // namespace
}  // namespace viewpeel
