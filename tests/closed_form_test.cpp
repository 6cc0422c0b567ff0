// Whole estimates against closed forms.
#include <gtest/gtest.h>

#include "compare.h"
#include "scenes.h"
#include "test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

// Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11 and C-14, to ten digits.
constexpr double kParallelSquares = 0.1998248957, kPerpendicularSquares = 0.2000437761, kTenDigits = 5e-11;

// Both samplers, both engines, and a lattice so coarse that a square is only a few spacings wide: resolution costs variance, never bias.
std::vector<TestRun> runsToTry() {
  std::vector<TestRun> runs(4);
  runs[1].lattice.resolution = 6;
  runs[2].estimate.sampler = Sampler::iid;
  runs[3].make_engine = makeGraphicsEngine;
  runs[3].lattice.resolution = 24;
  return runs;
}

void expectFactor(const InputScene& scene, double truth) {
  for (const TestRun& run : runsToTry()) {
    const Estimate e = estimateScene(scene, run);
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 0)})
      EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(i, j), truth, e.replicates, kTenDigits))
          << scene.file << " F[" << i << "][" << j << "], resolution " << run.lattice.resolution << ", seed " << run.estimate.seed;
    EXPECT_LT(e.largest_standard_error, run.estimate.sampler == Sampler::iid ? 0.02 : 0.005);  // the comparison means something
  }
}

TEST(ClosedForm, ParallelSquares) { expectFactor(ts::parallelSquares(), kParallelSquares); }

TEST(ClosedForm, PerpendicularSquaresWithACommonEdge) { expectFactor(ts::perpendicularSquares(), kPerpendicularSquares); }

TEST(ClosedForm, EnvironmentTakesTheRest) {
  const Estimate e = estimateScene(ts::parallelSquares());
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, kEnvironment), 1 - kParallelSquares, e.replicates, kTenDigits));
}

TEST(ClosedForm, SixFacesOfACube) {
  for (const TestRun& run : runsToTry()) {
    const Estimate e = estimateScene(ts::insideOfCube(), run);
    for (uint32_t i = 0; i < 6; ++i)
      for (uint32_t j = 0; j < 6; ++j) {
        const double truth = i == j ? 0 : i / 2 == j / 2 ? kParallelSquares : kPerpendicularSquares;
        EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(i, j), truth, e.replicates, kTenDigits)) << "F[" << i << "][" << j << "]";
      }
  }
}

// The inner cube sees only the outer one; the outer one sees the inner one by the ratio of areas, and itself past it.
TEST(ClosedForm, CubeInsideALargerCube) {
  constexpr double kInner = 0.4;
  TestRun run;
  run.by = By::surface;
  const Estimate e = estimateScene(ts::cubeInCube(kInner), run);
  const double ratio = kInner * kInner;
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(1, 0), 1, e.replicates));
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 1), ratio, e.replicates));
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 0), 1 - ratio, e.replicates));
  EXPECT_EQ(e.form_factors.formFactor(1, 1).value, 0);
  EXPECT_EQ(e.form_factors.formFactor(0, kLeak).value, 0);
}

TEST(ClosedForm, TwoSidedPlatesShareWhatBothSidesEmit) {
  TestRun run;
  run.two_sided = true;
  const Estimate e = estimateScene(ts::parallelSquares(), run);
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 1), kParallelSquares / 2, e.replicates, kTenDigits));
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, kEnvironment), 1 - kParallelSquares / 2, e.replicates, kTenDigits));
}

TEST(ClosedForm, ComparisonRejectsAWrongFactor) {
  const Estimate e = estimateScene(ts::parallelSquares());
  const Measured f = e.form_factors.formFactor(0, 1);
  EXPECT_FALSE(isEstimateOf(f, kParallelSquares * 1.05, e.replicates, kTenDigits));
  EXPECT_FALSE(areEstimatesOfTheSame(f, {f.value * 0.9, f.standard_error}, e.replicates));
}

}  // namespace
}  // namespace viewpeel
