// These functions add up numbers by the rows of a result, on all threads.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>
#include "threads.h"

namespace viewpeel {

// RowTotals are two sums for each row.
using RowTotals = std::array<std::vector<double>, 2>;

// Adds a number to both rows of an entry, or to its only one.
inline void addToRows(std::vector<double>& totals, const FormFactors::Entry& entry, double number) {
  totals[entry.i] += number;
  if (entry.j < kEnvironment && entry.j != entry.i) totals[entry.j] += number;
}

// Goes through `count` items: add(k, totals) adds item k to its rows. The items are divided into parts, whose number
// does not depend on the number of threads. Their totals are added in one order, so the result has the same bits for
// any number of threads.    Cost: memory of at most 16 bytes an item
template <class Add>
RowTotals sumByRow(size_t count, size_t rows, const Add& add) {
  constexpr size_t kLeastOfPart = size_t(1) << 16, kMostParts = 32;
  const size_t parts = std::clamp<size_t>(count / std::max(kLeastOfPart, rows), 1, kMostParts);
  std::vector<RowTotals> found(parts);
  shareOut(threadsFor(count), parts, 1, [&](size_t, size_t part) {
    RowTotals& totals = found[part];
    totals = {std::vector<double>(rows), std::vector<double>(rows)};
    for (size_t k = count * part / parts, end = count * (part + 1) / parts; k < end; ++k) add(k, totals);
  });
  for (size_t part = 1; part < parts; ++part)
    for (size_t sum = 0; sum < 2; ++sum)
      for (size_t i = 0; i < rows; ++i) found[0][sum][i] += found[part][sum][i];
  return std::move(found[0]);
}

// Returns the row sums of entries, sum_j x_ij / A_i, with their standard errors as if the entries were independent. A
// pair (i, i) is added once.
std::vector<Measured> sumRows(const std::vector<FormFactors::Entry>& entries, const std::vector<double>& areas);

// Returns row sums from the totals of exchange areas, and of their squared errors.    In: areas: double[rows]
std::vector<Measured> rowSumsOf(const RowTotals& totals, const std::vector<double>& areas);

}  // namespace viewpeel
