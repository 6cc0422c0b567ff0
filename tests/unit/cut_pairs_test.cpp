// These tests compare what cutting proves of pairs, and lines between the parts, with integrals past one blocker. They
// also check that a stored plan gives the same parts again.
#include <cmath>
#include <utility>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "pair_lines/pair_lines.h"
#include "reference/closed_forms/past_blocker.h"
#include "scenes/exact_scenes.h"
#include "scenes/stress.h"
#include "tests/support/face_pairs.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace rt = reference::test;
using test::sceneOf;

// --- halves of patches ----------------------------------------------------------------------------------------------

// Returns how far a point lies beyond the farthest edge of a patch; at most 0 inside.
double beyondEdges(const Patch& patch, const glm::dvec3& point) {
  double beyond = -INFINITY;
  for (uint32_t e = 0; e < patch.corner_count; ++e)
    beyond = std::max(beyond, glm::dot(patch.edge_normals[e], point) - patch.edge_offsets[e]);
  return beyond;
}

// Two halves have the area of the whole, lie inside it, and overlap nowhere: the middle of one lies outside the other.
// Lengths are up to 1, so rounding is below 1e-14.
TEST(Patches, HalvesAreTheWhole) {
  constexpr double kRounding = 1e-14;
  rt::Random random(11);
  size_t triangles = 0, backs = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const auto [a, b] = rt::randomPair(random);
    const Scene scene = sceneOf({a, b});
    const Ids ids = makeIds(scene, By::polygon, true);
    for (const Patch& patch : makePatches(scene, ids, {})) {
      triangles += patch.corner_count == 3, backs += patch.side % 2;
      const auto [first, second] = halvesOf(patch);
      EXPECT_NEAR(first.area + second.area, patch.area, kRounding);
      EXPECT_EQ(std::pair(first.cut, second.cut), std::pair(2u, 3u));
      EXPECT_GT(beyondEdges(first, second.middle), 0);
      EXPECT_GT(beyondEdges(second, first.middle), 0);
      for (const Patch& half : {first, second}) {
        EXPECT_LT(beyondEdges(half, half.middle), 0);
        for (const glm::dvec3& corner : half.corners) EXPECT_LE(beyondEdges(patch, corner), kRounding);
      }
    }
  }
  EXPECT_GT(triangles, 20u);
  EXPECT_GT(backs, 20u);
}

// Eight halvings cut each of two ways in about four, so that lengths fall to 1/16. Halves of skew quadrilaterals may be
// as long as the whole, some times in a row, but not slivers for ever: a quarter is reached.
TEST(Patches, HalvesOfHalvesAreSmall) {
  rt::Random random(12);
  for (int trial = 0; trial < 20; ++trial) {
    const auto [a, b] = rt::randomPair(random);
    const Scene scene = sceneOf({a, b});
    for (const Patch& whole : makePatches(scene, makeIds(scene, By::polygon, false), {})) {
      std::vector<Patch> parts{whole};
      for (int times = 0; times < 8; ++times) {
        std::vector<Patch> halves;
        for (const Patch& part : parts)
          for (const Patch& half : halvesOf(part)) halves.push_back(half);
        parts = std::move(halves);
      }
      for (const Patch& part : parts) EXPECT_LT(lengthOf(part), 0.25 * lengthOf(whole));
    }
  }
}

// --- pairs past one blocker -----------------------------------------------------------------------------------------

struct PastBlocker {
  Scene scene;
  Ids ids;
  double truth;  // exchange area, input units squared
  double error;  // bound on its error
};

// Returns pairs of which one blocker hides a part.
std::vector<PastBlocker> pairsPastBlockers() {
  std::vector<PastBlocker> found;
  rt::Random random(7);
  for (int trial = 0; trial < 160; ++trial) {
    const auto [a, b] = rt::randomPair(random);
    if (a.size() > 4 || b.size() > 4) continue;
    const rt::Corners blocker = random.convexPolygon(0.5 * (a[0] + b[0]), random.direction(), 4);
    const double past = reference::formFactorPastBlocker(a, b, blocker).value,
                 clear = reference::formFactorPastBlocker(a, b, rt::moved(blocker, 1, {90, 0, 0})).value;
    if (!(past < 0.98 * clear && past > 0.02 * clear)) continue;
    Scene scene = sceneOf({a, b, blocker});
    Ids ids = makeIds(scene, By::polygon, false);
    const double area = ids.areas[0];
    found.push_back({std::move(scene), std::move(ids), past * area, reference::kPastBlockerError * area});
  }
  return found;
}

size_t firstPairOf(const std::vector<LinePair>& pairs) {
  for (size_t k = 0; k < pairs.size(); ++k)
    if (pairs[k].i == 0 && pairs[k].j == 1) return k;
  ADD_FAILURE() << "the first two faces are no pair";
  return 0;
}

// Cuts the first two faces' pair and returns it.
LinePair cutPair(const PastBlocker& of, uint32_t cuts) {
  PairLines lines(of.scene, of.ids, {}, 1, 1);
  std::vector<LinePair> pairs = lines.find();
  LinePair& pair = pairs[firstPairOf(pairs)];
  pair.cuts = cuts;
  lines.cut(pairs);
  return pair;
}

// What is clear of blockers is below the exchange area, and what is not hidden is above it. More cuts bring the two
// nearer to each other. Blockers that reach less than kTouchingShaft into a shaft may be overlooked: strips of this
// width, of which a few change the area by 1e-8 in units of the radius squared (see pair_lines_test.cpp).
TEST(CutPairs, BoundsEncloseTheIntegral) {
  double widths = 0, cut_widths = 0;
  size_t wrong_enclosed = 0;
  const std::vector<PastBlocker> all = pairsPastBlockers();
  ASSERT_GE(all.size(), 20u);
  for (const PastBlocker& of : all) {
    const double allowed = of.error + 1e-8 * of.scene.scale * of.scene.scale;
    double width = INFINITY;
    for (const uint32_t cuts : {0u, 1u, 20u, 300u}) {
      const LinePair pair = cutPair(of, cuts);
      EXPECT_LE(pair.clear, of.truth + pair.error + allowed) << cuts;
      EXPECT_GE(pair.exchange, of.truth - pair.error - allowed) << cuts;
      EXPECT_LE(pair.exchange - pair.clear, width + 1e-12);
      width = pair.exchange - pair.clear;
      if (cuts == 0) widths += width;
      if (cuts < 300) continue;
      cut_widths += width;
      // Negative control: of two values near the ends of what the whole pair allows, one is outside.
      const LinePair whole = cutPair(of, 0);
      for (const double share : {0.1, 0.9}) {
        const double wrong = std::lerp(whole.clear, whole.exchange, share);
        wrong_enclosed += pair.clear <= wrong && wrong <= pair.exchange;
      }
    }
  }
  // Lines have four coordinates, which 300 cuts divide in about four each. The lines that pass an edge of the blocker
  // are a surface of three dimensions, in some 2 x 4^3 of the 4^4 parts.
  EXPECT_LT(cut_widths, 0.75 * widths);
  EXPECT_LT(wrong_enclosed, all.size());
}

// Lines between the parts have the integral as their mean. Each of some 20 values may err by 6 of its standard errors.
// Where parts need no fewer lines than the whole pair, it stays whole.
TEST(CutPairs, LinesOfPartsGiveTheIntegral) {
  size_t cut = 0, all = 0;
  for (const PastBlocker& of : pairsPastBlockers()) {
    PairLines lines(of.scene, of.ids, {}, 3, 1);
    std::vector<LinePair> pairs = lines.find();
    const size_t k = firstPairOf(pairs);
    const auto allowed = [&](const LinePair& pair) { return 1e-4 * pair.exchange; };
    lines.plan(pairs, allowed, 8);
    const double whole = pairs[k].linesIn(8);
    lines.cutAndPlan(pairs, allowed, 8);
    ++all;
    cut += pairs[k].cuts > 0;
    EXPECT_TRUE(pairs[k].linesIn(8) < whole || (pairs[k].cuts == 0 && pairs[k].linesIn(8) == whole))
        << pairs[k].linesIn(8) << ", whole " << whole;
    LineSums sums(of.ids, By::polygon, pairs);
    for (uint64_t replicate = 0; replicate < 8; ++replicate) sums.add(lines.count(pairs, replicate));
    const Measured found = sums.exchangeArea(k);
    EXPECT_LT(found.standard_error, 1e-3 * of.truth + pairs[k].error);
    EXPECT_NEAR(found.value, of.truth, 6 * found.standard_error + of.error);
  }
  EXPECT_GT(cut, 0u);
  EXPECT_LT(cut, all);
}

// --- plans ----------------------------------------------------------------------------------------------------------

struct Street {
  Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  Ids ids = makeIds(scene, By::polygon, false);
  std::vector<LinePair> pairs;

  LeakingFaces allLeak() const { return {std::vector<bool>(ids.count(), true)}; }
  PairLines planned(size_t threads, double tolerance) {
    PairLines lines(scene, ids, allLeak(), 5, threads);
    pairs = lines.find();
    const auto allowed = [&](const LinePair& pair) { return tolerance * ids.areas[pair.i]; };
    lines.plan(pairs, allowed, 8);
    lines.cutAndPlan(pairs, allowed, 8);
    return lines;
  }
  size_t cutCount() const {
    return static_cast<size_t>(std::ranges::count_if(pairs, [](const LinePair& pair) { return pair.cuts > 0; }));
  }
};

TEST(CutPairs, ThreadsDoNotMatter) {
  Street one, three;
  PairLines lines_one = one.planned(1, 3e-5), lines_three = three.planned(3, 3e-5);
  EXPECT_GT(one.cutCount(), 20u);
  EXPECT_EQ(one.pairs, three.pairs);
  EXPECT_EQ(lines_one.count(one.pairs, 3), lines_three.count(three.pairs, 3));
}

// Pairs with few lines are not worth a cut.
TEST(CutPairs, FewLinesAreNotCut) {
  Street street;
  street.planned(1, 0.05);
  EXPECT_EQ(street.cutCount(), 0u);
}

// A run that is continued has the pairs of its checkpoint. They give the parts, and so the lines, of the first run.
// A second call changes nothing.
TEST(CutPairs, AStoredPlanGivesTheSameLines) {
  Street street;
  PairLines first = street.planned(1, 1e-4), second(street.scene, street.ids, street.allLeak(), 5, 2);
  second.find();
  std::vector<LinePair> stored = street.pairs;
  for (int times = 0; times < 2; ++times) {
    second.cut(stored);
    EXPECT_EQ(stored, street.pairs);
    EXPECT_EQ(first.count(street.pairs, 2), second.count(stored, 2));
  }
  // Negative control: without the cuts lines differ.
  PairLines uncut(street.scene, street.ids, street.allLeak(), 5, 1);
  std::vector<LinePair> pairs = uncut.find();
  for (size_t k = 0; k < pairs.size(); ++k) pairs[k].blocks = street.pairs[k].blocks;
  EXPECT_NE(first.count(street.pairs, 2), uncut.count(pairs, 2));
}

}  // namespace
}  // namespace viewpeel
