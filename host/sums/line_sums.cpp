#include "sums/line_sums.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>

#include "sums/add_pairs.h"
#include "threads.h"

namespace viewpeel {
namespace {

// The variance expected by chance in eq. (47) has this many degrees of freedom; the replicates' degrees are added.
constexpr double kChanceDegrees = 5;

// Returns a b / 2^8, with both rounded down to multiples of 2^4; see PairSum.
uint64_t squareUnits(uint64_t a, uint64_t b) { return (a >> 4) * (b >> 4); }

constexpr size_t kChunk = 1 << 12;  // pairs that a thread takes at once

// Returns the part of a pair's unoccluded exchange area that something may block.
double blockable(const LinePair& pair) { return std::max(0.0, pair.exchange - pair.clear); }

// Adds an entry of the same pair of ids, whose error is independent. The sum has the larger margin of the two.
void addEntry(FormFactors::Entry& sum, const FormFactors::Entry& entry) {
  const double margin = std::max(sum.margin(), entry.margin());
  sum.error_in_sums = std::hypot(sum.errorInSums(), entry.errorInSums());
  sum.exchange_area.value += entry.exchange_area.value;
  sum.exchange_area.standard_error = std::hypot(sum.error_in_sums, std::sqrt(margin));
}

// Returns how often a pair counts in A_i F_ij: twice where two polygons of one face see each other, both ways.
double waysOf(const LinePair& pair) { return pair.i == pair.j ? 2 : 1; }

// Returns the class of a pair in eq. (61) of docs/method.md: class c has 2^(c-1) to 2^c - 1 blocks.
size_t classOf(const LinePair& pair) { return static_cast<size_t>(std::bit_width(pair.blocks)); }

}  // namespace

std::pair<uint32_t, uint32_t> entryOf(const LinePair& pair, const Ids& face_ids, By by) {
  const bool is_leak = pair.j >= face_ids.count();
  if (by == By::polygon) return {pair.i, is_leak ? kLeak : pair.j};
  return std::minmax(face_ids.surface[pair.i], is_leak ? kLeak : face_ids.surface[pair.j]);
}

LineSums::LineSums(Ids ids, By by, std::vector<LinePair> pairs, double least_form_factor, LeakingFaces leaking)
    : ids_(std::move(ids)),
      by_(by),
      pairs_(std::move(pairs)),
      least_form_factor_(least_form_factor),
      leaking_(std::move(leaking)) {
  findPlaces();
}

LineSums::LineSums(Ids ids, By by, std::vector<LinePair> pairs, double least_form_factor, LeakingFaces leaking,
                   const std::vector<PairSum>& sums, uint64_t replicate_count)
    : LineSums(std::move(ids), by, std::move(pairs), least_form_factor, std::move(leaking)) {
  for (size_t k = 0; k < sums.size(); ++k)
    if (places_[k] != kNoPlace) sums_[places_[k]] = sums[k];
  replicate_count_ = replicate_count;
}

void LineSums::findPlaces() {
  uint32_t count = 0;
  places_.reserve(pairs_.size());
  for (const LinePair& pair : pairs_) places_.push_back(pair.blocks ? count++ : kNoPlace);
  sums_.resize(count);
}

const LineSums::PairSum& LineSums::sumOf(size_t pair) const {
  static constexpr PairSum kNone{};
  return places_[pair] == kNoPlace ? kNone : sums_[places_[pair]];
}

void LineSums::add(const LineCounts& counts) {
  ++replicate_count_;
  for (const LineCount& count : counts) addTo(sums_[places_[count.pair]], count);
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
  for (size_t k = 0; k < pairs_.size(); ++k) lines += 16 * sumOf(k).blocks * pairs_[k].parts;
  return lines;
}

double varianceByChance(double visibility, double lines) {
  // Half a facing and half a blocked line are added: however many lines agree, others may not.
  const double likely = (lines * visibility + 0.5) / (lines + 1);
  return likely * (1 - likely) / (lines + 1);
}

LineVariances variancesOf(const LineSums::PairSum& sum) {
  const double facing = double(sum.facing), all = double(sum.all), visibility = facing / all;
  LineVariances found{.lines = double(sum.effective) / kEffectiveUnit};
  found.by_chance = varianceByChance(visibility, found.lines);
  // D of eq. (47): even lines err less, but not where few are of the rarer kind.
  const double deciding = std::max(1.0, 4 * found.by_chance * (found.lines + 1) * double(sum.blocks));
  found.expected = found.by_chance / std::sqrt(std::sqrt(deciding));
  // Replicates of different sizes count as this number of replicates of one size.
  const double sizes = all * all / (256 * double(sum.all_squares)),
               replicates = std::min(double(sum.replicates), sizes);
  if (!(replicates > 1)) return found;
  const double residuals = double(sum.facing_squares) - 2 * visibility * double(sum.products) +
                           visibility * visibility * double(sum.all_squares);
  found.of_replicates = std::max(0.0, residuals) * 256 * replicates / (replicates - 1) / (all * all);
  found.degrees_of_freedom = replicates - 1;
  return found;
}

Visibility visibilityOf(const LineSums::PairSum& sum, uint32_t planned_blocks) {
  return sum.all == 0 ? Visibility{} : visibilityOf(sum, planned_blocks, variancesOf(sum));
}

Visibility visibilityOf(const LineSums::PairSum& sum, uint32_t planned_blocks, const LineVariances& of) {
  const double all = double(sum.all), half_a_line = 0.25 / ((of.lines + 1) * (of.lines + 1));
  // Where the lines have less weight than expected, a few heavy lines are missing, which may be blocked or not.
  const double missing = std::max(0.0, 1 - all * planned_blocks / (kLineUnit * double(sum.blocks)));
  const double unknown = half_a_line + 0.25 * missing * missing;
  if (of.degrees_of_freedom == 0) return {double(sum.facing) / all, of.by_chance + unknown};
  return {double(sum.facing) / all, (kChanceDegrees * of.expected + of.degrees_of_freedom * of.of_replicates) /
                                            (kChanceDegrees + of.degrees_of_freedom) +
                                        unknown};
}

Measured LineSums::exchangeArea(size_t k) const { return exchangeArea(k, visibilityOf(sumOf(k), pairs_[k].blocks)); }

Measured LineSums::exchangeArea(size_t k, const Visibility& visibility) const {
  const LinePair& pair = pairs_[k];
  const double ways = waysOf(pair), most = std::min(pair.exchange, smallerArea(pair) / ways),
               of_lines = blockable(pair);
  if (pair.blocks == 0) return {ways * most, ways * pair.error};
  const double value = std::min(most, pair.clear + visibility.value * of_lines);
  double error = of_lines * std::sqrt(visibility.variance);
  error = std::min(error, of_lines * std::max(visibility.value, 1 - visibility.value));
  return {ways * value, ways * (error + pair.error)};
}

LineSums::ChanceFactors LineSums::chanceFactors() const {
  struct Class {
    double of_replicates = 0, by_chance = 0, degrees = 0;
  };
  using Classes = std::array<Class, std::tuple_size_v<ChanceFactors>>;
  // Each chunk has sums of its own, which are added in order: the same bits for any number of threads.
  std::vector<Classes> of_chunks(chunkCount());
  forEachChunk([&](size_t chunk, size_t first, size_t end) {
    for (size_t k = first; k < end; ++k) {
      if (pairs_[k].blocks == 0 || sumOf(k).all == 0) continue;
      const LineVariances of = variancesOf(sumOf(k));
      if (of.degrees_of_freedom == 0) continue;
      const double square = std::pow(blockable(pairs_[k]), 2);
      Class& found = of_chunks[chunk][classOf(pairs_[k])];
      found.of_replicates += square * of.of_replicates;
      found.by_chance += square * of.by_chance;
      found.degrees += of.degrees_of_freedom;
    }
  });
  ChanceFactors factors;
  for (size_t c = 0; c < factors.size(); ++c) {
    Class all;
    for (const Classes& of_chunk : of_chunks) {
      all.of_replicates += of_chunk[c].of_replicates;
      all.by_chance += of_chunk[c].by_chance;
      all.degrees += of_chunk[c].degrees;
    }
    const double ratio = all.by_chance > 0 ? all.of_replicates / all.by_chance : 1;
    factors[c] = (kChanceDegrees + all.degrees * ratio) / (kChanceDegrees + all.degrees);
  }
  return factors;
}

FormFactors::Entry LineSums::entryAt(size_t k, const ChanceFactors& factors) const {
  FormFactors::Entry entry{pairs_[k].i, hasBack(k) ? kLeak : pairs_[k].j, {}};
  if (sumOf(k).all == 0) {
    entry.exchange_area = exchangeArea(k, {});
    return entry;
  }
  const LineVariances of = variancesOf(sumOf(k));
  entry.exchange_area = exchangeArea(k, visibilityOf(sumOf(k), pairs_[k].blocks, of));
  if (hasBack(k)) return entry;
  const double variance =
      (kChanceDegrees * factors[classOf(pairs_[k])] * of.by_chance + of.degrees_of_freedom * of.of_replicates) /
      (kChanceDegrees + of.degrees_of_freedom);
  entry.error_in_sums = std::min(waysOf(pairs_[k]) * (blockable(pairs_[k]) * std::sqrt(variance) + pairs_[k].error),
                                 entry.exchange_area.standard_error);
  return entry;
}

size_t LineSums::chunkCount() const { return (pairs_.size() + kChunk - 1) / kChunk; }

void LineSums::forEachChunk(const std::function<void(size_t chunk, size_t first, size_t end)>& work) const {
  shareOut(threadsFor(pairs_.size()), chunkCount(), 1,
           [&](size_t, size_t chunk) { work(chunk, chunk * kChunk, std::min(pairs_.size(), (chunk + 1) * kChunk)); });
}

bool LineSums::goesWith(const LineSums& others) const {
  const auto linesOf = [](const LinePair& pair) {
    return std::tuple(pair.i, pair.j, pair.blocks, pair.period, pair.by_angles, pair.cuts);
  };
  return by_ == others.by_ && least_form_factor_ == others.least_form_factor_ && leaking_ == others.leaking_ &&
         std::ranges::equal(pairs_, others.pairs_, {}, linesOf, linesOf);
}

std::vector<FormFactors::Entry> LineSums::entriesOfResult() const {
  return by_ == By::polygon ? entries() : mergeBySurface(entries(), ids_.surface);
}

double LineSums::smallerArea(const LinePair& pair) const {
  return std::min(ids_.areas[pair.i], pair.j < ids_.count() ? ids_.areas[pair.j] : INFINITY);
}

std::vector<FormFactors::Entry> LineSums::entries() const {
  std::vector<FormFactors::Entry> entries(pairs_.size());
  const ChanceFactors factors = chanceFactors();
  forEachChunk([&](size_t, size_t first, size_t end) {
    for (size_t k = first; k < end; ++k) entries[k] = entryAt(k, factors);
  });
  addSameKeys(entries);  // a face has one pair for each back that it sees
  return entries;
}

std::vector<FormFactors::Entry> mergeBySurface(std::vector<FormFactors::Entry> entries,
                                               const std::vector<uint32_t>& surface) {
  // Two faces of one surface exchange both ways within it. An entry of one face has both ways already.
  for (FormFactors::Entry& entry : entries)
    if (entry.j < kEnvironment && entry.i != entry.j && surface[entry.i] == surface[entry.j]) {
      entry.exchange_area.value *= 2;
      entry.exchange_area.standard_error *= 2;
      entry.error_in_sums *= 2;
    }
  return mergePairs(entries, surface, addEntry);
}

void addSameKeys(std::vector<FormFactors::Entry>& entries) {
  if (entries.empty()) return;
  auto last = entries.begin();
  for (auto entry = last + 1; entry != entries.end(); ++entry) {
    if (keyOf(*entry) == keyOf(*last)) addEntry(*last, *entry);
    else *++last = *entry;
  }
  entries.erase(last + 1, entries.end());
}

}  // namespace viewpeel
