#include "reference/exact/projected_estimate.h"

#include <viewpeel/error.h>
#include "reference/closed_forms/contour_integral.h"
#include "reference/exact/exact_pair_areas.h"
#include "tests/support/reference_shapes.h"
#include "scenes/named_scenes.h"

namespace viewpeel::reference {
namespace {

using test::Corners;
using test::isEstimateOf;
using test::rectangle;

constexpr uint64_t kDirections = 40'000;

// The 30 comparisons allow 4.5 standard errors: a false alarm in 5,000 choices of the seed. Pairs so small that fewer
// than 100 directions count are left out, for their mean is not normal.
TEST(ProjectedEstimate, RandomPairsAgreeWithContourIntegral) {
  test::Random random(21);
  int compared = 0;
  for (int trial = 0; compared < 30; ++trial) {
    const auto [a, b] = test::randomPair(random);
    const double truth = formFactor(a, b);
    if (truth < 0.01) continue;
    ++compared;
    const ProjectedEstimate estimate = estimateFormFactor(a, b, kDirections, 100 + (uint64_t)trial);
    EXPECT_TRUE(isEstimateOf(estimate.value, estimate.standard_error, truth, kContourError))
        << "trial " << trial << ", seed " << 100 + trial;
    EXPECT_LE(estimate.standard_error, 0.798 / std::sqrt((double)kDirections) * 1.1) << "trial " << trial;
    EXPECT_FALSE(isEstimateOf(estimate.value, estimate.standard_error, truth + 10 * estimate.standard_error))
        << "trial " << trial;
  }
}

// The area along one direction is exact. Rounding moves the boundary of a region by some 1e-15 of the unit ball. Its
// area changes by at most that times its perimeter, 6.3.
TEST(ProjectedPair, OneDirectionIsTheExactArea) {
  InputScene slanted{"slanted", {}, {}};
  test_scenes::addFace(slanted, "a", {{0, 0, 0}, {1, 0.1, 0}, {0.2, 0.9, 0.3}});
  test_scenes::addFace(slanted, "b", {{0, 0, 1}, {0.3, 1, 1.4}, {1.1, 0.2, 0.7}});
  test::Random random(3);
  int seen = 0;
  for (const InputScene& input : {test_scenes::parallelSquares(), test_scenes::perpendicularSquares(), slanted}) {
    const Scene scene = buildScene(input);
    const ProjectedPair pair(input.faces[0].corners, input.faces[1].corners);
    for (int trial = 0; trial < 50; ++trial) {
      const glm::dvec3 u = random.direction();
      double exact = 0;
      for (const PairArea& area : computeExactPairAreas(scene, u).pairs)
        if (area.a == 0 && area.b == 1) exact = 2 * area.area / scene.polygons[0].area;
      EXPECT_TRUE(test::isWithin(pair.zeta(u), exact, 2 * 1e-14 / scene.polygons[0].area))
          << input.file << ", trial " << trial;
      EXPECT_EQ(pair.zeta(u) > 0, exact > 0) << input.file << ", trial " << trial;
      seen += exact > 0;
    }
  }
  EXPECT_GT(seen, 30);  // enough directions see the pair
}

TEST(ProjectedEstimate, PublishedValues) {
  const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  const Corners ceiling = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
  const ProjectedEstimate to_ceiling = estimateFormFactor(floor, ceiling, 200'000, 1),
                          to_wall = estimateFormFactor(floor, wall, 200'000, 2);
  EXPECT_TRUE(isEstimateOf(to_ceiling.value, to_ceiling.standard_error, 0.1998248957, 5e-11));
  EXPECT_TRUE(isEstimateOf(to_wall.value, to_wall.standard_error, 0.2000437761, 5e-11));
  EXPECT_LT(to_wall.standard_error, 1.5e-3);  // the comparison is not too weak
}

TEST(ProjectedEstimate, SpreadIsTheStandardError) {
  const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  double squares = 0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    const ProjectedEstimate estimate = estimateFormFactor(floor, wall, 200, 1000 + (uint64_t)run);
    const double z = (estimate.value - 0.2000437761) / estimate.standard_error;
    squares += z * z;
  }
  // The mean of kRuns squares of nearly normal numbers is 1 with a standard deviation of sqrt(2 / kRuns) = 0.07. The
  // tolerance is 4.5 of them.
  EXPECT_TRUE(test::isWithin(squares / kRuns, 1, 4.5 * std::sqrt(2.0 / kRuns)));
}

TEST(ProjectedEstimate, BacksSeeNothingAndSeedsRepeat) {
  const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                ceiling = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
  EXPECT_EQ(estimateFormFactor(floor, test::flipped(ceiling), 1000, 1).value, 0);
  EXPECT_EQ(estimateFormFactor(floor, ceiling, 1000, 7).value, estimateFormFactor(floor, ceiling, 1000, 7).value);
  EXPECT_NE(estimateFormFactor(floor, ceiling, 1000, 7).value, estimateFormFactor(floor, ceiling, 1000, 8).value);
  EXPECT_THROW(estimateFormFactor(floor, ceiling, 1, 1), Error);
}

}  // namespace
}  // namespace viewpeel::reference
