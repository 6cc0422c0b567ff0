#include "estimator/pilot_variances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "estimator/find_prior.h"
#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

struct Residual {
  uint32_t i, j;
  double counts;
};

// Moments holds sums over the replicates of either half of the pilot. They are the sums of the residuals on the first
// lattice (a) and on the second (b), of their squares (aa, bb), and of their products (ab).
struct Moments {
  uint32_t i, j;
  std::array<double, 2> a{}, b{}, aa{}, bb{}, ab{};
  uint32_t meetings = 0;  // replicates that met the pair
};

// A Spread holds the variance of one replicate of one form factor, and the part of it that is due to the lattice.
struct Spread {
  double total, between_lattices;
};

std::vector<PairVisibility> visibilitiesOf(std::span<const PilotCounts> replicates) {
  PairCounts all;
  for (const PilotCounts& replicate : replicates) all = addCounts(addCounts(all, replicate.first), replicate.second);
  return fitVisibilities(withRows(std::move(all)));
}

// Returns the counts. Where there are unoccluded form factors (id_of_face is not empty), their control variates are
// subtracted.
std::vector<Residual> residualsOf(const PairCounts& counts, const std::vector<PairVisibility>& visibilities,
                                  const std::vector<uint32_t>& id_of_face) {
  std::vector<Residual> residuals;
  if (id_of_face.empty()) {
    for (const PairCount& count : counts) residuals.push_back({count.i, count.j, double(count.count)});
  } else {
    for (const ControlVariate& control :
         mergeIds(takeControlVariates(withRows(counts, visibilities), visibilities), id_of_face))
      residuals.push_back({control.i, control.j, double(control.control) / kVisibilityOne});
  }
  return residuals;
}

void addReplicate(std::vector<Moments>& moments, size_t half, const std::vector<Residual>& first,
                  const std::vector<Residual>& second) {
  std::vector<Moments> merged;
  merged.reserve(std::max(moments.size(), first.size()));
  auto at = first.begin(), bt = second.begin();
  auto mt = moments.begin();
  const auto keyAt = [](const auto& it, const auto& all) { return it == all.end() ? std::pair(~0u, ~0u) : keyOf(*it); };
  while (at != first.end() || bt != second.end() || mt != moments.end()) {
    const auto key = std::min({keyAt(at, first), keyAt(bt, second), keyAt(mt, moments)});
    Moments& sum = merged.emplace_back(keyAt(mt, moments) == key ? *mt++ : Moments{key.first, key.second});
    const double x = keyAt(at, first) == key ? (at++)->counts : 0, y = keyAt(bt, second) == key ? (bt++)->counts : 0;
    sum.a[half] += x, sum.b[half] += y, sum.aa[half] += x * x, sum.bb[half] += y * y, sum.ab[half] += x * y;
    sum.meetings += x != 0 || y != 0;
  }
  moments = std::move(merged);
}

// Returns the mean spread of the two halves, which have n replicates each.
Spread spreadOf(const Moments& m, double n) {
  double total = 0, common = 0;
  for (size_t half = 0; half < 2; ++half) {
    total += (m.aa[half] - m.a[half] * m.a[half] / n + m.bb[half] - m.b[half] * m.b[half] / n) / (4 * (n - 1));
    common += (m.ab[half] - m.a[half] * m.b[half] / n) / (2 * (n - 1));
  }
  return {total, total - common};
}

// Returns means over all form factors between rows, from the moments of the halves' n replicates each.
PilotVariances meansOf(const std::vector<Moments>& moments, const Ids& ids, double measure_area, size_t n) {
  PilotVariances variances{.are_means = true, .by_meetings = std::vector<double>(2 * n + 1)};
  double total = 0, between_lattices = 0, doubts = 0;
  for (const Moments& m : moments) {
    if (m.j >= kEnvironment) continue;
    const double unit = (m.i == m.j ? 4 : 2) * measure_area / double(ids.count()),
                 squares = std::pow(unit / ids.areas[m.i], 2) + (m.i == m.j ? 0 : std::pow(unit / ids.areas[m.j], 2));
    const Spread spread = spreadOf(m, double(n));
    total += spread.total * squares;
    between_lattices += spread.between_lattices * squares;
    doubts += std::pow(spread.total * squares, 2);
    variances.by_meetings[m.meetings] += spread.total * squares;
  }
  variances.of_directions = std::max(total - between_lattices, 0.0);
  variances.of_lattices = between_lattices;
  // As in pilotVariances(), but covariances of different pairs add up.
  variances.doubt = std::sqrt(2 * doubts / (2 * double(n - 1)));
  return variances;
}

}  // namespace

PilotVariances pilotVariances(const std::vector<PilotCounts>& counted, const Ids& ids,
                              const std::vector<uint32_t>& id_of_face, double measure_area,
                              const EstimateOptions& options) {
  const std::span<const PilotCounts> all = counted;
  const size_t n = counted.size() / 2;
  std::vector<Moments> moments;
  for (size_t half = 0; half < 2; ++half) {
    const std::vector<PairVisibility> visibilities =
        id_of_face.empty() ? std::vector<PairVisibility>{} : visibilitiesOf(all.subspan((1 - half) * n, n));
    for (const PilotCounts& replicate : all.subspan(half * n, n))
      addReplicate(moments, half, residualsOf(replicate.first, visibilities, id_of_face),
                   residualsOf(replicate.second, visibilities, id_of_face));
  }

  if (options.rms) return meansOf(moments, ids, measure_area, n);
  PilotVariances variances;
  variances.by_meetings.assign(counted.size() + 1, 0);
  std::vector<Spread> spreads;  // of max(F_ij, F_ji)
  for (const Moments& m : moments) {
    double unit = (m.i == m.j ? 4 : 2) * measure_area / ids.smallerArea(m.i, m.j);
    if (options.relative && !options.tolerance) {
      const double factor = unit * (m.a[0] + m.a[1] + m.b[0] + m.b[1]) / (2 * double(counted.size()));
      if (!(factor >= options.relative_floor)) continue;
      unit /= factor;
    }
    const Spread spread = spreadOf(m, double(n));
    spreads.push_back({spread.total * unit * unit, spread.between_lattices * unit * unit});
    double& largest = variances.by_meetings[m.meetings];
    largest = std::max(largest, spreads.back().total);
  }
  if (spreads.empty()) return variances;
  // Few replicates give a rough covariance. So the share of the lattice is a mean over the pairs with the largest
  // variances.
  const size_t top = std::clamp<size_t>(spreads.size() / 50, 1, 64);
  std::partial_sort(spreads.begin(), spreads.begin() + static_cast<std::ptrdiff_t>(top), spreads.end(),
                    [](const Spread& a, const Spread& b) { return a.total > b.total; });
  double total = 0, between_lattices = 0;
  for (const Spread& spread : std::span(spreads).first(top)) {
    total += spread.total;
    between_lattices += spread.between_lattices;
  }
  variances.of_directions = total > 0 ? spreads[0].total * std::clamp(1 - between_lattices / total, 0.0, 1.0) : 0;
  // A covariance c of two counts of variance v from k degrees of freedom has the variance (v^2 + c^2) / k (Anderson, An
  // Introduction to Multivariate Statistical Analysis, 3.4).
  variances.doubt = std::sqrt((std::pow(spreads[0].total, 2) + std::pow(variances.of_directions, 2)) /
                              (2 * double(n - 1) * double(top)));
  for (const Spread& spread : spreads) variances.of_lattices = std::max(variances.of_lattices, spread.between_lattices);
  return variances;
}

double varianceLeft(double meetings, double more) { return (1 + meetings) / (more * (1 + meetings * more)); }

double varianceLeft(const PilotVariances& variances, double more) {
  const double replicates = double(variances.by_meetings.size()) - 1;
  double before = 0, after = 0;
  const auto add = [&](double& sum, double variance) {
    sum = variances.are_means ? sum + variance : std::max(sum, variance);
  };
  for (size_t k = 0; k < variances.by_meetings.size(); ++k) {
    // A replicate meets the pair with probability 1 - e^-m, where m directions of it do so in the mean. Where every
    // replicate met the pair, m is the value that half a miss would give.
    const double meetings = -std::log1p(-std::min(double(k), replicates - 0.5) / replicates);
    add(before, variances.by_meetings[k]);
    add(after, variances.by_meetings[k] * varianceLeft(meetings, more));
  }
  return before > 0 ? after / before : 1;
}

}  // namespace viewpeel
