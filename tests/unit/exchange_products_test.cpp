// Compares products that are made while directions are peeled with those of counts in a matrix.
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
      EXPECT_EQ(double(outside[i].ahead + outside[i].behind), environment[i]) << of.ids.names[i];
      EXPECT_EQ(double(outside[i].leak), leak[i]) << of.ids.names[i];
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

TEST(ExchangeProducts, HaveTheSameBitsOnAnyNumberOfThreads) {
  const Case of;
  std::vector<double> factors = of.factors;
  for (double& factor : factors) factor = std::sin(factor);  // these are rounded
  ExchangeProducts alone(of.scene, of.ids, optionsOf(Sampling::lattice, 1));
  ExchangeProducts three(of.scene, of.ids, optionsOf(Sampling::lattice, 3));
  EXPECT_EQ(alone.multiply(of.directions, factors, 2), three.multiply(of.directions, factors, 2));
}

// Columns are scaled each for itself: one with tiny factors keeps its digits beside one with large ones.
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
