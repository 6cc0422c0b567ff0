// Rays of each polygon's own give the form factors that the exact engine and pair lines give.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>

#include <viewpeel/compute.h>
#include "tests/support/test_device.h"
#include "directions/sampler.h"
#include "rays/ray_engine.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"
#include "sums/replicate_sums.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr uint32_t kSeries = 32;

// Returns form factors from replicates of this number of rays of each polygon.
//   In: of_ids: as RayEngine::setRays() takes them, or empty
FormFactors byRays(const Scene& scene, const Ids& ids, uint32_t rays, std::vector<uint32_t> of_ids = {}) {
  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  engine->setRays(std::move(of_ids));
  ReplicateSums sums(ids);
  for (uint32_t r = 0; r < kSeries; ++r) sums.add(engine->count(sampleDirections(Sampler::iid, rays, 3, r)));
  const double unit = engine->unitArea() * scene.scale * scene.scale;
  return sums.formFactors(unit / rays, unit);
}

Measured entryOf(const FormFactors& all, uint32_t i, uint32_t j) {
  for (const FormFactors::Entry& entry : all.entries())
    if (entry.i == i && entry.j == j) return entry.exchange_area;
  return {0, 0};
}

// Expects entries to agree. Hits of independent rays are binomial, and hits by scrambled Sobol' points vary less. An
// entry of at least 100 expected hits, where as many rays of its row go elsewhere, may be off by six of its standard
// errors: with 32 replicates a normal mean exceeds this in 1 of 800,000 cases. Fewer hits are not normal; they exceed
// the bound below with a probability under exp(-18), by Bernstein's inequality.
//   In: rays: of each polygon, in all replicates
void expectNear(const FormFactors& found, const FormFactors& wanted, double rays) {
  const Ids& ids = found.ids();
  const auto expectEntry = [&](uint32_t i, uint32_t j, const Measured& value, const Measured& exchange) {
    const double hit = ids.smallerArea(i, j) / rays,  // the most that a ray adds
        rounding = 1e-7 * ids.smallerArea(i, j),
                 rarer =
                     j < kEnvironment ? exchange.value : std::clamp(ids.areas[i] - exchange.value, 0.0, exchange.value),
                 error = rarer >= 100 * hit ? 6 * value.standard_error : 6 * std::sqrt(rarer * hit) + 12 * hit;
    EXPECT_NEAR(value.value, exchange.value, error + 6 * exchange.standard_error + rounding)
        << ids.names[i] << " " << j;
  };
  for (const FormFactors::Entry& entry : wanted.entries())
    expectEntry(entry.i, entry.j, entryOf(found, entry.i, entry.j), entry.exchange_area);
  for (const FormFactors::Entry& entry : found.entries())
    if (entryOf(wanted, entry.i, entry.j).value == 0) expectEntry(entry.i, entry.j, entry.exchange_area, {0, 0});
}

FormFactors byLines(const Scene& scene, By by, bool two_sided = false) {
  Request request;
  request.by = by, request.promise = false, request.two_sided = two_sided;
  request.goal = Tolerance{1e-3};
  return computeFormFactors(scene, request).form_factors;
}

TEST(RayEngine, AgreesWithPairLines) {
  for (const InputScene& input : {ts::insideOfCube(), ts::cubeInCube(0.4), ts::roomWithTouchingBoxes(),
                                  ts::triangleSoup(60, 0.5, 3), bench::triangulatedCity(120).scene}) {
    const Scene scene = buildScene(input);
    for (const By by : {By::polygon, By::surface})
      for (const bool two_sided : {false, true}) {
        SCOPED_TRACE(input.file + (by == By::surface ? ", by surface" : "") + (two_sided ? ", two-sided" : ""));
        expectNear(byRays(scene, makeIds(scene, by, two_sided), 256), byLines(scene, by, two_sided), 256 * kSeries);
      }
  }
}

// Every third polygon has all rays, and the others have a quarter of them.
TEST(RayEngine, PolygonsMayHaveUnequalNumbersOfRays) {
  constexpr uint32_t kMost = 256, kLeast = 64;
  for (const InputScene& input :
       {ts::roomWithTouchingBoxes(), ts::triangleSoup(60, 0.5, 3), bench::triangulatedCity(120).scene}) {
    SCOPED_TRACE(input.file);
    const Scene scene = buildScene(input);
    const Ids ids = makeIds(scene, By::polygon, false);
    std::vector<uint32_t> rays;
    for (uint32_t id = 0; id < ids.count(); ++id) rays.push_back(id % 3 ? kLeast : kMost);
    expectNear(byRays(scene, ids, kMost, rays), byLines(scene, By::polygon), kLeast * kSeries);
  }
}

TEST(RayEngine, OutsideCountsAreThatPartOfAllCounts) {
  const Scene scene = buildScene(bench::triangulatedCity(300).scene);
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  const auto directions = sampleDirections(Sampler::iid, 48, 3, 0);
  std::vector<uint32_t> blocks;  // of two: those in which an id has rays
  for (uint32_t id = 0; id < ids.count(); ++id) blocks.push_back(id % 3);
  const std::vector<PairCounts> outside = engine->countOutside(directions, 24, blocks);
  ASSERT_EQ(outside.size(), 2u);
  for (uint32_t block = 0; block < 2; ++block) {
    PairCounts wanted = engine->count(std::span(directions).subspan(24 * block, 24));
    std::erase_if(wanted, [&](const PairCount& of) { return of.j < kEnvironment || blocks[of.i] <= block; });
    EXPECT_GT(wanted.size(), 50u);
    EXPECT_EQ(outside[block], wanted);
  }
}

// The same rays are counted with a horizon and without. A sliver of 8 x 1e-5 has its rays in double precision. Upwards
// goes (1 + n_z) / 2 of what a polygon of normal n emits with nothing in the way.
TEST(RayEngine, AHorizonDividesWhatLeavesTheScene) {
  const Scene scene = buildScene({"plates",
                                  {"tilted", "sliver", "facing", "back"},
                                  {{{{0, 0, 0}, {0, 1, 0}, {0.6, 1, 0.8}, {0.6, 0, 0.8}}, 0},
                                   {{{0, 90, 0}, {8, 90, 0}, {8, 90, 1e-5}, {0, 90, 1e-5}}, 1},
                                   {{{50, 0, 0}, {51, 0, 0}, {51, 1, 0}, {50, 1, 0}}, 2},
                                   {{{50, 0, 2}, {51, 0, 2}, {51, 1, 2}, {50, 1, 2}}, 3}}});
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  constexpr uint32_t kRays = 4096;
  const std::vector<Direction> directions = sampleDirections(Sampler::iid, kRays, 3, 0);
  const auto sharesOf = [&] {
    std::vector<std::pair<double, double>> shares(ids.count());  // environment, leak
    const std::vector<PairCounts> counts = engine->countOutside(directions, kRays, std::vector<uint32_t>(4, 1));
    for (const PairCount& count : counts.front())
      (count.j == kEnvironment ? shares[count.i].first : shares[count.i].second) =
          2 * double(count.count) * engine->unitArea() * scene.scale * scene.scale / kRays / ids.areas[count.i];
    return shares;
  };
  const auto whole = sharesOf();
  engine->setHorizon({0, 0, 2});
  const auto divided = sharesOf();
  constexpr double kRounding = 1e-3;  // of a count, of which the sliver has 2^14
  for (uint32_t id = 0; id < 4; ++id)
    EXPECT_NEAR(divided[id].first + divided[id].second, whole[id].first, kRounding) << id;
  // 4,096 independent rays err by 1/128 at most, and these by less: six times this are a chance of 1e-9.
  constexpr double kError = 6.0 / 128;
  EXPECT_NEAR(divided[0].first, (1 - 0.6) / 2, kError);  // the front of `tilted` looks down
  EXPECT_NEAR(divided[1].first, 0.5, kError);
  EXPECT_GT(whole[2].second, 0.05);  // what `facing` sends to the back of `back`
  EXPECT_EQ(divided[2].second, 0);   // and not below the horizon
  EXPECT_NEAR(divided[3].first, 1, kRounding);
}

TEST(RayEngine, NumbersOfRaysAreEnoughAndFillTheLanes) {
  for (const auto& [at_least, rays] :
       {std::pair(0.0, 16), {16, 16}, {16.5, 32}, {33, 48}, {48, 48}, {48.1, 64}, {65, 96}, {97, 128}, {769, 1024}})
    EXPECT_EQ(RayEngine::usualRays(at_least), static_cast<uint32_t>(rays)) << at_least;
}

// A box stands on a floor, and a sheet of two faces in one plane hangs above it. Corners that were rounded may stand a
// little above the floor.
TEST(RayEngine, CoincidentFacesHaveTheirOrder) {
  for (const double gap : {0.0, 1e-9}) {
    SCOPED_TRACE(gap);
    InputScene input;
    ts::addBox(input, "room", {0, 0, 0}, {4, 4, 3}, true, true);
    ts::addBox(input, "box", {1, 1, gap}, {2, 2, 1}, false, true);
    const ts::Corners sheet = ts::parallelogram({2.5, 1, 1}, {0, 2, 0}, {0, 0, 1});
    ts::addFace(input, "left", sheet);
    ts::addFace(input, "right", {sheet.rbegin(), sheet.rend()});
    const Scene scene = buildScene(input);
    const Ids ids = makeIds(scene, By::polygon, false);
    const FormFactors found = byRays(scene, ids, 256);
    expectNear(found, byLines(scene, By::polygon), 256 * kSeries);
    expectNear(byRays(scene, makeIds(scene, By::polygon, true), 256), byLines(scene, By::polygon, true), 256 * kSeries);
    const auto idOf = [&](const char* name) {
      return static_cast<uint32_t>(std::ranges::find(ids.names, name) - ids.names.begin());
    };
    // All that the box's bottom emits ends on the floor, and nothing goes from one side of the sheet to the other.
    const uint32_t floor = idOf("roomz0"), bottom = idOf("boxz0");
    EXPECT_NEAR(entryOf(found, std::min(floor, bottom), std::max(floor, bottom)).value, 1, 1e-3);
    EXPECT_EQ(entryOf(found, std::min(idOf("left"), idOf("right")), std::max(idOf("left"), idOf("right"))).value, 0);
  }
}

TEST(RayEngine, RowsOfAClosedSceneAddUpToOneWithoutLeak) {
  for (const Scene& scene : {buildScene(ts::roomWithTouchingBoxes()), loadScene(VIEWPEEL_SCENES "/office.obj")}) {
    const Ids ids = makeIds(scene, By::polygon, false);
    constexpr uint32_t kRays = 1024;
    const FormFactors found = byRays(scene, ids, kRays);
    // In single precision 1e-5 of all rays pass an edge. They are cast again in double precision, where 1e-12 of them
    // would.
    for (const FormFactors::Entry& entry : found.entries())
      EXPECT_LT(entry.j, kEnvironment) << ids.names[entry.i] << " " << entry.exchange_area.value;
    // Counts are rounded to 2^-14 of the smallest area.
    const double rounding = double(ids.count()) * 0x1p-14 / kRays;
    for (size_t i = 0; i < ids.count(); ++i)
      EXPECT_NEAR(found.rowSums()[i].value, 1, 6 * found.rowSums()[i].standard_error + rounding) << ids.names[i];
  }
}

// A body with an inner edge is seen from outside. Half of all rays leave the scene, and rays that end on backs, as past
// the edges of its many parts, are cast again alone.
TEST(RayEngine, NoRayEntersABody) {
  const glm::dvec3 up(0, 0, 1),
      corners[] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 0, 0}};
  InputScene input;
  for (size_t k = 0; k + 1 < std::size(corners); ++k)
    ts::addFace(input, "side", ts::parallelogram(corners[k], corners[k + 1] - corners[k], up));
  for (const glm::dvec3& height : {glm::dvec3(0), up}) {
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z = height;
    const bool is_top = height == up;
    ts::addFace(input, "end", is_top ? ts::parallelogram(z, 2.0 * x, y) : ts::parallelogram(z, y, 2.0 * x));
    ts::addFace(input, "end", is_top ? ts::parallelogram(y + z, x, y) : ts::parallelogram(y + z, y, x));
  }
  const Scene scene = buildScene(bench::refined(buildScene(input), 6));
  const Ids ids = makeIds(scene, By::surface, false);
  const FormFactors found = byRays(scene, ids, 1024);
  EXPECT_EQ(found.formFactor(0, kLeak).value, 0);
  EXPECT_EQ(found.formFactor(1, kLeak).value, 0);
  // The inner sides see each other as two squares with a common edge do.
  EXPECT_NEAR(found.formFactor(0, 0).value, 2 * 0.2000437 / 8, 1e-3);
}

// A lamp sees the sky through a slit, by 1 of 1,000 rays. So few rays leave the scene that they are cast again, and
// leave it again.
TEST(RayEngine, FewRaysThatLeaveTheSceneDoLeaveIt) {
  constexpr uint32_t kRays = 4096;
  InputScene input;
  ts::addFace(input, "lamp", ts::parallelogram({-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "left", ts::parallelogram({-50, -50, 0.1}, {0, 100, 0}, {49.9995, 0, 0}));
  ts::addFace(input, "right", ts::parallelogram({0.0005, -50, 0.1}, {0, 100, 0}, {49.9995, 0, 0}));
  const Scene scene = buildScene(input);
  const FormFactors found = byRays(scene, makeIds(scene, By::polygon, false), kRays);
  const double sky = found.formFactor(0, kEnvironment).value, rays = double(kRays) * kSeries;
  // The slit, 100 long and d = 1e-3 wide, is seen by each row across it. A strip of the lamp at x has the form factor
  // d h^2 / (2 (x^2 + h^2)^(3/2)) to it, whose mean over -1/2 < x < 1/2 is d / sqrt(1/4 + h^2) / 2. Past the
  // plates' far edges go (h / 50)^2 of all rays.
  const double wanted = 1e-3 / std::sqrt(0.25 + 0.01) / 2;
  EXPECT_NEAR(sky, wanted, 6 * std::sqrt(wanted / rays) + 1e-5);
}

// A strip lies on top of a plate, behind the plate's front, and is about as wide as single precision rounds in the unit
// ball. So the strip sees nothing of the plate, and the room as if the plate were not there.
TEST(RayEngine, NarrowPolygonsSeeWhatLinesSee) {
  constexpr double kWidth = 5e-7;
  constexpr uint32_t kRays = 1024;
  InputScene input = bench::refined(buildScene(ts::insideOfCube()), 4);
  ts::addFace(input, "plate", ts::parallelogram({0.5, 0.3, 0.2}, {0, 0.4, 0}, {0, 0, 0.3}));
  ts::addFace(input, "strip", ts::parallelogram({0.5 - kWidth, 0.3, 0.5}, {kWidth, 0, 0}, {0, 0.4, 0}));
  const Scene scene = buildScene(input);
  const FormFactors found = byRays(scene, makeIds(scene, By::surface, false), kRays),
                    wanted = byLines(scene, By::surface);
  const Ids& ids = found.ids();
  const auto strip = static_cast<uint32_t>(std::ranges::find(ids.names, "strip") - ids.names.begin()),
             plate = static_cast<uint32_t>(std::ranges::find(ids.names, "plate") - ids.names.begin());
  EXPECT_EQ(found.formFactor(strip, plate).value, 0);
  // The share of a row's rays that end on a surface errs no more than that of independent rays would. Form factors by
  // lines err by 1e-3.
  const double error = 6 * std::sqrt(0.25 / (kRays * kSeries)) + 1e-3;
  for (uint32_t j = 0; j < ids.count(); ++j)
    EXPECT_NEAR(found.formFactor(strip, j).value, wanted.formFactor(strip, j).value, error) << ids.names[j];
}

// The sides of a wedge see nothing of each other, however thin it is, and neither do the sides of a box seen from
// outside. At a wedge of 1/100 the share 1e-3 of a side's rays starts nearer to the other side's plane than single
// precision tells, and the other side is a narrow strip.
TEST(RayEngine, SidesOfConvexBodiesSeeNothingOfEachOther) {
  constexpr uint32_t kRays = 1024;
  InputScene input;
  ts::addFace(input, "left", ts::parallelogram({0, 0, 0}, {0, 1, 0}, {-0.01, 0, -1}));
  ts::addFace(input, "strip", ts::parallelogram({0, 0, 0}, {0.01 * 0.002, 0, -0.002}, {0, 1, 0}));
  ts::addFace(input, "right", ts::parallelogram({0.01 * 0.002, 0, -0.002}, {0.01 * 0.998, 0, -0.998}, {0, 1, 0}));
  ts::addBox(input, "box", {-0.4, 0.2, -3}, {0.4, 0.8, -2}, false, true);
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto normalOf = [&](uint32_t k) { return frontNormal(scene, scene.polygons[k]); };
  ASSERT_LT(normalOf(0).x, -0.99);
  ASSERT_GT(std::min(normalOf(1).x, normalOf(2).x), 0.99);
  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  uint64_t between_bodies = 0;
  for (uint64_t series = 0; series < kSeries; ++series)
    for (const PairCount& count : engine->count(sampleDirections(Sampler::iid, kRays, 3, series))) {
      if (count.j >= kEnvironment) continue;
      EXPECT_EQ(count.i < 3, count.j >= 3) << ids.names[count.i] << " " << ids.names[count.j];
      between_bodies += count.count;
    }
  EXPECT_GT(between_bodies, 0u);
}

// A post stands in a room, and beside it two strips are at right angles; all are 70 times as wide as single precision
// rounds in the unit ball. Nothing ends on a back of the post, and the strips see as much of each other as wide ones.
TEST(RayEngine, RaysStartOnTheRightSideOfNeighbours) {
  constexpr double kWidth = 2e-5;
  constexpr uint32_t kRays = 1024;
  InputScene input = ts::insideOfCube();
  ts::addBox(input, "post", {0.5, 0.5, 0}, {0.5 + kWidth, 0.5 + kWidth, 0.5}, false, true);
  ts::addFace(input, "across", ts::parallelogram({0.3, 0.3, 0.5}, {kWidth, 0, 0}, {0, 0.3, 0}));
  ts::addFace(input, "along", ts::parallelogram({0.3, 0.3, 0.5}, {0, 0.3, 0}, {0, 0, kWidth}));
  const Scene scene = buildScene(input);
  const FormFactors found = byRays(scene, makeIds(scene, By::surface, false), kRays);
  const Ids& ids = found.ids();
  const auto idOf = [&](const char* name) {
    return static_cast<uint32_t>(std::ranges::find(ids.names, name) - ids.names.begin());
  };
  // Two long strips of one width that meet at right angles have the form factor 1 - 1/sqrt(2): strings across them are
  // as long as the strips are wide. Their ends change it by less than their width over their length.
  const double of_strips = 1 - std::sqrt(0.5), rays = kRays * kSeries,
               error = 6 * std::sqrt(of_strips * (1 - of_strips) / rays) + kWidth / 0.3;
  EXPECT_NEAR(found.formFactor(idOf("across"), idOf("along")).value, of_strips, error);
  // Rays that start within reach of an edge may end on the back of the neighbour: 2^-12 of the width, at either edge.
  const double leak = 2 * 0x1p-12;
  for (const char* name : {"postx0", "postx1", "posty0", "posty1", "across", "along"})
    EXPECT_LE(found.formFactor(idOf(name), kLeak).value, leak + 6 * std::sqrt(leak / rays)) << name;
}

TEST(RayEngine, IsNotForTinyPolygons) {
  EXPECT_TRUE(suitsRays(buildScene(ts::insideOfCube())));
  InputScene input = ts::insideOfCube();
  ts::addFace(input, "tiny", ts::parallelogram({0.5, 0.5, 0.5}, {1e-6, 0, 0}, {0, 1e-6, 0}));
  EXPECT_FALSE(suitsRays(buildScene(input)));
}

// Directions of three replicates, one after another. The rays of one are not a multiple of the sixteen cast at a time.
constexpr uint32_t kRaysOfBlock = 40;
std::vector<Direction> threeBlocks() { return sampleReplicates(Sampler::iid, kRaysOfBlock, 3, 0, 3); }

TEST(RayEngine, CountsDependOnNeitherThreadsNorCalls) {
  const Scene scene = buildScene(bench::triangulatedCity(300).scene);
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::vector<Direction> all = threeBlocks();
  const auto directions = std::span(all).first(kRaysOfBlock), others = std::span(all).subspan(kRaysOfBlock).first(40);
  const std::unique_ptr<RayEngine> one = makeRayEngine(scene, ids, {.thread_count = 1}),
                                   three = makeRayEngine(scene, ids, {.thread_count = 3});
  const PairCounts first = one->count(directions);
  EXPECT_FALSE(first.empty());
  EXPECT_NE(three->count(others), first);
  EXPECT_EQ(three->count(directions), first);
}

// Rays of several blocks go through the tree side by side, in other company than alone. Many of this city's triangles
// touch in one plane, where a ray may meet two at one distance: without facets' numbers to decide, counts differed.
TEST(RayEngine, CountsBlocksAsOneByOne) {
  const Scene scene = buildScene(bench::triangulatedCity(4'200).scene);
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  const std::vector<Direction> directions = threeBlocks();
  const std::vector<PairCounts> blocks = engine->countBlocks(directions, kRaysOfBlock);
  ASSERT_EQ(blocks.size(), 3u);
  for (size_t block = 0; block < 3; ++block)
    EXPECT_EQ(engine->count(std::span(directions).subspan(block * kRaysOfBlock, kRaysOfBlock)), blocks[block]);
}

// In a cube every ray ends on a face, however many rays a face has: more than are cast in one bundle.
TEST(RayEngine, EveryRayCountsOnce) {
  const Scene scene = buildScene(ts::insideOfCube());
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  constexpr uint32_t kRays = 10'003;
  const std::vector<Direction> directions = sampleReplicates(Sampler::iid, kRays, 3, 0, 2);
  const double area = ids.areas[0] / (scene.scale * scene.scale);
  for (const PairCounts& counts : engine->countBlocks(directions, kRays)) {
    double rays = 0;
    for (const PairCount& pair : counts) {
      ASSERT_LT(pair.j, kEnvironment);
      rays += double(pair.count) * 2 * engine->unitArea() * 2 / area;  // a ray between two such faces adds half of one
    }
    // Each of 30 numbers is rounded to a unit, 2^-14 of a face.
    EXPECT_NEAR(rays, 6.0 * kRays, 30 * 0.5 * 4 * 0x1p-14);
  }
}

}  // namespace
}  // namespace viewpeel
