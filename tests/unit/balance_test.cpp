// These tests compare balanced form factors with solutions by hand, with the conditions of the minimum, and with an
// enumeration of all sets of nonzero pairs.
#include <viewpeel/balance.h>

#include <bit>
#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "tests/support/balance_norm.h"

namespace viewpeel {
namespace {

FormFactors matrixOf(std::vector<double> areas, std::vector<Entry> entries) {
  Ids ids;
  for (size_t k = 0; k < areas.size(); ++k) ids.names.push_back("id" + std::to_string(k));
  ids.surface.assign(areas.size(), 0);
  std::vector<Measured> row_sums(areas.size());
  ids.areas = std::move(areas);
  return {std::move(ids), std::move(entries), std::move(row_sums)};
}

// Returns the message with which balanceRows refuses the form factors.
std::string refusalOf(const FormFactors& measured) {
  try {
    balanceRows(measured);
  } catch (const Error& error) {
    EXPECT_TRUE(error.code() == ErrorCode::bad_input || error.code() == ErrorCode::bad_usage) << error.what();
    return error.what();
  }
  return "not refused";
}

// --- by hand -----------------------------------------------------------------------------------------------------

// Three rows that do not see themselves have only one solution, whatever the measured values are: x_01 = (A_0 + A_1 -
// A_2) / 2 and so on. Row sums err by kBalanceTolerance of their areas, which are 12 in all. The changes, over standard
// errors of 0.1, err by less than 1e-9.
TEST(Balance, ThreePlanarRowsAreDetermined) {
  const BalancedFormFactors balanced =
      balanceRows(matrixOf({3, 4, 5}, {{0, 1, {1.1, 0.1}}, {0, 2, {1.7, 0.1}}, {1, 2, {3.5, 0.1}}}));
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 1).value, 1, 12 * kBalanceTolerance);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 2).value, 2, 12 * kBalanceTolerance);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(1, 2).value, 3, 12 * kBalanceTolerance);
  EXPECT_NEAR(balanced.rms_change, std::sqrt((0.01 + 0.09 + 0.25) / 0.03), 1e-9);
  EXPECT_NEAR(balanced.largest_change, 5, 1e-9);
  EXPECT_NEAR(balanced.largest_form_factor_change, 0.5 / 4, 1e-9);
  EXPECT_EQ(balanced.from, 1u);
  EXPECT_EQ(balanced.to, 2u);
}

// The third row sees itself, so t = x_22 is free. The derivative of the sum of squares vanishes at the solution. Row
// sums err by 1e-12 of areas, which are 13 in all. The derivatives of t by the areas are below 0.9 here, so that every
// x errs by less than 13e-12.
TEST(Balance, ThreeRowsWithASelfView) {
  const double c01 = 1.1, c02 = 1.7, c12 = 3.2, c22 = 0.8, s01 = 0.1, s02 = 0.2, s12 = 0.05, A0 = 3, A1 = 4, A2 = 6;
  const BalancedFormFactors balanced = balanceRows(
      matrixOf({A0, A1, A2}, {{0, 1, {c01, s01}}, {0, 2, {c02, s02}}, {1, 2, {c12, s12}}, {2, 2, {c22, 0}}}));
  // x_01 = (A0 + A1 - A2 + t) / 2, x_02 = (A0 + A2 - A1 - t) / 2, x_12 = (A1 + A2 - A0 - t) / 2
  const double t =
      (1 + ((A0 + A2 - A1 - 2 * c02) / s02 + (A1 + A2 - A0 - 2 * c12) / s12 - (A0 + A1 - A2 - 2 * c01) / s01) / 4) /
      (1 / c22 + (1 / s01 + 1 / s02 + 1 / s12) / 4);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(2, 2).value, t, 1e-10);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 1).value, (A0 + A1 - A2 + t) / 2, 1e-10);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 2).value, (A0 + A2 - A1 - t) / 2, 1e-10);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(1, 2).value, (A1 + A2 - A0 - t) / 2, 1e-10);
}

// One pair has a far smaller standard error than the other pairs of its rows, and hardly moves. With x_01 = t the
// others are x_00 = A0 - t and x_11 = A1 - t.
TEST(Balance, MostCertainPairsStay) {
  const double c00 = 2.2, c01 = 0.9, c11 = 1.3, s00 = 0.1, s01 = 1e-6, s11 = 0.2, A0 = 3, A1 = 2;
  const BalancedFormFactors balanced =
      balanceRows(matrixOf({A0, A1}, {{0, 0, {c00, s00}}, {0, 1, {c01, s01}}, {1, 1, {c11, s11}}}));
  const double t = ((A0 - c00) / s00 + c01 / s01 + (A1 - c11) / s11) / (1 / s00 + 1 / s01 + 1 / s11);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 1).value, t, 1e-11);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 1).value, c01,
              3e-6);  // t - c_01 = s_01 ((A0 - c00 - c01) / s00 + (A1 - c11 - c01) / s11) = -2e-6, nearly
  EXPECT_NEAR(balanced.form_factors.exchangeArea(0, 0).value, A0 - t, 1e-11);
}

// Rows that already sum to 1 keep every bit.
TEST(Balance, BalancedRowsStay) {
  const FormFactors measured = matrixOf({3, 4, 5}, {{0, 1, {1, 0.1}}, {0, 2, {2, 0.1}}, {1, 2, {3, 0.1}}});
  const BalancedFormFactors balanced = balanceRows(measured);
  EXPECT_EQ(valuesOf(balanced.form_factors), valuesOf(measured));
  EXPECT_EQ(balanced.steps, 0u);
  EXPECT_EQ(balanced.rms_change, 0);
}

// Two plates see only each other. Both rows give the same equation, so the Hessian is singular.
TEST(Balance, TwoPlates) {
  const FormFactors balanced = balanceRows(matrixOf({2, 2}, {{0, 1, {1.9, 0.1}}})).form_factors;
  EXPECT_NEAR(balanced.formFactor(0, 1).value, 1, kBalanceTolerance);
  EXPECT_EQ(balanced.formFactor(0, 1).value, balanced.formFactor(1, 0).value);
}

// --- against the conditions of the minimum, and against an enumeration --------------------------------------------

struct Instance {
  FormFactors measured;
  std::string name;
};

// Makes `count` rows of which a share `density` of all pairs was met. Areas are row sums of a feasible x, 30 % of whose
// entries are 0. Measured values differ from x by factors up to exp(spread).
Instance randomInstance(uint32_t count, double density, double spread, bool self_views, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> areas(count, 0);
  std::vector<Entry> entries;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + !self_views; j < count; ++j) {
      if (j != i + 1 && uniform(random) > density) continue;
      const double x = j == i + 1 || uniform(random) < 0.7 ? std::exp(4 * uniform(random)) : 0;
      areas[i] += x;
      if (i != j) areas[j] += x;
      const double c = (x > 0 ? x : 1) * std::exp(spread * (2 * uniform(random) - 1));
      entries.push_back({i, j, {c, c * (0.01 + 1.1 * uniform(random))}});
    }
  return {matrixOf(areas, entries),
          "count " + std::to_string(count) + ", spread " + std::to_string(spread) + ", seed " + std::to_string(seed)};
}

// The problem is convex, so x is its solution if rows sum to their areas and one multiplier for each row explains every
// entry.
TEST(Balance, ConditionsOfTheMinimum) {
  size_t zeros = 0, positive = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    const Instance instance =
        randomInstance(seed % 3 ? 40 : 300, seed % 2 ? 0.1 : 0.8, seed % 5 ? 0.3 : 2.5, seed % 4 < 2, seed);
    SCOPED_TRACE(instance.name);
    const FormFactors& measured = instance.measured;
    const BalancedFormFactors balanced = balanceRows(measured);
    std::vector<double> sums(measured.ids().count(), 0);
    for (size_t k = 0; k < measured.entries().size(); ++k) {
      const auto& [i, j, x, in_sums] = balanced.form_factors.entries()[k];
      const double c = measured.entries()[k].exchange_area.value, w = weightOf(measured.entries()[k].exchange_area);
      const double pull = balanced.row_corrections[i] + (i == j ? 0 : balanced.row_corrections[j]);
      const double rounding =
          4e-16 * (c + w * (std::abs(balanced.row_corrections[i]) + std::abs(balanced.row_corrections[j])));
      ASSERT_GE(x.value, 0);
      if (x.value > 0) ASSERT_NEAR((x.value - c), w * pull, rounding);  // the derivative is 0
      else ASSERT_LE(c + w * pull, rounding);                           // the derivative pushes the entry to 0
      (x.value > 0 ? positive : zeros)++;
      sums[i] += x.value;
      if (i != j) sums[j] += x.value;
    }
    // These sums are in another order, so they differ by n more roundings.
    const double rounding = 1.2e-16 * double(sums.size());
    for (size_t i = 0; i < sums.size(); ++i)
      ASSERT_NEAR(sums[i] / measured.ids().areas[i], 1, kBalanceTolerance + rounding) << "row " << i;
  }
  EXPECT_GT(zeros, 100u);  // the bound 0 is reached, in few entries
  EXPECT_GT(positive, 10 * zeros);
}

// Enumerates all sets of pairs that may be positive. Returns the solution of least change that keeps the row sums and
// has no negative entry.
std::vector<double> enumerateBalanced(const FormFactors& measured) {
  const Eigen::Index n = measured.ids().count();
  const size_t count = measured.entries().size();
  const Eigen::VectorXd areas = Eigen::Map<const Eigen::VectorXd>(measured.ids().areas.data(), n);
  std::vector<double> best;
  for (uint32_t set = 1; set < 1u << count; ++set) {
    // z is the minimum-norm solution of B D z = A - B c over the set, with x = c + D z and D^2 = w.
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n, std::popcount(set));
    Eigen::VectorXd missing = areas;
    std::vector<size_t> members;
    for (size_t k = 0; k < count; ++k) {
      if (!(set >> k & 1)) continue;
      const auto& [i, j, c, in_sums] = measured.entries()[k];
      for (uint32_t row : {i, j}) rows(row, members.size()) = std::sqrt(weightOf(c));
      missing[i] -= c.value;
      if (i != j) missing[j] -= c.value;
      members.push_back(k);
    }
    const Eigen::VectorXd z = rows.completeOrthogonalDecomposition().solve(missing);
    if ((rows * z - missing).cwiseAbs().maxCoeff() > 1e-9 * areas.maxCoeff()) continue;
    std::vector<double> x(count, 0);
    for (size_t m = 0; m < members.size(); ++m) {
      const Measured& c = measured.entries()[members[m]].exchange_area;
      x[members[m]] = c.value + std::sqrt(weightOf(c)) * z[m];
    }
    if (*std::min_element(x.begin(), x.end()) < 0) continue;
    if (best.empty() || objective(measured, x) < objective(measured, best)) best = x;
  }
  return best;
}

TEST(Balance, AgreesWithEnumeration) {
  size_t zeros = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const Instance instance = randomInstance(4, 0.9, seed % 2 ? 0.5 : 2, seed % 3 == 0, seed);
    SCOPED_TRACE(instance.name);
    const std::vector<double> x = valuesOf(balanceRows(instance.measured).form_factors),
                              best = enumerateBalanced(instance.measured);
    ASSERT_EQ(best.size(), x.size());
    // The enumeration keeps row sums to 1e-9 and the solver to 1e-12. Ratios of weights w amplify these errors in
    // single entries.
    for (size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(x[k], best[k], 1e-6) << "entry " << k;
    zeros += std::count(x.begin(), x.end(), 0.0);
  }
  EXPECT_GT(zeros, 10u);
}

TEST(Balance, EnumerationFindsAWrongWeight) {
  const Instance instance = randomInstance(4, 1, 0.5, true, 7);
  std::vector<Entry> entries = instance.measured.entries();
  entries[3].exchange_area.value *= 1.01;
  const std::vector<double> x = valuesOf(balanceRows(instance.measured).form_factors);
  const std::vector<double> other = enumerateBalanced({instance.measured.ids(), entries, instance.measured.rowSums()});
  double difference = 0;
  for (size_t k = 0; k < x.size(); ++k) difference = std::max(difference, std::abs(x[k] - other[k]));
  EXPECT_GT(difference, 1e-4);
}

// Rows of one half see only rows of the other half, so there are no self views and no odd cycles. The Hessian is
// singular at every point.
TEST(Balance, TwoSidesOfManyRows) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0.5, 2);
  const uint32_t side = 200;
  std::vector<double> areas(2 * side, 0);
  std::vector<Entry> entries;
  for (uint32_t i = 0; i < side; ++i)
    for (uint32_t j = side; j < 2 * side; ++j) {
      const double x = uniform(random);
      areas[i] += x;
      areas[j] += x;
      entries.push_back({i, j, {x * uniform(random), 0.1}});
    }
  const BalancedFormFactors balanced = balanceRows(matrixOf(areas, entries));
  for (const Measured& sum : balanced.form_factors.rowSums()) EXPECT_NEAR(sum.value, 1, kBalanceTolerance);
  areas[3] *= 1.001;
  EXPECT_NE(refusalOf(matrixOf(areas, entries)).find("hit only rows of area"), std::string::npos);
}

// Neither the unit of length nor areas that differ by 10^8 change the result.
TEST(Balance, ScalesAndSmallRows) {
  Instance instance = randomInstance(60, 0.5, 0.3, true, 11);
  const std::vector<double> x = valuesOf(balanceRows(instance.measured).form_factors);
  std::vector<double> areas = instance.measured.ids().areas;
  std::vector<Entry> entries = instance.measured.entries();
  for (double& area : areas) area *= 0x1p-40;
  for (Entry& entry : entries) {
    entry.exchange_area.value *= 0x1p-40;
    entry.exchange_area.standard_error *= 0x1p-40;
  }
  const std::vector<double> scaled = valuesOf(balanceRows(matrixOf(areas, entries)).form_factors);
  for (size_t k = 0; k < x.size(); ++k) EXPECT_EQ(scaled[k], x[k] * 0x1p-40);

  const double tiny = 1e-8;
  const BalancedFormFactors balanced = balanceRows(
      matrixOf({3, 4, 5, tiny}, {{0, 1, {1.1, 0.1}}, {0, 2, {1.7, 0.1}}, {1, 2, {3.5, 0.1}}, {1, 3, {tiny / 3, 0.1}}}));
  for (const Measured& sum : balanced.form_factors.rowSums()) EXPECT_NEAR(sum.value, 1, kBalanceTolerance);
  EXPECT_NEAR(balanced.form_factors.formFactor(3, 1).value, 1, kBalanceTolerance);
}

// --- refusals ----------------------------------------------------------------------------------------------------

TEST(Balance, RefusesWhatCannotBeBalanced) {
  const std::vector<Entry> three = {{0, 1, {1.1, 0.1}}, {0, 2, {1.7, 0.1}}, {1, 2, {3.5, 0.1}}};
  const auto with = [&](const Entry& entry) {
    std::vector<Entry> entries = three;
    entries.insert(
        std::upper_bound(entries.begin(), entries.end(), entry,
                         [](const Entry& a, const Entry& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); }),
        entry);
    return matrixOf({3, 4, 5}, entries);
  };
  EXPECT_NE(refusalOf(with({1, kEnvironment, {0.12, 0.1}})).find("1 % of all emitted radiation leaves"),
            std::string::npos);
  EXPECT_NE(refusalOf(with({2, kLeak, {0.12, 0.1}})).find("1 % ends on backs"), std::string::npos);
  EXPECT_NE(refusalOf(matrixOf({3, 4, 5, 1}, three)).find("no line from 'id3'"), std::string::npos);
  // Lines from id2 hit id1 alone, which is smaller.
  EXPECT_NE(refusalOf(matrixOf({3, 4, 5}, {{0, 1, {1, 0.1}}, {0, 0, {2, 0.1}}, {1, 2, {3, 0.1}}}))
                .find("'id2' of area 5 hit only rows of area 4"),
            std::string::npos);
  // Lines from three rows hit only one row. It is larger than each of them, but smaller than all together.
  EXPECT_NE(refusalOf(matrixOf({4, 2, 2, 2}, {{0, 0, {1, 0.1}}, {0, 1, {1, 0.1}}, {0, 2, {1, 0.1}}, {0, 3, {1, 0.1}}}))
                .find("and 2 more rows of area 6 hit only rows of area 4"),
            std::string::npos);
  EXPECT_NE(refusalOf(matrixOf({2, 2.001}, {{0, 1, {1.9, 0.1}}})).find("'id1' of area 2.001 hit only rows of area 2;"),
            std::string::npos);
  Ids some = matrixOf({3, 4, 5}, three).ids();
  some.requested = {true, false, true};
  EXPECT_NE(refusalOf({some, three, {{}, {}, {}}}).find("--from"), std::string::npos);
}

// Where one line in 10^7 leaves a row by grazing an edge, the row is not open. Its radiation goes to the rows that it
// was measured to see.
TEST(Balance, GrazingLinesAreNoOpening) {
  const BalancedFormFactors balanced = balanceRows(matrixOf({3, 4, 5}, {{0, 1, {1.1, 0.1}},
                                                                        {0, 2, {1.7, 0.1}},
                                                                        {0, kEnvironment, {1e-7, 1e-7}},
                                                                        {1, 2, {3.5, 0.1}},
                                                                        {1, kLeak, {1e-7, 1e-7}}}));
  ASSERT_EQ(balanced.form_factors.entries().size(), 5u);
  EXPECT_EQ(balanced.form_factors.formFactor(0, kEnvironment).value, 0);
  EXPECT_EQ(balanced.form_factors.formFactor(1, kLeak).value, 0);
  EXPECT_NEAR(balanced.form_factors.exchangeArea(1, 2).value, 3, 12 * kBalanceTolerance);
}

}  // namespace
}  // namespace viewpeel
