// These tests check solveScene(), which goes from a scene to heat in one call, and its tolerances of answers.
#include <gtest/gtest.h>

#include "scenes/named_scenes.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using Of = HeatTolerance::Of;

MaterialTable tableOf(std::vector<MaterialTable::Line> lines, std::optional<double> environment = {}) {
  return {"materials", std::move(lines), environment};
}

Request onHost(By by) { return {.by = by, .engine = EngineKind::host}; }

// Returns a cube in a cube with a two-sided plate between them, so that form factors have sampling errors.
InputScene boxesAndPlate() {
  InputScene scene = ts::cubeInCube(0.4);
  ts::addFace(scene, "plate", ts::parallelogram({0.2, 0.2, 0.1}, {0.6, 0, 0}, {0, 0.5, 0}));
  ts::addFace(scene, "plate", ts::parallelogram({0.2, 0.2, 0.1}, {0, 0.5, 0}, {0.6, 0, 0}));
  return scene;
}

const std::vector<MaterialTable::Line> kLines{
    {"outer", te::hot(0.5, 300), 2}, {"inner", te::flux(0.8, 200), 3}, {"plate", te::flux(0.3, 0), 4}};

TEST(SolveScene, IsComputeThenSolve) {
  const Scene scene = buildScene(boxesAndPlate());
  const SceneHeat found = solveScene(scene, tableOf(kLines), onHost(By::polygon));
  Request estimated = onHost(By::polygon);
  estimated.promise = false;
  const Result result = computeFormFactors(scene, estimated);
  const HeatSolution heat = solveHeat(
      result.form_factors, assignMaterials(tableOf(kLines), result.form_factors.ids(), {"outer", "inner", "plate"}));
  ASSERT_EQ(found.heat.rows.size(), heat.rows.size());
  for (size_t k = 0; k < heat.rows.size(); ++k) {
    EXPECT_EQ(found.heat.rows[k].irradiation.value, heat.rows[k].irradiation.value);
    EXPECT_EQ(found.heat.rows[k].irradiation.standard_error, heat.rows[k].irradiation.standard_error);
  }
  EXPECT_EQ(found.form_factor_tolerance, 1e-3);
  EXPECT_EQ(found.runs, 1u);
}

TEST(SolveScene, TolerancesAreReached) {
  const Scene scene = buildScene(boxesAndPlate());
  // With kLines, outer takes up exactly what inner gives off: its heat flux has no error. With two temperatures given,
  // heat fluxes depend on form factors.
  std::vector<MaterialTable::Line> held = kLines;
  held[1] = {"inner", te::hot(0.8, 340), 3};
  for (const HeatTolerance tolerance :
       {HeatTolerance{1, Of::temperature}, {0.02, Of::temperature}, {0.1, Of::heat_flux}, {1e-3, Of::relative}}) {
    SCOPED_TRACE(tolerance.standard_error);
    const auto& lines = tolerance.of == Of::temperature ? kLines : held;
    const SceneHeat found = solveScene(scene, tableOf(lines), onHost(By::surface), tolerance);
    EXPECT_LE(largestHeatError(found.heat, tolerance.of), tolerance.standard_error);
    EXPECT_GT(largestHeatError(found.heat, tolerance.of), 0);
    EXPECT_TRUE(found.is_reached);
    EXPECT_TRUE(found.runs == 1 || found.form_factor_tolerance < 0.02);
  }
  // Nothing is between these two squares. Their form factors have the errors of their integrals, about 1e-14, which no
  // lines can reduce, so a finer tolerance is refused.
  const Scene squares = buildScene(ts::parallelSquares());
  EXPECT_THROW(solveScene(squares, tableOf({{"lower", te::hot(0.5, 300), 2}, {"upper", te::flux(0.8, 200), 3}}, 280),
                          onHost(By::surface), HeatTolerance{1e-18, Of::temperature}),
               Error);
  // Where time runs out after the first run, its answers are returned and is_reached is false.
  Request hurried = onHost(By::surface);
  hurried.time_limit_s = 1e-3;
  EXPECT_FALSE(solveScene(scene, tableOf(kLines), hurried, HeatTolerance{1e-6, Of::temperature}).is_reached);
}

TEST(SolveScene, RefusesBeforeItComputes) {
  const Scene scene = buildScene(boxesAndPlate());
  const auto refuses = [&](const MaterialTable& table, std::optional<HeatTolerance> tolerance,
                           const std::string& part) {
    Observer observer;
    bool has_begun = false;
    observer.on_progress = [&](const Progress&) { has_begun = true; };
    try {
      solveScene(scene, table, onHost(By::surface), tolerance, observer);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      EXPECT_FALSE(has_begun);
      return;
    }
    ADD_FAILURE() << "nothing says " << part;
  };
  refuses(tableOf({kLines[0]}), {}, "'inner' has no material");
  refuses(tableOf({{"default", te::flux(0.5, 0), 1}}), {}, "no temperature is given");
  refuses(tableOf({{"default", te::hot(0.5, 300), 1}}), HeatTolerance{1, Of::temperature},
          "all temperatures are given");
  MaterialTable fluxes = tableOf({{"default", te::flux(0.5, 30), 1}});
  fluxes.environment_temperature = 300;
  for (const auto of : {Of::relative, Of::heat_flux})
    refuses(fluxes, HeatTolerance{0.01, of}, "all heat fluxes are given");
  EXPECT_TRUE(
      solveScene(buildScene(ts::parallelSquares()), fluxes, onHost(By::surface), HeatTolerance{1, Of::temperature})
          .is_reached);
  refuses(tableOf(kLines), HeatTolerance{0, Of::relative}, "not above 0");
}

}  // namespace
}  // namespace viewpeel
