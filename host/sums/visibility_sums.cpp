#include "sums/visibility_sums.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include "sums/add_pairs.h"
#include "sums/pair_walk.h"
#include "sums/neighbour_visibility.h"
#include "threads.h"

namespace viewpeel {
namespace {

// Returns (1.96 / t)^2 of eq. (22), with Student's t of R - 1 degrees of freedom at 95 %. Intervals are t standard
// errors long, because R replicates show their own spread only roughly. A variance that is known without replicates is
// multiplied by this factor, so that intervals are 1.96 times its root. R is taken as 8 at least: with fewer, standard
// errors would be far less than errors, and intervals longer than they need be.
double besideReplicates(uint64_t replicates) {
  const double degrees = static_cast<double>(std::max<uint64_t>(replicates, 8) - 1), beyond = 0.025;
  const double ratio = quantile(complement(boost::math::normal(), beyond)) /
                       quantile(complement(boost::math::students_t(degrees), beyond));
  return ratio * ratio;
}

}  // namespace

VisibilitySums::VisibilitySums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs,
                               const std::vector<Squares>& squares)
    : ids_(std::move(ids)), pairs_(std::move(pairs)), replicate_count_(replicate_count) {
  for (size_t k = 0; k < pairs_.size(); ++k) addSquares(pairs_[k], squares[k]);
}

void VisibilitySums::addSquares(PairSum& sum, const Squares& squares) {
  const std::array<Wide, 3> added{squares.facing, squares.product, squares.blocked};
  for (size_t k = 0; k < added.size(); ++k) {
    const Wide total = sum.low_squares[k] + added[k];
    sum.low_squares[k] = static_cast<uint64_t>(total);
    if (const auto high = static_cast<uint64_t>(total >> 64)) high_squares_[keyOf(sum)][k] += high;
  }
}

VisibilitySums::Squares VisibilitySums::squaresOf(const PairSum& pair) const {
  std::array<Wide, 3> squares{pair.low_squares[0], pair.low_squares[1], pair.low_squares[2]};
  if (!high_squares_.empty())
    if (const auto high = high_squares_.find(keyOf(pair)); high != high_squares_.end())
      for (size_t k = 0; k < squares.size(); ++k) squares[k] |= Wide(high->second[k]) << 64;
  return {squares[0], squares[1], squares[2]};
}

void VisibilitySums::add(const PairCounts& counts) {
  ++replicate_count_;  // comes first, so that RunSums::isWhole notices where an exception ends this call
  addPairs(pairs_, counts, [&](PairSum& sum, const PairCount& count) {
    requireCountsForVisibilities(count);
    sum.facing += count.count;
    sum.blocked += count.blocked;
    addSquares(
        sum, {Wide(count.count) * count.count, Wide(count.count) * count.blocked, Wide(count.blocked) * count.blocked});
  });
}

void VisibilitySums::add(const VisibilitySums& others) {
  replicate_count_ += others.replicate_count_;
  addPairs(pairs_, others.pairs_, [&](PairSum& sum, const PairSum& other) {
    sum.facing += other.facing;
    sum.blocked += other.blocked;
    addSquares(sum, others.squaresOf(other));
  });
}

// Entries makes the entries of some rows. It goes through three lists in the order of (i, j) at the same time: the
// pairs of the prior, the pairs with lines, and the sampled entries.
class VisibilitySums::Entries {
  template <class Pairs>
  static auto firstOf(const Pairs& pairs, uint32_t i) {
    return std::lower_bound(pairs.begin(), pairs.end(), i, [](const auto& pair, uint32_t row) { return pair.i < row; });
  }

 public:
  Entries(const VisibilitySums& sums, const std::vector<PairPrior>& prior, const std::vector<uint64_t>& lines,
          double measure_area, double count_area, std::span<const ReplicateSums::Sum> rows,
          const std::vector<FormFactors::Entry>& sampled, const NeighbourVisibility* neighbours)
      : sums_(sums),
        prior_pairs_(prior),
        lines_(lines),
        rows_(rows),
        sampled_entries_(sampled),
        neighbours_(neighbours),
        measure_area_(measure_area),
        count_area_(count_area),
        beside_replicates_(besideReplicates(sums.replicate_count_)) {}

  // Returns the entries and guesses of rows first_row to end_row - 1.
  Found of(uint32_t first_row, uint32_t end_row, const ExchangeRow& row) {
    prior_ = firstOf(prior_pairs_, first_row);
    counted_ = firstOf(sums_.pairs_, first_row);
    sampled_ = firstOf(sampled_entries_, first_row);
    std::vector<BoundedExchange> later;
    if (row)
      // Reserved memory costs nothing before it is written to.
      found_.entries.reserve(size_t(end_row - first_row) * (sums_.ids_.count() - first_row));
    for (uint32_t i = first_row; i < end_row; ++i) {
      if (row) {
        later.assign(sums_.ids_.count() - i - 1, {});
        for (auto prior = prior_; prior != prior_pairs_.end() && prior->i == i; ++prior)
          if (prior->j > i && prior->j < kEnvironment) later[prior->j - i - 1].error = -1;
        row(i, later);
      }
      for (uint32_t j = i + 1, end = static_cast<uint32_t>(i + 1 + later.size()); j < end; ++j) {
        // All pairs before the next one of the three lists are guesses.
        for (const uint32_t next = std::min(nextAfter(i, j), end); j < next; ++j)
          if (const BoundedExchange& exchange = later[j - i - 1]; exchange.area > 0 || exchange.error > 0)
            guess(i, j, exchange.area, exchange.error);
        if (j == end) break;
        addBefore(i, j);
        const BoundedExchange& exchange = later[j - i - 1];
        if (isAt(prior_, prior_pairs_, i, j)) {
          // The pair is in the prior: addBefore adds it.
          addBefore(i, j + 1);
          continue;
        }
        if (!(exchange.area > 0 || exchange.error > 0)) continue;
        const PairSum lines_of_pair = take(i, j);
        if (isAt(sampled_, sampled_entries_, i, j)) ++sampled_;
        add(lines_of_pair, {i, j, 0, 0, exchange.area}, exchange.error);
      }
      addBefore(i + 1, 0);
    }
    return std::move(found_);
  }

 private:
  template <class At, class Pairs>
  static bool isAt(const At& at, const Pairs& pairs, uint32_t i, uint32_t j) {
    return at != pairs.end() && keyOf(*at) == std::pair(i, j);
  }

  // Returns the sums of a pair, which are 0 where no line met it.
  PairSum take(uint32_t i, uint32_t j) {
    while (counted_ != sums_.pairs_.end() && keyOf(*counted_) < std::pair(i, j)) ++counted_;
    return isAt(counted_, sums_.pairs_, i, j) ? *counted_ : PairSum{i, j};
  }

  // Returns the sums of a pair with environment or leak, with O = L - V. L is the number of all lines of its row in a
  // replicate. The sums of `pair` lack replicates with V = 0; in the others V + O = L. So over all replicates
  //   sum O^2 = sum (L - V)^2 = sum L^2 - 2 sum V (V + O) + sum V^2.
  // Other pairs are returned as they are.
  std::pair<PairSum, Squares> withRow(PairSum pair) const {
    Squares squares = sums_.squaresOf(pair);
    if (pair.j < kEnvironment || rows_.empty()) return {pair, squares};
    const ReplicateSums::Sum& row = rows_[pair.i];
    pair.blocked = static_cast<uint64_t>(row.sum - pair.facing);
    squares.blocked = row.sum_of_squares - 2 * (squares.facing + squares.product) + squares.facing;
    return {pair, squares};
  }

  // Returns the least j >= from such that (i, j) is in one of the three lists, or UINT32_MAX.
  uint32_t nextAfter(uint32_t i, uint32_t from) {
    while (counted_ != sums_.pairs_.end() && keyOf(*counted_) < std::pair(i, from)) ++counted_;
    uint32_t next = UINT32_MAX;
    if (counted_ != sums_.pairs_.end() && counted_->i == i) next = counted_->j;
    if (prior_ != prior_pairs_.end() && prior_->i == i) next = std::min(next, std::max(from, prior_->j));
    if (sampled_ != sampled_entries_.end() && sampled_->i == i) next = std::min(next, std::max(from, sampled_->j));
    return next;
  }

  // Adds the guess of a pair that no line met.
  //   In: area: its unoccluded exchange area; error: a bound on the error of `area`
  void guess(uint32_t i, uint32_t j, double area, double error) {
    const NeighbourVisibility::Value visibility = neighbours_->of(i, j);
    const double most = std::min({area, sums_.ids_.areas[i], sums_.ids_.areas[j]});
    found_.guesses.push_back(
        {static_cast<uint32_t>(found_.entries.size()), static_cast<float>(most), visibility.mean, 1});
    found_.entries.push_back(
        {i,
         j,
         {visibility.mean * most,
          sums_.replicate_count_ < 2 ? INFINITY : visibility.deviation() * most + visibility.mean * error}});
  }

  // Adds the pairs before (i, j) of the prior and of the sampled entries. A pair in both lists gets its sampled entry.
  void addBefore(uint32_t i, uint32_t j) {
    const std::pair key(i, j);
    for (;;) {
      const bool has_prior = prior_ != prior_pairs_.end() && keyOf(*prior_) < key,
                 has_sampled = sampled_ != sampled_entries_.end() && keyOf(*sampled_) < key;
      if (!has_prior && !has_sampled) return;
      if (has_sampled && (!has_prior || keyOf(*sampled_) < keyOf(*prior_))) {
        found_.entries.push_back(*sampled_++);
        continue;
      }
      const PairPrior& pair = *prior_++;
      const bool is_sampled = has_sampled && keyOf(*sampled_) == keyOf(pair);
      if (is_sampled) found_.entries.push_back(*sampled_);
      else add(take(pair.i, pair.j), pair, 0);
      if (is_sampled) ++sampled_;
    }
  }

  // Adds a pair from its lines, or as a guess where it has none.
  //   In: error: a bound on the error of its unoccluded exchange area
  void add(const PairSum& lines_of_pair, const PairPrior& pair, double error) {
    const PriorExchange prior = exchangeOf(pair, pair.visibility, sums_.ids_.areas, lines_);
    const auto [sum, squares] = withRow(lines_of_pair);
    if (sum.facing + sum.blocked == 0 && !std::isinf(prior.most) && neighbours_ && pair.j < kEnvironment)
      return guess(pair.i, pair.j, prior.most, error);
    found_.entries.push_back({pair.i, pair.j, measure(sum, squares, prior, error)});
  }

  // Returns the exchange area of a pair with lines, or of a pair that cannot be guessed. Guesses are impossible with
  // environment or leak, with an unknown unoccluded exchange area, and in a run without neighbours.    In: error: a
  // bound on the error of prior.most
  Measured measure(const PairSum& pair, const Squares& squared, const PriorExchange& prior, double error) {
    const auto replicates = static_cast<double>(sums_.replicate_count_), facing = double(pair.facing),
               blocked = double(pair.blocked), lines = facing + blocked;
    const bool has_form = !std::isinf(prior.most), has_visibility = lines > 0 && has_form;
    const double b = lines > 0 ? facing / lines : 0;
    Measured exchange{has_visibility ? b * prior.most : prior.area, INFINITY};
    if (sums_.replicate_count_ < 2) return exchange;
    const double area = std::min(sums_.ids_.areas[pair.i], pair.j < kEnvironment ? sums_.ids_.areas[pair.j] : INFINITY);
    // `variance` is the variance of the sum of residuals (16) over replicates, in counts. `squares` would be this
    // variance if each line were blocked independently.
    const double residuals = (1 - b) * (1 - b) * double(squared.facing) - 2 * b * (1 - b) * double(squared.product) +
                             b * b * double(squared.blocked);
    const double variance = std::max(0.0, residuals) * replicates / (replicates - 1),
                 squares = b * blocked * double(prior.line);
    if (has_visibility && neighbours_ && pair.j < kEnvironment) {
      const double lines_of_pair = effectiveLines(pair, squared, double(prior.line));
      const float mean = neighbours_->of(pair.i, pair.j).mean;
      const double visibility = lines_of_pair < kFewLines ? withNeighbours(lines_of_pair, b, mean) : b;
      if (lines_of_pair < kFewLines)
        found_.guesses.push_back({static_cast<uint32_t>(found_.entries.size()), static_cast<float>(prior.most), mean,
                                  static_cast<float>(withNeighbours(lines_of_pair, 0, 1))});
      exchange.value = visibility * prior.most;
      exchange.standard_error = std::sqrt(varianceOfVisibility(pair, squared, b, variance / lines / lines,
                                                               area / count_area_, double(prior.line))) *
                                prior.most;
      exchange.standard_error =
          std::min(exchange.standard_error, std::max(exchange.value, prior.most - exchange.value)) + visibility * error;
      return exchange;
    }
    const double count_exchange =
        has_visibility ? prior.most / lines : (pair.i == pair.j ? 4 : 2) * measure_area_ / replicates;
    // If all lines of a row leave the scene, one direction may still have met something: D of eq. (12) without counts.
    const double most = area / count_area_,
                 line = double(prior.line) + (pair.j >= kEnvironment && squares == 0 ? 8 / 27.0 * most : 0);
    exchange.standard_error = errorOfSum(variance, squares, line, most) * count_exchange;
    exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, prior.most - exchange.value));
    if (squares == 0) exchange = allowForUnmet(exchange, prior, replicates * count_area_ / measure_area_, area);
    exchange.standard_error += b * error;  // not added in squares, because `error` is a bound and no standard error
    return exchange;
  }

  // A pair with fewer lines than this takes a part of its visibility from its neighbours, eq. (21).
  static constexpr double kFewLines = 4;
  static double withNeighbours(double lines_of_pair, double b, double m) {
    return (lines_of_pair * b + NeighbourVisibility::kNeighbours * m) /
           (lines_of_pair + NeighbourVisibility::kNeighbours);
  }

  // Returns the variance of a pair's visibility b: docs/method.md, eq. (22), whose factors were measured in five scenes
  // (bench/programs/coverage.cpp, docs/accuracy.md).
  //   In: of_replicates: variance of b from replicates; most_counts: the most counts that a direction adds; line:
  //     counts that one line adds
  double varianceOfVisibility(const PairSum& pair, const Squares& squared, double b, double of_replicates,
                              double most_counts, double line) const {
    const double n = effectiveLines(pair, squared, line + 8 / 27.0 * most_counts),
                 s = neighbours_->of(pair.i, pair.j).smoothed;
    const double p = (n * b + 2 * s + 0.1) / (n + 2.2), rarer = n * p * (1 - p),
                 trust = rarer * rarer / (rarer * rarer + 0.25);
    const double by_chance = p * (1 - p) / (n + NeighbourVisibility::kNeighbours),
                 few = std::max(0.0, 1 - n * b * (1 - b)), left = few + (1 - few) * 2 / (n + 3);
    return trust * of_replicates + (1 - trust) * left * by_chance * beside_replicates_;
  }

  const VisibilitySums& sums_;
  const std::vector<PairPrior>& prior_pairs_;
  const std::vector<uint64_t>& lines_;
  std::span<const ReplicateSums::Sum> rows_;
  const std::vector<FormFactors::Entry>& sampled_entries_;
  const NeighbourVisibility* neighbours_;
  double measure_area_, count_area_, beside_replicates_;
  std::vector<PairPrior>::const_iterator prior_;
  std::vector<PairSum>::const_iterator counted_;
  std::vector<FormFactors::Entry>::const_iterator sampled_;
  Found found_;
};

VisibilitySums::Found VisibilitySums::find(const std::vector<PairPrior>& prior, const std::vector<uint64_t>& lines,
                                           double measure_area, double count_area,
                                           std::span<const ReplicateSums::Sum> rows,
                                           const std::vector<FormFactors::Entry>& sampled,
                                           const NeighbourVisibility* neighbours, const ExchangeRow& row) const {
  // The rows are divided into parts of about as many pairs each; the first rows have the most pairs.
  constexpr size_t kParts = 64;
  const size_t n = ids_.count(), part_count = std::min(n, kParts);
  std::vector<std::optional<Found>> parts(part_count);
  Found all;
  // Reserved memory costs nothing before it is written to.
  all.entries.reserve((row ? size_t(pairCount(n)) : prior.size()) + sampled.size() + 2 * n);
  std::mutex mutex;
  size_t added = 0;
  const auto firstRow = [&](size_t part) {
    return static_cast<uint32_t>(double(n) * (1 - std::sqrt(1 - double(part) / double(part_count))));
  };
  const auto addPart = [&](size_t, size_t part) {
    const uint32_t end = part + 1 == part_count ? static_cast<uint32_t>(n) : firstRow(part + 1);
    Found made =
        Entries(*this, prior, lines, measure_area, count_area, rows, sampled, neighbours).of(firstRow(part), end, row);
    const std::lock_guard lock(mutex);
    parts[part] = std::move(made);
    // Parts are added in order and freed at once, so that the list of all pairs is never in memory twice.
    for (; added < part_count && parts[added]; ++added) {
      for (Guess& guess : parts[added]->guesses) guess.entry += static_cast<uint32_t>(all.entries.size());
      all.guesses.insert(all.guesses.end(), parts[added]->guesses.begin(), parts[added]->guesses.end());
      all.entries.insert(all.entries.end(), parts[added]->entries.begin(), parts[added]->entries.end());
      parts[added].emplace();
    }
  };
  shareOut(threadsFor(row ? n * n / 2 : prior.size()), part_count, 1, addPart);
  return all;
}

ControlVariateSums VisibilitySums::controls(const std::vector<PairVisibility>& visibilities,
                                            const std::vector<uint64_t>& lines) const {
  std::vector<ControlVariateSums::PairSum> controls;
  PairWalk walk(visibilities);
  for (const PairSum& pair : pairs_) {
    const PairVisibility* const visibility = walk.find(pair);
    const Wide b = visibility ? visibility->visibility : 0, rest = kVisibilityOne - b;
    ControlVariateSums::PairSum control{pair.i, pair.j};
    control.line = lineOf(lines, pair.i, pair.j);
    control.squares = (pair.facing * rest * rest + pair.blocked * b * b) * control.line;
    if (control.squares == 0) continue;
    control.sum = static_cast<ControlVariateSums::SignedWide>(pair.facing * rest) -
                  static_cast<ControlVariateSums::SignedWide>(pair.blocked * b);
    const Squares squared = squaresOf(pair);
    control.sum_of_squares = rest * rest * squared.facing + b * b * squared.blocked - 2 * b * rest * squared.product;
    controls.push_back(control);
  }
  return {ids_, replicate_count_, std::move(controls)};
}

}  // namespace viewpeel
