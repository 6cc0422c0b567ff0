// These tests check bounds of heat flows and temperatures that follow from intervals of form factors. They hold for
// every matrix within the intervals.
#include <random>

#include <gtest/gtest.h>

#include "scenes/heat_scenes.h"
#include "tests/support/enclosures.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using Entry = FormFactors::Entry;

constexpr uint32_t kBoundedRows = 8;
constexpr double kRounding = 1e-9;  // W/m2; fluxes are some 1,000

struct Drawn {
  std::vector<double> areas = std::vector<double>(kBoundedRows);
  std::vector<Entry> entries;
};

// Draws symmetric exchange areas at random. The areas of rows are their sums, plus a random share for the environment
// in an open scene.
Drawn drawTruth(std::mt19937_64& random, bool is_open) {
  std::uniform_real_distribution<double> uniform(0.1, 1);
  Drawn drawn;
  for (uint32_t i = 0; i < kBoundedRows; ++i)
    for (uint32_t j = i; j < kBoundedRows; ++j) {
      const double exchange = uniform(random);
      drawn.entries.push_back({i, j, {exchange, 0}});
      drawn.areas[i] += exchange;
      if (j != i) drawn.areas[j] += exchange;
    }
  for (uint32_t i = 0; i < kBoundedRows && is_open; ++i) drawn.areas[i] += uniform(random);
  return drawn;
}

// Adds to each row the exchange area with the environment that its other entries leave.
std::vector<Entry> withRest(const std::vector<double>& areas, std::vector<Entry> entries) {
  std::vector<double> rest = areas;
  for (const Entry& entry : entries) {
    rest[entry.i] -= entry.exchange_area.value;
    if (entry.i != entry.j) rest[entry.j] -= entry.exchange_area.value;
  }
  for (uint32_t i = 0; i < kBoundedRows; ++i) entries.push_back({i, kEnvironment, {rest[i], 0}});
  std::ranges::sort(entries, {}, [](const Entry& entry) { return std::pair(entry.i, entry.j); });
  return entries;
}

std::vector<Material> materials() {
  std::vector<Material> found;
  for (uint32_t i = 0; i < kBoundedRows; ++i)
    found.push_back(i % 3 == 2 ? te::flux(0.5, 30.0 * i - 100) : te::hot(i % 3 == 0 ? 0.2 + 0.1 * i : 1, 300 + 15 * i));
  return found;
}

// Draws matrices at the corners of the intervals around a measured matrix. The bounds of the measured one hold for each
// of them. Negative control: a tenth of a bound does not hold for some.
TEST(SolveBounds, HoldForEveryMatrixWithinTheIntervals) {
  std::mt19937_64 random(9);
  for (const bool is_open : {false, true}) {
    const Drawn centre = drawTruth(random, is_open);
    const double width = 0.01;
    std::vector<Entry> entries = is_open ? withRest(centre.areas, centre.entries) : centre.entries;
    std::vector<Interval> intervals;
    for (const Entry& entry : entries)
      intervals.push_back({entry.exchange_area.value - width, entry.exchange_area.value + width});
    const FormFactors plain = te::formFactors(centre.areas, entries);
    const FormFactors measured(plain.ids(), plain.entries(), plain.rowSums(), intervals);
    const Enclosure enclosure{materials(), 280, std::vector<std::string>{"all"}};
    const HeatSolution found = solveHeat(measured, enclosure);
    double nearest = INFINITY;
    for (int draw = 0; draw < 200; ++draw) {
      std::vector<Entry> moved = centre.entries;
      // In a closed scene the diagonal entry and the areas stay. The row's sum is then not 1, and its lack returns to
      // the row.
      for (Entry& entry : moved)
        if (is_open || entry.i != entry.j) entry.exchange_area.value += random() % 2 ? width : -width;
      const FormFactors truth = te::formFactors(centre.areas, is_open ? withRest(centre.areas, moved) : moved);
      const HeatSolution of_truth = solveHeat(truth, enclosure);
      for (uint32_t i = 0; i < kBoundedRows; ++i) {
        const HeatRow &row = found.rows[i], &true_row = of_truth.rows[i];
        ASSERT_TRUE(row.bounds);
        const auto expectWithin = [&](const Measured& a, const Measured& b, double bound) {
          EXPECT_LE(std::abs(a.value - b.value), bound + kRounding) << i;
        };
        expectWithin(row.irradiation, true_row.irradiation, row.bounds->irradiation);
        expectWithin(row.radiosity, true_row.radiosity, row.bounds->radiosity);
        expectWithin(row.heat_flux, true_row.heat_flux, row.bounds->heat_flux);
        expectWithin(row.heat_flow, true_row.heat_flow, row.bounds->heat_flow);
        expectWithin(row.temperature, true_row.temperature, row.bounds->temperature);
        nearest =
            std::min(nearest, row.bounds->irradiation / std::abs(row.irradiation.value - true_row.irradiation.value));
      }
    }
    EXPECT_LT(nearest, 10);  // a tenth of the bounds would not hold
  }
}

// Intervals as wide as the form factors themselves give no bound, so the bound is infinite.
TEST(SolveBounds, AreInfiniteWhereIntervalsAreWide) {
  std::vector<Entry> entries{{0, 1, {1, 0}}, {1, 1, {0.5, 0}}};
  const FormFactors plain = te::formFactors({1, 1.5}, entries);
  const FormFactors wide(plain.ids(), plain.entries(), plain.rowSums(), {{0, 2}, {0, 1.5}});
  const HeatSolution found = solveHeat(wide, te::enclosureOf(wide, {te::hot(0.01, 400), te::flux(0.5, 10)}));
  EXPECT_TRUE(std::isinf(found.rows[0].bounds->irradiation));
  EXPECT_EQ(found.rows[0].bounds->temperature, 0);
}

// A guarantee of form factors past a sheet becomes bounds of heat. They hold the values that follow from closed forms.
TEST(SolveBounds, AGuaranteeHoldsClosedForms) {
  const InputScene input = ts::squaresPastASheet(2);
  const Scene scene = buildScene(input);
  const MaterialTable table{"sheet", {{"low", te::hot(0.8, 400), 0}, {"*", te::flux(0.5, 50), 0}}, 300};
  const FormFactors exact = ts::exactPastASheet(input, makeIds(scene, By::polygon, false));
  const HeatSolution truth =
      solveHeat(exact, assignMaterials(table, exact.ids(), {"low", "high", "sheet_down", "sheet_up"}));
  const Request request{.goal = EpsilonDelta{.epsilon = 0.02, .delta = 0.01}, .engine = EngineKind::host};
  const SceneHeat found = solveScene(scene, table, request);
  for (size_t k = 0; k < truth.rows.size(); ++k) {
    const HeatRow& row = found.heat.rows[k];
    ASSERT_TRUE(row.bounds);
    EXPECT_GT(row.bounds->irradiation, 0);
    EXPECT_LT(row.bounds->irradiation, 0.2 * truth.rows[k].irradiation.value);
    EXPECT_LE(std::abs(row.irradiation.value - truth.rows[k].irradiation.value), row.bounds->irradiation);
    EXPECT_LE(std::abs(row.temperature.value - truth.rows[k].temperature.value), row.bounds->temperature + kRounding);
  }
}

}  // namespace
}  // namespace viewpeel
