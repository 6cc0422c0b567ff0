// With C_ij = E[A'_ij] the form factor is F_ij = 2 C_ij / A_i (Pellegrini 1997, section 5.1), so A_i F_ij = 2 C_ij. An
// id of several polygons can see itself; each unordered pair of its polygons then exchanges both ways, so A_i F_ii = 4
// C_ii.
#include "sums/replicate_sums.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

double exchangesPerLine(uint32_t i, uint32_t j) { return i == j ? 4 : 2; }

}  // namespace

void ReplicateSums::add(const PairCounts& counts) {
  addRows(counts);
  const auto addTo = [](PairSum& sum, const PairCount& count) { sum.sum.add(count.count); };
  const auto is_seen = [](const PairCount& count) { return count.count > 0; };
  if (std::all_of(counts.begin(), counts.end(), is_seen)) return addPairs(pairs_, counts, addTo);
  PairCounts seen;  // pairs of which all lines were blocked are left out
  std::copy_if(counts.begin(), counts.end(), std::back_inserter(seen), is_seen);
  addPairs(pairs_, seen, addTo);
}

void ReplicateSums::addRows(const PairCounts& counts) {
  ++replicate_count_;  // first: what ends early is seen (RunSums::isWhole)
  std::vector<uint64_t> rows(ids_.count(), 0);
  for (const PairCount& count : counts) {
    rows[count.i] += count.count;
    if (count.j < kEnvironment) rows[count.j] += count.count;  // a pair within one id counts twice
  }
  for (size_t k = 0; k < rows.size(); ++k) row_sums_[k].add(rows[k]);
}

void ReplicateSums::add(const ReplicateSums& others) {
  replicate_count_ += others.replicate_count_;
  addPairs(pairs_, others.pairs_, [](PairSum& sum, const PairSum& pair) { sum.sum.add(pair.sum); });
  for (size_t k = 0; k < row_sums_.size(); ++k) row_sums_[k].add(others.row_sums_[k]);
}

// With R replicates that count c_r, K = sum c_r and s^2 = sum (c_r - K / R)^2 / (R - 1), the estimate is K / R and its
// standard error
//   sqrt(R s^2 + D^2) / R,   D = (K + D_0) / (K / max(1, R s^2 / K) + 1),
// infinite from a single replicate. R s^2 alone has the variance of K as its mean, but where few lines count, K and s
// fall short together and K +- t sqrt(R s^2) holds the expectation m too rarely. With D counts that come at a time the
// variance is D m; |K - m| <= z sqrt(D m) (the score interval) is K + D z^2 / 2 +- z sqrt(D K + D^2 z^2 / 4), and z^2 /
// 4 is 0.96 at 95 %: hence D^2. The centre stays, for the estimate is to be unbiased. Where s^2 is all there is to know
// the surplus is nothing: a factor of sqrt(1 + q^2) for a relative standard error q. D_1 = R s^2 / K would be those
// counts, at least 1, for they are integers: replicates that agree by chance are not exact. But one or two directions
// that saw a pair, each with many lines or only grazing it, do not tell how many lines others would have seen. So K /
// D_1 of them are joined by one more with D_0, what a direction that sees the pair counts: along it two convex regions
// overlap as they happen to lie. Of an area X that varies so, and of counts on a lattice beside, E[X^2] / E[X] is 4/9
// of the smaller region for parallelograms of one shape; lines leave a polygon with 2/3 as their mean cosine; counts
// are at least 1: D_0 = 1 + 8/27 A / h^2 with A the smaller of the two areas and h^2 that of a count. Where many
// directions saw the pair this is nothing. What no line met has no entry. Of n directions none meets a pair with
// probability (1 - p)^n, which is 5 % for p = ln 20 / n, where p is the share of lattices and directions that meet it;
// E[A'] is at most p max(h^2, A), for a lattice meets an area a below h^2 with probability a / h^2. Hence F <= 2 ln 20
// max(1, h^2 / A) / n at 95 %, from the smaller of the two (unmetBound). How often intervals hold the truth:
// bench/coverage.cpp. Source: A. Agresti & B. A. Coull, Approximate is better than "exact" for interval estimation of
// binomial proportions, The American Statistician 52, 1998.
Measured ReplicateSums::measure(const Sum& sum, double most_counts) const {
  const Wide replicates = replicate_count_;
  Measured measured;
  measured.value = double(sum.sum) / double(replicate_count_);
  if (replicate_count_ < 2) {
    measured.standard_error = INFINITY;
    return measured;
  }
  // R (R - 1) s^2, exactly
  const Wide spread = replicates * sum.sum_of_squares - sum.sum * sum.sum;
  const double r = double(replicate_count_), variance = double(spread) / (r - 1);
  const double counted = double(sum.sum), at_a_time = spread ? std::max(1.0, variance / counted) : 1;
  const double surplus = (counted + 1 + 8 / 27.0 * most_counts) / (counted / at_a_time + 1);
  measured.standard_error = std::sqrt(variance + surplus * surplus) / r;
  return measured;
}

Measured ReplicateSums::exchangeArea(const PairSum& pair, double measure_area, double count_area) const {
  const Measured count = measure(pair.sum, std::isinf(count_area) ? 0 : ids_.smallerArea(pair.i, pair.j) / count_area);
  const double scale = exchangesPerLine(pair.i, pair.j) * measure_area;
  return {count.value * scale, count.standard_error * scale};
}

FormFactors ReplicateSums::formFactors(double measure_area, double count_area) const {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(pairs_.size());
  for (const PairSum& pair : pairs_) entries.push_back({pair.i, pair.j, exchangeArea(pair, measure_area, count_area)});
  std::vector<Measured> rows;
  for (size_t k = 0; k < row_sums_.size(); ++k) {
    const Measured count = measure(row_sums_[k], 0);
    const double scale = 2 * measure_area / ids_.areas[k];
    rows.push_back({count.value * scale, count.standard_error * scale});
  }
  return {ids_, std::move(entries), std::move(rows)};
}

double ReplicateSums::largestStandardError(double measure_area, double count_area) const {
  double largest = 0;
  for (const PairSum& pair : pairs_)
    largest = std::max(largest,
                       exchangeArea(pair, measure_area, count_area).standard_error / ids_.smallerArea(pair.i, pair.j));
  return largest;
}

double ReplicateSums::largestRelativeError(double measure_area, double floor, double count_area) const {
  double largest = 0;
  for (const PairSum& pair : pairs_) {
    // Both ways the relative error is the same: it counts if one of the two reaches the floor.
    const Measured exchange = exchangeArea(pair, measure_area, count_area);
    if (exchange.value / ids_.smallerArea(pair.i, pair.j) >= floor)
      largest = std::max(largest, exchange.standard_error / exchange.value);
  }
  return largest;
}

double unmetBound(double area, double count_area, double directions) {
  return 2 * std::log(20.0) * std::max(1.0, count_area / area) / directions;
}

PairCounts mergeIds(const PairCounts& counts, const std::vector<uint32_t>& id_map) {
  return mergePairs(counts, id_map, [](PairCount& sum, const PairCount& count) { sum.add(count); });
}

}  // namespace viewpeel
