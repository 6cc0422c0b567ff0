// These tests compare whole estimates with closed forms.
#include <gtest/gtest.h>

#include "tests/support/compare.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

// The values are C-11 and C-14 of Howell, A Catalog of Radiation Heat Transfer Configuration Factors, to ten digits.
constexpr double kParallelSquares = 0.1998248957, kPerpendicularSquares = 0.2000437761, kTenDigits = 5e-11;

// Returns runs with several engines, samplers and samplings. On the coarsest lattice a square is only a few spacings
// wide: a coarse lattice adds variance, never bias.
std::vector<TestRun> runsToTry() {
  std::vector<TestRun> runs(8);
  runs[1].lattice.resolution = 6;
  runs[2].estimate.sampler = Sampler::iid;
  runs[3].engine = EngineKind::graphics;
  runs[3].lattice.resolution = 24;
  runs[4].lattice.sampling = Sampling::scanline;
  runs[6].estimate.sampler = Sampler::jittered;
  runs[7].estimate.sampler = Sampler::sobol;
  runs[5].lattice = {.resolution = 6, .sampling = Sampling::scanline};
  return runs;
}

void expectFactor(const InputScene& scene, double truth) {
  for (const TestRun& run : runsToTry()) {
    const Estimate e = estimateScene(scene, run);
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 0)})
      EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(i, j), truth, e.replicates, kTenDigits))
          << scene.file << " F[" << i << "][" << j << "], resolution " << run.lattice.resolution << ", seed "
          << run.estimate.seed;
    EXPECT_LT(e.largest_standard_error,
              run.estimate.sampler == Sampler::iid ? 0.02 : 0.005);  // the comparison is not too weak
  }
}

TEST(ClosedForm, ParallelSquares) { expectFactor(ts::parallelSquares(), kParallelSquares); }

TEST(ClosedForm, PerpendicularSquaresWithACommonEdge) {
  expectFactor(ts::perpendicularSquares(), kPerpendicularSquares);
}

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
        EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(i, j), truth, e.replicates, kTenDigits))
            << "F[" << i << "][" << j << "]";
      }
  }
}

// The inner cube sees only the outer one. The outer cube sees the inner one by the ratio of areas, and itself with the
// rest.
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
  EXPECT_TRUE(
      isEstimateOf(e.form_factors.formFactor(0, kEnvironment), 1 - kParallelSquares / 2, e.replicates, kTenDigits));
}

Estimate estimateDrawn(const InputScene& input, const Question& question, const LatticeOptions& lattice,
                       By by = By::polygon) {
  const Scene scene = buildScene(input);
  Ids ids = makeIds(scene, by, false);
  restrictToQuestion(question, scene, ids);
  EstimateOptions options{.directions = 100, .replicates = 16};
  if (!question.pair.empty()) {
    const DirectionRegion region =
        findPairRegion(scene, findPolygons(scene, question.pair[0]), findPolygons(scene, question.pair[1]));
    options.drawn_directions = [=](uint32_t count, uint64_t replicate) {
      return sampleRegion(region, count, 7, replicate);
    };
  } else {
    const std::vector<uint32_t> emitter = findPolygons(scene, question.from.at(0));
    options.drawn_directions = [=](uint32_t count, uint64_t replicate) {
      return sampleEmitter(scene, emitter, count, 7, replicate);
    };
  }
  return estimateFormFactors(*makeComputeEngine(testDevice(), scene, ids, lattice), scene, ids, options);
}

// Directions from the region of one pair, or by the emitter's cosine, give unbiased form factors. Their error is
// smaller than with the same number of directions over the sphere.
TEST(ClosedForm, DirectionsDrawnForAPairOrAnEmitter) {
  TestRun whole;
  whole.estimate.directions = 100;
  whole.lattice.resolution = 128;
  for (const auto& [scene, truth] : {std::pair(ts::parallelSquares(), kParallelSquares),
                                     std::pair(ts::perpendicularSquares(), kPerpendicularSquares)}) {
    const Measured all = estimateScene(scene, whole).form_factors.formFactor(0, 1);
    for (Sampling sampling : {Sampling::lattice, Sampling::scanline}) {
      const LatticeOptions lattice{.resolution = 128, .sampling = sampling};
      const Estimate pair = estimateDrawn(scene, {.pair = {scene.surface_names[0], scene.surface_names[1]}}, lattice);
      const Estimate row = estimateDrawn(scene, {.from = {scene.surface_names[1]}}, lattice);
      EXPECT_TRUE(isEstimateOf(pair.form_factors.formFactor(0, 1), truth, pair.replicates, kTenDigits)) << scene.file;
      EXPECT_TRUE(isEstimateOf(row.form_factors.formFactor(1, 0), truth, row.replicates, kTenDigits)) << scene.file;
      EXPECT_TRUE(isEstimateOf(row.form_factors.formFactor(1, kEnvironment), 1 - truth, row.replicates, kTenDigits))
          << scene.file;
      EXPECT_LT(pair.form_factors.formFactor(0, 1).standard_error, all.standard_error / 2) << scene.file;
      EXPECT_EQ(pair.form_factors.entries().size(), 1u);
    }
  }
}

// The outer cube has a row, and the inner cube blocks lines without a row of its own.
TEST(ClosedForm, BlockersTakeWhatTheyHide) {
  const InputScene scene = ts::cubeInCube(0.4);
  const Estimate e = estimateDrawn(scene, {.from = {"outer"}, .blockers = {"inner"}}, {}, By::surface);
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 0), 1 - 0.16, e.replicates));
  EXPECT_EQ(e.form_factors.entries().size(), 1u);
}

// A question may name one face of a surface if rows are polygons, but not if rows are surfaces.
TEST(ClosedForm, AFaceOfASurface) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  Ids ids = makeIds(scene, By::polygon, false);
  restrictToQuestion({.from = {"floor[3]"}}, scene, ids);
  EXPECT_TRUE(ids.splits_surfaces);
  Ids by_surface = makeIds(scene, By::surface, false);
  for (const Question& question : {Question{.from = {"floor[3]"}}, Question{.blockers = {"floor[3]"}},
                                   Question{.pair = {"floor[3]", "upper box"}}}) {
    try {
      restrictToQuestion(question, scene, by_surface);
      ADD_FAILURE() << "accepted";
    } catch (const std::exception& error) {
      EXPECT_NE(std::string(error.what()).find("--by polygon"), std::string::npos) << error.what();
    }
  }
}

TEST(ClosedForm, ComparisonRejectsAWrongFactor) {
  const Estimate e = estimateScene(ts::parallelSquares());
  const Measured f = e.form_factors.formFactor(0, 1);
  EXPECT_FALSE(isEstimateOf(f, kParallelSquares * 1.05, e.replicates, kTenDigits));
  EXPECT_FALSE(areEstimatesOfTheSame(f, {f.value * 0.9, f.standard_error}, e.replicates));
}

}  // namespace
}  // namespace viewpeel
