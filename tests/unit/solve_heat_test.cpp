// These tests compare heat flows and temperatures with closed forms, from exact form factors and from computed ones.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <viewpeel/balance.h>

#include "reference/closed_forms/rectangles.h"
#include "reference/exact/exact_engine.h"
#include "scenes/heat_scenes.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using reference::test::isEstimateOf;
using reference::test::isWithin;

// Solutions satisfy the equations to 1e-13 of the right side, and sums of a few terms are rounded by 1e-15. The
// tolerance is 100 times as wide, relative to the values compared.
constexpr double kSolved = 1e-11;

// Returns the form factor between two unit squares that face each other.
double unitSquares(double distance) { return reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, distance); }

const std::vector<double> kEmissivities{1, 0.9, 0.3, 1e-3};

// Returns the form factors of an inner row of area 1 that sees only the outer one, of area 2.5.
FormFactors nested() { return te::formFactors({1, 2.5}, {{0, 1, {1, 0}}, {1, 1, {1.5, 0}}}); }

TEST(SolveHeat, TwoSurfaces) {
  const FormFactors f = nested();
  for (const double inner : kEmissivities)
    for (const double outer : kEmissivities) {
      SCOPED_TRACE(testing::Message() << "emissivities " << inner << ", " << outer);
      const double truth = te::betweenTwo(1, inner, 400, 2.5, outer, 300);
      const HeatSolution found = solveHeat(f, te::enclosureOf(f, {te::hot(inner, 400), te::hot(outer, 300)}));
      EXPECT_TRUE(isWithin(found.rows[0].heat_flow.value, truth, kSolved * truth));
      EXPECT_TRUE(isWithin(found.rows[1].heat_flow.value, -truth, kSolved * truth));
      EXPECT_LE(std::abs(found.balance_residual), kSolved * truth);
      EXPECT_FALSE(isWithin(found.rows[0].heat_flow.value, truth * (1 + 1e-9), kSolved * truth));  // negative control
      EXPECT_FALSE(found.is_open);
      EXPECT_EQ(found.rows[0].heat_flow.standard_error, 0);
      // With this heat flow given instead of the inner temperature, the solution is that temperature.
      const HeatSolution back = solveHeat(f, te::enclosureOf(f, {te::flux(inner, truth), te::hot(outer, 300)}));
      EXPECT_TRUE(isWithin(back.rows[0].temperature.value, 400, 400 * kSolved / inner));
    }
}

// The closed form is Oppenheim's network of two rows with given temperatures and an adiabatic one, whose emissivity
// does not matter.
TEST(SolveHeat, ThreeSurfacesOneAdiabatic) {
  // The rows are the sides, 3, 4 and 5 long, of a triangular duct; crossed strings give A_i F_ij.
  const double x01 = (3 + 4 - 5) / 2.0, x02 = (3 + 5 - 4) / 2.0, x12 = (4 + 5 - 3) / 2.0;
  const FormFactors f = te::formFactors({3, 4, 5}, {{0, 1, {x01, 0}}, {0, 2, {x02, 0}}, {1, 2, {x12, 0}}});
  const double through = x01 + 1 / (1 / x02 + 1 / x12);
  for (const double first : kEmissivities)
    for (const double second : kEmissivities) {
      const double truth =
          (te::power(500) - te::power(300)) / ((1 - first) / (3 * first) + 1 / through + (1 - second) / (4 * second));
      for (const double adiabatic : kEmissivities) {
        SCOPED_TRACE(testing::Message() << "emissivities " << first << ", " << second << ", " << adiabatic);
        const HeatSolution found =
            solveHeat(f, te::enclosureOf(f, {te::hot(first, 500), te::hot(second, 300), te::flux(adiabatic, 0)}));
        EXPECT_TRUE(isWithin(found.rows[0].heat_flow.value, truth, kSolved * te::power(500)));
        EXPECT_TRUE(isWithin(found.rows[1].heat_flow.value, -truth, kSolved * te::power(500)));
        EXPECT_EQ(found.rows[2].heat_flow.value, 0);
        // The radiosity of the adiabatic row is the mean of the others', weighted by its exchange areas.
        const double b0 = te::power(500) - truth * (1 - first) / (3 * first),
                     b1 = te::power(300) + truth * (1 - second) / (4 * second),
                     b2 = (x02 * b0 + x12 * b1) / (x02 + x12);
        EXPECT_TRUE(isWithin(te::power(found.rows[2].temperature.value), b2, 10 * kSolved * te::power(500)));
      }
    }
}

// Two plates see only the environment. One has a temperature, the other a heat flux.
TEST(SolveHeat, TheEnvironmentIsBlack) {
  const FormFactors f = te::formFactors({2, 1}, {{0, kEnvironment, {2, 0}}, {1, kEnvironment, {1, 0}}});
  Enclosure enclosure = te::enclosureOf(f, {te::hot(0.7, 350), te::flux(0.4, 100)});
  EXPECT_THROW(solveHeat(f, enclosure), Error);
  enclosure.environment_temperature = 280;
  const HeatSolution found = solveHeat(f, enclosure);
  EXPECT_TRUE(found.is_open);
  const double truth = 2 * 0.7 * (te::power(350) - te::power(280));
  EXPECT_TRUE(isWithin(found.rows[0].heat_flow.value, truth, kSolved * truth));
  EXPECT_TRUE(isWithin(te::power(found.rows[1].temperature.value), te::power(280) + 100 / 0.4, kSolved * 1000));
  EXPECT_TRUE(isWithin(found.to_environment.value, truth + 100, kSolved * truth));
  enclosure.environment_temperature = 0;
  EXPECT_TRUE(isWithin(solveHeat(f, enclosure).rows[0].heat_flow.value, 1.4 * te::power(350), kSolved * 1000));
}

// The solution equals that of the radiosity equation (I - R F) B = E by LU decomposition, in a box with one row for
// each side.
TEST(SolveHeat, EqualsTheRadiosityEquation) {
  const double opposite = unitSquares(1), adjacent = (1 - opposite) / 4;
  std::vector<FormFactors::Entry> entries;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(6, 6);
  for (uint32_t i = 0; i < 6; ++i)
    for (uint32_t j = i + 1; j < 6; ++j) {
      const double f = j == i + 3 ? opposite : adjacent;
      entries.push_back({i, j, {f, 0}});
      matrix(i, j) = matrix(j, i) = f;
    }
  const FormFactors f = te::formFactors(std::vector<double>(6, 1.0), entries);
  std::vector<Material> materials;
  Eigen::VectorXd emitted(6), reflectivity(6);
  for (int k = 0; k < 6; ++k) {
    materials.push_back(te::hot(0.15 * (k + 1), 300 + 20 * k));
    reflectivity[k] = 1 - materials[k].emissivity;
    emitted[k] = materials[k].emissivity * te::power(*materials[k].temperature);
  }
  const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(6, 6) - reflectivity.asDiagonal() * matrix;
  const Eigen::VectorXd truth = system.fullPivLu().solve(emitted);
  const HeatSolution found = solveHeat(f, te::enclosureOf(f, materials));
  for (int k = 0; k < 6; ++k) {
    EXPECT_TRUE(isWithin(found.rows[k].radiosity.value, truth[k], kSolved * truth[k]));
    const double arriving = matrix.row(k).dot(truth);
    EXPECT_TRUE(isWithin(found.rows[k].irradiation.value, arriving, kSolved * arriving));
    EXPECT_TRUE(isWithin(found.rows[k].heat_flux.value, truth[k] - arriving, kSolved * te::power(400)));
  }
}

// Where all temperatures are equal no heat flows, even if form factors have errors: the lack of a row's sum returns to
// the row.
TEST(SolveHeat, OneTemperatureMeansNoHeat) {
  const FormFactors f =
      te::formFactors({1, 2, 3}, {{0, 1, {0.4, 0.01}}, {0, 2, {0.7, 0.01}}, {1, 2, {1.3, 0.02}}, {2, 2, {0.5, 0.1}}});
  for (const double emissivity : kEmissivities) {
    const HeatSolution found =
        solveHeat(f, te::enclosureOf(f, {te::hot(emissivity, 300), te::hot(0.5, 300), te::flux(0.3, 0)}));
    for (const HeatRow& row : found.rows) {
      EXPECT_EQ(row.heat_flow.value, 0);
      EXPECT_EQ(row.heat_flow.standard_error, 0);
      EXPECT_TRUE(isWithin(row.temperature.value, 300, 1e-12 * 300));
    }
    EXPECT_NEAR(found.largest_lack, 1 - 2.5 / 3, 1e-12);
    EXPECT_EQ(found.lacking_row, "row2");
  }
}

TEST(SolveHeat, RefusesWhatHasNoAnswer) {
  const FormFactors f = nested();
  const auto refusal = [&](const FormFactors& form_factors, std::vector<Material> materials) {
    try {
      solveHeat(form_factors, te::enclosureOf(form_factors, std::move(materials)));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal(f, {te::flux(0.5, 1), te::flux(0.5, -0.4)}).find("have heat fluxes only"), std::string::npos);
  EXPECT_NE(refusal(f, {te::flux(0.5, -1e4), te::hot(0.5, 300)}).find("less than nothing"), std::string::npos);
  EXPECT_NE(refusal(f, {te::hot(0, 300), te::hot(0.5, 300)}).find("emissivity of 0"), std::string::npos);
  EXPECT_NE(refusal(f, {te::hot(0.5, 300)}).find("1 materials for 2 rows"), std::string::npos);
  EXPECT_NE(refusal(f, {te::hot(0.5, 300), {0.5, {}, {}}}).find("either a temperature or a heat flux"),
            std::string::npos);
  const FormFactors leaking = te::formFactors({1, 1}, {{0, 1, {0.9, 0}}, {0, kLeak, {0.1, 0}}});
  EXPECT_NE(refusal(leaking, {te::hot(0.5, 300), te::hot(0.5, 300)}).find("5 % of all emitted radiation ends on backs"),
            std::string::npos);
  // Rows 0 and 1 do not see rows 2 and 3, and neither row 2 nor row 3 has a given temperature.
  const FormFactors apart = te::formFactors({1, 1, 1, 1}, {{0, 1, {1, 0}}, {2, 3, {1, 0}}});
  EXPECT_NE(
      refusal(apart, {te::hot(0.5, 300), te::hot(0.5, 300), te::flux(1, 0), te::flux(1, 0)}).find("of 'row2' is open"),
      std::string::npos);
}

// --- from a scene -----------------------------------------------------------------------------------------------

HeatSolution solveScene(const InputScene& input, std::vector<Material> materials, By by = By::surface,
                        std::optional<double> environment = {}, bool two_sided = false) {
  const Scene scene = buildScene(input);
  Request request{.by = by, .two_sided = two_sided, .engine = EngineKind::host};
  const Result result = computeFormFactors(scene, request);
  const Ids& ids = result.form_factors.ids();
  std::vector<Material> of_rows;
  for (const uint32_t surface : ids.surface) of_rows.push_back(materials[surface]);
  return solveHeat(result.form_factors, {of_rows, environment, result.between_surfaces.ids().names});
}

// The inner of two nested boxes sees the outer one alone, for which there is a closed form.
TEST(SolveHeat, ConcentricBoxes) {
  const double truth = te::betweenTwo(1.5, 0.6, 400, 6, 0.4, 300);
  const HeatSolution found = solveScene(ts::cubeInCube(0.5), {te::hot(0.4, 300), te::hot(0.6, 400)});
  const HeatRow& inner = found.surfaces[1];
  EXPECT_TRUE(isEstimateOf(inner.heat_flow.value, inner.heat_flow.standard_error, truth)) << found.largest_lack;
  EXPECT_LE(inner.heat_flow.standard_error, 2e-3 * truth);
  EXPECT_LE(std::abs(found.balance_residual), kSolved * found.heat_flow_total);
}

InputScene spheres(double inner, double outer) {
  InputScene scene{"spheres", {"inner", "outer"}, {}};
  constexpr int kRings = 6, kSectors = 12;
  for (uint32_t surface = 0; surface < 2; ++surface) {
    const double radius = surface == 0 ? inner : outer;
    const auto corner = [&](int ring, int sector) {
      const double polar = std::numbers::pi * ring / kRings, angle = 2 * std::numbers::pi * sector / kSectors;
      return radius * glm::dvec3(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
    };
    for (int ring = 0; ring < kRings; ++ring)
      for (int sector = 0; sector < kSectors; ++sector) {
        ts::Corners corners{corner(ring, sector), corner(ring + 1, sector), corner(ring + 1, sector + 1),
                            corner(ring, sector + 1)};
        if (ring == 0) corners.erase(corners.begin());
        else if (ring == kRings - 1) corners.erase(corners.begin() + 1);
        if (surface == 1) std::reverse(corners.begin(), corners.end());
        scene.faces.push_back({corners, surface, 0});
      }
  }
  return scene;
}

// Concentric spheres are approximated by facets. The closed form takes the areas of the facets.
TEST(SolveHeat, ConcentricSpheres) {
  const HeatSolution found = solveScene(spheres(1, 2), {te::hot(0.3, 350), te::hot(0.8, 280)});
  const HeatRow &inner = found.surfaces[0], &outer = found.surfaces[1];
  const double truth = te::betweenTwo(inner.area, 0.3, 350, outer.area, 0.8, 280);
  EXPECT_TRUE(isEstimateOf(inner.heat_flow.value, inner.heat_flow.standard_error, truth)) << found.largest_lack;
  EXPECT_LE(inner.heat_flow.standard_error, 2e-3 * truth);
}

// A box with an open side radiates through it as a body of emissivity 1 / (1 + (1 - e) / e A_o / A_w).
TEST(SolveHeat, Hohlraum) {
  InputScene box = ts::insideOfCube();
  box.faces.pop_back();
  for (InputFace& face : box.faces) face.surface = 0;
  box.surface_names = {"walls"};
  for (const double emissivity : {0.9, 0.5, 0.1}) {
    const HeatSolution found = solveScene(box, {te::hot(emissivity, 500)}, By::surface, 0);
    const double truth = te::power(500) / (1 + (1 - emissivity) / emissivity / 5);
    EXPECT_TRUE(isEstimateOf(found.to_environment.value, found.to_environment.standard_error, truth, 1e-6 * truth));
    EXPECT_LE(std::abs(found.balance_residual), kSolved * truth);
  }
}

// Two plates are a small gap apart. From a gap of 4e-6 down less than 1e-5 of the radiation leaves through it. Such a
// share may come from lines that graze an edge, so it returns to the rows. Plates 1e-6 apart coincide.
TEST(SolveHeat, PlatesWithASmallGap) {
  for (const double gap : {1e-2, 1e-4, 4e-6, 1e-6}) {
    InputScene plates{"plates", {}, {}};
    ts::addFace(plates, "lower", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    ts::addFace(plates, "upper", ts::parallelogram({0, 0, gap}, {0, 1, 0}, {1, 0, 0}));
    const HeatSolution found = solveScene(plates, {te::hot(0.8, 400), te::hot(0.5, 300)}, By::surface, 300);
    const double f = unitSquares(gap);
    // The closed form solves B_0 = 0.8 E_0 + 0.2 H_0 and B_1 = 0.5 E_1 + 0.5 H_1, where the environment's emission is
    // taken from every term.
    const double hot = te::power(400) - te::power(300), b1_of_b0 = 0.5 * f, b0 = 0.8 * hot / (1 - 0.2 * f * b1_of_b0);
    const double truth = b0 - f * b1_of_b0 * b0;
    EXPECT_EQ(found.is_open, 1 - f > kGrazingShare);
    // Unoccluded form factors are exact to 1e-6, and the errors of both rows add up.
    const double error = 2e-6 + (found.is_open ? 0 : 1 - f);
    EXPECT_TRUE(isWithin(found.rows[0].heat_flux.value, truth, error * hot)) << gap;
  }
}

// Black sheets between two plates have no heat of their own, and one row for both sides. They divide the heat flow by
// their number plus 1.
TEST(SolveHeat, BlackShields) {
  constexpr double kGap = 1e-3;
  for (const int shields : {0, 1, 3}) {
    InputScene scene{"shields", {}, {}};
    std::vector<Material> materials;
    for (int k = 0; k < shields + 2; ++k) {
      ts::addFace(scene, "sheet" + std::to_string(k), ts::parallelogram({0, 0, kGap * k}, {1, 0, 0}, {0, 1, 0}));
      materials.push_back(k == 0 ? te::hot(1, 400) : k == shields + 1 ? te::hot(1, 300) : te::flux(1, 0));
    }
    const HeatSolution found = solveScene(scene, materials, By::surface, 350, true);
    const double f = unitSquares(kGap), between = te::power(400) - te::power(300);
    // The outer sides exchange with the environment. A sheet loses 2 (1 - f) of its emission through the rims.
    const double outside = te::power(400) - te::power(350), truth = outside + between / (shields + 1);
    EXPECT_TRUE(isWithin(found.rows[0].heat_flow.value, truth, 4 * (shields + 1) * (1 - f) * between)) << shields;
  }
}

// Two squares exchange past a sheet. The exact engine along random directions agrees with closed forms.
TEST(SolveHeat, TheExactEngineAgrees) {
  const InputScene input = ts::squaresPastASheet(1);
  const Scene scene = buildScene(input);
  const FormFactors exact = ts::exactPastASheet(input, makeIds(scene, By::polygon, false));
  const Enclosure enclosure{
      {te::hot(0.8, 400), te::flux(0.6, 50), te::flux(0.3, 0), te::flux(0.3, 0)}, 300, exact.ids().names};
  const Request request{.goal = FixedAmount{.directions = 100, .replicates = 16},
                        .engine = EngineKind::exact,
                        .exact_engine = reference::exactEngines()};
  const HeatSolution truth = solveHeat(exact, enclosure),
                     found = solveHeat(computeFormFactors(scene, request).form_factors, enclosure);
  for (size_t k = 0; k < truth.rows.size(); ++k) {
    const HeatRow &row = found.rows[k], &of_truth = truth.rows[k];
    EXPECT_TRUE(isEstimateOf(row.irradiation.value, row.irradiation.standard_error, of_truth.irradiation.value));
    EXPECT_TRUE(isEstimateOf(row.temperature.value, row.temperature.standard_error, of_truth.temperature.value));
  }
}

// The values of a surface are the sums, or the means by area, of its polygons' values. The inner box of area 1.5 has
// 50 W/m2. The outer box takes up as much; its equations are solved to 1e-13 of its emission of some 3,000 W, and 30
// times as much is allowed.
TEST(SolveHeat, SurfacesSumTheirPolygons) {
  const HeatSolution found = solveScene(ts::cubeInCube(0.5), {te::hot(0.4, 300), te::flux(0.6, 50)}, By::polygon);
  ASSERT_EQ(found.rows.size(), 12u);
  ASSERT_EQ(found.surfaces.size(), 2u);
  double flow = 0, arriving = 0;
  for (const HeatRow& row : found.rows) {
    if (row.name.starts_with("outer")) flow += row.heat_flow.value, arriving += row.irradiation.value / 6;
  }
  EXPECT_TRUE(isWithin(found.surfaces[0].heat_flow.value, flow, 1e-12 * std::abs(flow)));
  EXPECT_TRUE(isWithin(found.surfaces[0].irradiation.value, arriving, 1e-12 * arriving));
  EXPECT_TRUE(isWithin(found.surfaces[1].heat_flow.value, 75, 1e-10));
  EXPECT_TRUE(isWithin(found.surfaces[0].heat_flow.value, -75, 1e-8));
  EXPECT_EQ(found.surfaces[0].temperature.value, 300);
  EXPECT_GT(found.surfaces[1].temperature.standard_error, 0);
}

}  // namespace
}  // namespace viewpeel
