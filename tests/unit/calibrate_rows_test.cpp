// calibrateRows() adjusts guesses so that rows sum to 1. Visibilities stay between 0 and 1, and measured entries do not
// change.
#include "sums/calibrate_rows.h"
#include "sums/row_sums.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace viewpeel {
namespace {

using Entry = FormFactors::Entry;

struct Matrix {
  std::vector<Entry> entries;
  std::vector<Guess> guesses;
  std::vector<double> areas;
};

// Makes a matrix in which every third pair is measured with standard error `error` times F0. Every other pair has a
// guess of 0.7 of its true value, so that all guesses err alike.
Matrix makeGuessed(uint32_t count, double error, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  Matrix matrix;
  matrix.areas.assign(count, 0);
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; ++j) {
      const double most = uniform(random) / count, share = 0.2 + 0.6 * uniform(random), truth = share * most;
      matrix.areas[i] += truth;
      matrix.areas[j] += truth;
      if ((i + j) % 3 == 0) {
        matrix.entries.push_back({i, j, {truth + error * most * normal(random), error * most}});
        continue;
      }
      const double guess = 0.7 * share;
      matrix.guesses.push_back(
          {static_cast<uint32_t>(matrix.entries.size()), static_cast<float>(most), static_cast<float>(guess), 1});
      matrix.entries.push_back({i, j, {guess * most, std::sqrt(guess * (1 - guess)) * most}});
    }
  return matrix;
}

double largestMiss(const Matrix& matrix) {
  double largest = 0;
  for (const Measured& sum : sumRows(matrix.entries, matrix.areas))
    largest = std::max(largest, std::abs(sum.value - 1));
  return largest;
}

TEST(CalibrateRows, GuessesThatErrTogetherAreMended) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    Matrix matrix = makeGuessed(40, 1e-3, seed);
    const Matrix before = matrix;
    ASSERT_GT(largestMiss(before), 0.15);
    calibrateRows(matrix.entries, matrix.guesses, matrix.areas);
    // A row's sum comes within 1 % of the sum of its guesses' errors, which is below 1. The share 1 - f_i of (41),
    // which measured entries take, is small beside it.
    EXPECT_LT(largestMiss(matrix), 0.012) << "seed " << seed;
    size_t guess = 0;
    double off_before = 0, off = 0;
    for (uint32_t k = 0; k < matrix.entries.size(); ++k) {
      const double value = matrix.entries[k].exchange_area.value;
      if (guess < matrix.guesses.size() && matrix.guesses[guess].entry == k) {
        EXPECT_GE(value, 0);
        EXPECT_LE(value, double(matrix.guesses[guess].most) * (1 + 1e-6));
        const double truth = before.entries[k].exchange_area.value / 0.7;
        off_before += std::pow(before.entries[k].exchange_area.value - truth, 2);
        off += std::pow(value - truth, 2);
        ++guess;
        continue;
      }
      EXPECT_EQ(value, before.entries[k].exchange_area.value) << "a measured entry moved, seed " << seed;
    }
    EXPECT_LT(off, 0.1 * off_before) << "seed " << seed;  // the common error of all guesses is gone
  }
}

// The large errors of measured entries explain why the row's sum is not 1. A guess that is nearly certain does not
// move.
TEST(CalibrateRows, WhatMeasuredEntriesMissIsNotForcedOnGuesses) {
  Matrix matrix{{{0, 1, {0.5, 0.1}}, {0, 2, {0.3, 1e-4}}}, {{1, 0.3001f, 0.9996f, 1}}, {1, 0.5, 0.3}};
  calibrateRows(matrix.entries, matrix.guesses, matrix.areas);
  EXPECT_EQ(matrix.entries[0].exchange_area.value, 0.5);
  EXPECT_NEAR(matrix.entries[1].exchange_area.value, 0.3, 1e-3);
  EXPECT_LE(matrix.entries[1].exchange_area.value, double(0.3001f));
}

TEST(CalibrateRows, RowsWithoutRoomGainWhatThereIs) {
  Matrix matrix{{{0, 1, {0.1, 0.05}}}, {{0, 0.2f, 0.5f, 1}}, {1, 1}};
  calibrateRows(matrix.entries, matrix.guesses, matrix.areas);
  EXPECT_GT(matrix.entries[0].exchange_area.value, 0.19);
  EXPECT_LE(matrix.entries[0].exchange_area.value, double(0.2f));
}

TEST(CalibrateRows, RowSums) {
  const std::vector<Measured> rows = sumRows({{0, 0, {1, 0.3}}, {0, 1, {2, 0.4}}, {1, kLeak, {1, 0}}}, {3, 6});
  EXPECT_DOUBLE_EQ(rows[0].value, 1);
  EXPECT_DOUBLE_EQ(rows[0].standard_error, 0.5 / 3);
  EXPECT_DOUBLE_EQ(rows[1].value, 0.5);
  EXPECT_DOUBLE_EQ(rows[1].standard_error, 0.4 / 6);
}

}  // namespace
}  // namespace viewpeel
