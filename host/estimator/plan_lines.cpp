#include "estimator/plan_lines.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <boost/math/distributions/normal.hpp>

namespace viewpeel {
namespace {

constexpr double kFailing = 0.05;  // of runs, in which the error of a row may exceed the goal
constexpr int kMostPlans = 8;      // plans of lines for one goal: the goal, and coarser ones until the lines fit
constexpr double kSlack = 2;       // lines of a coarser goal may exceed their limit by this factor

// Returns the error that a goal allows for an exchange area, input units squared.
double allowedBy(const EstimateOptions& options, double exchange, double smaller_area) {
  double allowed = options.tolerance ? *options.tolerance * smaller_area : INFINITY;
  // No visibility is known before the run, so a relative error refers to half of the unoccluded form factor.
  if (options.relative && exchange >= options.relative_floor * smaller_area)
    allowed = std::min(allowed, *options.relative * exchange / 2);
  return allowed;
}

// Returns a number in proportion to the part that a pair should have of the variance of a sum of pairs. With these
// parts the sum needs the fewest lines: docs/method.md, eq. (48).
double partOf(const LinePair& pair) { return std::pow(pair.exchange - pair.clear, 8.0 / 9); }

// Returns the squares of the errors of F_ij and F_ji together, over the square of the error of A_i F_ij. A line that
// ends on a back has no second row.
double squaresOf(const LinePair& pair, const Ids& ids) {
  const auto squareOf = [&](uint32_t id) { return id < ids.count() ? std::pow(ids.areas[id], -2) : 0; };
  return squareOf(pair.i) + squareOf(pair.j);
}

// Returns a number in proportion to the part that a pair should have of the sum of all squares of errors: eq. (48) once
// more, in which errors of form factors replace errors of exchange areas.
double partOfSquares(const LinePair& pair, const Ids& ids) {
  return std::pow(std::sqrt(squaresOf(pair, ids)) * (pair.exchange - pair.clear), 8.0 / 9);
}

// AllowedErrors are standard errors of pairs that are small enough for all entries of the result to reach the goal.
class AllowedErrors {
 public:
  AllowedErrors(const std::vector<LinePair>& pairs, const Ids& face_ids, const Ids& ids, const EstimateOptions& options,
                bool with_rows)
      : face_ids_(face_ids),
        ids_(ids),
        options_(options),
        errors_in_goal_(ids.count()),
        row_parts_(with_rows && options.tolerance ? ids.count() : 0) {
    for (const LinePair& pair : pairs) {
      const Key key = entryOf(pair, face_ids, options.by);
      const double part = partOf(pair);
      if (options.rms) all_parts_ += partOfSquares(pair, face_ids);
      for (const uint32_t id : {key.first, key.second})
        if (hasGoal(id)) row_parts_[id] += part;
      if (key == Key(pair.i, pair.j)) continue;
      Sum& sum = sums_[key];
      sum.exchange += pair.exchange;
      sum.parts += part;
    }
  }

  // Returns the standard error that a pair's exchange area may have, input units squared.
  double of(const LinePair& pair) const {
    const Key key = entryOf(pair, face_ids_, options_.by);
    const double area = ids_.smallerArea(key.first, key.second), errors = errors_in_goal_.of(key.second);
    const double part = partOf(pair);
    const auto sum = sums_.find(key);
    double allowed = sum == sums_.end() ? allowedBy(options_, pair.exchange, area) / errors
                                        : allowedBy(options_, sum->second.exchange, area) / errors *
                                              std::sqrt(part / sum->second.parts);
    if (options_.rms)
      allowed =
          std::min(allowed, *options_.rms * double(ids_.count()) *
                                std::sqrt(partOfSquares(pair, face_ids_) / all_parts_ / squaresOf(pair, face_ids_)));
    // A pair within one row exchanges both ways, and has been added to the row twice.
    const double ways = key.first == key.second ? 2 : 1;
    for (const uint32_t id : {key.first, key.second})
      if (hasGoal(id) && row_parts_[id] > 0)
        allowed = std::min(allowed, *options_.tolerance * ids_.areas[id] / errors_in_goal_.of(kEnvironment) *
                                        std::sqrt(part / (ways * row_parts_[id])));
    return allowed;
  }

 private:
  using Key = std::pair<uint32_t, uint32_t>;
  // A Sum is an entry between surfaces, or a row's leak: a sum over many pairs with independent errors.
  struct Sum {
    double exchange = 0, parts = 0;
  };

  // Returns whether all pairs of this row must reach the tolerance together.
  bool hasGoal(uint32_t id) const { return id < row_parts_.size() && ids_.isRequested(id); }

  const Ids& face_ids_;
  const Ids& ids_;
  const EstimateOptions& options_;
  ErrorsInGoal errors_in_goal_;
  std::map<Key, Sum> sums_;
  std::vector<double> row_parts_;  // by row, sums of partOf()
  double all_parts_ = 0;           // sum of partOfSquares(), for the goal of a root mean square
};

}  // namespace

double errorsInRowGoal(size_t row_count) {
  // Either sign of each row's error has the same share of the probability.
  const double of_one = kFailing / 2 / double(std::max<size_t>(row_count, 1));
  return boost::math::quantile(boost::math::complement(boost::math::normal(), of_one));
}

std::vector<LinePair> planLines(PairLines& lines, std::vector<LinePair> pairs, const Ids& face_ids, const Ids& ids,
                                const EstimateOptions& options, bool with_rows, double most_lines) {
  const AllowedErrors errors(pairs, face_ids, ids, options, with_rows);
  // If the plan has too many lines, all allowed errors are multiplied by `relief`. The number of lines goes as the
  // error to the power of -8/5, or of -1 for pairs whose lines all agree (kAgreeingLines). No pair gets more than
  // kMostLineBlocks, so the first sum of lines may be too small, and a second relief may be needed.
  double relief = 1, power = 5.0 / 8;
  const auto allowed = [&](const LinePair& pair) { return relief * errors.of(pair); };
  for (int plans = 0; plans < kMostPlans; ++plans, power = 1) {
    lines.plan(pairs, allowed, options.replicates);
    double all = 0;
    for (const LinePair& pair : pairs) all += pair.linesIn(options.replicates);
    if (!(all > (plans ? kSlack : 1) * most_lines)) break;
    relief *= std::pow(all / most_lines, power);
  }
  lines.cutAndPlan(pairs, allowed, options.replicates);
  return pairs;
}

}  // namespace viewpeel
