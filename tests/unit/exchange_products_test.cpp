// ExchangeProducts multiply by exchange areas while directions are peeled (docs/solve.md, eq. (14)). These tests
// compare the products with products of the same counts in a matrix.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "directions/sampler.h"
#include "engines/exchange_products.h"
#include "engines/host_engine.h"
#include "scenes/generate.h"

namespace viewpeel {
namespace {

using bench::city;

struct Case {
  Scene scene = buildScene(city(300));
  Ids ids = makeIds(scene, By::polygon, false);
  std::vector<Direction> directions = sampleDirections(Sampler::fibonacci, 12, 5, 0);
  std::vector<double> factors;  // of two columns; whole numbers, which are not rounded

  Case() {
    for (uint32_t k = 0; k < 2 * ids.count(); ++k) factors.push_back(double((k * 7919 + 13) % 1009) - 500);
  }
};

LatticeOptions optionsOf(Sampling sampling, uint32_t threads) {
  return {.resolution = 96, .sampling = sampling, .thread_count = threads};
}

// Sums of whole numbers below 2^53 are exact, so that the two have to be equal to the last bit.
TEST(ExchangeProducts, AreThoseOfTheEnginesCounts) {
  const Case of;
  for (const Sampling sampling : {Sampling::lattice, Sampling::scanline}) {
    std::vector<double> expected(of.factors.size());
    std::vector<double> environment(of.ids.count()), leak(of.ids.count());
    const auto engine = makeHostEngine(of.scene, of.ids, optionsOf(sampling, 2));
    for (const PairCount& pair : engine->count(of.directions)) {
      if (pair.j == kEnvironment) environment[pair.i] += double(pair.count);
      else if (pair.j == kLeak) leak[pair.i] += double(pair.count);
      else if (pair.i != pair.j)
        for (size_t column = 0; column < 2; ++column) {
          expected[pair.i * 2 + column] += double(pair.count) * of.factors[pair.j * 2 + column];
          expected[pair.j * 2 + column] += double(pair.count) * of.factors[pair.i * 2 + column];
        }
    }
    ExchangeProducts products(of.scene, of.ids, optionsOf(sampling, 2));
    std::vector<ExchangeProducts::Outside> outside(of.ids.count());
    const std::vector<double> found = products.multiply(of.directions, of.factors, 2, &outside);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(products.unitArea(), engine->unitArea());
    double leaving = 0;
    for (uint32_t i = 0; i < of.ids.count(); ++i) {
      EXPECT_EQ(outside[i].ahead + outside[i].behind, environment[i]) << of.ids.names[i];
      EXPECT_EQ(outside[i].leak, leak[i]) << of.ids.names[i];
      leaving += environment[i];
    }
    EXPECT_GT(leaving, 0);  // the city is open
    // A product with one factor changed is another one.
    std::vector<double> changed = of.factors;
    const auto seen = std::ranges::find_if(expected, [](double product) { return product != 0; });
    ASSERT_NE(seen, expected.end());
    changed[static_cast<size_t>(seen - expected.begin())] += 1;
    EXPECT_NE(products.multiply(of.directions, changed, 2), expected);
  }
}

// Polygons share their lines between two rows: the same as the counts of each direction between polygons, weighted by
// the share of each end. Factors and sums are rounded to 2^-52 of a column's largest factor times the counts of a
// direction, and both sums have some hundred terms: 1e-12 of the sum of the terms' sizes holds all of it.
TEST(ExchangeProducts, SharesWeightTheCounts) {
  const Case of;
  const auto polygons = static_cast<uint32_t>(of.scene.polygons.size());
  PolygonShares shares;
  shares.row_count = 2 * of.ids.count();
  for (uint32_t k = 0; k < polygons; ++k) {
    const uint32_t id = of.ids.of_polygon[k];
    shares.rows.push_back({id, id % 3 ? id + of.ids.count() : PolygonShares::kNone});
  }
  shares.share_of_first = [](uint32_t k, const glm::dvec3& u) { return 0.5 + 0.4 * std::sin(k + 3 * u.x); };
  const auto shareOf = [&](uint32_t k, bool of_first, const glm::dvec3& u) {
    if (shares.rows[k].second == PolygonShares::kNone) return of_first ? 1.0 : 0.0;
    return of_first ? shares.share_of_first(k, u) : 1 - shares.share_of_first(k, u);
  };
  std::vector<double> factors, expected(2 * of.ids.count()), sizes(expected.size()), environment(expected.size());
  for (uint32_t p = 0; p < shares.row_count; ++p) factors.push_back(std::cos(p));
  Ids by_polygon = of.ids;
  by_polygon.names.assign(polygons, "");
  by_polygon.areas.assign(polygons, 1);
  for (uint32_t k = 0; k < polygons; ++k) by_polygon.of_polygon[k] = k;
  const auto engine = makeHostEngine(of.scene, by_polygon, optionsOf(Sampling::lattice, 2));
  double exchanged = 0;  // the largest difference where the shares of the two ends are exchanged
  for (const Direction& direction : of.directions)
    for (const PairCount& pair : engine->count({&direction, 1})) {
      if (pair.j == kLeak) continue;
      for (const bool first : {true, false}) {
        const uint32_t p = first ? shares.rows[pair.i].first : shares.rows[pair.i].second;
        const double of_i = shareOf(pair.i, first, direction.u);
        if (of_i == 0) continue;
        if (pair.j == kEnvironment) environment[p] += of_i * double(pair.count);
        for (const bool second : {true, false}) {
          if (pair.j == kEnvironment) continue;
          const double of_j = shareOf(pair.j, second, direction.u), both = of_i * of_j * double(pair.count);
          if (of_j == 0) continue;
          const uint32_t q = second ? shares.rows[pair.j].first : shares.rows[pair.j].second;
          expected[p] += both * factors[q], expected[q] += both * factors[p];
          sizes[p] += both, sizes[q] += both;
          exchanged = std::max(exchanged, std::abs(shareOf(pair.j, first, direction.u) - of_i));
        }
      }
    }
  ExchangeProducts products(of.scene, shares, optionsOf(Sampling::lattice, 2));
  std::vector<ExchangeProducts::Outside> outside(shares.row_count);
  const std::vector<double> found = products.multiply(of.directions, factors, 1, &outside);
  double leaving = 0;
  for (uint32_t p = 0; p < shares.row_count; ++p) {
    EXPECT_NEAR(found[p], expected[p], 1e-12 * sizes[p]) << p;
    EXPECT_NEAR(outside[p].ahead + outside[p].behind, environment[p], 1e-9 * (1 + environment[p])) << p;
    leaving += environment[p];
  }
  EXPECT_GT(leaving, 0);
  EXPECT_GT(exchanged, 0.1);  // shares of the other end would be seen
  ExchangeProducts alone(of.scene, shares, optionsOf(Sampling::lattice, 1));
  EXPECT_EQ(alone.multiply(of.directions, factors, 1), found);
  // The shares of the next polygon give other products.
  shares.share_of_first = [](uint32_t k, const glm::dvec3& u) { return 0.5 + 0.4 * std::sin(k + 1 + 3 * u.x); };
  ExchangeProducts other(of.scene, shares, optionsOf(Sampling::lattice, 2));
  EXPECT_NE(other.multiply(of.directions, factors, 1), found);
}

TEST(ExchangeProducts, HaveTheSameBitsOnAnyNumberOfThreads) {
  const Case of;
  std::vector<double> factors = of.factors;
  for (double& factor : factors) factor = std::sin(factor);  // no whole numbers, so that products are rounded
  ExchangeProducts alone(of.scene, of.ids, optionsOf(Sampling::lattice, 1));
  ExchangeProducts three(of.scene, of.ids, optionsOf(Sampling::lattice, 3));
  EXPECT_EQ(alone.multiply(of.directions, factors, 2), three.multiply(of.directions, factors, 2));
}

// Each column has a scale of its own: a column of tiny factors keeps its digits beside a column of large ones.
TEST(ExchangeProducts, ColumnsKeepTheirDigits) {
  const Case of;
  std::vector<double> scaled = of.factors;
  for (size_t k = 1; k < scaled.size(); k += 2) scaled[k] *= 0x1p-60;
  ExchangeProducts products(of.scene, of.ids, optionsOf(Sampling::lattice, 2));
  std::vector<double> expected = products.multiply(of.directions, of.factors, 2);
  for (size_t k = 1; k < expected.size(); k += 2) expected[k] *= 0x1p-60;
  EXPECT_EQ(products.multiply(of.directions, scaled, 2), expected);
}

TEST(ExchangeProducts, AreSymmetric) {
  const Case of;
  ExchangeProducts products(of.scene, of.ids, optionsOf(Sampling::lattice, 2));
  const std::vector<double> found = products.multiply(of.directions, of.factors, 2);
  double first = 0, second = 0;  // y^T C x and x^T C y, of whole numbers below 2^53
  for (uint32_t i = 0; i < of.ids.count(); ++i) {
    first += found[2 * i] * of.factors[2 * i + 1];
    second += found[2 * i + 1] * of.factors[2 * i];
  }
  EXPECT_EQ(first, second);
  EXPECT_NE(first, 0);
}

}  // namespace
}  // namespace viewpeel
