// These tests check laws that hold for every scene: reciprocity, closure, rigid motion, scale, order of corners,
// subdivision, and equal bits for equal seeds.
#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/same_bits.h"
#include "tests/support/compare.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

TEST(Laws, ReciprocityToTheLastBit) {
  const Estimate e = estimateScene(ts::roomWithTouchingBoxes());
  const FormFactors& f = e.form_factors;
  const auto& areas = f.ids().areas;
  ASSERT_FALSE(f.entries().empty());
  for (uint32_t i = 0; i < f.ids().count(); ++i)
    for (uint32_t j = 0; j < f.ids().count(); ++j) {
      EXPECT_EQ(f.exchangeArea(i, j).value, f.exchangeArea(j, i).value);
      // A form factor is this exchange area over the row's area, rounded once.
      EXPECT_EQ(f.formFactor(i, j).value, f.exchangeArea(j, i).value / areas[i]);
    }
}

// Returns a bound on the exchange area that is lost in cracks. A corner in the middle of another edge is snapped off it
// by at most 2^-24 of the scene's diameter. The area of the crack is below this distance times its length. A_i F_i,leak
// is twice the mean area in which i meets a back.
double mostLost(const InputScene& scene) {
  double edges = 0;
  for (const InputFace& face : scene.faces)
    for (size_t k = 0; k < face.corners.size(); ++k)
      edges += glm::length(face.corners[(k + 1) % face.corners.size()] - face.corners[k]);
  return 2 * edges * 0x1p-24 * 2 * buildScene(scene).scale;
}

double exchangeOfAll(const FormFactors& form_factors, uint32_t with) {
  double sum = 0;
  for (uint32_t i = 0; i < form_factors.ids().count(); ++i) sum += form_factors.exchangeArea(i, with).value;
  return sum;
}

// Closed scenes have neither leak nor environment, and rows sum to 1. No lattice point falls into a crack here. The
// ends of scanlines may, in the scene with T-junctions.
TEST(Laws, ClosedSceneClosesAndDoesNotLeak) {
  for (const InputScene& scene : {ts::insideOfCube(), ts::cubeInCube(0.3), ts::roomWithTouchingBoxes()})
    for (const TestRun& run : withEngines()) {
      SCOPED_TRACE(fmt::format("{}, {}", scene.file, run.name));
      const Estimate e = estimateScene(scene, run);
      const double most = run.lattice.sampling == Sampling::scanline && scene.faces.size() > 12 ? mostLost(scene) : 0;
      EXPECT_LE(exchangeOfAll(e.form_factors, kLeak), most);
      EXPECT_LE(exchangeOfAll(e.form_factors, kEnvironment), most);
      for (uint32_t i = 0; i < e.form_factors.ids().count(); ++i)
        EXPECT_TRUE(isEstimateOf(e.form_factors.rowSums()[i], 1, e.replicates)) << " row " << i;
    }
}

TEST(Laws, OfficeClosesAndDoesNotLeak) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/office.obj");
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeComputeEngine(testDevice(), scene, ids, {.resolution = 96});
  const Estimate e = estimateFormFactors(*engine, scene, ids, {.directions = 150, .replicates = 8});
  for (uint32_t i = 0; i < ids.count(); ++i) {
    EXPECT_EQ(e.form_factors.formFactor(i, kLeak).value, 0) << ids.names[i];
    EXPECT_EQ(e.form_factors.formFactor(i, kEnvironment).value, 0) << ids.names[i];
    EXPECT_TRUE(isEstimateOf(e.form_factors.rowSums()[i], 1, e.replicates)) << ids.names[i];
  }
}

// Expects that two estimates of one matrix agree in all entries.
void expectSame(const Estimate& a, const Estimate& b, const std::string& what) {
  ASSERT_EQ(a.form_factors.ids().count(), b.form_factors.ids().count());
  uint64_t compared = 0;
  for (uint32_t i = 0; i < a.form_factors.ids().count(); ++i)
    for (uint32_t j = 0; j < a.form_factors.ids().count(); ++j, ++compared)
      EXPECT_TRUE(areEstimatesOfTheSame(a.form_factors.formFactor(i, j), b.form_factors.formFactor(i, j), a.replicates))
          << what << ": F[" << i << "][" << j << "]";
  EXPECT_GT(compared, 0u);
}

TEST(Laws, RigidMotionAndScaleLeaveFactorsAlone) {
  const InputScene scene = ts::cubeInCube(0.5);
  const Estimate expected = estimateScene(scene);
  const double c = std::cos(0.7), s = std::sin(0.7), d = std::cos(-1.1), t = std::sin(-1.1);
  const glm::dmat3 turn = glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1) * glm::dmat3(1, 0, 0, 0, d, t, 0, -t, d);
  for (TestRun other : withEngines()) {
    SCOPED_TRACE(other.name);
    other.estimate.seed = 2;
    expectSame(expected, estimateScene(ts::transformed(scene, turn, 1, {100, -20, 3}), other), "turned and moved");
    expectSame(expected, estimateScene(ts::transformed(scene, glm::dmat3(1), 1e-6, {0, 0, 0}), other),
               "scaled by 1e-6");
    expectSame(expected, estimateScene(ts::transformed(scene, turn, 1e6, {1e6, 0, 0}), other), "scaled by 1e6");
    expectSame(expected, estimateScene(ts::transformed(scene, turn, 1e-12, {0, 0, 0}), other), "scaled by 1e-12");
    expectSame(expected, estimateScene(ts::transformed(scene, turn, 1e12, {0, 0, 0}), other), "scaled by 1e12");
  }
}

// The scene is moved so far that coordinates are rounded to 1.5e-8 of its size. This is more than planes may differ to
// count as one. Form factors stay the same, no line is lost, and a warning names planes in doubt.
TEST(Laws, MovedFarAwayFactorsStay) {
  TestRun run;
  run.estimate.directions = 150;
  const double c = std::cos(0.7), s = std::sin(0.7);
  const glm::dmat3 turn(c, s, 0, -s, c, 0, 0, 0, 1);
  for (const InputScene& scene : {ts::cubeInCube(0.5), ts::transformed(ts::cubeInCube(0.5), turn, 1, {0, 0, 0})}) {
    const InputScene moved = ts::transformed(scene, glm::dmat3(1), 1, {1e8, -1e8, 1e8});
    const Estimate expected = estimateScene(scene, run);
    for (TestRun other : withEngines(run)) {
      SCOPED_TRACE(other.name);
      other.estimate.seed = 2;
      const Estimate found = estimateScene(moved, other);
      expectSame(expected, found, "moved by 1e8");
      for (uint32_t i = 0; i < 12; ++i) EXPECT_EQ(found.form_factors.formFactor(i, kLeak).value, 0) << i;
    }
  }
}

TEST(Laws, ReflectionLeavesFactorsAlone) {
  const InputScene scene = ts::roomWithTouchingBoxes();
  InputScene mirrored = ts::transformed(scene, glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), 1, {0, 0, 0});
  for (InputFace& face : mirrored.faces)
    std::reverse(face.corners.begin(), face.corners.end());  // mirroring turns fronts into backs
  TestRun run;
  run.estimate.directions = 150;
  const Estimate expected = estimateScene(scene, run);
  for (TestRun other : withEngines(run)) {
    SCOPED_TRACE(other.name);
    other.estimate.seed = 2;
    expectSame(expected, estimateScene(mirrored, other), "mirrored");
  }
}

// The order of polygons decides ties only. There is no tie here, so counts have the same bits.
TEST(Laws, OrderOfPolygonsDoesNotMatter) {
  const InputScene scene = ts::cubeInCube(0.5);
  InputScene reversed{"reversed", {}, {}};
  for (auto face = scene.faces.rbegin(); face != scene.faces.rend(); ++face)
    ts::addFace(reversed, scene.surface_names[face->surface], face->corners);
  const auto last = static_cast<uint32_t>(scene.faces.size() - 1);
  for (TestRun run : withEngines()) {
    run.estimate.directions = 150;
    const Estimate a = estimateScene(scene, run), b = estimateScene(reversed, run);
    for (uint32_t i = 0; i <= last; ++i)
      for (uint32_t j = 0; j <= last; ++j)
        EXPECT_EQ(a.form_factors.exchangeArea(i, j).value, b.form_factors.exchangeArea(last - i, last - j).value)
            << run.name << ": " << i << ", " << j;
  }
}

// Each quadrilateral is cut into 3 x 5. Form factors between surfaces stay.
TEST(Laws, SubdivisionLeavesFactorsBetweenSurfacesAlone) {
  const InputScene scene = ts::roomWithTouchingBoxes();
  InputScene fine{"fine", scene.surface_names, {}};
  for (const InputFace& face : scene.faces)
    for (int x = 0; x < 3; ++x)
      for (int y = 0; y < 5; ++y) {
        const auto at = [&](double s, double t) {
          return face.corners[0] + s / 3 * (face.corners[1] - face.corners[0]) +
                 t / 5 * (face.corners[3] - face.corners[0]);
        };
        fine.faces.push_back({{at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)}, face.surface, 0});
      }
  TestRun run;
  run.estimate.directions = 150;
  run.by = By::surface;
  const Estimate expected = estimateScene(scene, run);
  for (TestRun other : withEngines(run)) {
    SCOPED_TRACE(other.name);
    other.estimate.seed = 2;
    const Estimate found = estimateScene(fine, other);
    expectSame(expected, found, "subdivided");
    EXPECT_LE(exchangeOfAll(found.form_factors, kLeak), mostLost(fine));
  }
}

TEST(Laws, ComparisonOfMatricesRejectsAnotherScene) {
  const Estimate a = estimateScene(ts::cubeInCube(0.5)), b = estimateScene(ts::cubeInCube(0.52));
  int rejected = 0;
  for (uint32_t i = 0; i < 12; ++i)
    for (uint32_t j = 0; j < 12; ++j)
      rejected +=
          !areEstimatesOfTheSame(a.form_factors.formFactor(i, j), b.form_factors.formFactor(i, j), a.replicates);
  EXPECT_GT(rejected, 0);
}

// It does not matter with which corner a polygon starts: the same points are snapped and the same plane is found.
TEST(Laws, FirstCornerDoesNotMatter) {
  InputScene scene = ts::insideOfCube();
  const Estimate a = estimateScene(scene);
  for (InputFace& face : scene.faces) std::rotate(face.corners.begin(), face.corners.begin() + 1, face.corners.end());
  const Estimate b = estimateScene(scene);
  expectSameBits(a.form_factors, b.form_factors);
}

TEST(Laws, SplittingAPolygonLeavesSumsAlone) {
  const InputScene whole = ts::perpendicularSquares();
  InputScene split{"split", {}, {}};
  ts::addFace(split, "floor", {{0, 0, 0}, {0.3, 0, 0}, {0.6, 1, 0}, {0, 1, 0}});
  ts::addFace(split, "floor", {{0.3, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.6, 1, 0}});
  split.surface_names.push_back("wall");
  split.faces.push_back({whole.faces[1].corners, 1, 0});
  TestRun run;
  run.estimate.seed = 5;
  const Estimate a = estimateScene(whole), b = estimateScene(split, run);
  EXPECT_TRUE(
      areEstimatesOfTheSame(a.between_surfaces.formFactor(0, 1), b.between_surfaces.formFactor(0, 1), a.replicates));
  // By polygon, the wall's form factors to the two pieces add up to its form factor to the floor, for they are the same
  // counts.
  EXPECT_NEAR(b.form_factors.formFactor(2, 0).value + b.form_factors.formFactor(2, 1).value,
              b.between_surfaces.formFactor(1, 0).value, 4e-16);
}

TEST(Laws, SameSeedSameBitsWhateverTheBatch) {
  TestRun run, small_batches;
  run.estimate.directions = small_batches.estimate.directions = 60;
  small_batches.lattice.batch_directions = 7;
  expectSameBits(estimateScene(ts::roomWithTouchingBoxes(), run).form_factors,
                 estimateScene(ts::roomWithTouchingBoxes(), small_batches).form_factors);
}

TEST(Laws, AnotherSeedGivesOtherBits) {
  TestRun run, other;
  run.estimate.directions = other.estimate.directions = 60;
  other.estimate.seed = 2;
  EXPECT_NE(estimateScene(ts::insideOfCube(), run).form_factors.formFactor(0, 1).value,
            estimateScene(ts::insideOfCube(), other).form_factors.formFactor(0, 1).value);
}

TEST(Laws, ToleranceIsKept) {
  TestRun run;
  run.estimate.directions = 50;
  run.estimate.replicates = 4;
  run.estimate.tolerance = 1.5e-3;
  const Estimate e = estimateScene(ts::insideOfCube(), run);
  EXPECT_GT(e.replicates, 4u);  // four replicates are not enough
  double largest = 0;
  for (uint32_t i = 0; i < 6; ++i)
    for (uint32_t j = 0; j < 6; ++j) largest = std::max(largest, e.form_factors.formFactor(i, j).standard_error);
  EXPECT_LE(largest, 1.5e-3);
  EXPECT_DOUBLE_EQ(largest, e.largest_standard_error);
}

// Runs reach their goals without many replicates too many, and keep their time limit.
TEST(Laws, GoalsStopTheReplicates) {
  TestRun run;
  run.estimate = {.directions = 50, .replicates = 2};
  run.estimate.relative = 0.01;
  const Estimate relative = estimateScene(test_scenes::insideOfCube(), run);
  EXPECT_LE(relative.largest_relative_error, 0.01);
  EXPECT_GT(relative.replicates, 2u);
  double largest = 0;
  for (const auto& entry : relative.form_factors.entries()) {
    const Measured f = relative.form_factors.formFactor(entry.i, entry.j);
    if (f.value >= 0.01) largest = std::max(largest, f.standard_error / f.value);
  }
  EXPECT_NEAR(relative.largest_relative_error, largest, 1e-12);

  run.estimate = {.directions = 50, .replicates = 1000};
  run.estimate.seconds = 1e-6;
  EXPECT_EQ(estimateScene(test_scenes::insideOfCube(), run).replicates, 2u);
  run.estimate.tolerance = 1e-9;  // out of reach in this time
  run.estimate.seconds = 0.2;
  EXPECT_GT(estimateScene(test_scenes::insideOfCube(), run).largest_standard_error, 1e-9);
}

}  // namespace
}  // namespace viewpeel
