// These tests compare standard errors of heat flows and temperatures with finite differences, with the spread of random
// draws, and with the coverage of intervals.
#include <random>

#include <gtest/gtest.h>

#include "scenes/heat_scenes.h"
#include "solve/carry_pair_errors.h"
#include "solve/heat_errors.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using reference::test::isWithin;
using Entry = FormFactors::Entry;

constexpr uint32_t kRows = 12;

// RandomRows has random exchange areas with random standard errors of `error` at most. Rows sum to 1, in an open scene
// together with an environment.
struct RandomRows {
  std::vector<double> areas = std::vector<double>(kRows);
  std::vector<Entry> entries;
  bool environment_is_rest;

  RandomRows(bool is_open, bool is_rest, double error) : environment_is_rest(is_rest) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(0.1, 1);
    std::vector<double> sums(kRows);
    for (uint32_t i = 0; i < kRows; ++i)
      for (uint32_t j = i; j < kRows; ++j) {
        const double exchange = uniform(random);
        entries.push_back({i, j, {exchange, error * uniform(random)}});
        sums[i] += exchange;
        if (i != j) sums[j] += exchange;
      }
    for (uint32_t i = 0; i < kRows; ++i) {
      const double environment = is_open ? uniform(random) : 0;
      areas[i] = sums[i] + environment;
      if (is_open) entries.push_back({i, kEnvironment, {environment, error * uniform(random)}});
    }
    sort();
  }
  void sort() {
    std::ranges::sort(entries, {}, [](const Entry& entry) { return std::pair(entry.i, entry.j); });
  }
  FormFactors formFactors() const { return te::formFactors(areas, entries); }
  // Changes entry k by `share` standard errors. Where the environment is the rest of its row, it changes by as much the
  // other way.
  void change(size_t k, double share) {
    const double by = share * entries[k].exchange_area.standard_error;
    entries[k].exchange_area.value += by;
    if (!environment_is_rest || entries[k].j == kEnvironment) return;
    for (Entry& entry : entries)
      if (entry.j == kEnvironment && (entry.i == entries[k].i || entry.i == entries[k].j))
        entry.exchange_area.value -= by;
  }
  bool isFree(size_t k) const { return !environment_is_rest || entries[k].j != kEnvironment; }
};

std::vector<Material> mixedMaterials() {
  std::vector<Material> materials;
  for (uint32_t i = 0; i < kRows; ++i) {
    const double emissivity = i % 4 == 0 ? 1 : 0.2 * (i % 4);
    materials.push_back(i % 3 == 2 ? te::flux(emissivity, 40.0 * i - 200) : te::hot(emissivity, 280 + 10 * i));
  }
  return materials;
}

// Returns all measured values of a solution in one list.
std::vector<Measured> answersOf(const HeatSolution& solution) {
  std::vector<Measured> answers{solution.to_environment, solution.to_up.value_or(Measured{}),
                                solution.to_down.value_or(Measured{})};
  for (const auto* rows : {&solution.rows, &solution.surfaces})
    for (const HeatRow& row : *rows)
      for (const Measured& value : {row.temperature, row.radiosity, row.irradiation, row.heat_flux, row.heat_flow})
        answers.push_back(value);
  return answers;
}

Enclosure withBands(Enclosure enclosure) {
  enclosure.band_limits_um = {6, 15};
  for (Material& material : enclosure.materials)
    material.band_emissivities = {material.emissivity, 0.5 * material.emissivity, 0.9};
  return enclosure;
}

// Solves for heat with three surfaces of four rows each.
HeatSolution solveRows(const FormFactors& f, const std::optional<EnvironmentParts>& parts = {},
                       bool has_bands = false) {
  Ids ids = f.ids();
  for (uint32_t i = 0; i < kRows; ++i) ids.surface[i] = i / 4;
  FormFactors grouped(ids, f.entries(), f.rowSums());
  Enclosure enclosure{mixedMaterials(), 270, {"a", "b", "c"}};
  if (parts) {
    enclosure.environment_temperature.reset();
    enclosure.sky_and_ground = {250, 290};
    enclosure.environment_parts = parts;
  }
  return solveHeat(grouped, has_bands ? withBands(std::move(enclosure)) : enclosure);
}

HeatSolution solve(const FormFactors& f) { return solveRows(f); }

// Returns shares of the part above the horizon. Their errors, of three replicates, are correlated between rows.
EnvironmentParts randomParts(double error) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  EnvironmentParts parts;
  parts.up_share_errors.assign(3, std::vector<double>(kRows));
  for (uint32_t i = 0; i < kRows; ++i) {
    parts.up_share.push_back({uniform(random), 0});
    for (std::vector<double>& of_replicate : parts.up_share_errors) of_replicate[i] = error * (uniform(random) - 0.5);
  }
  return parts;
}

class SolveErrors : public testing::TestWithParam<std::tuple<bool, bool>> {};

// The standard errors equal central differences, for which each entry moves by its standard error both ways. Central
// differences leave third-order terms, 1e-6 of the first order, and the rounding of a solution, 1e-12 / 1e-4.
TEST_P(SolveErrors, EqualCentralDifferences) {
  const auto [is_open, is_rest] = GetParam();
  const RandomRows rows(is_open, is_rest, 1e-4);
  // Here the sum of a row is not quite 1, so that the environment counts as measured, with an error of its own.
  RandomRows measured = rows;
  if (is_open && !is_rest)
    for (Entry& entry : measured.entries)
      if (entry.i == entry.j) entry.exchange_area.value += 1e-9;
  const std::vector<Measured> answers = answersOf(solve(measured.formFactors()));
  std::vector<double> variances(answers.size());
  for (size_t k = 0; k < rows.entries.size(); ++k) {
    if (!rows.isFree(k)) continue;
    RandomRows up = measured, down = measured;
    up.change(k, 1), down.change(k, -1);
    const std::vector<Measured> above = answersOf(solve(up.formFactors())),
                                below = answersOf(solve(down.formFactors()));
    for (size_t a = 0; a < answers.size(); ++a) variances[a] += std::pow((above[a].value - below[a].value) / 2, 2);
  }
  double largest = 0;
  for (size_t a = 0; a < answers.size(); ++a) {
    const double truth = std::sqrt(variances[a]);
    EXPECT_TRUE(isWithin(answers[a].standard_error, truth, 1e-5 * truth + 1e-9)) << "answer " << a;
    if (answers[a].standard_error > 1e-6) {
      EXPECT_FALSE(isWithin(1.001 * answers[a].standard_error, truth, 1e-5 * truth + 1e-9));
    }
    largest = std::max(largest, truth);
  }
  EXPECT_GT(largest, 1e-4);  // something was compared
}

// With sky and ground, entries move by their standard errors, and shares by each replicate's contribution to their
// errors. Bands of wavelengths are tested in the same way.
TEST(SolveErrors, SkyAndGroundEqualCentralDifferences) {
  for (const int kind : {0, 1, 2, 3}) {
    const bool is_rest = kind % 2 == 1, bands = kind / 2 == 1;
    const auto solve = [&](const FormFactors& f, const EnvironmentParts& of) { return solveRows(f, of, bands); };
    const RandomRows rows(true, is_rest, 1e-4);
    RandomRows measured = rows;
    if (!is_rest)
      for (Entry& entry : measured.entries)
        if (entry.i == entry.j) entry.exchange_area.value += 1e-9;  // as above
    const EnvironmentParts parts = randomParts(1e-4);
    const std::vector<Measured> answers = answersOf(solve(measured.formFactors(), parts));
    std::vector<double> variances(answers.size());
    const auto addDifferences = [&](const HeatSolution& above, const HeatSolution& below) {
      const std::vector<Measured> up = answersOf(above), down = answersOf(below);
      for (size_t a = 0; a < answers.size(); ++a) variances[a] += std::pow((up[a].value - down[a].value) / 2, 2);
    };
    for (size_t k = 0; k < rows.entries.size(); ++k) {
      if (!rows.isFree(k)) continue;
      RandomRows up = measured, down = measured;
      up.change(k, 1), down.change(k, -1);
      addDifferences(solve(up.formFactors(), parts), solve(down.formFactors(), parts));
    }
    for (const std::vector<double>& errors : parts.up_share_errors) {
      EnvironmentParts up = parts, down = parts;
      for (uint32_t i = 0; i < kRows; ++i) up.up_share[i].value += errors[i], down.up_share[i].value -= errors[i];
      addDifferences(solve(measured.formFactors(), up), solve(measured.formFactors(), down));
    }
    for (size_t a = 0; a < answers.size(); ++a) {
      const double truth = std::sqrt(variances[a]);
      // With bands, temperatures are found to 1e-10 K, which differences show, and responses to 1e-7.
      EXPECT_TRUE(isWithin(answers[a].standard_error, truth, 1e-5 * truth + (bands ? 1e-7 : 1e-9))) << "answer " << a;
    }
    for (size_t a = 0; a < 3; ++a) EXPECT_GT(answers[a].standard_error, 1e-4);  // outside, above, below
    EXPECT_TRUE(isWithin(answers[0].value, answers[1].value + answers[2].value, 1e-9 * std::abs(answers[1].value)));
    EXPECT_LE(std::abs(solve(measured.formFactors(), parts).balance_residual), bands ? 1e-7 : 1e-9);
  }
}

// If only shares are uncertain, their errors need no random signs. So probes have the inverse's errors to 1e-7, the
// residual of rough solutions.
TEST(SolveErrors, ProbesOfSkyAndGroundAreTheInverse) {
  const FormFactors f = RandomRows(true, true, 0).formFactors();
  const ClosedExchange closed = closeRows(f);
  const Eigen::VectorXd reflectivity = Eigen::VectorXd::LinSpaced(kRows, 0, 0.99),
                        radiosity = Eigen::VectorXd::LinSpaced(kRows, -100, 300);
  Enclosure enclosure{mixedMaterials(), {}, {}};
  enclosure.sky_and_ground = {250, 290};
  enclosure.environment_parts = randomParts(1e-3);
  const Outside outside =
      makeOutside(closed, enclosure, [](double temperature) { return te::power(temperature) - 200; });
  const Irradiation irradiation(closed, reflectivity);
  const HeatErrors exact(f, closed, irradiation, radiosity, outside),
      probed(f, closed, irradiation, radiosity, outside, 0);
  for (uint32_t k = 0; k < kRows; ++k) {
    const double truth = exact.standardError({{k, 1}});
    EXPECT_GT(truth, 0);
    EXPECT_TRUE(isWithin(probed.standardError({{k, 1}}), truth, 1e-5 * truth)) << k;
  }
  for (const auto part : {HeatErrors::Part::all, HeatErrors::Part::up, HeatErrors::Part::down}) {
    const double truth = exact.environmentError(reflectivity, part);
    EXPECT_TRUE(isWithin(probed.environmentError(reflectivity, part), truth, 1e-5 * truth));
  }
}

// With bands the test is the same as ProbesComeToTheInverse.
TEST(SolveErrors, ProbesOfBandsComeToTheirSources) {
  const FormFactors f = RandomRows(true, true, 1e-3).formFactors();
  const ClosedExchange closed = closeRows(f);
  const Enclosure enclosure = withBands({mixedMaterials(), 270, {}});
  BandSystem system(closed, enclosure);
  system.solve(f.ids().names);
  const BandErrors exact = carryPairErrors(f, closed, system), probed = carryPairErrors(f, closed, system, 0);
  for (const auto answer : {BandErrors::kTemperature, BandErrors::kRadiosity, BandErrors::kIrradiation})
    for (uint32_t k = 2; k < kRows; k += 3) {  // rows of given heat fluxes
      const double truth = exact.standardError(answer, {{k, 1}});
      EXPECT_GT(truth, 0);
      EXPECT_TRUE(isWithin(probed.standardError(answer, {{k, 1}}), truth, 5.0 / 16 * truth)) << k;
      EXPECT_FALSE(isWithin(2 * probed.standardError(answer, {{k, 1}}), truth, 5.0 / 16 * truth)) << k;
    }
  EXPECT_TRUE(isWithin(probed.toEnvironment(), exact.toEnvironment(), 5.0 / 16 * exact.toEnvironment()));
}

INSTANTIATE_TEST_SUITE_P(Rows, SolveErrors,
                         testing::Values(std::tuple(false, false), std::tuple(true, false), std::tuple(true, true)));

// 128 random sign vectors estimate a standard error to 1/16 of itself; the inverse matrix gives it exactly. A deviation
// of five times this happens in fewer than 1 of 10^5 comparisons.
TEST(SolveErrors, ProbesComeToTheInverse) {
  for (const bool is_open : {false, true}) {
    const RandomRows rows(is_open, is_open, 1e-3);
    const FormFactors f = rows.formFactors();
    const ClosedExchange closed = closeRows(f);
    const Eigen::VectorXd reflectivity = Eigen::VectorXd::LinSpaced(kRows, 0, 0.99),
                          radiosity = Eigen::VectorXd::LinSpaced(kRows, -100, 300);
    const Irradiation irradiation(closed, reflectivity);
    const Outside outside{.up_share = Eigen::VectorXd::Ones(kRows), .power = Eigen::VectorXd::Zero(kRows)};
    const HeatErrors exact(f, closed, irradiation, radiosity, outside),
        probed(f, closed, irradiation, radiosity, outside, 0);
    for (uint32_t k = 0; k < kRows; ++k) {
      const std::vector<HeatErrors::Term> terms{{k, 1}, {(k + 1) % kRows, 0.5}};
      const double truth = exact.standardError(terms);
      EXPECT_TRUE(isWithin(probed.standardError(terms), truth, 5.0 / 16 * truth)) << k;
      EXPECT_FALSE(isWithin(2 * probed.standardError(terms), truth, 5.0 / 16 * truth)) << k;
    }
    const double truth = exact.environmentError(reflectivity);
    EXPECT_TRUE(isWithin(probed.environmentError(reflectivity), truth, 5.0 / 16 * truth));
  }
}

// Conjugate gradients and the inverse matrix give the same solution of the same equations.
// Pairs of which all lines agreed have a margin, which a sum over many pairs leaves out. The variance of an answer has
// the largest part that such a margin of one pair gives it, beside the parts of all errors in sums.
TEST(SolveErrors, HaveTheMarginOfOnePair) {
  RandomRows rows(true, true, 1e-3);
  const auto variancesOf = [&] {
    std::vector<double> variances;
    for (const Measured& answer : answersOf(solve(rows.formFactors())))
      variances.push_back(answer.standard_error * answer.standard_error);
    return variances;
  };
  std::vector<double> expected = variancesOf();
  const std::vector<Entry> measured = rows.entries;
  constexpr double kMargin = 4;  // standard error over error in sums
  std::vector<double> largest(expected.size());
  for (size_t k = 0; k < measured.size(); k += 7) {
    if (measured[k].j == kEnvironment) continue;
    for (size_t m = 0; m < measured.size(); ++m)
      rows.entries[m].exchange_area.standard_error =
          m == k ? std::sqrt(kMargin * kMargin - 1) * measured[k].exchange_area.standard_error : 0;
    const std::vector<double> of_pair = variancesOf();
    for (size_t answer = 0; answer < largest.size(); ++answer)
      largest[answer] = std::max(largest[answer], of_pair[answer]);
  }
  rows.entries = measured;
  for (size_t k = 0; k < measured.size(); k += 7) {
    if (measured[k].j == kEnvironment) continue;
    rows.entries[k].error_in_sums = measured[k].exchange_area.standard_error;
    rows.entries[k].exchange_area.standard_error *= kMargin;
  }
  const std::vector<double> found = variancesOf();
  int with_margin = 0;
  for (size_t answer = 0; answer < found.size(); ++answer) {
    expected[answer] += largest[answer];
    EXPECT_NEAR(found[answer], expected[answer], 1e-9 * expected[answer]) << answer;
    with_margin += largest[answer] > 0;
  }
  EXPECT_GT(with_margin, 12);
}

// Where nothing is reflected, answers depend on the pairs of their own row alone, and probes have the same margin.
TEST(SolveErrors, ProbesHaveTheMarginOfTheirRow) {
  RandomRows rows(true, true, 0);
  rows.entries[1].exchange_area.standard_error = 1e-3, rows.entries[1].error_in_sums = 1e-9;
  const FormFactors f = rows.formFactors();
  const ClosedExchange closed = closeRows(f);
  const Eigen::VectorXd black = Eigen::VectorXd::Zero(kRows), radiosity = Eigen::VectorXd::LinSpaced(kRows, -100, 300);
  const Irradiation irradiation(closed, black);
  const Outside outside{.up_share = Eigen::VectorXd::Ones(kRows), .power = Eigen::VectorXd::Constant(kRows, 500)};
  const HeatErrors exact(f, closed, irradiation, radiosity, outside),
      probed(f, closed, irradiation, radiosity, outside, 0);
  for (const uint32_t row : {rows.entries[1].i, rows.entries[1].j}) {
    const double truth =
        1e-3 * std::abs(radiosity[rows.entries[1].i + rows.entries[1].j - row] - 500) / rows.areas[row];
    EXPECT_NEAR(exact.standardError({{row, 1}}), truth, 1e-5 * truth);
    EXPECT_NEAR(probed.standardError({{row, 1}}), truth, 1e-5 * truth);
  }
}

TEST(SolveErrors, TheInverseIsTheSolution) {
  const RandomRows rows(true, true, 1e-3);
  const FormFactors f = rows.formFactors();
  const ClosedExchange closed = closeRows(f);
  const Eigen::VectorXd reflectivity = Eigen::VectorXd::LinSpaced(kRows, 0, 1), b = Eigen::VectorXd::Random(kRows);
  const Irradiation irradiation(closed, reflectivity);
  const Eigen::VectorXd h = irradiation.solve(b),
                        residual = closed.areas.cwiseProduct(h) - closed.pairs * reflectivity.cwiseProduct(h) - b;
  EXPECT_LE(residual.norm(), 1e-12 * b.norm());
  EXPECT_LE((irradiation.inverse() * b - h).norm(), 1e-12 * h.norm());
}

// Entries get normal errors of their standard error in 400 draws. The 95 % interval of each answer holds the truth in
// 95 % of them, within 0.049: 4.5 standard deviations of the binomial distribution. There are 61 answers and three
// kinds of rows, so chance passes this bound in one of 800 runs; seeds are fixed. Second-order terms are 1e-3 of the
// first and are left out.
TEST_P(SolveErrors, IntervalsHoldTheTruth) {
  const auto [is_open, is_rest] = GetParam();
  constexpr uint32_t kDraws = 400;
  constexpr double kBound = 0.049;
  const RandomRows rows(is_open, is_rest, 1e-3);
  const std::vector<Measured> truth = answersOf(solve(rows.formFactors()));
  std::vector<uint32_t> held(truth.size()), held_by_half(truth.size());
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (uint32_t draw = 0; draw < kDraws; ++draw) {
    RandomRows drawn = rows;
    for (size_t k = 0; k < rows.entries.size(); ++k)
      if (rows.isFree(k)) drawn.change(k, normal(random));
    if (is_open && !is_rest)
      for (Entry& entry : drawn.entries)
        if (entry.i == entry.j) entry.exchange_area.value += 1e-9;  // as in EqualCentralDifferences
    const std::vector<Measured> answers = answersOf(solve(drawn.formFactors()));
    for (size_t a = 0; a < truth.size(); ++a) {
      const double off = std::abs(answers[a].value - truth[a].value);
      held[a] += off <= 1.96 * answers[a].standard_error + 1e-9;
      held_by_half[a] += off <= 0.98 * answers[a].standard_error + 1e-9;
    }
  }
  uint32_t compared = 0;
  for (size_t a = 0; a < truth.size(); ++a) {
    if (truth[a].standard_error < 1e-6) continue;
    ++compared;
    EXPECT_TRUE(isWithin(double(held[a]) / kDraws, 0.95, kBound)) << "answer " << a;
    EXPECT_FALSE(isWithin(double(held_by_half[a]) / kDraws, 0.95, kBound)) << "answer " << a;  // negative control
  }
  EXPECT_GE(compared, 40u);
}

// Compares heat from pair lines past a sheet with closed forms, for 60 seeds. With Student's t of 7 degrees of freedom
// intervals hold the truth in 95 % of cases or more. Even if all answers of a run held or failed together, fewer than
// 48 of 60 runs would hold with a chance of 1e-5.
TEST(SolveErrors, PairLinesHoldClosedForms) {
  constexpr uint32_t kSeeds = 60;
  constexpr double kQuantile = 2.365;
  const InputScene input = ts::squaresPastASheet(2);
  const Scene scene = buildScene(input);
  const MaterialTable table{
      "sheet", {{"low", te::hot(0.8, 400), 0}, {"high", te::flux(0.6, 50), 0}, {"*", te::flux(0.3, 0), 0}}, 300};
  const FormFactors exact = ts::exactPastASheet(input, makeIds(scene, By::polygon, false));
  const HeatSolution truth =
      solveHeat(exact, assignMaterials(table, exact.ids(), {"low", "high", "sheet_down", "sheet_up"}));
  uint32_t compared = 0, held = 0, held_by_quarter = 0;
  double squares = 0;
  for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const Request request{.goal = Tolerance{1e-2}, .pair_lines = true, .seed = seed, .engine = EngineKind::host};
    const SceneHeat found = solveScene(scene, table, request);
    for (size_t k = 0; k < truth.rows.size(); ++k)
      for (const auto of : {&HeatRow::temperature, &HeatRow::irradiation}) {
        const Measured answer = found.heat.rows[k].*of;
        if (!(answer.standard_error > 1e-3)) continue;
        const double off = std::abs(answer.value - (truth.rows[k].*of).value) / answer.standard_error;
        ++compared, held += off <= kQuantile, held_by_quarter += off <= kQuantile / 4, squares += off * off;
      }
  }
  EXPECT_GT(compared, 8 * kSeeds);
  EXPECT_GE(held, 0.8 * compared);
  EXPECT_LT(held_by_quarter, 0.8 * compared);     // negative control
  EXPECT_GE(std::sqrt(squares / compared), 0.5);  // standard errors are at most twice the actual ones
}

}  // namespace
}  // namespace viewpeel
