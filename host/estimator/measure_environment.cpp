// measureEnvironment() measures the environment above and below a horizon by the host engine.
//
// Every direction is turned to point above the horizon. A line that leaves the scene forwards then goes to the part
// above, and a line that leaves it backwards to the part below. The engine counts both separately.
#include <viewpeel/environment.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <glm/glm.hpp>

#include "directions/replicates.h"
#include "directions/sampler.h"
#include "engines/host_engine.h"
#include "estimator/estimate.h"
#include "stopwatch.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr uint32_t kReplicates = 8, kLeastReplicates = 4, kFirstDirections = 32, kMostDirections = 1 << 16;
// Errors are taken to fall as N^-0.8 with N directions, and after two rounds as N^-0.5, the power of independent
// directions. With exact areas the power is 1.29 (docs/accuracy.md).
constexpr double kLeastExponent = 0.5, kUsualExponent = 0.8;
constexpr double kMargin = 0.9, kLeastGrowth = 1.5, kMostGrowth = 64;
// The next round is planned to end when this share of the time that is left is over.
constexpr double kShareOfTime = 0.9;
// Two spacings fit along the side of a square of the median area.
constexpr double kSpacingsPerSide = 2;
constexpr int kFinestResolution = 1024;

// Counts hold the lines of one replicate that leave the scene above the horizon (up) and below it: double[row].
struct Counts {
  std::vector<double> up, down;
};

class Measurement {
 public:
  Measurement(const Scene& scene, const EnvironmentRequest& request, const Observer& observer)
      : request_(request), observer_(observer), ids_(makeIds(scene, request.by, request.two_sided)) {
    if (!(glm::length(request.up) > 0))
      throw Error(ErrorCode::bad_usage, "the direction up has no length; give one like 0,0,1");
    if (!(request.tolerance > 0)) throw Error(ErrorCode::bad_usage, "the tolerance is not above 0; give a larger");
    ids_.roles.assign(scene.polygons.size(), kEmits);  // no polygon receives, so no pair counts
    LatticeOptions options;
    options.resolution = chooseResolution(scene, kSpacingsPerSide, kFinestResolution);
    options.sampling = chooseSampling(scene, ids_, false);
    options.split_environment = true;
    options.thread_count = request.threads;
    options.on_batch = [&](uint64_t) {
      if (observer_.should_stop && observer_.should_stop()) throw Interrupted{};
      if (may_end_ && isTimeUp()) throw TimeUp{};
    };
    engine_ = makeHostEngine(scene, ids_, options);
    ids_.roles.clear();
    findExtents(scene);
    unit_area_ = engine_->unitArea() * scene.scale * scene.scale;
  }

  EnvironmentParts measure() {
    EnvironmentParts best;
    for (double directions = kFirstDirections;;) {
      const auto of_round = static_cast<uint32_t>(directions);
      const double began_s = secondsSince(start_);
      const std::vector<Counts> replicates = countRound(of_round, best);
      // A round that was cut short may have fewer directions than the round before.
      if (replicates.size() * of_round > best.directions) best = partsOf(replicates, of_round);
      const double excess = best.largest_standard_error / request_.tolerance;
      best.is_reached = excess <= 1;
      if (best.is_reached || directions >= kMostDirections || isTimeUp()) return best;
      const double exponent = rounds_ > 2 ? kLeastExponent : kUsualExponent;
      const double growth = std::clamp(std::pow(excess / kMargin, 1 / exponent), kLeastGrowth, kMostGrowth);
      double fitting = growth;
      if (request_.time_limit_s) {
        const double now_s = secondsSince(start_);
        fitting = kShareOfTime * (*request_.time_limit_s - now_s) / (now_s - began_s);
        if (fitting <= 1) return best;
      }
      directions = std::min<double>(directions * std::min(growth, fitting), kMostDirections);
    }
  }

 private:
  Counts count(uint32_t directions, uint64_t replicate) {
    std::vector<Direction> set = sampleDirections(Sampler::fibonacci, directions, request_.seed, replicate);
    for (Direction& direction : set)
      if (glm::dot(direction.u, request_.up) < 0) direction.u = -direction.u, direction.x_axis = -direction.x_axis;
    Counts counts{std::vector<double>(ids_.count()), std::vector<double>(ids_.count())};
    for (const PairCount& pair : engine_->count(set))
      (pair.j == kEnvironment ? counts.up : counts.down)[pair.i] += double(pair.count);
    return counts;
  }

  bool isTimeUp() const { return request_.time_limit_s && secondsSince(start_) >= *request_.time_limit_s; }

  // Counts eight replicates, or fewer where time is up.
  std::vector<Counts> countRound(uint32_t directions, const EnvironmentParts& best) {
    std::vector<Counts> replicates;
    const uint64_t first = kEnvironmentReplicates.first + kReplicates * rounds_++;
    for (uint32_t r = 0; r < kReplicates; ++r) {
      may_end_ = best.replicates > 0 || r >= kLeastReplicates;
      if (may_end_ && isTimeUp()) break;
      try {
        replicates.push_back(count(directions, first + r));
      } catch (const TimeUp&) {
        break;
      }
      if (observer_.on_progress)
        observer_.on_progress({.phase = Progress::Phase::counting,
                               .replicates = r + 1,
                               .largest_standard_error = best.replicates ? best.largest_standard_error : INFINITY,
                               .directions = 0,
                               .directions_of_replicate = directions});
    }
    // The spread of fewer replicates says too little.
    if (replicates.size() < kLeastReplicates) replicates.clear();
    return replicates;
  }

  EnvironmentParts partsOf(const std::vector<Counts>& replicates, uint32_t directions) const {
    const size_t replicate_count = replicates.size();
    EnvironmentParts parts{
        .ids = ids_, .extents = extents_, .replicates = replicate_count, .directions = directions * replicate_count};
    parts.up_share_errors.assign(replicate_count, std::vector<double>(ids_.count()));
    const double count_area = 2 * unit_area_ / directions;
    for (uint32_t i = 0; i < ids_.count(); ++i) {
      const double of_count = count_area / ids_.areas[i];
      parts.up.push_back(meanOf(
          replicates, [&](const Counts& counts) { return counts.up[i]; }, of_count));
      parts.down.push_back(meanOf(
          replicates, [&](const Counts& counts) { return counts.down[i]; }, of_count));
      parts.all.push_back(meanOf(
          replicates, [&](const Counts& counts) { return counts.up[i] + counts.down[i]; }, of_count));
      addShare(replicates, i, parts);
      for (const Measured& part : {parts.up[i], parts.down[i], parts.all[i]})
        parts.largest_standard_error = std::max(parts.largest_standard_error, part.standard_error);
    }
    return parts;
  }

  template <class Of>
  static Measured meanOf(const std::vector<Counts>& replicates, const Of& of, double form_factor_of_count) {
    double sum = 0, squares = 0;
    const auto replicate_count = static_cast<double>(replicates.size());
    for (const Counts& counts : replicates) sum += of(counts);
    const double mean = sum / replicate_count;
    for (const Counts& counts : replicates) squares += std::pow(of(counts) - mean, 2);
    return {mean * form_factor_of_count,
            std::sqrt(squares / (replicate_count * (replicate_count - 1))) * form_factor_of_count};
  }

  // With nothing in the way (1 + n_up) / 2 of what a polygon of normal n emits goes up, and half of it from both sides.
  void findExtents(const Scene& scene) {
    const glm::dvec3 up = glm::normalize(request_.up);
    extents_.assign(ids_.count(), {0, INFINITY, -INFINITY});
    std::vector<double> areas(ids_.count(), 0);
    for (size_t k = 0; k < scene.polygons.size(); ++k) {
      const Polygon& polygon = scene.polygons[k];
      const uint32_t id = ids_.of_polygon[k];
      EnvironmentParts::Extent& extent = extents_[id];
      const double slope =
          (polygon.front_along_plane_normal ? 1 : -1) * glm::dot(scene.planes[polygon.plane].normal, up);
      extent.up += polygon.area * (ids_.two_sided ? 0.5 : (1 + slope) / 2);
      areas[id] += polygon.area;
      for (uint32_t c = 0; c < polygon.corner_count; ++c) {
        const double height = glm::dot(scene.corners[polygon.first_corner + c], up);
        extent.lowest = std::min(extent.lowest, height), extent.highest = std::max(extent.highest, height);
      }
    }
    for (uint32_t id = 0; id < ids_.count(); ++id) extents_[id].up /= areas[id];
  }

  // The share is a ratio of means; its error follows from the residuals of the ratio, in first order.
  static void addShare(const std::vector<Counts>& replicates, uint32_t row, EnvironmentParts& parts) {
    double up = 0, all = 0;
    for (const Counts& counts : replicates) {
      up += counts.up[row];
      all += counts.up[row] + counts.down[row];
    }
    if (all == 0) {
      parts.up_share.push_back({0.5, 0.5});
      parts.up_share_errors.front()[row] = 0.5;
      return;
    }
    const double share = up / all;
    const auto replicate_count = static_cast<double>(replicates.size());
    const double scale = replicate_count / all / std::sqrt(replicate_count * (replicate_count - 1));
    double squares = 0;
    for (size_t r = 0; r < replicates.size(); ++r) {
      const Counts& counts = replicates[r];
      const double residual = counts.up[row] - share * (counts.up[row] + counts.down[row]);
      parts.up_share_errors[r][row] = residual * scale;
      squares += std::pow(residual * scale, 2);
    }
    parts.up_share.push_back({share, std::sqrt(squares)});
  }

  struct TimeUp {};

  const EnvironmentRequest& request_;
  const Observer& observer_;
  Clock::time_point start_ = Clock::now();
  bool may_end_ = false;  // whether enough replicates are counted for a result, so that the time limit may end the run
  Ids ids_;
  std::unique_ptr<Engine> engine_;
  std::vector<EnvironmentParts::Extent> extents_;
  double unit_area_ = 0;
  uint64_t rounds_ = 0;
};

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

EnvironmentParts measureEnvironment(const Scene& scene, const EnvironmentRequest& request, const Observer& observer) {
  try {
    return Measurement(scene, request, observer).measure();
  } catch (const Interrupted&) {
    throw Error(ErrorCode::limit, "the run was stopped before the environment was measured; let it run longer");
  }
}

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
