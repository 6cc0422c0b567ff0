// These tests compare heat with bands of wavelengths with closed forms, with grey heat, and with the radiosity
// equation.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "solve/blackbody.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
using reference::test::isWithin;

// Given heat fluxes are kept to 1e-12 of the largest emission, and the equations of a band to 1e-13.
constexpr double kSolved = 1e-11;

const std::vector<double> kLimits{3, 10};
const std::vector<Band> kBands{{0, 3}, {3, 10}, {10, INFINITY}};

Material withBands(Material material, std::vector<double> emissivities) {
  material.band_emissivities = std::move(emissivities);
  return material;
}

Enclosure enclosureOf(const FormFactors& f, std::vector<Material> materials) {
  Enclosure enclosure = te::enclosureOf(f, std::move(materials));
  enclosure.band_limits_um = kLimits;
  return enclosure;
}

FormFactors nested() { return te::formFactors({1, 2.5}, {{0, 1, {1, 0}}, {1, 1, {1.5, 0}}}); }

// Two surfaces that see only each other exchange heat through one radiative resistance in each band.
TEST(SolveBands, TwoSurfaces) {
  const std::vector<double> inner{0.9, 0.3, 0.05}, outer{0.2, 0.7, 1};
  double truth = 0;
  for (size_t k = 0; k < kBands.size(); ++k)
    truth +=
        (bandPower(kBands[k], 900) - bandPower(kBands[k], 400)) / (1 / inner[k] + (1 - outer[k]) / (2.5 * outer[k]));
  const FormFactors f = nested();
  const HeatSolution found =
      solveHeat(f, enclosureOf(f, {withBands(te::hot(1, 900), inner), withBands(te::hot(1, 400), outer)}));
  EXPECT_TRUE(isWithin(found.rows[0].heat_flow.value, truth, kSolved * truth));
  EXPECT_TRUE(isWithin(found.rows[1].heat_flow.value, -truth, kSolved * truth));
  EXPECT_FALSE(isWithin(found.rows[0].heat_flow.value, truth * (1 + 1e-9), kSolved * truth));  // negative control
  EXPECT_LE(std::abs(found.balance_residual), kSolved * truth);
  // If the heat is given in place of either temperature, the solution is this temperature.
  const HeatSolution hot =
      solveHeat(f, enclosureOf(f, {withBands(te::flux(1, truth), inner), withBands(te::hot(1, 400), outer)}));
  EXPECT_TRUE(isWithin(hot.rows[0].temperature.value, 900, 900 * kSolved));
  const HeatSolution cold =
      solveHeat(f, enclosureOf(f, {withBands(te::hot(1, 900), inner), withBands(te::flux(1, -truth / 2.5), outer)}));
  // The error is relative to the emission at 900 K, 26 times that at 400 K. An emissivity of 0.2 multiplies it by 5,
  // and the fourth root divides it by 4: 32 times kSolved, rounded up to 100.
  EXPECT_TRUE(isWithin(cold.rows[1].temperature.value, 400, 400 * 100 * kSolved));
  EXPECT_EQ(cold.rows[1].heat_flux.value, -truth / 2.5);
}

// Returns a triangular duct with sides 3, 4, 5, one of them adiabatic. Crossed strings give its form factors.
FormFactors duct() { return te::formFactors({3, 4, 5}, {{0, 1, {1, 0}}, {0, 2, {2, 0}}, {1, 2, {3, 0}}}); }

// The temperature of an adiabatic row depends on emissivities here. It is checked by the radiosity equation (I - R F) B
// = E, by LU, band by band.
TEST(SolveBands, AnAdiabaticRowKeepsTheRadiosityEquation) {
  const std::vector<std::vector<double>> emissivities{{0.9, 0.2, 0.5}, {0.4, 0.8, 0.1}, {0.05, 0.6, 0.95}};
  const FormFactors f = duct();
  const HeatSolution found = solveHeat(
      f, enclosureOf(f, {withBands(te::hot(1, 1200), emissivities[0]), withBands(te::hot(1, 300), emissivities[1]),
                         withBands(te::flux(1, 0), emissivities[2])}));
  Eigen::Matrix3d factors;
  factors << 0, 1.0 / 3, 2.0 / 3, 1.0 / 4, 0, 3.0 / 4, 2.0 / 5, 3.0 / 5, 0;
  Eigen::Vector3d radiosity = Eigen::Vector3d::Zero(), flux = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < kBands.size(); ++k) {
    Eigen::Vector3d emitted, reflectivity;
    for (int i = 0; i < 3; ++i) {
      reflectivity[i] = 1 - emissivities[i][k];
      emitted[i] = emissivities[i][k] * bandPower(kBands[k], found.rows[i].temperature.value);
    }
    const Eigen::Vector3d of_band =
        (Eigen::Matrix3d::Identity() - reflectivity.asDiagonal() * factors).fullPivLu().solve(emitted);
    radiosity += of_band;
    flux += of_band - factors * of_band;
  }
  const double scale = te::power(1200);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(isWithin(found.rows[i].radiosity.value, radiosity[i], kSolved * scale));
    EXPECT_TRUE(isWithin(found.rows[i].heat_flux.value, flux[i], kSolved * scale));
  }
  EXPECT_TRUE(isWithin(flux[2], 0, kSolved * scale));
  EXPECT_GT(found.rows[2].temperature.value, 500);
  // With one emissivity for all wavelengths the row would have another temperature.
  const HeatSolution grey = solveHeat(f, te::enclosureOf(f, {te::hot(0.5, 1200), te::hot(0.5, 300), te::flux(0.5, 0)}));
  EXPECT_GT(std::abs(grey.rows[2].temperature.value - found.rows[2].temperature.value), 5);
}

// Emissivities that are the same in all bands are grey.
TEST(SolveBands, AlikeBandsAreGrey) {
  const FormFactors f = te::formFactors(
      {3, 4, 5},
      {{0, 1, {1, 0.01}}, {0, 2, {1.5, 0.01}}, {0, kEnvironment, {0.5, 0.02}}, {1, 2, {3, 0.02}}, {2, 2, {0.5, 0.01}}});
  std::vector<Material> materials{te::hot(0.3, 700), te::flux(0.8, 500), te::flux(0.05, -10)};
  Enclosure grey = te::enclosureOf(f, materials);
  grey.environment_temperature = 250;
  Enclosure bands = grey;
  bands.band_limits_um = kLimits;
  for (Material& material : bands.materials) material.band_emissivities.assign(3, material.emissivity);
  const HeatSolution truth = solveHeat(f, grey), found = solveHeat(f, bands);
  for (size_t i = 0; i < 3; ++i)
    for (const auto of : {&HeatRow::temperature, &HeatRow::radiosity, &HeatRow::irradiation, &HeatRow::heat_flux}) {
      const Measured value = found.rows[i].*of, exact = truth.rows[i].*of;
      // A heat flux that is off by 1e-12 of all emission changes emissive powers by this over the emissivity.
      EXPECT_TRUE(isWithin(value.value, exact.value, kSolved * te::power(700) / 0.05)) << i;
      EXPECT_TRUE(isWithin(value.standard_error, exact.standard_error, 1e-6 * exact.standard_error + 1e-9)) << i;
    }
  EXPECT_TRUE(isWithin(found.to_environment.value, truth.to_environment.value, kSolved * te::power(700) * 12));
  EXPECT_TRUE(isWithin(found.to_environment.standard_error, truth.to_environment.standard_error, 1e-6));
}

TEST(SolveBands, OneTemperatureMeansNoHeat) {
  const FormFactors f =
      te::formFactors({1, 2, 3}, {{0, 1, {0.4, 0.01}}, {0, 2, {0.7, 0.01}}, {1, 2, {1.3, 0.02}}, {2, 2, {0.5, 0.1}}});
  const HeatSolution found = solveHeat(
      f, enclosureOf(f, {withBands(te::hot(1, 300), {1e-3, 0.5, 1}), withBands(te::hot(1, 300), {0.9, 0.8, 1e-3}),
                         withBands(te::flux(1, 0), {0.2, 1, 0.3})}));
  for (const HeatRow& row : found.rows) {
    EXPECT_TRUE(isWithin(row.temperature.value, 300, 300 * kSolved)) << row.name;
    EXPECT_TRUE(isWithin(row.heat_flux.value, 0, kSolved * te::power(300))) << row.name;
  }
}

TEST(SolveBands, WhatHasNoSolutionIsRefused) {
  const FormFactors f = nested();
  const auto refuses = [&](const Enclosure& enclosure, ErrorCode code, const std::string& part) {
    try {
      solveHeat(f, enclosure);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      return;
    }
    ADD_FAILURE() << "nothing says " << part;
  };
  const std::vector<double> all{0.5, 0.6, 0.7};
  refuses(enclosureOf(f, {withBands(te::flux(1, -1e5), all), withBands(te::hot(1, 300), all)}), ErrorCode::bad_input,
          "'row0' would have to emit -");
  refuses(enclosureOf(f, {withBands(te::hot(1, 400), {0.5, 0.5}), withBands(te::hot(1, 300), all)}),
          ErrorCode::bad_usage, "'row0' has 2 emissivities for 3 bands");
  refuses(enclosureOf(f, {withBands(te::hot(1, 400), {0.5, 0, 1}), withBands(te::hot(1, 300), all)}),
          ErrorCode::bad_usage, "an emissivity of 0");
  EXPECT_THROW(
      findExchangeFactors(f, enclosureOf(f, {withBands(te::hot(1, 400), all), withBands(te::hot(1, 300), all)})),
      Error);
}

}  // namespace
}  // namespace viewpeel
