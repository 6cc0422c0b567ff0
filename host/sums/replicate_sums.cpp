// Counts become form factors by docs/method.md, eq. (7). A row of several polygons can see itself. Each pair of its
// polygons then exchanges radiation in both directions within the row, so A_i F_ii = 4 C_ii.
#include "sums/replicate_sums.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

// Returns the factor by which the mean count, times measure_area, is the exchange area A_i F_ij.
double exchangesPerLine(uint32_t i, uint32_t j) { return i == j ? 4 : 2; }

}  // namespace

void ReplicateSums::add(const PairCounts& counts) {
  addRows(counts);
  const auto addTo = [](PairSum& sum, const PairCount& count) { sum.sum.add(count.count); };
  const auto is_seen = [](const PairCount& count) { return count.count > 0; };
  if (std::all_of(counts.begin(), counts.end(), is_seen)) return pairs_.add(counts, addTo);
  PairCounts seen;  // the counts of pairs with a facing line
  std::copy_if(counts.begin(), counts.end(), std::back_inserter(seen), is_seen);
  pairs_.add(seen, addTo);
}

void ReplicateSums::addRows(const PairCounts& counts) {
  ++replicate_count_;  // comes first, so that RunSums::isWhole notices where an exception ends this call
  std::vector<uint64_t> rows(ids_.count(), 0);
  for (const PairCount& count : counts) {
    rows[count.i] += count.count;
    if (count.j < kEnvironment) rows[count.j] += count.count;  // a pair (i, i) counts twice
  }
  for (size_t k = 0; k < rows.size(); ++k) row_sums_[k].add(rows[k]);
}

void ReplicateSums::addOutside(const PairCounts& counts, const std::vector<bool>& rows) {
  ++replicate_count_;
  ++further_.replicates;
  further_.of_rows.resize(ids_.count());
  for (size_t k = 0; k < rows.size(); ++k) further_.of_rows[k] += rows[k];
  pairs_.add(counts, [](PairSum& sum, const PairCount& count) { sum.sum.add(count.count); });
}

void ReplicateSums::add(const ReplicateSums& others) {
  replicate_count_ += others.replicate_count_;
  further_.replicates += others.further_.replicates;
  further_.of_rows.resize(std::max(further_.of_rows.size(), others.further_.of_rows.size()));
  for (size_t k = 0; k < others.further_.of_rows.size(); ++k) further_.of_rows[k] += others.further_.of_rows[k];
  pairs_.add(others.pairs_, [](PairSum& sum, const PairSum& pair) { sum.sum.add(pair.sum); });
  for (size_t k = 0; k < row_sums_.size(); ++k) row_sums_[k].add(others.row_sums_[k]);
}

uint64_t ReplicateSums::replicatesOf(uint32_t i, uint32_t j) const {
  const bool has_further = j >= kEnvironment && !further_.of_rows.empty();
  return replicate_count_ - further_.replicates + (has_further ? further_.of_rows[i] : 0);
}

// Returns the variance of the sum of the counts of all replicates, of at least 2, from their spread.
double ReplicateSums::varianceOf(const Sum& sum, uint64_t replicate_count) const {
  const Wide replicates = replicate_count;
  // The spread is R (R - 1) s^2, without rounding.
  const Wide spread = replicates * sum.sum_of_squares - sum.sum * sum.sum;
  return double(spread) / (double(replicates) - 1);
}

double ReplicateSums::spreadOf(const PairSum& pair, double measure_area) const {
  const uint64_t replicates = replicatesOf(pair.i, pair.j);
  if (replicates < 2) return 0;
  return exchangesPerLine(pair.i, pair.j) * measure_area * std::sqrt(varianceOf(pair.sum, replicates)) /
         double(replicates);
}

// Returns the mean count of a replicate with the standard error of docs/method.md, eq. (12), which is infinite from a
// single replicate.
//   In: replicates: in which the pair could be counted; steps: of the pair's counts
Measured ReplicateSums::measure(const Sum& sum, uint64_t replicate_count, const Steps& steps) const {
  Measured measured;
  measured.value = double(sum.sum) / double(replicate_count);
  if (replicate_count < 2) {
    measured.standard_error = INFINITY;
    return measured;
  }
  const double r = double(replicate_count), variance = varianceOf(sum, replicate_count);
  const double counted = double(sum.sum),
               at_a_time = variance > 0 ? std::max(steps.least, variance / counted) : steps.least;
  const double surplus = (counted + steps.of_direction) / (counted / at_a_time + 1);
  measured.standard_error = std::sqrt(variance + surplus * surplus) / r;
  return measured;
}

ReplicateSums::Steps ReplicateSums::stepsOf(const PairSum& pair, double count_area, bool is_rare) const {
  const double line = line_steps_.empty()     ? 1
                      : pair.j < kEnvironment ? std::min(line_steps_[pair.i], line_steps_[pair.j])
                                              : line_steps_[pair.i];
  if (std::isinf(count_area)) return {line, line};
  if (!ray_areas_.empty()) {
    const double area = pair.j < kEnvironment ? std::min(ray_areas_[pair.i], ray_areas_[pair.j]) : ray_areas_[pair.i];
    return {1 + 8 / 27.0 * area / count_area, std::max(1.0, area / count_area / 2)};
  }
  const double area = ids_.smallerArea(pair.i, pair.j);
  if (!is_rare) return {line + 8 / 27.0 * area / count_area, line};
  const double side = std::sqrt(area / std::max(ids_.areas[pair.i], ids_.areas[pair.j])),
               of_direction = line + 2 / 3.0 * std::pow(1 - side / 3, 2) * area / count_area;
  return {of_direction, of_direction};
}

Measured ReplicateSums::exchangeArea(const PairSum& pair, double measure_area, double count_area, bool is_rare) const {
  const Measured count = measure(pair.sum, replicatesOf(pair.i, pair.j), stepsOf(pair, count_area, is_rare));
  const double scale = exchangesPerLine(pair.i, pair.j) * measure_area;
  return {count.value * scale, count.standard_error * scale};
}

double ReplicateSums::binomialVariance(uint32_t row, double exchange, double measure_area, double count_area) const {
  const double area = ids_.areas[row], directions = count_area / measure_area,
               rays = directions * area / ray_areas_[row] * double(replicatesOf(row, kEnvironment));
  return std::max(0.0, exchange * (area - exchange)) / rays;
}

std::vector<double> ReplicateSums::exchangesOfRays(double measure_area, double count_area) const {
  const double directions = count_area / measure_area * double(replicate_count_ - further_.replicates);
  std::vector<double> exchanges = ray_areas_;
  for (double& exchange : exchanges) exchange /= directions;
  return exchanges;
}

double ReplicateSums::rayEfficiency(double measure_area, double count_area) const {
  if (ray_areas_.empty()) return 0;
  struct alignas(64) Part {  // threads write to different lines of the processor's caches
    double variance = 0, binomial = 0;
  };
  std::vector<Part> parts(pairs_.ranges().count());
  pairs_.forEachBlock([&](size_t block, size_t) {
    for (const PairSum& pair : pairs_.block(block)) {
      if (pair.j != kEnvironment) continue;
      const Measured exchange = exchangeArea(pair, measure_area, count_area);
      const double error = exchange.standard_error / ids_.areas[pair.i],
                   binomial = binomialVariance(pair.i, exchange.value, measure_area, count_area);
      parts[block].variance += error * error;
      parts[block].binomial += binomial / (ids_.areas[pair.i] * ids_.areas[pair.i]);
    }
  });
  Part all;
  for (const Part& part : parts) all.variance += part.variance, all.binomial += part.binomial;
  return all.binomial > 0 ? std::min(1.0, all.variance / all.binomial) : 0;
}

FormFactors ReplicateSums::formFactors(double measure_area, double count_area) const {
  std::vector<FormFactors::Entry> entries(pairs_.size());
  pairs_.forEachBlock([&](size_t block, size_t first) {
    for (const PairSum& pair : pairs_.block(block))
      entries[first++] = {pair.i, pair.j, exchangeArea(pair, measure_area, count_area)};
  });
  return {ids_, std::move(entries), measureRows(measure_area)};
}

std::vector<Measured> ReplicateSums::measureRows(double measure_area) const {
  std::vector<Measured> rows;
  for (size_t k = 0; k < row_sums_.size(); ++k) {
    const Measured count = measure(row_sums_[k], replicate_count_ - further_.replicates, {});
    const double scale = 2 * measure_area / ids_.areas[k];
    rows.push_back({count.value * scale, count.standard_error * scale});
  }
  return rows;
}

// Returns the largest error_of(pair), or 0 where there is none above 0.
template <class ErrorOf>
double ReplicateSums::largestOf(const ErrorOf& error_of) const {
  std::vector<double> largest(pairs_.ranges().count() + 1, 0);  // one more, for there may be no block
  pairs_.forEachBlock([&](size_t block, size_t) {
    double of_block = 0;
    for (const PairSum& pair : pairs_.block(block)) of_block = std::max(of_block, error_of(pair));
    largest[block] = of_block;
  });
  return *std::ranges::max_element(largest);
}

double ReplicateSums::largestStandardError(double measure_area, double count_area) const {
  return largestOf([&](const PairSum& pair) {
    return exchangeArea(pair, measure_area, count_area).standard_error / ids_.smallerArea(pair.i, pair.j);
  });
}

double ReplicateSums::largestRelativeError(double measure_area, double floor, double count_area) const {
  return largestOf([&](const PairSum& pair) {
    // F_ij and F_ji have the same relative error, which counts if the larger of the two reaches the floor.
    const Measured exchange = exchangeArea(pair, measure_area, count_area);
    const bool is_large = exchange.value / ids_.smallerArea(pair.i, pair.j) >= floor;
    return is_large ? exchange.standard_error / exchange.value : 0;
  });
}

double lineStep(double line, bool is_scanline, double area, double count_area) {
  return std::max(1.0, is_scanline ? std::min(line, std::sqrt(line * area / 2 / count_area)) : line);
}

double unmetBound(double area, double count_area, double directions) {
  return 2 * std::log(20.0) * std::max(1.0, count_area / area) / directions;
}

// Let the polygons k of row i have n_k rays each. The chance that none of them ends on row j is at most
// exp(-sum_k n_k F_kj), and A_i F_ij = sum_k A_k F_kj is at most max_k(A_k / n_k) times this sum.
double ReplicateSums::unmetBoundOfRays(double directions) const {
  double largest = 0;
  for (uint32_t i = 0; i < ids_.count(); ++i)
    if (ids_.isRequested(i)) largest = std::max(largest, ray_areas_[i] / ids_.areas[i]);
  return std::log(20.0) * largest / directions;
}

PairCounts mergeIds(const PairCounts& counts, const std::vector<uint32_t>& id_map) {
  return mergePairs(counts, id_map, [](PairCount& sum, const PairCount& count) { sum.add(count); });
}

}  // namespace viewpeel
