#include "sums/line_sums.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

// N independent lines give a variance; N scrambled Sobol' points give this factor times (N / 16)^-1/4 of it. The factor
// was measured: docs/accuracy.md.
constexpr double kEvenness = 1;
// The variance expected by chance in eq. (47) has this many degrees of freedom; the replicates' degrees are added.
constexpr double kChanceDegrees = 5;

// Returns a b / 2^8, with both rounded down to multiples of 2^4; see PairSum.
uint64_t squareUnits(uint64_t a, uint64_t b) { return (a >> 4) * (b >> 4); }

}  // namespace

std::pair<uint32_t, uint32_t> entryOf(const LinePair& pair, const Ids& face_ids, By by) {
  const bool is_leak = pair.j >= face_ids.count();
  if (by == By::polygon) return {pair.i, is_leak ? kLeak : pair.j};
  return std::minmax(face_ids.surface[pair.i], is_leak ? kLeak : face_ids.surface[pair.j]);
}

LineSums::LineSums(Ids ids, By by, std::vector<LinePair> pairs, double least_form_factor)
    : ids_(std::move(ids)),
      by_(by),
      pairs_(std::move(pairs)),
      least_form_factor_(least_form_factor),
      sums_(pairs_.size()) {}

LineSums::LineSums(Ids ids, By by, std::vector<LinePair> pairs, double least_form_factor, std::vector<PairSum> sums,
                   uint64_t replicate_count)
    : ids_(std::move(ids)),
      by_(by),
      pairs_(std::move(pairs)),
      least_form_factor_(least_form_factor),
      sums_(std::move(sums)),
      replicate_count_(replicate_count) {}

void LineSums::add(const LineCounts& counts) {
  ++replicate_count_;
  for (const LineCount& count : counts) addTo(sums_[count.pair], count);
}

void LineSums::addTo(PairSum& sum, const LineCount& count) {
  sum.facing += count.facing, sum.all += count.all, sum.effective += count.effective;
  sum.facing_squares += squareUnits(count.facing, count.facing);
  sum.products += squareUnits(count.facing, count.all);
  sum.all_squares += squareUnits(count.all, count.all);
  sum.blocks += count.blocks;
  ++sum.replicates;
}

void LineSums::add(const LineSums& others) {
  replicate_count_ += others.replicate_count_;
  for (size_t k = 0; k < sums_.size(); ++k) {
    PairSum& sum = sums_[k];
    const PairSum& other = others.sums_[k];
    sum.facing += other.facing, sum.all += other.all, sum.effective += other.effective;
    sum.facing_squares += other.facing_squares, sum.products += other.products, sum.all_squares += other.all_squares;
    sum.blocks += other.blocks, sum.replicates += other.replicates;
  }
}

uint64_t LineSums::lineCount() const {
  uint64_t lines = 0;
  for (size_t k = 0; k < sums_.size(); ++k) lines += 16 * sums_[k].blocks * pairs_[k].parts;
  return lines;
}

double varianceByChance(double visibility, double lines) {
  // Half a facing and half a blocked line are added: however many lines agree, others may not.
  const double likely = (lines * visibility + 0.5) / (lines + 1);
  return likely * (1 - likely) / (lines + 1);
}

Visibility visibilityOf(const LineSums::PairSum& sum, uint32_t planned_blocks) {
  if (sum.all == 0) return {};
  const double facing = double(sum.facing), all = double(sum.all), lines = double(sum.effective) / kEffectiveUnit;
  Visibility found;
  found.value = facing / all;
  const double by_chance = varianceByChance(found.value, lines), half_a_line = 0.25 / ((lines + 1) * (lines + 1));
  // Where the lines have less weight than expected, a few heavy lines are missing, which may be blocked or not.
  const double missing = std::max(0.0, 1 - all * planned_blocks / (kLineUnit * double(sum.blocks)));
  const double unknown = half_a_line + 0.25 * missing * missing;
  // Replicates of different sizes count as this number of replicates of one size.
  const double sizes = all * all / (256 * double(sum.all_squares)),
               replicates = std::min(double(sum.replicates), sizes);
  if (!(replicates > 1)) {
    found.variance = by_chance + unknown;
    return found;
  }
  const double residuals = double(sum.facing_squares) - 2 * found.value * double(sum.products) +
                           found.value * found.value * double(sum.all_squares);
  const double of_replicates = std::max(0.0, residuals) * 256 * replicates / (replicates - 1) / (all * all);
  const double expected = kEvenness * std::pow(double(sum.blocks), -0.25) * by_chance;
  found.variance =
      (kChanceDegrees * expected + (replicates - 1) * of_replicates) / (kChanceDegrees + replicates - 1) + unknown;
  return found;
}

Measured LineSums::exchangeArea(size_t k) const {
  const LinePair& pair = pairs_[k];
  const double most = std::min(pair.exchange, smallerArea(pair)), blockable = std::max(0.0, pair.exchange - pair.clear);
  if (pair.blocks == 0) return {most, pair.error};
  const Visibility visibility = visibilityOf(sums_[k], pair.blocks);
  const double value = std::min(most, pair.clear + visibility.value * blockable);
  double error = blockable * std::sqrt(visibility.variance);
  error = std::min(error, blockable * std::max(visibility.value, 1 - visibility.value));
  return {value, error + pair.error};
}

bool LineSums::goesWith(const LineSums& others) const {
  const auto linesOf = [](const LinePair& pair) {
    return std::tuple(pair.i, pair.j, pair.blocks, pair.period, pair.by_angles, pair.cuts);
  };
  return by_ == others.by_ && least_form_factor_ == others.least_form_factor_ &&
         std::ranges::equal(pairs_, others.pairs_, {}, linesOf, linesOf);
}

std::vector<FormFactors::Entry> LineSums::entriesOfResult() const {
  return by_ == By::polygon ? entries() : mergeBySurface(entries(), ids_.surface);
}

bool LineSums::hasBacks() const {
  return std::ranges::any_of(pairs_, [&](const LinePair& pair) { return pair.j >= ids_.count(); });
}

double LineSums::smallerArea(const LinePair& pair) const {
  return std::min(ids_.areas[pair.i], pair.j < ids_.count() ? ids_.areas[pair.j] : INFINITY);
}

std::vector<FormFactors::Entry> LineSums::entries() const {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(pairs_.size());
  for (size_t k = 0; k < pairs_.size(); ++k) {
    const Measured exchange = exchangeArea(k);
    if (!hasBack(k)) {
      entries.push_back({pairs_[k].i, pairs_[k].j, exchange});
      continue;
    }
    if (entries.empty() || keyOf(entries.back()) != std::pair(pairs_[k].i, kLeak))
      entries.push_back({pairs_[k].i, kLeak, {}});
    Measured& leak = entries.back().exchange_area;
    leak = {leak.value + exchange.value, std::hypot(leak.standard_error, exchange.standard_error)};
  }
  return entries;
}

std::vector<FormFactors::Entry> mergeBySurface(std::vector<FormFactors::Entry> entries,
                                               const std::vector<uint32_t>& surface) {
  for (FormFactors::Entry& entry : entries) {
    const auto [i, j] = std::minmax({surface[entry.i], entry.j < kEnvironment ? surface[entry.j] : entry.j});
    // Two faces of one surface exchange both ways within it.
    const double ways = i == j ? 2 : 1;
    entry = {i, j, {ways * entry.exchange_area.value, ways * entry.exchange_area.standard_error}};
  }
  std::ranges::sort(entries, {}, keyOf<FormFactors::Entry>);
  addSameKeys(entries);
  return entries;
}

void addSameKeys(std::vector<FormFactors::Entry>& entries) {
  if (entries.empty()) return;
  auto last = entries.begin();
  for (auto entry = last + 1; entry != entries.end(); ++entry) {
    if (keyOf(*entry) != keyOf(*last)) {
      *++last = *entry;
      continue;
    }
    Measured& sum = last->exchange_area;
    sum.value += entry->exchange_area.value;
    sum.standard_error = std::hypot(sum.standard_error, entry->exchange_area.standard_error);
  }
  entries.erase(last + 1, entries.end());
}

}  // namespace viewpeel
