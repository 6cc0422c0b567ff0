// These tests compare exchange factors with solveHeat() on the same form factors and with closed forms. They also check
// that small exchange factors can be dropped without loss of energy.
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "scenes/named_scenes.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using reference::test::isWithin;

// Returns random rows whose sums differ from 1 by as much as sampling errors do. In an open scene half of them see the
// environment.
FormFactors randomRows(uint32_t n, bool is_open) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> areas(n);
  std::vector<FormFactors::Entry> entries;
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = i; j < n; ++j) {
      const double exchange = std::pow(uniform(random), 8);  // a few entries are large, most are small
      entries.push_back({i, j, {exchange, 0}});
      areas[i] += exchange;
      if (j != i) areas[j] += exchange;
    }
    if (!is_open || i % 2) continue;
    entries.push_back({i, kEnvironment, {0.3, 0}});
    areas[i] += 0.3;
  }
  for (double& area : areas) area *= 1 + 0.01 * uniform(random);
  return te::formFactors(areas, entries);
}

std::vector<Material> materialsOf(uint32_t n) {
  std::vector<Material> materials;
  for (uint32_t i = 0; i < n; ++i)
    materials.push_back(te::hot(i % 5 == 0 ? 1 : i % 5 == 1 ? 1e-3 : 0.2 * (i % 5), 250 + 7.0 * i));
  return materials;
}

// Returns for each row the heat flow, W, and the sum of the absolute values of its terms.
std::vector<std::pair<double, double>> flowsOf(const ExchangeFactors& factors, const Enclosure& enclosure) {
  std::vector<std::pair<double, double>> flows(factors.names.size());
  const auto powerOf = [&](uint32_t i) {
    return te::power(i == kEnvironment ? *enclosure.environment_temperature : *enclosure.materials[i].temperature);
  };
  for (const ExchangeFactors::Entry& entry : factors.entries) {
    const double flow = entry.conductor * (powerOf(entry.i) - powerOf(entry.j));
    const auto add = [&](uint32_t i, double value) { flows[i].first += value, flows[i].second += std::abs(value); };
    add(entry.i, flow);
    if (entry.j != kEnvironment) add(entry.j, -flow);
  }
  return flows;
}

std::vector<double> rowSums(const ExchangeFactors& factors) {
  std::vector<double> sums(factors.names.size());
  for (const ExchangeFactors::Entry& entry : factors.entries) {
    sums[entry.i] += entry.conductor;
    if (entry.j != kEnvironment && entry.j != entry.i) sums[entry.j] += entry.conductor;
  }
  for (size_t i = 0; i < sums.size(); ++i) sums[i] /= factors.areas[i] * factors.emissivities[i];
  return sums;
}

// Exchange factors and solveHeat() give the same heat flows for random materials, in open and closed scenes.
// solveHeat() satisfies its equations to 1e-13 of the right side; ten times as much of a row's terms is allowed.
TEST(ExchangeFactors, GiveTheFlowsOfSolveHeat) {
  for (const bool is_open : {false, true}) {
    const FormFactors f = randomRows(40, is_open);
    const Enclosure enclosure{materialsOf(40), 270, f.ids().names};
    const HeatSolution heat = solveHeat(f, enclosure);
    const ExchangeFactors factors = findExchangeFactors(f, enclosure);
    const auto flows = flowsOf(factors, enclosure);
    for (size_t i = 0; i < flows.size(); ++i) {
      EXPECT_TRUE(isWithin(flows[i].first, heat.rows[i].heat_flow.value, 1e-12 * flows[i].second)) << i;
      EXPECT_FALSE(isWithin(flows[i].first * (1 + 1e-8), heat.rows[i].heat_flow.value, 1e-12 * flows[i].second));
    }
    for (const double sum : rowSums(factors)) EXPECT_TRUE(isWithin(sum, 1, 1e-12));
    EXPECT_EQ(factors.dropped, 0u);
  }
}

// The inner row sees the outer row alone; the outer row sees itself, too. Of the inner row's emission A_1 e_1 the outer
// row absorbs a share, counting all reflections. It is e_2 / (1 - (1 - e_2) F_22 - (1 - e_1) (1 - e_2) F_21). With F_12
// = 1 the product is the textbook's A_1 / (1 / e_1 + A_1 / A_2 (1 / e_2 - 1)), which betweenTwo() has.
TEST(ExchangeFactors, OfTwoSurfaces) {
  const FormFactors f = te::formFactors({1, 2.5}, {{0, 1, {1, 0}}, {1, 1, {1.5, 0}}});
  for (const double inner : {1.0, 0.3, 1e-3})
    for (const double outer : {1.0, 0.6, 1e-3}) {
      const ExchangeFactors factors =
          findExchangeFactors(f, te::enclosureOf(f, {te::hot(inner, 400), te::hot(outer, 300)}));
      const double truth = te::betweenTwo(1, inner, 400, 2.5, outer, 300) / (te::power(400) - te::power(300));
      ASSERT_GE(factors.entries.size(), 2u);
      const auto pair = std::ranges::find_if(factors.entries, [](const auto& e) { return e.i == 0 && e.j == 1; });
      EXPECT_TRUE(isWithin(pair->conductor, truth, 1e-12 * truth));
    }
}

// Dropping small conductors keeps symmetry and the sums of rows. The rest of a row gains as much as was dropped, which
// changes its heat flow by at most twice that share. Partners may pass on their gain, which may double the change.
TEST(ExchangeFactors, ACutKeepsEnergy) {
  for (const bool is_open : {false, true}) {
    const FormFactors f = randomRows(60, is_open);
    Enclosure enclosure{materialsOf(60), 270, f.ids().names};
    for (Material& material : enclosure.materials) material.emissivity = std::max(material.emissivity, 0.2);
    const ExchangeFactors all = findExchangeFactors(f, enclosure), cut = findExchangeFactors(f, enclosure, 3e-3);
    EXPECT_GT(cut.dropped, 50u);
    EXPECT_EQ(cut.entries.size() + cut.dropped, all.entries.size());
    EXPECT_GT(cut.largest_dropped_share, 0);
    for (const double sum : rowSums(cut)) EXPECT_TRUE(isWithin(sum, 1, 2e-12));
    for (const ExchangeFactors::Entry& entry : cut.entries) EXPECT_GE(entry.conductor, 0);
    const auto flows = flowsOf(cut, enclosure), truth = flowsOf(all, enclosure);
    double sum = 0, size = 0;
    for (size_t i = 0; i < flows.size(); ++i) {
      sum += flows[i].first, size += std::abs(flows[i].first);
      const double hottest = te::power(250 + 7.0 * 59) * f.ids().areas[i] * enclosure.materials[i].emissivity;
      EXPECT_LE(std::abs(flows[i].first - truth[i].first), 4 * cut.largest_dropped_share * hottest) << i;
    }
    if (is_open) continue;
    EXPECT_LE(std::abs(sum), 1e-12 * size);
  }
}

TEST(ExchangeFactors, ACutThatLeavesTooLittleIsRefused) {
  // Without the pairs (0, 2) and (2, 2), rows 0 and 2 exchange with row 1 alone, whose area is smaller than theirs
  // together. So no matrix balances, and the cut is refused.
  const FormFactors f =
      te::formFactors({1, 1.02, 0.95}, {{0, 1, {0.61, 0}}, {0, 2, {0.39, 0}}, {1, 2, {0.41, 0}}, {2, 2, {0.15, 0}}});
  const Enclosure enclosure = te::enclosureOf(f, {te::hot(1, 1), te::hot(1, 1), te::hot(1, 1)});
  try {
    findExchangeFactors(f, enclosure, 0.42);
    ADD_FAILURE() << "nothing was refused";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("lower --drop-below"), std::string::npos) << error.what();
  }
  // The largest conductor of each row is never dropped.
  const FormFactors g = te::formFactors({1, 0.5, 1.5}, {{0, 2, {1, 0}}, {1, 2, {0.5, 0}}});
  EXPECT_EQ(findExchangeFactors(g, te::enclosureOf(g, {te::hot(1, 1), te::hot(1, 1), te::hot(1, 1)}), 0.7).dropped, 0u);
}

TEST(ExchangeFactors, AreWrittenBothWays) {
  ExchangeFactors factors{{{0, 0, 0.5}, {0, 1, 1.5}, {1, kEnvironment, 2.5}}, {"a", "b,c"}, {4, 8}, {0.5, 1}};
  std::ostringstream gebhart, script_f;
  writeExchange(factors, ExchangeKind::gebhart, gebhart);
  writeExchange(factors, ExchangeKind::script_f, script_f);
  EXPECT_EQ(gebhart.str(),
            "from,to,gebhart,conductor\na,a,0.25,0.5\na,\"b,c\",0.75,1.5\n\"b,c\",a,0.1875,1.5\n"
            "\"b,c\",environment,0.3125,2.5\n");
  EXPECT_EQ(script_f.str().find("from,to,script_f,conductor\na,a,0.125,0.5\na,\"b,c\",0.375,1.5\n"), 0u);
}

}  // namespace
}  // namespace viewpeel
