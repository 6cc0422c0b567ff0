// measureEnvironment() measures the environment above and below a horizon by the host engine, and by rays from rows
// that its directions hardly meet.
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
#include "engines/lattice.h"
#include "estimator/environment_rays.h"
#include "estimator/estimate.h"
#include "stopwatch.h"
#include "threads.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr uint32_t kReplicates = 8, kLeastReplicates = 4, kFirstDirections = 32, kMostDirections = 1 << 16;
// Errors are taken to fall as N^-0.8 with N directions, and after two rounds as N^-0.5, the power of independent
// directions. With exact areas the power is 1.29 (docs/accuracy.md).
constexpr double kLeastExponent = 0.5, kUsualExponent = 0.8;
constexpr double kMargin = 0.9, kLeastGrowth = 1.5, kMostDirectionGrowth = 64;
// The next round is planned to end when this share of the time that is left is over.
constexpr double kShareOfTime = 0.9;
// Two spacings fit along the side of a square of the median area.
constexpr double kSpacingsPerSide = 2;
constexpr int kFinestResolution = 1024;

// A row with rays has from kFirstRays to kMostRays of them in a replicate. Errors are taken to fall as n^-0.6 with n
// rays.
constexpr uint32_t kFirstRays = 64, kMostRays = 1 << 16;
constexpr double kRayExponent = 0.6, kMostRayGrowth = 16;
// A direction takes the time of this many rays, or quick rays, for each polygon of the scene.
constexpr double kRaysOfDirection = 0.1, kQuickRaysOfDirection = 1.3;
// Variances of n Sobol' points are n^-0.4 of those of independent ones (plan_rays.cpp). So where N independent rays in
// a replicate would do, N to this power do. Rays of all rounds are this many times those of the last one.
constexpr double kRaysOfIndependent = 1 / 1.4, kRoundsOfRays = 1.5;
// The share s of a row's environment comes from few lines. So its variance s (1 - s) is taken to be at least this.
constexpr double kLeastBinomial = 0.05;

// Counts hold the lines of one replicate that leave the scene above the horizon (up) and below it: double[row].
struct Counts {
  std::vector<double> up, down;
};

class Measurement {
 public:
  Measurement(const Scene& scene, const EnvironmentRequest& request, const Observer& observer)
      : scene_(scene), request_(request), observer_(observer), ids_(makeIds(scene, request.by, request.two_sided)) {
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
    for (const double area : ids_.areas)
      lines_.push_back(expectedPoints(options.sampling, area / (scene.scale * scene.scale) / ids_.sides(),
                                      2.0 / options.resolution));
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
      if (best.is_reached || isTimeUp()) return best;
      if (best.directions == replicates.size() * of_round && arePaid(best, of_round))
        return neededRays(best) > request_.most_rays.value_or(INFINITY) ? best : measureByRays(replicates, of_round);
      if (directions >= kMostDirections) return best;
      const double exponent = rounds_ > 2 ? kLeastExponent : kUsualExponent;
      const double growth = std::clamp(std::pow(excess / kMargin, 1 / exponent), kLeastGrowth, kMostDirectionGrowth);
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

  void report(uint32_t replicates, const EnvironmentParts& best, uint32_t directions) const {
    if (observer_.on_progress)
      observer_.on_progress({.phase = Progress::Phase::counting,
                             .replicates = replicates,
                             .largest_standard_error = best.replicates ? best.largest_standard_error : INFINITY,
                             .directions = 0,
                             .directions_of_replicate = directions});
  }

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
      report(r + 1, best, directions);
    }
    // The spread of fewer replicates says too little.
    if (replicates.size() < kLeastReplicates) replicates.clear();
    return replicates;
  }

  double largestError(const EnvironmentParts& parts, uint32_t row) const {
    if (!request_.whole_environment.empty())
      return request_.whole_environment[row] * parts.up_share[row].standard_error;
    return std::max({parts.up[row].standard_error, parts.down[row].standard_error, parts.all[row].standard_error});
  }

  // Returns about how many rays all rows need that miss the tolerance.
  double neededRays(const EnvironmentParts& parts) const {
    double rays = 0;
    for (uint32_t row = 0; row < ids_.count(); ++row) {
      if (largestError(parts, row) <= request_.tolerance) continue;
      const double share = parts.all[row].value,
                   independent = std::max(kLeastBinomial, share * (1 - share)) / std::pow(request_.tolerance, 2),
                   needed = kReplicates * std::pow(independent / kReplicates, kRaysOfIndependent);
      rays += std::clamp<double>(kRoundsOfRays * needed, kReplicates * kFirstRays, kReplicates * kMostRays);
    }
    return rays;
  }

  // Returns whether rays, or what the caller does in place of more than request_.most_rays, are less work than the
  // directions that the worst row needs. It depends on counts alone, so that results do not depend on the machine.
  bool arePaid(const EnvironmentParts& parts, double directions) const {
    const double more = std::pow(parts.largest_standard_error / request_.tolerance, 1 / kLeastExponent);
    return std::min(neededRays(parts), request_.most_rays.value_or(INFINITY)) <
           kReplicates * directions * more * raysOfDirection() * double(ids_.of_polygon.size());
  }

  double raysOfDirection() const {
    return hasQuickRays(scene_, request_.tolerance) ? kQuickRaysOfDirection : kRaysOfDirection;
  }

  // Casts rays from all rows that miss the tolerance, until these reach it. Where the tolerance is too fine for quick
  // rays, they go as far as they can, so that other rays begin with known errors, or a time limit with small ones.
  //   In: replicates: of common directions, for the other rows
  EnvironmentParts measureByRays(std::vector<Counts> replicates, uint32_t directions) {
    rays_of_row_.assign(ids_.count(), 0);
    rays_cast_.assign(ids_.count(), 0);
    EnvironmentParts parts = partsOf(replicates, directions);
    const double of_quick = std::max(request_.tolerance, kLeastQuickTolerance);
    const bool has_quick = hasQuickRays(scene_, of_quick);
    if (has_quick) castTo(of_quick, directions, replicates, parts);
    if (!has_quick || request_.tolerance < of_quick) castTo(request_.tolerance, directions, replicates, parts);
    return parts;
  }

  // Casts rays from all rows that miss this tolerance, until these reach it, or time is up.
  //   In, Out: replicates, parts: the results so far
  void castTo(double tolerance, uint32_t directions, std::vector<Counts>& replicates, EnvironmentParts& parts) {
    EnvironmentRays rays(scene_, ids_, request_.up, request_.seed, tolerance,
                         request_.threads ? request_.threads : threadCount(), [this] {
                           if (observer_.should_stop && observer_.should_stop()) throw Interrupted{};
                           if (isTimeUp()) throw TimeUp{};
                         });
    for (;;) {
      std::vector<EnvironmentRays::RowRays> rows;
      for (uint32_t row = 0; row < ids_.count(); ++row) {
        const double excess = largestError(parts, row) / tolerance;
        const uint32_t before = rays_of_row_[row];
        if (excess <= 1 || before >= kMostRays) continue;
        const double growth = std::clamp(std::pow(excess / kMargin, 1 / kRayExponent), kLeastGrowth, kMostRayGrowth);
        rows.push_back(
            {row, before ? static_cast<uint32_t>(std::min(before * growth, double(kMostRays))) : kFirstRays, 0, {}});
      }
      parts.is_reached = parts.largest_standard_error <= request_.tolerance;
      if (rows.empty() || isTimeUp()) return;
      try {
        rays.cast(rows, static_cast<uint32_t>(replicates.size()));
      } catch (const TimeUp&) {
      }
      for (const EnvironmentRays::RowRays& of : rows) takeRays(of, directions, replicates);
      parts = partsOf(replicates, directions);
      report(kReplicates, parts, directions);
    }
  }

  // Puts what rays have found in the place of a row's counts.
  void takeRays(const EnvironmentRays::RowRays& of, uint32_t directions, std::vector<Counts>& replicates) {
    if (of.replicates.empty()) return;
    const double count_of_share = ids_.areas[of.row] / countArea(directions);
    for (size_t r = 0; r < replicates.size(); ++r) {
      replicates[r].up[of.row] = of.replicates[r].up * count_of_share;
      replicates[r].down[of.row] = of.replicates[r].down * count_of_share;
    }
    rays_of_row_[of.row] = of.rays;
    rays_cast_[of.row] = of.rays_cast;
  }

  double countArea(uint32_t directions) const { return 2 * unit_area_ / directions; }

  EnvironmentParts partsOf(const std::vector<Counts>& replicates, uint32_t directions) const {
    const size_t replicate_count = replicates.size();
    EnvironmentParts parts{
        .ids = ids_, .extents = extents_, .replicates = replicate_count, .directions = directions * replicate_count};
    parts.up_share_errors.assign(replicate_count, std::vector<double>(ids_.count()));
    const double count_area = countArea(directions);
    for (uint32_t i = 0; i < ids_.count(); ++i) {
      const double of_count = count_area / ids_.areas[i];
      parts.up.push_back(meanOf(
          replicates, [&](const Counts& counts) { return counts.up[i]; }, of_count));
      parts.down.push_back(meanOf(
          replicates, [&](const Counts& counts) { return counts.down[i]; }, of_count));
      parts.all.push_back(meanOf(
          replicates, [&](const Counts& counts) { return counts.up[i] + counts.down[i]; }, of_count));
      addShare(replicates, i, parts);
    }
    boundErrorsByLines(parts);
    if (!rays_of_row_.empty()) boundErrorsOfRays(parts);
    for (uint32_t i = 0; i < ids_.count(); ++i)
      parts.largest_standard_error = std::max(parts.largest_standard_error, largestError(parts, i));
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

  // Makes errors of rows no smaller than the weight of one line. Rows that no line met would otherwise have none.
  void boundErrorsByLines(EnvironmentParts& parts) const {
    for (uint32_t row = 0; row < ids_.count(); ++row) {
      const bool has_rays = !rays_of_row_.empty() && rays_of_row_[row] > 0;
      const double lines =
          has_rays ? double(parts.replicates) * rays_of_row_[row] : lines_[row] * double(parts.directions);
      for (Measured* part : {&parts.up[row], &parts.down[row], &parts.all[row]})
        part->standard_error = std::max(part->standard_error, 1 / lines);
      if (parts.all[row].value > 0) raiseShareError(parts, row, 1 / (lines * parts.all[row].value));
    }
  }

  static void raiseShareError(EnvironmentParts& parts, uint32_t row, double least) {
    const double before = parts.up_share[row].standard_error, after = std::max(before, least);
    parts.up_share[row].standard_error = after;
    for (auto& errors : parts.up_share_errors) errors[row] = before > 0 ? errors[row] * after / before : 0;
    if (!(before > 0)) parts.up_share_errors.front()[row] = after;
  }

  // Eight replicates may agree by chance, and thousands of rows end as soon as their error is small. So errors of rows
  // with rays are no smaller than binomial errors times the efficiency of all these rows together: the root of the sum
  // of their variances over that of their binomial variances.
  void boundErrorsOfRays(EnvironmentParts& parts) const {
    double variance = 0, binomial = 0;
    const auto binomialOf = [](double share, double rays) { return std::max(0.0, share * (1 - share)) / rays; };
    const auto raysOf = [&](uint32_t row) { return double(parts.replicates) * rays_of_row_[row]; };
    for (uint32_t row = 0; row < ids_.count(); ++row) {
      if (rays_of_row_[row] == 0) continue;
      ++parts.rows_with_rays;
      parts.rays += static_cast<uint64_t>(double(parts.replicates) * rays_cast_[row]);
      variance += std::pow(parts.all[row].standard_error, 2);
      binomial += binomialOf(parts.all[row].value, raysOf(row));
    }
    const double efficiency = binomial > 0 ? std::min(variance / binomial, 1.0) : 1;
    for (uint32_t row = 0; row < ids_.count(); ++row) {
      if (rays_of_row_[row] == 0) continue;
      const double rays = raysOf(row), all = parts.all[row].value;
      const auto leastError = [&](double share, double of_rays) {
        return std::sqrt(efficiency * binomialOf(share, of_rays));
      };
      for (Measured* part : {&parts.up[row], &parts.down[row], &parts.all[row]})
        part->standard_error = std::max(part->standard_error, leastError(part->value, rays));
      if (all > 0) raiseShareError(parts, row, leastError(parts.up_share[row].value, rays * all));
    }
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

  const Scene& scene_;
  const EnvironmentRequest& request_;
  const Observer& observer_;
  Clock::time_point start_ = Clock::now();
  bool may_end_ = false;  // whether enough replicates are counted for a result, so that the time limit may end the run
  Ids ids_;
  std::unique_ptr<Engine> engine_;
  std::vector<EnvironmentParts::Extent> extents_;
  double unit_area_ = 0;
  std::vector<double> lines_;  // of each row: lines of a direction that meet it, in the mean
  uint64_t rounds_ = 0;
  // Rays of a replicate, where the row has its own; else 0, or no rows at all. The first number is of rays of equal
  // weight that would say as much.
  std::vector<uint32_t> rays_of_row_;
  std::vector<double> rays_cast_;
};

}  // namespace

EnvironmentParts measureEnvironment(const Scene& scene, const EnvironmentRequest& request, const Observer& observer) {
  try {
    return Measurement(scene, request, observer).measure();
  } catch (const Interrupted&) {
    throw Error(ErrorCode::limit, "the run was stopped before the environment was measured; let it run longer");
  }
}

}  // namespace viewpeel
