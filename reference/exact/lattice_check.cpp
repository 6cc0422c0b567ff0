#include "reference/exact/lattice_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>

#include "directions/sampler.h"
#include "reference/exact/exact_pair_areas.h"
#include "stopwatch.h"

namespace viewpeel::reference {
namespace {

struct Key {
  uint32_t i, j;  // i <= j
  bool blocked;
  auto operator<=>(const Key&) const = default;
};

struct Region {
  double area = 0, perimeter = 0;  // exact
};
using Regions = std::map<Key, Region>;

// Returns regions by id: areas and perimeters of polygons with one id add up. The sum of perimeters is a bound on the
// perimeter of their union.
Regions exactRegions(const Scene& scene, const Ids& ids, bool blocked, const glm::dvec3& u) {
  Regions regions;
  ExactOptions options;
  options.two_sided = ids.two_sided;
  options.perimeters = true;
  options.blocked = blocked;
  const ExactPairAreas areas = computeExactPairAreas(scene, u, options);
  for (const std::vector<PairArea>* pairs : {&areas.pairs, &areas.blocked})
    for (const PairArea& pair : *pairs) {
      const uint32_t i = ids.of_polygon[pair.a], j = pair.b < kEnvironment ? ids.of_polygon[pair.b] : pair.b;
      Region& region = regions[{std::min(i, j), std::max(i, j), pairs == &areas.blocked}];
      region.area += pair.area;
      region.perimeter += pair.perimeter;
    }
  return regions;
}

// Calls add(key, count) for the facing lines of a pair and for its blocked lines.
template <class Add>
void forCounts(const PairCount& pair, const Add& add) {
  if (pair.count) add(Key{pair.i, pair.j, false}, double(pair.count));
  if (pair.blocked) add(Key{pair.i, pair.j, true}, double(pair.blocked));
}

struct Sums {
  double sum = 0, squares = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
  }
  double mean(double n) const { return sum / n; }
  double variance(double n) const { return std::max(0.0, squares - sum * sum / n) / (n - 1); }
};

std::string pairName(const Ids& ids, const Key& key) {
  return ids.names[key.i] + " - " +
         (key.j == kEnvironment ? "environment"
          : key.j == kLeak      ? "leak"
                                : ids.names[key.j]) +
         (key.blocked ? ", blocked" : "");
}

class RowCheck {
 public:
  RowCheck(int resolution, const Ids& ids, const CheckOptions& options)
      : ids_(ids),
        options_(options),
        h_(2.0 / resolution),
        count_area_(h_ * h_ / options.counts_per_point),
        n_(options.lattices),
        pooled_(options.lattices, 0.0) {
    row_.resolution = resolution;
  }

  void addDirection(const Regions& exact, const std::vector<PairCounts>& counts) {
    std::map<Key, Sums> sums;
    for (const auto& [key, region] : exact) sums[key];
    for (const PairCounts& lattice : counts)
      for (const PairCount& c : lattice)
        forCounts(c, [&](const Key& key, double count) { sums[key].add(count * count_area_); });
    std::set<Key> pooled_keys;
    for (const auto& [key, sum] : sums) {
      const auto at = exact.find(key);
      const Region region = at == exact.end() ? Region{} : at->second;
      row_.total_counted += sum.mean(n_);
      row_.total_exact += region.area;
      if (key.j == kLeak) {
        row_.leak_counted += sum.mean(n_);
        row_.leak_exact += region.area;
      }
      if (region.area < h_ * h_ / 2 || 4 * region.area < h_ * region.perimeter) {
        ++row_.regions_pooled;
        pooled_expectation_ += region.area;
        pooled_keys.insert(key);
        continue;
      }
      ++row_.regions_tested;
      test(pairName(ids_, key), sum, region.area, 0);
      if (region.area >= h_ * region.perimeter) {
        ++row_.spread_regions;
        measured_variance_ += sum.variance(n_);
        predicted_variance_ += options_.variance * h_ * h_ * h_ * region.perimeter;
      }
    }
    for (size_t m = 0; m < counts.size(); ++m)
      for (const PairCount& c : counts[m])
        forCounts(c, [&](const Key& key, double count) {
          if (pooled_keys.count(key)) pooled_[m] += count * count_area_;
        });
  }

  CheckRow finish(double tests) {
    const double rate = options_.false_alarm_rate / std::max(1.0, tests);
    row_.allowed_deviation = quantile(complement(boost::math::students_t(n_ - 1), rate / 2));
    if (row_.regions_pooled > 0) {
      Sums sums;
      for (double sum : pooled_) sums.add(sum);
      // Rare events have no normal tail, so Bernstein's second term is added.
      test("small and thin regions together", sums, pooled_expectation_, h_ * h_ * std::log(2 / rate) / (3 * n_));
    }
    row_.unbiased = row_.largest_deviation <= row_.allowed_deviation;
    if (row_.spread_regions >= kFewestSpreadRegions) {
      row_.spread_ratio = measured_variance_ / predicted_variance_;
      row_.spread_as_predicted = row_.spread_ratio >= 0.5 && row_.spread_ratio <= 2;
    }
    return row_;
  }

  uint64_t tests() const { return row_.regions_tested + (row_.regions_pooled > 0); }

 private:
  // With fewer regions the ratio of variances says little.
  static constexpr uint64_t kFewestSpreadRegions = 10;

  void test(const std::string& name, const Sums& sums, double expectation, double slack) {
    const double difference = sums.mean(n_) - expectation, error = std::sqrt(sums.variance(n_) / n_);
    // The error is at least the rounding of the sums: a region with equal counts on all lattices must not divide by
    // zero.
    const double rounding = 1e-13 * (std::abs(expectation) + h_ * h_);
    const double deviation = std::max(0.0, std::abs(difference) - slack) / std::max(error, rounding);
    if (deviation <= row_.largest_deviation) return;
    row_.largest_deviation = deviation;
    row_.worst_pair = name;
    row_.worst_difference = difference;
    row_.worst_standard_error = error;
  }

  const Ids& ids_;
  const CheckOptions& options_;
  double h_, count_area_, n_;
  CheckRow row_;
  std::vector<double> pooled_;  // per lattice
  double pooled_expectation_ = 0, measured_variance_ = 0, predicted_variance_ = 0;
};

}  // namespace

bool CheckReport::passes() const {
  return std::all_of(rows.begin(), rows.end(),
                     [](const CheckRow& row) { return row.unbiased && row.spread_as_predicted; });
}

CheckReport checkLattice(const Scene& scene, const Ids& ids, const CountLattice& count, const CheckOptions& options) {
  CheckReport report;
  std::vector<RowCheck> rows;
  for (int resolution : options.resolutions) rows.emplace_back(resolution, ids, options);
  const auto directions = sampleDirections(Sampler::iid, options.directions, options.seed, 0);
  for (uint32_t d = 0; d < options.directions; ++d) {
    auto start = Clock::now();
    const Regions exact = exactRegions(scene, ids, options.blocked, directions[d].u);
    report.exact_seconds += secondsSince(start);
    start = Clock::now();
    for (size_t r = 0; r < rows.size(); ++r) {
      std::vector<PairCounts> counts;
      for (const Direction& lattice :
           sampleLattices(directions[d].u, options.lattices, options.seed * 1000003 + d * 101 + r))
        counts.push_back(count(lattice, options.resolutions[r]));
      rows[r].addDirection(exact, counts);
    }
    report.counting_seconds += secondsSince(start);
  }
  double tests = 0;
  for (const RowCheck& row : rows) tests += double(row.tests());
  for (RowCheck& row : rows) report.rows.push_back(row.finish(tests));
  return report;
}

}  // namespace viewpeel::reference
