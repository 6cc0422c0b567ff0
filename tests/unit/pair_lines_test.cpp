// These tests compare the blockers found between two polygons with exact areas, and visibilities with integrals past
// one blocker. They also check that sums do not depend on threads, vector width or order.
#include <cmath>
#include <map>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "engines/lattice_options.h"
#include "pair_lines/pair_lines.h"
#include "scene/coincident.h"
#include "reference/closed_forms/past_blocker.h"
#include "reference/exact/exact_engine.h"
#include "scenes/exact_scenes.h"
#include "scenes/named_scenes.h"
#include "scenes/stress.h"
#include "directions/sampler.h"
#include "tests/support/face_pairs.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;
namespace rt = reference::test;
using test::sceneOf;

PatchPairs findAll(const PairFinder& finder) { return finder.find(1); }

// --- blockers -------------------------------------------------------------------------------------------------------

TEST(Blockers, AGridOfTilesIsOne) {
  const Scene scene = buildScene(ts::squaresInParts(6, 1, 1));
  ASSERT_EQ(scene.polygons.size(), 72u);
  const std::vector<Blocker> blockers = makeBlockers(scene);
  ASSERT_EQ(blockers.size(), 2u);
  for (const Blocker& blocker : blockers) EXPECT_EQ(blocker.corner_count, 4u);
  EXPECT_EQ(makeBlockers(scene, false).size(), 72u);
}

// Blockers cover the area that polygons cover: on each plane and level their areas have the same sum.
TEST(Blockers, CoverWhatPolygonsCover) {
  for (const stress::Kind kind : stress::kKinds)
    for (uint64_t seed = 0; seed < 5; ++seed) {
      const Scene scene = buildScene(stress::makeScene(kind, seed));
      std::map<std::pair<uint32_t, int>, double> areas;
      for (const Polygon& polygon : scene.polygons) areas[{polygon.plane, levelOf(polygon)}] += polygon.area;
      for (const Blocker& blocker : makeBlockers(scene)) {
        glm::dvec3 area(0);
        for (uint32_t k = 2; k < blocker.corner_count; ++k)
          area += glm::cross(blocker.corners[k - 1] - blocker.corners[0], blocker.corners[k] - blocker.corners[0]);
        areas[{blocker.plane, blocker.level}] -= glm::length(area) / 2;
      }
      for (const auto& [plane, left] : areas)
        EXPECT_NEAR(left, 0, 1e-12) << stress::nameOf(kind) << " " << seed << ", plane " << plane.first;
    }
}

// --- which blockers are between two polygons -------------------------------------------------------------------------

// Shafts agree with exact areas along directions: a pair that the finder leaves out is hidden, and a pair without
// blockers is never blocked. Blockers that reach less than kTouchingShaft into a shaft may be overlooked. They are
// strips of this width, and at most 2 long, the scene's diameter. A few of them change an area by some 1e-8.
TEST(PairFinder, ExactAreasAgreeWithWhatIsHiddenAndClear) {
  constexpr double kStrips = 1e-8;
  uint64_t scene_count = 0, pair_count = 0, clear_count = 0, hidden_count = 0;
  for (const stress::Kind kind : stress::kKinds)
    for (uint64_t seed = 0; seed < 12; ++seed) {
      const Scene scene = buildScene(stress::makeScene(kind, seed));
      const Ids ids = makeIds(scene, By::polygon, false);
      LatticeOptions options;
      options.count_blocked = true;
      const auto exact = reference::exactEngines()(scene, ids, options);
      const PairFinder finder(scene, ids);
      if (finder.hasUnordered()) {
        EXPECT_GT(scene.coincidences.in_doubt + scene.coincidences.alike_unordered, 0u);
        continue;
      }
      ++scene_count;
      std::map<std::pair<uint32_t, uint32_t>, bool> is_clear;  // by pair of faces; true if nothing blocks it
      for (const PatchPair& pair : findAll(finder).pairs) {
        const auto key = std::minmax(
            {ids.of_polygon[finder.patches()[pair.a].side / 2], ids.of_polygon[finder.patches()[pair.b].side / 2]});
        const auto at = is_clear.try_emplace(key, true).first;
        at->second = at->second && pair.blocker_count == 0;
      }
      for (const Direction& direction : sampleDirections(Sampler::iid, 12, 5, seed))
        for (const PairCount& count : exact->count({&direction, 1})) {
          if (count.j >= kEnvironment) continue;
          ++pair_count;
          const auto at = is_clear.find({count.i, count.j});
          const double facing = double(count.count) * exact->unitArea(),
                       blocked = double(count.blocked) * exact->unitArea();
          if (at == is_clear.end()) {
            ++hidden_count;
            EXPECT_LE(facing, kStrips) << stress::nameOf(kind) << " " << seed << ": " << ids.names[count.i] << " sees "
                                       << ids.names[count.j];
          } else if (at->second) {
            ++clear_count;
            EXPECT_LE(blocked, kStrips) << stress::nameOf(kind) << " " << seed << ": something is between "
                                        << ids.names[count.i] << " and " << ids.names[count.j];
          }
        }
    }
  EXPECT_GT(scene_count, 60u);
  EXPECT_GT(clear_count, 1000u);
  EXPECT_GT(hidden_count, 1000u);
  EXPECT_GT(pair_count, clear_count + hidden_count);
}

// Negative control of the test above: a plate that hides one square from the other is found, and so is one that hides
// half.
TEST(PairFinder, APlateIsSeen) {
  const rt::Corners floor = rt::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                    ceiling = rt::rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0}),
                    plate = rt::rectangle({-1, -1, 0.5}, {3, 0, 0}, {0, 3, 0}),
                    half = rt::rectangle({0.5, -1, 0.5}, {3, 0, 0}, {0, 3, 0});
  const auto between = [](const std::vector<rt::Corners>& faces) {
    const Scene scene = sceneOf(faces);
    const Ids ids = makeIds(scene, By::polygon, false);
    const PairFinder finder(scene, ids);
    int found = -1;
    for (const PatchPair& pair : findAll(finder).pairs)
      if (pair.a == 0 && pair.b == 1) found = static_cast<int>(pair.blocker_count);
    return found;
  };
  EXPECT_EQ(between({floor, ceiling}), 0);
  EXPECT_EQ(between({floor, ceiling, half}), 1);
  EXPECT_EQ(between({floor, ceiling, plate}), -1);
}

// --- lines -----------------------------------------------------------------------------------------------------------

// Returns the visibility between the first two faces and its standard error, from 16 scramblings of 2^14 lines each.
// mean_weight gets the mean weight of a line. A hidden pair leaves mean_weight as it is.
std::pair<double, double> visibilityOfLines(const std::vector<rt::Corners>& faces, LineWay way, double& mean_weight) {
  const Scene scene = sceneOf(faces);
  const Ids ids = makeIds(scene, By::polygon, false);
  const PairFinder finder(scene, ids);
  const PatchPairs found = findAll(finder);
  for (const PatchPair& pair : found.pairs) {
    if (pair.a != 0 || pair.b != 1) continue;
    const LineDrawer drawer(finder.patches()[0], finder.patches()[1], way, pair.exchange, finder.blockers(),
                            {found.between.data() + pair.first_blocker, pair.blocker_count});
    constexpr int kTimes = 16;
    double sum = 0, squares = 0, weight = 0;
    for (uint32_t k = 0; k < kTimes; ++k) {
      const DrawnLines lines =
          drawer.draw({77 * k + 1, 1234567 * k + 5, 999983 * k + 7, 31337 * k + 11}, 0, 1024, widestVectors());
      const double share = lines.facing / lines.all;
      sum += share, squares += share * share, weight += lines.all / double(lines.lines);
    }
    mean_weight = weight / kTimes;
    const double mean = sum / kTimes;
    return {mean, std::sqrt(std::max(0.0, squares / kTimes - mean * mean) / (kTimes - 1))};
  }
  return {0, 0};
}

// The visibility past one blocker is the quotient of two integrals, with and without the blocker. The tolerance is 6
// standard errors of 16 replicates, and 1e-5 for single precision. The mean weight (43) is 1 up to the error that 2^18
// lines leave; 0.03 is a coarse check of it, for weights of near polygons vary without bound.
TEST(DrawLines, VisibilityPastOneBlockerIsTheIntegral) {
  rt::Random random(7);
  int tried = 0;
  for (int trial = 0; trial < 120; ++trial) {
    const auto [a, b] = rt::randomPair(random);
    if (a.size() > 4 || b.size() > 4) continue;
    const glm::dvec3 middle = 0.5 * (a[0] + b[0]);
    const rt::Corners blocker = random.convexPolygon(middle, random.direction(), 4);
    const reference::Approximation past = reference::formFactorPastBlocker(a, b, blocker),
                                   clear = reference::formFactorPastBlocker(a, b, rt::moved(blocker, 1, {90, 0, 0}));
    if (!(clear.value > 1e-4)) continue;
    const double truth = past.value / clear.value;
    for (const LineWay way : {LineWay::points, LineWay::angles}) {
      SCOPED_TRACE(testing::Message() << "trial " << trial << (way == LineWay::points ? ", points" : ", angles"));
      double mean_weight = 0;
      const auto [visibility, error] = visibilityOfLines({a, b, blocker}, way, mean_weight);
      if (mean_weight == 0) {
        EXPECT_LE(truth, 1e-6);
        continue;
      }
      EXPECT_NEAR(visibility, truth, 6 * error + 1e-5);
      EXPECT_NEAR(mean_weight, 1, 0.03);
      ++tried;
    }
  }
  EXPECT_GE(tried, 20);
}

// Three corners of a wall lie on one line, but for the rounding of a file: the middle one lies 5e-8 before the plane.
// The triangle of these corners says nothing of the wall's normal.
TEST(DrawLines, ThreeCornersMayLieOnALine) {
  const rt::Corners wall = {{0, 0, 0}, {0.5, 0, 5e-8}, {0.7, 0, 0}, {0.7, 0.6, 0}},
                    other = rt::rectangle({0, 0, 0.5}, {0, 1, 0}, {1, 0, 0}),
                    blocker = rt::rectangle({0.3, 0.2, 0.2}, {0.3, 0, 0}, {0, 0.3, 0});
  for (const LineWay way : {LineWay::points, LineWay::angles}) {
    double mean_weight = 0;
    visibilityOfLines({wall, other, blocker}, way, mean_weight);
    EXPECT_NEAR(mean_weight, 1, 0.03) << (way == LineWay::points ? "points" : "angles");
  }
}

// Two squares touch along an edge. Weights of uniform points have infinite variance there, so lines are drawn by
// angles.
TEST(DrawLines, AnglesOfTouchingSquaresPastABlocker) {
  const rt::Corners floor = rt::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                    wall = rt::rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1}),
                    blocker = rt::rectangle({0.2, 0.3, 0.1}, {0.3, 0, 0.3}, {0, 0.5, 0});
  const reference::Approximation past = reference::formFactorPastBlocker(floor, wall, blocker);
  double mean_weight = 0;
  const auto [visibility, error] = visibilityOfLines({floor, wall, blocker}, LineWay::angles, mean_weight);
  EXPECT_NEAR(visibility, past.value / 0.2000437761, 6 * error + 1e-5);
  EXPECT_LT(error, 1e-3);
  EXPECT_NEAR(mean_weight, 1, 0.01);
}

TEST(DrawLines, AllVectorsGiveTheSameBits) {
  const Scene scene = buildScene(stress::makeScene(stress::Kind::boxes, 3));
  const Ids ids = makeIds(scene, By::polygon, false);
  const PairFinder finder(scene, ids);
  const PatchPairs found = findAll(finder);
  int compared = 0;
  for (const PatchPair& pair : found.pairs) {
    if (!pair.blocker_count) continue;
    for (const LineWay way : {LineWay::points, LineWay::angles}) {
      const LineDrawer drawer(finder.patches()[pair.a], finder.patches()[pair.b], way, pair.exchange, finder.blockers(),
                              {found.between.data() + pair.first_blocker, pair.blocker_count});
      const auto drawnBy = [&](Vectors vectors) { return drawer.draw({1, 2, 3, 4}, 3, 9, vectors); };
      const DrawnLines plain = drawnBy(Vectors::plain), widest = drawnBy(widestVectors());
      EXPECT_EQ(plain.facing, widest.facing);
      EXPECT_EQ(plain.all, widest.all);
      EXPECT_EQ(plain.squares, widest.squares);
      ++compared;
    }
  }
  EXPECT_GT(compared, 20);
}

// --- sums ------------------------------------------------------------------------------------------------------------

struct Street {
  Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  Ids ids = makeIds(scene, By::polygon, false);
  std::vector<LinePair> pairs;

  PairLines planned(size_t threads) {
    PairLines lines(scene, ids, {}, 5, threads);
    pairs = lines.find();
    lines.plan(
        pairs, [&](const LinePair& pair) { return 1e-3 * std::min(ids.areas[pair.i], ids.areas[pair.j]); }, 8);
    return lines;
  }
};

TEST(PairLines, ThreadsDoNotMatter) {
  Street one, three;
  PairLines of_one = one.planned(1), of_three = three.planned(3);
  ASSERT_EQ(one.pairs, three.pairs);
  EXPECT_EQ(of_one.count(one.pairs, 2), of_three.count(three.pairs, 2));
  EXPECT_FALSE(of_one.count(one.pairs, 2) == of_one.count(one.pairs, 3));
}

// Some pairs have lines in every replicate, others in one of several, and one has most of all lines.
TEST(PairLines, ReplicatesDrawnAtOnceAreTheSame) {
  Street street;
  PairLines lines = street.planned(3);
  const auto isRare = [](const LinePair& pair) { return pair.blocks && pair.period > 1; };
  const auto isFrequent = [](const LinePair& pair) { return pair.blocks && pair.period == 1; };
  ASSERT_TRUE(std::ranges::any_of(street.pairs, isRare) && std::ranges::any_of(street.pairs, isFrequent));
  // Threads share the replicates of a pair with so many lines.
  std::ranges::find_if(street.pairs, isFrequent)->blocks = kMostLineBlocks / 2;
  const std::vector<LineCounts> ahead = lines.countAhead(street.pairs, 3, 5);
  ASSERT_EQ(ahead.size(), 5u);
  for (size_t r = 0; r < ahead.size(); ++r) EXPECT_EQ(ahead[r], lines.count(street.pairs, 3 + r)) << r;
}

TEST(PairLines, AnotherPairChangesNone) {
  Street street;
  PairLines lines = street.planned(2);
  const LineCounts all = lines.count(street.pairs, 0);
  std::vector<LinePair> fewer = street.pairs;
  for (size_t k = 0; k < fewer.size(); k += 2) fewer[k].blocks = 0;
  std::map<uint32_t, LineCount> by_pair;
  for (const LineCount& count : all) by_pair[count.pair] = count;
  size_t compared = 0;
  for (const LineCount& count : lines.count(fewer, 0)) {
    EXPECT_TRUE(count == by_pair.at(count.pair));
    ++compared;
  }
  EXPECT_GT(compared, 50u);
}

TEST(LineSums, OrderOfReplicatesDoesNotMatter) {
  Street street;
  PairLines lines = street.planned(2);
  LineSums forwards(street.ids, By::polygon, street.pairs), first = forwards, second = forwards;
  for (uint64_t r = 0; r < 6; ++r) forwards.add(lines.count(street.pairs, r));
  for (const uint64_t r : {5, 1, 3}) first.add(lines.count(street.pairs, r));
  for (const uint64_t r : {4, 0, 2}) second.add(lines.count(street.pairs, r));
  second.add(first);
  EXPECT_EQ(forwards.sums(), second.sums());
  EXPECT_NE(forwards.sums(), first.sums());
}

// Sixteen lines that all arrive do not prove a visibility of 1. The variance counts half a line of the other kind.
TEST(LineSums, LinesThatAgreeHaveAnError) {
  LineSums::PairSum sum;
  LineSums::addTo(sum, {0, 1, uint32_t(kLineUnit), uint32_t(kLineUnit), 16 * 256});
  const Visibility visibility = visibilityOf(sum, 1);
  EXPECT_EQ(visibility.value, 1);
  // The value is the root of (46) and (47) in docs/method.md with n = 16: sqrt(0.5 * 16.5 / 17^3 + 0.25 / 17^2).
  EXPECT_NEAR(std::sqrt(visibility.variance), 0.05044, 1e-5);
}

// Lines of 3,000 pairs are far more even than by chance: of 16 lines 16 b are facing, rounded up or down at random.
// Half of the pairs have four replicates, half a single one, which has no spread. Errors in sums are the true ones, on
// the average, for both. A square error has 1.2 times its mean as standard deviation, so 1,500 of them average to 3 %.
// Three such errors meet here: of the truth, of the spread, and of the factor of all pairs; and the factor is drawn by
// 2 % towards 1. A quarter is 4.5 standard errors and this. Standard errors, which hold for one pair alone, are far
// larger.
TEST(LineSums, ErrorsInSumsAreTrueOnAverage) {
  constexpr uint32_t kPairs = 3000, kReplicates = 4;
  Ids ids;
  std::vector<LinePair> pairs;
  std::mt19937 random(7);
  const auto uniform = [&] { return std::uniform_real_distribution<double>()(random); };
  std::vector<double> truth;
  for (uint32_t k = 0; k <= kPairs; ++k) {
    ids.names.push_back(std::to_string(k));
    ids.areas.push_back(2);
    ids.surface.push_back(k);
  }
  for (uint32_t k = 0; k < kPairs; ++k) {
    LinePair& pair = pairs.emplace_back(LinePair{k, kPairs});
    pair.exchange = 1, pair.blocks = 1, pair.period = k % 2 ? kReplicates : 1;
    truth.push_back(uniform());
  }
  LineSums sums(ids, By::polygon, pairs);
  for (uint32_t r = 0; r < kReplicates; ++r) {
    LineCounts counts;
    for (uint32_t k = 0; k < kPairs; ++k)
      if (k % 2 == 0 || r == 0)
        counts.push_back({k, 1, uint32_t(kLineUnit / 16 * std::floor(16 * truth[k] + uniform())), uint32_t(kLineUnit),
                          16 * uint32_t(kEffectiveUnit)});
    sums.add(counts);
  }
  double squares[2] = {}, in_sums[2] = {}, alone[2] = {};
  const std::vector<FormFactors::Entry> entries = sums.entries();
  for (uint32_t k = 0; k < kPairs; ++k) {
    squares[k % 2] += std::pow(entries[k].exchange_area.value - truth[k], 2);
    in_sums[k % 2] += std::pow(entries[k].error_in_sums, 2);
    alone[k % 2] += std::pow(entries[k].exchange_area.standard_error, 2);
    EXPECT_LE(entries[k].error_in_sums, entries[k].exchange_area.standard_error);
  }
  for (const int half : {0, 1}) {
    EXPECT_NEAR(in_sums[half] / squares[half], 1, 0.25) << half;
    EXPECT_GT(alone[half], 2 * squares[half]);
  }
  // Sums between surfaces have the root of the sum of squares, and the largest margin of one pair.
  const std::vector<FormFactors::Entry> sum = mergeBySurface(entries, std::vector<uint32_t>(kPairs + 1, 0));
  ASSERT_EQ(sum.size(), 1u);
  EXPECT_NEAR(sum[0].error_in_sums, 2 * std::sqrt(in_sums[0] + in_sums[1]), 1e-12 * kPairs);
  double margin = 0;
  for (const FormFactors::Entry& entry : entries)
    margin = std::max(margin, std::pow(entry.exchange_area.standard_error, 2) - std::pow(entry.error_in_sums, 2));
  EXPECT_GT(margin, 0);
  EXPECT_NEAR(sum[0].exchange_area.standard_error, 2 * std::sqrt(in_sums[0] + in_sums[1] + margin), 1e-12 * kPairs);
}

// Lines of half the expected weight are missing. Nothing is known of them, so the standard error is at least m / 2 =
// 0.25, eq. (47), whatever the number of lines.
TEST(LineSums, MissingWeightIsUnknown) {
  LineSums::PairSum sum;
  for (int replicate = 0; replicate < 8; ++replicate)
    LineSums::addTo(sum, {0, 64, uint32_t(kLineUnit / 4), uint32_t(kLineUnit / 2), 1024 * 256});
  EXPECT_GE(std::sqrt(visibilityOf(sum, 64).variance), 0.25);
}

// Of 1,024 scrambled lines, 2 that are clear err as by chance. Half of them, an even share, err less: eq. (47).
TEST(LineSums, FewLinesOfAKindErrAsByChance) {
  const auto variancesWith = [](uint32_t clear) {
    LineSums::PairSum sum;
    LineSums::addTo(sum, {0, 64, uint32_t(kLineUnit / 1024) * clear, uint32_t(kLineUnit), 1024 * 256});
    return variancesOf(sum);
  };
  for (const uint32_t few : {0u, 2u, 1022u, 1024u})
    EXPECT_EQ(variancesWith(few).expected, variancesWith(few).by_chance) << few;
  // The half line of either kind changes 64 blocks by 1e-6 of them.
  EXPECT_NEAR(variancesWith(512).expected, std::pow(64, -0.25) * variancesWith(512).by_chance, 1e-9);
  EXPECT_NEAR(variancesWith(512).by_chance, 0.25 / 1025, 1e-9);
}

// A replicate of hardly any weight does not change the variance of the other two.
TEST(LineSums, ReplicatesCountByTheirWeight) {
  LineSums::PairSum two;
  LineSums::addTo(two, {0, 1, uint32_t(0.6 * kLineUnit), uint32_t(kLineUnit), 16 * 256});
  LineSums::addTo(two, {0, 1, uint32_t(0.4 * kLineUnit), uint32_t(kLineUnit), 16 * 256});
  LineSums::PairSum three = two;
  LineSums::addTo(three, {0, 0, 512, 1024, 4});
  // The third weight is about a thousandth of the others, so that the variance changes by some thousandths at most.
  EXPECT_NEAR(visibilityOf(three, 1).variance / visibilityOf(two, 1).variance, 1, 0.005);
}

// Where 16 lines reach the goal whatever the visibility is, the pair gets no pilot, and 16 lines once in 8 replicates.
// Other pairs may get more.
TEST(PairLines, SmallPairsGetSixteenLinesWithoutAPilot) {
  Street street;
  PairLines lines = street.planned(8);
  size_t small = 0;
  std::vector<LinePair> pairs = street.pairs;
  lines.plan(
      pairs, [](const LinePair& pair) { return 0.3 * (pair.exchange - pair.clear); }, 8);
  for (const LinePair& pair : pairs) {
    if (pair.blocks == 0) continue;
    EXPECT_EQ(pair.linesIn(8), 16) << pair.i << " " << pair.j;
    ++small;
  }
  EXPECT_GT(small, 1000u);
}

// A floor and a ceiling close above it meet above one line. Only lines near there have weights, so that sixteen lines
// by points say nothing: the pair has a pilot, which shows that weights are missing, and lines by angles.
TEST(PairLines, NearPairsHaveAPilot) {
  InputScene input{"floor and ceiling", {}, {}};
  ts::addFace(input, "floor", ts::parallelogram({0, 0, 0}, {40, 0, 0}, {0, 8, 0}));
  ts::addFace(input, "ceiling", ts::parallelogram({40, 0, 0.02}, {0, 8, 0}, {40, 0, 0}));
  ts::addFace(input, "blocker", ts::parallelogram({40, 2, 0.005}, {0, 1, 0}, {0, 0, 0.01}));
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  PairLines lines(scene, ids, {}, 1, 1);
  std::vector<LinePair> pairs = lines.find();
  const auto pair = std::ranges::find_if(pairs, [](const LinePair& of) { return of.i == 0 && of.j == 1; });
  ASSERT_NE(pair, pairs.end());
  ASSERT_FALSE(pair->by_angles);
  lines.plan(
      pairs, [](const LinePair& of) { return 0.35 * (of.exchange - of.clear); }, 8);
  EXPECT_TRUE(pair->by_angles);
  lines.plan(
      pairs, [](const LinePair& of) { return of.exchange - of.clear; }, 8);
  EXPECT_EQ(pair->linesIn(8), 16);  // no error is larger
}

}  // namespace
}  // namespace viewpeel
