// These tests check the visibility by which an unoccluded form factor is multiplied. Its sums are exact, its bias is
// small, and its standard errors are right.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "sums/neighbour_visibility.h"
#include "sums/prior_sums.h"

namespace viewpeel {
namespace {

Ids idsOf(std::vector<double> areas) {
  Ids ids;
  for (size_t k = 0; k < areas.size(); ++k) ids.names.push_back(std::string(1, static_cast<char>('a' + k)));
  ids.areas = std::move(areas);
  return ids;
}

Measured exchangeOf(const VisibilitySums& sums, double measure_area, const PairPrior& prior) {
  return FormFactors(sums.ids(), sums.find({prior}, {}, measure_area, INFINITY, {}, {}).entries, {})
      .exchangeArea(prior.i, prior.j);
}

TEST(VisibilitySums, ByHand) {
  VisibilitySums sums(idsOf({20, 20, 20}));
  sums.add({{0, 1, 3, 5}, {0, 2, 4, 0}});
  sums.add({{0, 1, 1, 11}, {0, 2, 6, 0}});
  // Of 20 lines 4 are facing, so b = 0.2. Residuals (16) are 0.8 x 3 - 0.2 x 5 = 1.4 and -1.4, and R s^2 = 2 x 3.92 =
  // 7.84. Squares are 0.64 x 4 + 0.04 x 16 = 3.2 lines, so that lines come 7.84 / 3.2 at a time in (12).
  const Measured f = exchangeOf(sums, 0.5, {0, 1, 0, 0, 16});
  EXPECT_DOUBLE_EQ(f.value, 3.2);
  EXPECT_DOUBLE_EQ(f.standard_error, 0.8 * std::hypot(std::sqrt(7.84), 4.2 / (3.2 * 3.2 / 7.84 + 1)));
  // A pair without blocked lines has its whole unoccluded form factor. Its error is one line of ten.
  const Measured whole = exchangeOf(sums, 0.5, {0, 2, 0, 0, 8});
  EXPECT_EQ(whole.value, 8);
  EXPECT_DOUBLE_EQ(whole.standard_error, 0.8);
  // A pair without lines has the visibility from before the run. Its error is that of one line, 2 x 0.5 / 2.
  const Measured unmet = exchangeOf(sums, 0.5, {1, 2, kVisibilityOne / 4 * 3, 0, 4});
  EXPECT_EQ(unmet.value, 3);
  EXPECT_EQ(unmet.standard_error, 0.5);
  // A pair without prior keeps its sampled value.
  const FormFactors sampled({}, {{0, 1, {5, 2}}, {1, 2, {7, 3}}}, {});
  const FormFactors all = FormFactors(
      sums.ids(),
      sums.find({{0, 1, 0, 0, INFINITY}, {0, 2, 0, 0, 8}}, {}, 0.5, INFINITY, {}, sampled.entries()).entries, {});
  ASSERT_EQ(all.entries().size(), 3u);
  EXPECT_EQ(all.exchangeArea(0, 1).value, 5);
  EXPECT_EQ(all.exchangeArea(0, 2).value, 8);
  EXPECT_EQ(all.exchangeArea(1, 2).standard_error, 3);
  VisibilitySums large(idsOf({1, 1}));
  EXPECT_THROW(large.add({{0, 1, 0, uint64_t(1) << 51}}), Error);
}

// With few lines the spread of replicates has the weight w of (22) in docs/method.md, and the neighbours' visibility
// has the rest.
TEST(VisibilitySums, FewLinesByHand) {
  VisibilitySums sums(idsOf({20, 20, 20}));
  sums.add({{0, 1, 3, 5}, {0, 2, 4, 0}});
  sums.add({{0, 1, 1, 11}, {0, 2, 6, 0}});
  const std::vector<uint32_t> ranks{0, 1, 2};
  const NeighbourVisibility neighbours(sums, {}, ranks);
  const FormFactors all = FormFactors(
      sums.ids(),
      sums.find({{0, 1, 0, 0, 16}, {0, 2, 0, 0, 8}, {1, 2, 0, 0, 4}}, {}, 0.5, INFINITY, {}, {}, &neighbours).entries,
      {});
  // All pairs are neighbours: 20 lines of one pair count as 1.4634, and 10 as 1.4286. Of these L = 2.8920 lines V =
  // 1.7213 are facing. So m = V / L = 0.595181 and s = (V + m + 0.1) / (L + 1.2) = 0.590529. In (22) p = (4 + 2 s +
  // 0.1) / 22.2 = 0.237885, r = 3.62592 and w = r^2 / (r^2 + 1/4) = 0.981340. The spread is R s^2 / 20^2 = 0.0196. The
  // other term is q = 2 / 23 of p (1 - p) / 20.5, which is 0.000769019, times (1.959964 / 2.364624)^2 with t of 8
  // replicates. The error is 16 times the root of 0.981340 x 0.0196 + 0.018660 x 0.000528334.
  EXPECT_EQ(all.exchangeArea(0, 1).value, 3.2);
  EXPECT_NEAR(all.exchangeArea(0, 1).standard_error, 2.219570, 1e-5);
  // All 10 lines are facing, so q = 1: p = (10 + 2 s + 0.1) / 12.2, and the term is p (1 - p) / 10.5.
  EXPECT_EQ(all.exchangeArea(0, 2).value, 8);
  EXPECT_NEAR(all.exchangeArea(0, 2).standard_error, 0.314946, 1e-5);
  EXPECT_NEAR(all.exchangeArea(1, 2).value, 4 * 0.5951807, 1e-6);  // in single precision
}

// Scanlines count parts of lines. Where a hundredth of a line is blocked and all others are facing, the error is nearly
// that of lines that are all facing. It was 0.4 of it.
TEST(VisibilitySums, APartOfALineIsNoLineOfTheRarerKind) {
  constexpr uint64_t kLine = 1000;  // counts
  const auto errorWith = [&](uint64_t blocked) {
    VisibilitySums sums(idsOf({20, 20}));
    sums.add({{0, 1, 4 * kLine, blocked}});
    sums.add({{0, 1, 6 * kLine, 0}});
    const std::vector<uint32_t> ranks{0, 1};
    const NeighbourVisibility neighbours(sums, {}, ranks);
    const std::vector<uint64_t> lines(2, kLine);
    return sums.find({{0, 1, 0, 0, 8}}, lines, 0.5, INFINITY, {}, {}, &neighbours).entries.at(0).exchange_area;
  };
  const Measured none = errorWith(0), little = errorWith(kLine / 100);
  EXPECT_EQ(none.value, 8);
  EXPECT_NEAR(little.value, 8 * 10 / 10.01, 1e-12);
  // Of n = 10.01 lines n b (1 - b) = 0.00999 are of the rarer kind. So q of eq. (22) is 1 - 0.00999 (1 - 2 / 13.01) =
  // 0.9915. The spread of replicates has a weight below 0.4, and adds to the variance. The neighbours' s and p change
  // by less than a hundredth.
  EXPECT_GT(little.standard_error, 0.75 * none.standard_error);
}

// All lines that were drawn from a row leave the scene. Another direction might have met something: it adds at most
// A / h^2 lines, here 10, of which 8 / 27 count, beside one line (eq. (12) without counts).
TEST(VisibilitySums, EnvironmentOfAllLinesErrsByADirection) {
  VisibilitySums sums(idsOf({20, 20}));
  for (int k = 0; k < 2; ++k) sums.add({{0, kEnvironment, 100, 0}});
  const std::vector<ReplicateSums::Sum> rows{{200, 20'000}, {}};
  const Measured found = sums.find({{0, kEnvironment, 0, 0, 20}}, {}, 0.1, 2, rows, {}).entries.at(0).exchange_area;
  EXPECT_EQ(found.value, 20);
  EXPECT_NEAR(found.standard_error, (1 + 8 / 27.0 * 10) * 20 / 200, 1e-12);
}

// The search over all pairs gives each pair the value that it has alone. A pair's unoccluded form factor comes from the
// prior or from a row. A pair with neither keeps its sampled value, and a pair without lines has its neighbours'
// visibility.
TEST(VisibilitySums, RowsAndPriorPairsAndSampledOnesGoTogether) {
  constexpr uint32_t n = 40;
  const Ids ids = idsOf(std::vector<double>(n, 100.0));
  std::mt19937_64 random(7);
  const auto isOneOf = [&](int count) { return random() % count == 0; };
  VisibilitySums sums(ids);
  for (int r = 0; r < 3; ++r) {
    PairCounts counts;
    for (uint32_t i = 0; i < n; ++i) {
      for (uint32_t j = i + 1; j < n; ++j)
        if (isOneOf(4)) counts.push_back({i, j, random() % 9, 1 + random() % 9});
      counts.push_back({i, kEnvironment, 1 + random() % 9, 5});
    }
    sums.add(counts);
  }
  std::vector<PairPrior> prior;
  std::vector<FormFactors::Entry> sampled_entries;
  std::vector<std::vector<double>> areas(n, std::vector<double>(n, 0.0));
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = i + 1; j < n; ++j) {
      areas[i][j] = isOneOf(5) ? 0 : 1 + double(random() % 50);
      if (isOneOf(3)) prior.push_back({i, j, 0, 0, 1 + double(random() % 50)});
      else if (isOneOf(3)) sampled_entries.push_back({i, j, {7, 2}});
    }
    prior.push_back({i, kEnvironment, 0, 0, 100});
    sampled_entries.push_back({i, kLeak, {3, 1}});
  }
  const FormFactors sampled({}, sampled_entries, {});
  std::vector<uint32_t> ranks(n);
  std::iota(ranks.begin(), ranks.end(), 0u);
  const NeighbourVisibility neighbours(sums, {}, ranks);
  const ExchangeRow row = [&](uint32_t i, std::span<BoundedExchange> later) {
    for (size_t k = 0; k < later.size(); ++k) later[k] = {areas[i][i + 1 + k], 0};
  };
  const FormFactors all =
      FormFactors(sums.ids(), sums.find(prior, {}, 0.5, INFINITY, {}, sampled.entries(), &neighbours, row).entries, {});
  EXPECT_TRUE(std::ranges::is_sorted(all.entries(), {},
                                     [](const FormFactors::Entry& entry) { return std::pair(entry.i, entry.j); }));
  std::array<size_t, 5> kinds{};
  for (uint32_t i = 0; i < n; ++i) {
    EXPECT_EQ(all.exchangeArea(i, kLeak).value, 3);
    EXPECT_EQ(all.exchangeArea(i, kEnvironment).value, exchangeOf(sums, 0.5, {i, kEnvironment, 0, 0, 100}).value);
    for (uint32_t j = i + 1; j < n; ++j) {
      const auto at =
          std::ranges::find(prior, std::pair(i, j), [](const PairPrior& pair) { return std::pair(pair.i, pair.j); });
      const bool has_prior = at != prior.end(),
                 has_lines = std::ranges::any_of(
                     sums.pairs(), [&](const VisibilitySums::PairSum&pair) { return pair.i == i && pair.j == j; });
      const double most = has_prior ? at->exchange : areas[i][j];
      const Measured f = all.exchangeArea(i, j);
      ++kinds[most == 0 ? 0 : 1 + 2 * has_prior + has_lines];
      if (most == 0) {
        EXPECT_EQ(f.value, sampled.exchangeArea(i, j).value);
      } else if (has_lines) {
        const Measured alone =
            FormFactors(sums.ids(), sums.find({{i, j, 0, 0, most}}, {}, 0.5, INFINITY, {}, {}, &neighbours).entries, {})
                .exchangeArea(i, j);
        EXPECT_EQ(f.value, alone.value) << i << " " << j;
        EXPECT_EQ(f.standard_error, alone.standard_error) << i << " " << j;
      } else {
        EXPECT_DOUBLE_EQ(f.value, double(neighbours.of(i, j).mean) * most) << i << " " << j;
        EXPECT_DOUBLE_EQ(f.standard_error, double(neighbours.of(i, j).deviation()) * most) << i << " " << j;
      }
    }
  }
  for (const size_t count : kinds) EXPECT_GT(count, 50u);
}

// With visibilities fixed beforehand the sums equal ControlVariateSums to the last bit, in any order and in parts.
TEST(VisibilitySums, MakeControlVariatesOfAnyVisibility) {
  constexpr uint32_t n = 12;
  const Ids ids = idsOf(std::vector<double>(n, 1.0));
  std::mt19937_64 random(3);
  std::vector<PairVisibility> visibilities;
  std::vector<uint64_t> lines;
  for (uint32_t i = 0; i < n; ++i) {
    lines.push_back(1 + random() % 300);
    for (uint32_t j = i + 1; j < n; ++j)
      if (random() % 3)
        visibilities.push_back(
            {i, j, std::array{1u, kVisibilityOne, static_cast<uint32_t>(random() % kVisibilityOne)}[random() % 3]});
  }
  VisibilitySums whole(ids), parts[2] = {VisibilitySums(ids), VisibilitySums(ids)};
  ControlVariateSums controls(ids);
  for (uint32_t r = 0; r < 9; ++r) {
    PairCounts counts;
    for (uint32_t i = 0; i < n; ++i)
      for (uint32_t j = i + 1; j <= n; ++j)
        if (random() % 2)
          counts.push_back(
              {i, j < n ? j : kEnvironment, random() % 3 ? random() >> 16 : 0, random() % 3 ? random() >> 16 : 1});
    whole.add(counts);
    parts[r % 2].add(counts);
    controls.add(takeControlVariates(counts, visibilities, lines));
  }
  parts[1].add(parts[0]);
  for (const VisibilitySums& sums : {whole, parts[1]}) {
    const ControlVariateSums same = sums.controls(visibilities, lines);
    EXPECT_EQ(same.replicateCount(), 9u);
    ASSERT_EQ(same.pairs().size(), controls.pairs().size());
    for (size_t k = 0; k < same.pairs().size(); ++k) {
      const ControlVariateSums::PairSum &a = same.pairs()[k], &b = controls.pairs()[k];
      EXPECT_TRUE(a.i == b.i && a.j == b.j && a.sum == b.sum && a.sum_of_squares == b.sum_of_squares &&
                  a.squares == b.squares && a.line == b.line)
          << a.i << " " << a.j;
    }
  }
}

// There are more pairs than one thread takes at once, also exactly a multiple. Each has the value that it has alone,
// and pairs without prior stand at their places.
TEST(VisibilitySums, ManyPairsAreEachWhatTheyAreAlone) {
  constexpr uint32_t n = 520;
  const Ids ids = idsOf(std::vector<double>(n, 100.0));
  std::mt19937_64 random(5);
  for (const size_t most_prior : {size_t(1) << 16, size_t(1) << 17, size_t(100'000)}) {
    PairCounts counts;
    std::vector<PairPrior> prior;
    std::vector<FormFactors::Entry> others;
    for (uint32_t i = 0; i < n; ++i)
      for (uint32_t j = i + 1; j < n; ++j) {
        if (random() % 4) counts.push_back({i, j, 1 + random() % 9, random() % 9});
        if (random() % 50 && prior.size() < most_prior) prior.push_back({i, j, 0, 0, 1.0 + double(random() % 9)});
        else if (random() % 2) others.push_back({i, j, {double(i), double(j)}});
      }
    VisibilitySums sums(ids);
    sums.add(counts);
    sums.add(counts);
    const FormFactors all = FormFactors(sums.ids(), sums.find(prior, {}, 0.1, INFINITY, {}, others).entries, {});
    ASSERT_EQ(all.entries().size(), prior.size() + others.size());
    EXPECT_TRUE(std::ranges::is_sorted(all.entries(), {},
                                       [](const FormFactors::Entry& entry) { return std::pair(entry.i, entry.j); }));
    for (const FormFactors::Entry& entry : others) ASSERT_EQ(all.exchangeArea(entry.i, entry.j).value, double(entry.i));
    for (size_t k = 0; k < prior.size(); k += 97) {
      const Measured alone = exchangeOf(sums, 0.1, prior[k]), together = all.exchangeArea(prior[k].i, prior[k].j);
      ASSERT_TRUE(alone.value == together.value && alone.standard_error == together.standard_error) << k;
    }
  }
}

// The number of lines follows Poisson's law, and each is facing with probability b. The estimate has no bias however
// few lines there are: the sum of its errors is within 4 standard deviations. Where a line met the pair, 95 % intervals
// are to hold the truth in 88 % of cases at least. This limit for few lines is a choice and not derived.
TEST(VisibilitySums, LinesByChanceHaveNoBias) {
  constexpr int kTrials = 4000, kReplicates = 8;
  const double t = quantile(complement(boost::math::students_t(kReplicates - 1), 0.025));
  std::mt19937_64 random(6);
  for (const double lines : {2.0, 6.0, 20.0, 200.0})
    for (const double b : {0.02, 0.3, 0.5, 0.9, 0.99}) {
      std::poisson_distribution<uint64_t> some(lines / kReplicates);
      double sum = 0, squares = 0;
      int trials = 0, held = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        VisibilitySums sums(idsOf({1e9, 1e9}));
        uint64_t all = 0;
        for (int r = 0; r < kReplicates; ++r) {
          const uint64_t of_replicate = some(random),
                         facing = std::binomial_distribution<uint64_t>(of_replicate, b)(random);
          all += of_replicate;
          sums.add({{0, 1, facing, of_replicate - facing}});
        }
        const Measured f = exchangeOf(sums, kReplicates / 2.0, {0, 1, 0, 0, lines});
        if (all == 0) continue;
        ++trials;
        sum += f.value - b * lines;
        squares += std::pow(f.value - b * lines, 2);
        held += std::abs(f.value - b * lines) <= t * f.standard_error;
      }
      EXPECT_LE(std::abs(sum), 4 * std::sqrt(squares)) << lines << " " << b;
      EXPECT_GE(held, trials * 0.88 - 4 * std::sqrt(0.88 * 0.12 * trials))
          << lines << " " << b << ": " << double(held) / trials;
    }
}

// Facing and blocked lines vary independently here. The bias is below the standard error times the relative standard
// error of all lines (Hartley & Ross 1954).
TEST(VisibilitySums, BiasIsBounded) {
  constexpr int kTrials = 20'000, kReplicates = 4;
  std::mt19937_64 random(8);
  for (const double spread : {0.1, 0.3}) {
    std::normal_distribution<double> varies(1, spread);
    const auto count = [&](double mean) { return static_cast<uint64_t>(std::max(0.0, mean * varies(random))); };
    std::vector<double> values;
    double lines = 0, squared_lines = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      VisibilitySums sums(idsOf({1e9, 1e9}));
      double all = 0;
      for (int r = 0; r < kReplicates; ++r) {
        const PairCount counts{0, 1, count(3e6), count(1e6)};
        sums.add({counts});
        all += double(counts.count + counts.blocked);
      }
      values.push_back(exchangeOf(sums, 1, {0, 1, 0, 0, 1}).value);
      lines += all, squared_lines += all * all;
    }
    double mean = 0, variance = 0;
    for (double value : values) mean += value / kTrials;
    for (double value : values) variance += std::pow(value - mean, 2) / kTrials;
    const double relative = std::sqrt(squared_lines / kTrials / std::pow(lines / kTrials, 2) - 1);
    EXPECT_LE(std::abs(mean - 0.75), std::sqrt(variance) * relative + 4 * std::sqrt(variance / kTrials)) << spread;
  }
}

// One of the 80 lines of a row leaves the scene, in one replicate of eight. The environment's share is 1 / 80, by
// polygon and by surface, whatever the pilots saw. It is not 1 / 10, the share in that replicate.
TEST(VisibilitySums, EnvironmentSeenInOneReplicateOfEight) {
  Ids ids;
  ids.names = {"a", "b"};
  ids.areas = {10, 10};
  ids.surface = {0, 1};
  ids.of_polygon = {0, 1};
  constexpr double kMeasureArea = 0.5;  // so a row of 10 lines has 2 * 0.5 * 10 = 10 input units squared
  for (const uint32_t visibility : {0u, kVisibilityOne / 3}) {
    Prior prior;
    if (visibility) prior.pairs = {{0, kEnvironment, visibility, visibility, ids.areas[0]}};
    PriorSums prior_sums(ids, ids, By::polygon, prior);
    ReplicateSums counted(ids);
    for (int replicate = 0; replicate < 8; ++replicate) {
      const PairCounts counts =
          replicate == 3 ? PairCounts{{0, 1, 9}, {0, kEnvironment, 1}, {1, kEnvironment, 1}} : PairCounts{{0, 1, 10}};
      prior_sums.add(counts, {});
      counted.add(counts);
    }
    if (!visibility) prior_sums.learn({{0, kEnvironment, 0, 0, ids.areas[0]}});
    const FormFactors by_polygon = prior_sums.byPolygon(kMeasureArea, INFINITY, counted, {});
    EXPECT_NEAR(by_polygon.formFactor(0, kEnvironment).value, 1 / 80.0, 1e-12) << visibility;
    const FormFactors by_surface = prior_sums.bySurface(kMeasureArea, INFINITY, counted.formFactors(kMeasureArea));
    EXPECT_NEAR(by_surface.formFactor(0, kEnvironment).value, 1 / 80.0, 1e-6)
        << visibility;  // visibilities are multiples of 2^-12, areas are rounded
  }
}

// If pilots saw leak and the run did not, the result has none.
TEST(VisibilitySums, WhatOnlyPilotsSawIsNotStated) {
  Ids ids;
  ids.names = {"a", "b"};
  ids.areas = {10, 10};
  ids.surface = {0, 1};
  ids.of_polygon = {0, 1};
  Prior prior;
  prior.pairs = {{0, kLeak, kVisibilityOne / 100, kVisibilityOne / 100, ids.areas[0]}};
  PriorSums prior_sums(ids, ids, By::polygon, prior);
  ReplicateSums counted(ids);
  for (int replicate = 0; replicate < 8; ++replicate) {
    prior_sums.add({{0, 1, 1000}}, {});
    counted.add(PairCounts{{0, 1, 1000}});
  }
  const Measured leak = prior_sums.byPolygon(0.005, INFINITY, counted, {}).formFactor(0, kLeak);
  EXPECT_EQ(leak.value, 0);
  EXPECT_NEAR(leak.standard_error, 1 / 8000.0, 1e-12);  // the error of one line
  EXPECT_NEAR(prior_sums.bySurface(0.005, INFINITY, counted.formFactors(0.005)).formFactor(0, kLeak).value, 0, 1e-6);
}

}  // namespace
}  // namespace viewpeel
