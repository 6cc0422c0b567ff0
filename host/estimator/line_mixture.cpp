#include "estimator/line_mixture.h"

#include <algorithm>
#include <cmath>

#include "estimator/plan_lines.h"
#include "sums/line_form_factors.h"

namespace viewpeel {
namespace {

// Along one of N directions a pair exchanges a form factor of 2 / N at most. At half the goal there is room for two
// such directions before a count is cut to the goal.
constexpr double kDirectionsOfGoal = 4;
// Along each direction this number of scanlines, or of lattice points to a side, meets a polygon of the mean area. The
// error that scanlines add to a row sum is then about as large as the goal: docs/method.md, mixtures.
constexpr double kLinesOfSide = 3.4;
constexpr double kMostResolution = 1024;
// These costs are in processor seconds. A pair with lines costs its search, its lines and its entry, and a hidden pair
// its search. In cities it takes longer to prove that a pair is hidden: 3.5 to 4.2 us fit the times of three cities.
constexpr double kSecondsOfPair = 2.5e-6, kSecondsOfHidden = 5e-7, kSecondsOfHiddenInOpen = 5e-6;
constexpr double kSecondsOfCount = 4.5e-7;  // of a pair that a common direction counts
constexpr double kMostFacingPairs = 1e8;    // finding what is between more pairs takes minutes
constexpr double kSecondsOfRay = 2e-7;      // of rays that run side by side, sixteen at a time
constexpr double kWorth = 1.05;             // lines for all pairs may cost this multiple of the mixture's time
constexpr double kWorthBesideRays = 2;      // the same, of a mixture with rays
constexpr double kSoon = 0.05;              // all pairs get lines where they cost less than this
// In the worst rows of cities the standard error of the environment is kRayError N^-kRayRate from N rays: measured with
// 8 x 128 and 8 x 1,024 rays in a city of 6,604 triangles.
constexpr double kRayError = 1.8, kRayRate = 0.7;
constexpr uint32_t kLeastRays = 32, kMostRays = 1 << 20;

struct LineSeconds {
  double all, few;  // that lines for all pairs take, and that lines for a few of them take
};

//   In: few: the number of these pairs, of pairs.found; of_hidden: seconds of a hidden pair
LineSeconds secondsOfLines(const PairNumbers& pairs, double few, double of_hidden) {
  const double all = pairs.found * kSecondsOfPair + (pairs.facing - pairs.found) * of_hidden;
  // The same share of hidden pairs is taken to be among the few as of the others.
  return {all, pairs.found > 0 ? few / pairs.found * all : 0};
}

}  // namespace

LineMixture mixtureFor(const EstimateOptions& options, double mean_area) {
  double goal = options.tolerance.value_or(1);
  if (options.relative) goal = std::min(goal, *options.relative * options.relative_floor);
  LineMixture mixture;
  mixture.least_form_factor = goal / kMostOfCounted;
  const double directions = std::ceil(kDirectionsOfGoal / goal / options.replicates);
  mixture.directions = static_cast<uint32_t>(std::clamp(directions, double(kLineRunDirections), 1e6));
  // The lattice is 2 radii across.
  const double resolution = 2 * kLinesOfSide / std::sqrt(mean_area);
  mixture.resolution = static_cast<int>(std::clamp(resolution, double(LatticeOptions{}.resolution), kMostResolution));
  return mixture;
}

LineMixture rayMixtureFor(const EstimateOptions& options, size_t row_count) {
  const double goal = *options.tolerance, rays = std::pow(kRayError * errorsInRowGoal(row_count) / goal, 1 / kRayRate),
               of_replicate = std::ceil(rays / options.replicates / kLineLanes) * kLineLanes;
  return {.least_form_factor = goal / kMostOfCounted,
          .directions = static_cast<uint32_t>(std::clamp(of_replicate, double(kLeastRays), double(kMostRays))),
          .resolution = LatticeOptions{}.resolution,
          .has_rays = true};
}

double shareOutside(const PairCounts& counts) {
  double all = 0, outside = 0;
  for (const PairCount& count : counts) {
    const bool is_pair = count.j < kEnvironment;
    all += (is_pair ? 2 : 1) * double(count.count);
    if (!is_pair) outside += double(count.count);
  }
  return all > 0 ? outside / all : 0;
}

bool mayFit(const LineMixture& mixture, uint32_t replicates, size_t face_count) {
  const double count = double(face_count);
  return count * count / 2 <= kMostFacingPairs ||
         countedPairs({.pairs_of_direction = count / 4}, mixture, replicates) <= kMostCountedPairs;
}

bool mayPayMixture(size_t face_count) { return double(pairCount(face_count)) * kSecondsOfPair > kSoon; }

bool mayFindAll(const PairNumbers& pairs) {
  return pairs.found <= double(kMostPatchPairs) && pairs.facing <= kMostFacingPairs;
}

bool paysLinesForAll(const LineWork& work, const LineMixture& mixture, uint32_t replicates) {
  if (!mayFindAll(work.pairs)) return false;
  const LineSeconds lines = secondsOfLines(work.pairs, work.pairs.large, kSecondsOfHidden);
  const double of_mixture = lines.few + countedPairs(work, mixture, replicates) * kSecondsOfCount;
  return lines.all <= std::max(kSoon, kWorth * of_mixture);
}

bool paysRays(const PairNumbers& pairs, const LineMixture& mixture, uint32_t replicates, size_t polygon_count) {
  if (!mayFindAll(pairs)) return true;
  const LineSeconds lines = secondsOfLines(pairs, pairs.large + pairs.small_of_parts, kSecondsOfHiddenInOpen);
  const double of_rays = kSecondsOfRay * double(polygon_count) * mixture.directions * replicates;
  return lines.all > std::max(kSoon, kWorthBesideRays * (lines.few + of_rays));
}

double countedPairs(const LineWork& work, const LineMixture& mixture, uint32_t replicates) {
  return work.pairs_of_direction * mixture.directions * replicates;
}

}  // namespace viewpeel
