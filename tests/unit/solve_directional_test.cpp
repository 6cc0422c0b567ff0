// These tests check heat between surfaces whose emissivity depends on the angle (docs/method.md, section 15). The truth
// for two plates is an integral over pairs of points with repeated reflection, which knows nothing of split rows.
#include <viewpeel/matrix_free.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "scenes/named_scenes.h"
#include "solve/directional_law.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"
#include "unoccluded/gauss.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using Of = HeatTolerance::Of;
using reference::test::isWithin;

// kForward emits most along the normal. kGrazing emits most towards the horizon, as polished metals do. kConstant emits
// alike at all angles.
const DirectionalLaw kForward{.cosine_power = 3},
    kGrazing{.cosine_power = 0, .angles_deg = {0, 40, 80, 90}, .values = {1, 1, 3, 0}},
    kConstant{.cosine_power = 0, .angles_deg = {0, 90}, .values = {2, 2}};

MaterialTable tableWithLaws(std::vector<MaterialTable::Line> lines, std::optional<double> environment = {}) {
  MaterialTable table{"materials", std::move(lines), environment};
  table.laws = {kForward, kGrazing, kConstant};
  return table;
}
Material with(Material material, uint32_t law) {
  material.directional = law;
  return material;
}

const HeatRow& rowOf(const HeatSolution& heat, const std::string& name) {
  return *std::ranges::find(heat.surfaces, name, &HeatRow::name);
}

// A Plate is a unit square, at the temperature of a black surface that emits `power`.
struct Plate {
  glm::dvec3 origin, u, v;
  double emissivity;
  uint32_t law;
  double temperature;
  glm::dvec3 normal() const { return glm::cross(u, v); }
  double power() const { return te::power(temperature); }
};

struct Geometry {
  Plate plates[2];
  double environment_temperature;
};

InputScene sceneOf(const Geometry& geometry) {
  InputScene scene{"plates", {"first", "second"}, {}};
  for (uint32_t k = 0; k < 2; ++k) {
    const Plate& p = geometry.plates[k];
    scene.faces.push_back({reference::test::rectangle(p.origin, p.u, p.v), k, 0});
  }
  return scene;
}

// A Model has each plate's directional emissivity, by the cosine of the angle to its normal. A plate reflects in
// proportion to 1 - e(angle) (method, eq. 58), unless it reflects_diffusely. The two flags make wrong models.
struct Model {
  std::function<double(double cosine)> emissivity[2];
  bool exchanges_cosines = false;  // each plate's emissivity is taken at the other plate's angle
  bool reflects_diffusely = false;
};

Model modelOf(const Geometry& geometry, const std::vector<RelativeEmissivity>& laws) {
  Model model;
  for (int k = 0; k < 2; ++k) {
    const Plate& plate = geometry.plates[k];
    model.emissivity[k] = [&laws, plate](double cosine) { return plate.emissivity * laws[plate.law].at(cosine); };
  }
  return model;
}

// Returns the heat fluxes of both plates, W/m2, which are squares of area 1. Plate j sends out the intensity (N_j +
// e_j(angle) (E_j - N_j)) / pi (method, eq. 59), with its black emission E_j and an unknown N_j. An integral over pairs
// of points gives the power that arrives at plate i, and the part of it that i absorbs. The N_j follow from repeated
// reflection. The environment is black.
std::array<double, 2> heatFluxes(const Geometry& geometry, const Model& model, int points) {
  const auto rule = gaussPoints(points);
  // weighted[f][g] is the exchange area between the plates. Pairs of points are weighted by the first plate's
  // emissivity where f is 1, and by the second plate's where g is 1.
  double weighted[2][2] = {};
  const auto& [a, b] = geometry.plates;
  std::vector<std::pair<double, double>> places;
  for (const auto& [node, weight] : rule) places.emplace_back(double(node + 1) / 2, double(weight) / 2);
  for (const auto& [s, s_weight] : places)
    for (const auto& [t, t_weight] : places)
      for (const auto& [p, p_weight] : places)
        for (const auto& [q, q_weight] : places) {
          const glm::dvec3 r = (b.origin + p * b.u + q * b.v) - (a.origin + s * a.u + t * a.v);
          const double length = glm::length(r), of_a = glm::dot(r, a.normal()) / length,
                       of_b = -glm::dot(r, b.normal()) / length;
          const double kernel =
              s_weight * t_weight * p_weight * q_weight * of_a * of_b / (std::numbers::pi * length * length);
          const double e_a = model.emissivity[0](model.exchanges_cosines ? of_b : of_a),
                       e_b = model.emissivity[1](model.exchanges_cosines ? of_a : of_b);
          weighted[0][0] += kernel;
          weighted[1][0] += kernel * e_a;
          weighted[0][1] += kernel * e_b;
          weighted[1][1] += kernel * e_a * e_b;
        }
  const double outside = te::power(geometry.environment_temperature);
  std::array<double, 2> reflected{outside, outside}, absorbed{};
  for (int turn = 0; turn < 500; ++turn) {
    std::array<double, 2> arriving{};
    for (int i = 0; i < 2; ++i) {
      const Plate &plate = geometry.plates[i], &other = geometry.plates[1 - i];
      const auto of = [&](int own, int others) { return i == 0 ? weighted[own][others] : weighted[others][own]; };
      const double n = reflected[1 - i], shape = other.power() - (model.reflects_diffusely ? 0 : n);
      arriving[i] = of(0, 0) * n + of(0, 1) * shape + (1 - of(0, 0)) * outside;
      absorbed[i] = of(1, 0) * n + of(1, 1) * shape + (plate.emissivity - of(1, 0)) * outside;
    }
    for (int i = 0; i < 2; ++i) {
      const double rest = arriving[i] - absorbed[i];
      reflected[i] = model.reflects_diffusely ? rest : rest / (1 - geometry.plates[i].emissivity);
    }
  }
  return {geometry.plates[0].emissivity * geometry.plates[0].power() - absorbed[0],
          geometry.plates[1].emissivity * geometry.plates[1].power() - absorbed[1]};
}

// A gap between the two plates keeps the integrand smooth but for the kinks of the table. The test asserts that 16 and
// 24 points agree to 1e-6 of the emission.
const Geometry kParallel{
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.35, 0, 500}, {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, 0.15, 1, 300}}, 250},
    kUpright{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.35, 0, 500}, {{-0.3, 0, 0.2}, {0, 1, 0}, {0, 0, 1}, 0.4, 1, 350}},
             250};

// Errors of 5 standard errors have a probability of 0.16 % for Student's t with 7 degrees of freedom; the seed is
// fixed.
TEST(Directional, TwoPlatesAgreeWithQuadrature) {
  const std::vector<RelativeEmissivity> laws{RelativeEmissivity(kForward), RelativeEmissivity(kGrazing)};
  for (const Geometry* geometry : {&kParallel, &kUpright}) {
    const auto& [first, second] = geometry->plates;
    Model model = modelOf(*geometry, laws);
    const auto truth = heatFluxes(*geometry, model, 24), coarser = heatFluxes(*geometry, model, 16);
    const double quadrature = 1e-6 * first.power();
    const MaterialTable table =
        tableWithLaws({{"first", with(te::hot(first.emissivity, first.temperature), first.law), 2},
                       {"second", with(te::hot(second.emissivity, second.temperature), second.law), 3}},
                      geometry->environment_temperature);
    const HeatSolution found =
        solveMatrixFree(buildScene(sceneOf(*geometry)), table, {.by = By::surface, .first_directions = 2048}).heat;
    model.exchanges_cosines = true;
    const auto exchanged = heatFluxes(*geometry, model, 16);
    model.exchanges_cosines = false;
    model.reflects_diffusely = true;
    const auto diffuse = heatFluxes(*geometry, model, 16);
    double of_exchange = 0, of_reflection = 0;
    for (int k = 0; k < 2; ++k) {
      const HeatRow& row = rowOf(found, k ? "second" : "first");
      const double bound = 5 * row.heat_flux.standard_error + quadrature;
      EXPECT_TRUE(isWithin(coarser[k], truth[k], quadrature));
      EXPECT_TRUE(isWithin(row.heat_flux.value, truth[k], bound)) << row.name;
      EXPECT_GT(row.heat_flux.standard_error, 0);
      EXPECT_NEAR(row.emissivity, geometry->plates[k].emissivity, 1e-15);
      of_exchange = std::max(of_exchange, std::abs(exchanged[k] - truth[k]) / bound);
      of_reflection = std::max(of_reflection, std::abs(diffuse[k] - truth[k]) / bound);
    }
    // Negative controls: wrong models are off by more than twice the bound. One model takes emissivities at the other
    // plate's angle, which differs between upright plates only. The other model's reflection forgets the angle.
    if (geometry == &kUpright) {
      EXPECT_GT(of_exchange, 2);
    }
    EXPECT_GT(of_reflection, 2);
  }
}

// In an enclosure of one temperature every heat flux is 0, and adiabatic rows have this temperature, whatever the laws.
// Powers are less the power at a reference temperature (HeatState::shift), here the only one. So the right side is 0,
// and 1e-9 allows for rounding. A temperature T is then off by T / 4 x 1e-9, below 1e-7 K.
TEST(Directional, OneTemperatureMeansNoHeat) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  const std::vector<std::vector<MaterialTable::Line>> cases{
      {{"inner", with(te::hot(0.35, 300), 0), 2}, {"outer", with(te::hot(0.2, 300), 1), 3}},
      {{"inner", with(te::hot(0.01, 300), 1), 2}, {"outer", te::hot(0.7, 300), 3}},
      {{"inner", with(te::flux(0.3, 0), 1), 2}, {"outer", with(te::hot(0.4, 300), 0), 3}},
      {{"inner", te::hot(1, 300), 2}, {"outer", with(te::hot(0.4, 300), 0), 3}}};
  for (const By by : {By::surface, By::polygon})
    for (const auto& lines : cases) {
      const HeatSolution heat =
          solveMatrixFree(scene, tableWithLaws(lines), {.by = by, .first_directions = 32, .residual = 1e-12}).heat;
      ASSERT_EQ(heat.rows.size(), by == By::surface ? 2u : scene.faces.size());
      for (const HeatRow& row : heat.rows) {
        EXPECT_TRUE(isWithin(row.heat_flux.value, 0, 1e-9 * te::power(300))) << row.name;
        EXPECT_TRUE(isWithin(row.temperature.value, 300, 1e-7)) << row.name;
        EXPECT_TRUE(isWithin(row.irradiation.value, te::power(300), 1e-9 * te::power(300))) << row.name;
        EXPECT_TRUE(isWithin(row.radiosity.value, te::power(300), 1e-9 * te::power(300))) << row.name;
      }
    }
}

// Within black surroundings a convex body of area A emits e A s T^4, with s the Stefan-Boltzmann constant, whatever its
// law. By Kirchhoff's law it absorbs the share e of the surroundings' radiation. If both temperatures are exchanged,
// the same heat flows the other way; the same directions are counted, so that only rounding differs.
TEST(Directional, KirchhoffsLaw) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  const double area = 6 * 0.4 * 0.4;
  for (const uint32_t law : {0u, 1u}) {
    const auto flowOf = [&](double inner, double outer) {
      const MaterialTable table =
          tableWithLaws({{"inner", with(te::hot(0.3, inner), law), 2}, {"outer", te::hot(1, outer), 3}});
      return rowOf(solveMatrixFree(scene, table, {.by = By::surface, .first_directions = 256}).heat, "inner").heat_flow;
    };
    const Measured out = flowOf(400, 300), in = flowOf(300, 400);
    const double truth = 0.3 * area * (te::power(400) - te::power(300));
    EXPECT_TRUE(isWithin(out.value, truth, 5 * out.standard_error));
    EXPECT_LT(out.standard_error, 0.01 * truth);
    EXPECT_TRUE(isWithin(in.value, -out.value, 1e-9 * truth));
  }
}

// A row that is given the heat flux of a solution gets the temperature of this solution. The equations are solved to
// 1e-12 of the emission. The temperature may be off by 1e-6 K, which is 8e-9 of the emission: a coarse check.
TEST(Directional, HeatFluxesGiveTemperatures) {
  const Scene scene = buildScene(sceneOf(kUpright));
  const auto solve = [&](const Material& first) {
    const MaterialTable table =
        tableWithLaws({{"first", with(first, 0), 2}, {"second", with(te::hot(0.4, 350), 1), 3}}, 250);
    return solveMatrixFree(scene, table, {.by = By::surface, .first_directions = 64, .residual = 1e-12}).heat;
  };
  const double flux = rowOf(solve(te::hot(0.35, 500)), "first").heat_flux.value;
  const HeatSolution back = solve(te::flux(0.35, flux));
  EXPECT_NEAR(rowOf(back, "first").temperature.value, 500, 1e-6);
  EXPECT_GT(rowOf(back, "first").temperature.standard_error, 0);
  EXPECT_NEAR(rowOf(back, "first").heat_flux.value, flux, 1e-12 * flux);
}

// A law that is the same at all angles gives the bits of a diffuse surface. Negative control: another law does not.
TEST(Directional, AConstantLawIsDiffuse) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  const auto solve = [&](const Material& inner) {
    const MaterialTable table = tableWithLaws({{"inner", inner, 2}, {"outer", te::hot(0.5, 300), 3}});
    return solveMatrixFree(scene, table, {.first_directions = 16}).heat.rows;
  };
  const auto diffuse = solve(te::hot(0.8, 400)), constant = solve(with(te::hot(0.8, 400), 2)),
             other = solve(with(te::hot(0.35, 400), 0)), grey = solve(te::hot(0.35, 400));
  for (size_t k = 0; k < diffuse.size(); ++k) {
    EXPECT_EQ(diffuse[k].irradiation.value, constant[k].irradiation.value);
    EXPECT_EQ(diffuse[k].irradiation.standard_error, constant[k].irradiation.standard_error);
    EXPECT_NE(other[k].irradiation.value, grey[k].irradiation.value);
  }
}

TEST(Directional, TheSameBitsOnAnyNumberOfThreads) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  const auto solve = [&](uint32_t threads, By by) {
    const MaterialTable table =
        tableWithLaws({{"inner", with(te::hot(0.35, 400), 0), 2}, {"outer", with(te::hot(0.2, 300), 1), 3}});
    return solveMatrixFree(scene, table, {.by = by, .first_directions = 16, .threads = threads}).heat.rows;
  };
  for (const By by : {By::surface, By::polygon}) {
    const auto alone = solve(1, by), three = solve(3, by);
    for (size_t k = 0; k < alone.size(); ++k) {
      EXPECT_EQ(alone[k].irradiation.value, three[k].irradiation.value);
      EXPECT_EQ(alone[k].heat_flux.standard_error, three[k].heat_flux.standard_error);
    }
  }
}

TEST(Directional, RefusesWhatHasNoAnswer) {
  const Scene scene = buildScene(ts::cubeInCube(0.4));
  const auto refuses = [&](const MaterialTable& table, const std::string& part) {
    try {
      solveMatrixFree(scene, table);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_usage);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      return;
    }
    ADD_FAILURE() << "nothing says " << part;
  };
  refuses(tableWithLaws({{"default", with(te::hot(0.5, 300), 0), 2}}), "would be 1.25 at the angle of most emission");
  refuses(tableWithLaws({{"default", with(te::hot(0.5, 300), 7), 2}}), "has no directional law");
  MaterialTable bad = tableWithLaws({{"default", with(te::hot(0.1, 300), 0), 2}});
  bad.laws[0].cosine_power = -1;
  refuses(bad, "a power of -1");
  // Form factors are of diffuse rows.
  const FormFactors f = te::formFactors({1, 1}, {{0, 1, {1, 0}}});
  Enclosure enclosure = te::enclosureOf(f, {with(te::hot(0.1, 300), 0), te::hot(0.5, 400)});
  enclosure.laws = {kForward};
  EXPECT_THROW(solveHeat(f, enclosure), Error);
  EXPECT_THROW(findExchangeFactors(f, enclosure), Error);
  EXPECT_THROW(solveScene(scene, tableWithLaws({{"default", with(te::hot(0.1, 300), 0), 2}})), Error);
}

}  // namespace
}  // namespace viewpeel
