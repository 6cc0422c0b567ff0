// splitEnvironment() divides form factors to the environment, which another method has computed, by measured shares.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include <viewpeel/environment.h>
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr double kTilt = 1e-6;  // bound on the rounding of a plane's normal, from coordinates in single precision

// A Blocked bounds the parts of a row's radiation that end on other rows above or below the horizon.
struct Blocked {
  Interval up{0, 0}, down{0, 0};
};

// Bounds what each row's pairs block. A pair is above the horizon where no point of the other row lies below one of
// this row. What a pair blocks that is on neither side, or of one row, may lie above or below as a whole.
std::vector<Blocked> findBlocked(const FormFactors& form_factors,
                                 const std::vector<EnvironmentParts::Extent>& extents) {
  const Ids& ids = form_factors.ids();
  std::vector<Blocked> blocked(ids.count());
  const auto add = [&](uint32_t i, uint32_t j) {
    const Interval interval = form_factors.interval(i, j);
    const bool is_row = j < kEnvironment, not_below = is_row && extents[j].lowest >= extents[i].highest,
               not_above = is_row && extents[j].highest <= extents[i].lowest;
    const bool is_up = not_below && !not_above, is_down = not_above && !not_below;
    if (!is_down) blocked[i].up.upper += interval.upper;
    if (!is_up) blocked[i].down.upper += interval.upper;
    if (is_up) blocked[i].up.lower += interval.lower;
    if (is_down) blocked[i].down.lower += interval.lower;
  };
  for (const FormFactors::Entry& entry : form_factors.entries()) {
    if (entry.j == kEnvironment) continue;
    if (ids.isRequested(entry.i)) add(entry.i, entry.j);
    if (entry.j < kEnvironment && entry.j != entry.i && ids.isRequested(entry.j)) add(entry.j, entry.i);
  }
  // Where not all that blocks is among the entries, only their lower bounds say something.
  if (!ids.rows_sum_to_one || form_factors.unlistedBound() > 0)
    for (Blocked& row : blocked) row.up.upper = row.down.upper = INFINITY;
  return blocked;
}

// Returns the intervals of a row's parts.
//   In: all: interval of the whole environment; open_up: part above with nothing in the way
std::pair<Interval, Interval> boundParts(const Interval& all, const Blocked& blocked, double open_up) {
  const auto partOf = [&](double open, const Interval& of_part) {
    return Interval{std::max(0.0, open - std::min(of_part.upper, 1 - all.lower) - kTilt),
                    std::max(0.0, std::min(all.upper, open - of_part.lower + kTilt))};
  };
  const Interval up = partOf(open_up, blocked.up), down = partOf(1 - open_up, blocked.down);
  const auto lessOther = [&](const Interval& part, const Interval& other) {
    const double upper = std::min(part.upper, std::max(0.0, all.upper - other.lower));
    return Interval{std::min(upper, std::max(part.lower, all.lower - other.upper)), upper};
  };
  return {lessOther(up, down), lessOther(down, up)};
}

// Moves the parts of a row into their intervals. Their sum stays as it is where the intervals have such parts.
void moveInside(const Interval& up_interval, const Interval& down_interval, Measured& up, Measured& down) {
  const double all = up.value + down.value, least = std::max(up_interval.lower, all - down_interval.upper),
               most = std::min(up_interval.upper, all - down_interval.lower);
  if (least <= most) {
    up.value = std::clamp(up.value, least, most);
    down.value = all - up.value;
  }
  up.value = std::clamp(up.value, up_interval.lower, up_interval.upper);
  down.value = std::clamp(down.value, down_interval.lower, down_interval.upper);
}

}  // namespace

EnvironmentParts splitEnvironment(const FormFactors& form_factors, EnvironmentParts parts) {
  const Ids& ids = form_factors.ids();
  if (ids.count() != parts.ids.count())
    throw Error(ErrorCode::bad_usage, "the environment was measured for other rows than those of the form factors");
  parts.largest_standard_error = 0;
  std::vector<Blocked> blocked;
  if (form_factors.hasIntervals()) {
    blocked = findBlocked(form_factors, parts.extents);
    parts.up_intervals.resize(ids.count()), parts.down_intervals.resize(ids.count());
  }
  for (uint32_t i = 0; i < ids.count(); ++i) {
    const Measured all = ids.isRequested(i) ? form_factors.formFactor(i, kEnvironment) : Measured{},
                   share = parts.up_share[i];
    const auto partOf = [&](double share_of_part) {
      return Measured{all.value * share_of_part,
                      std::hypot(all.standard_error * share_of_part, all.value * share.standard_error)};
    };
    parts.all[i] = all;
    parts.up[i] = partOf(share.value);
    parts.down[i] = partOf(1 - share.value);
    if (!blocked.empty() && ids.isRequested(i)) {
      const Interval whole = form_factors.interval(i, kEnvironment);
      std::tie(parts.up_intervals[i], parts.down_intervals[i]) = boundParts(whole, blocked[i], parts.extents[i].up);
      moveInside(parts.up_intervals[i], parts.down_intervals[i], parts.up[i], parts.down[i]);
    }
    for (const Measured& part : {parts.up[i], parts.down[i], all})
      parts.largest_standard_error = std::max(parts.largest_standard_error, part.standard_error);
  }
  return parts;
}

FormFactors environmentAlone(const EnvironmentParts& parts) {
  Ids ids = parts.ids;
  ids.rows_sum_to_one = false;
  std::vector<FormFactors::Entry> entries;
  for (uint32_t i = 0; i < ids.count(); ++i)
    if (parts.all[i].value > 0 || parts.all[i].standard_error > 0)
      entries.push_back(
          {i, kEnvironment, {ids.areas[i] * parts.all[i].value, ids.areas[i] * parts.all[i].standard_error}});
  return {std::move(ids), std::move(entries), parts.all};
}

}  // namespace viewpeel
