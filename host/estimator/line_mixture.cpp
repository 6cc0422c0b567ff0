#include "estimator/line_mixture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/promise_cost.h"
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
// its search.
constexpr double kSecondsOfPair = 2.5e-6, kSecondsOfHidden = 5e-7;
// In open scenes a pair that nothing blocks costs less, a pair that something may block more, and it takes longer to
// prove that a pair is hidden, where this is not proved of whole clusters. At 0.01 six cities of 1,016 to 8,592
// triangles and quads took 1.4 to 1.7 times what these costs give, on a processor on which rays take 1.5 to 1.7 times
// kSecondsOfRay.
constexpr double kSecondsOfClear = 2e-7, kSecondsOfBlocked = 8.5e-6, kSecondsOfHiddenInOpen = 1e-6;
constexpr double kSecondsOfCount = 4.5e-7;  // of a pair that a common direction counts
constexpr double kMostFacingPairs = 1e8;    // finding what is between more pairs takes minutes
// Between surfaces a mixture with rays costs these for each face, and for each pair that it finds, beside the rays.
// They fit cities of 8,936 and 19,994 triangles at 0.1 to 1e-3. The latter also says which pairs have lines where the
// goal is the root mean square of all errors. A third, or 30 times as much, took as long in an office of 2,320 polygons
// and a city of 2,892 at 1e-3 to 1e-4.
constexpr double kSecondsOfFaceBesideRays = 3e-4, kSecondsOfPairBesideRays = 1.5e-5;
// A ray takes 0.1 us. The rest is its part in sums, and in further rays of rows that miss the goal: three cities of
// 4,202 to 8,592 polygons at 0.01.
constexpr double kSecondsOfRay = 1.8e-7;
constexpr double kWorth = 1.05;            // lines for all pairs may cost this multiple of the mixture's time
constexpr double kWorthBesideRays = 1.25;  // the same, of a mixture with rays
constexpr double kSoon = 0.05;             // all pairs get lines where they cost less than this

// Returns the seconds of lines for a few of the pairs that find() would find. The same share of hidden pairs is taken
// to be among the few as of the others.    In: of_all: seconds of lines for all pairs; few: their number
double secondsOfFew(const PairNumbers& pairs, double of_all, double few) {
  return pairs.found > 0 ? few / pairs.found * of_all : 0;
}

// Returns the seconds of lines for all pairs of an open scene.
double secondsInOpen(const PairNumbers& pairs) {
  const double hidden = std::max(0.0, pairs.decided - pairs.found);
  return (pairs.found - pairs.blocked) * kSecondsOfClear + pairs.blocked * kSecondsOfBlocked +
         hidden * kSecondsOfHiddenInOpen;
}

// The same of a closed scene.
double secondsInClosed(const PairNumbers& pairs) {
  return pairs.found * kSecondsOfPair + (pairs.facing - pairs.found) * kSecondsOfHidden;
}

// Returns the seconds that the large pairs take beside rays, between surfaces.
double secondsBesideRays(const PairNumbers& pairs, size_t face_count) {
  return double(face_count) * kSecondsOfFaceBesideRays +
         (pairs.large + pairs.small_of_parts) * kSecondsOfPairBesideRays;
}

}  // namespace

LineMixture mixtureFor(const EstimateOptions& options, double mean_area) {
  const double goal = std::min(1.0, options.leastAllowedError());
  LineMixture mixture;
  mixture.least_form_factor = goal / kMostOfCounted;
  const double directions = std::ceil(kDirectionsOfGoal / goal / options.replicates);
  mixture.directions = static_cast<uint32_t>(std::clamp(directions, double(kLineRunDirections), 1e6));
  // The lattice is 2 radii across.
  const double resolution = 2 * kLinesOfSide / std::sqrt(mean_area);
  mixture.resolution = static_cast<int>(std::clamp(resolution, double(LatticeOptions{}.resolution), kMostResolution));
  return mixture;
}

double leastFormFactorBesideRays(const EstimateOptions& options, size_t face_count) {
  if (!options.rms) return options.leastAllowedError() / kMostOfCounted;
  return std::min(kAllCounted, kSecondsOfPairBesideRays / secondsOfRays(raysForRms(1, face_count, *options.rms)));
}

double raysForRms(double form_factors, size_t face_count, double rms) {
  return form_factors / (double(face_count) * rms * rms);
}

LineMixture rayMixtureFor(const EstimateOptions& options, std::vector<uint32_t> rays) {
  const double least = leastFormFactorBesideRays(options, rays.size());
  LineMixture mixture = raysAlone(std::move(rays));
  mixture.least_form_factor = least;
  return mixture;
}

LineMixture raysAlone(std::vector<uint32_t> rays) {
  const uint32_t most = std::ranges::max(rays);
  return {.least_form_factor = kAllCounted,
          .directions = most,
          .resolution = LatticeOptions{}.resolution,
          .rays = std::move(rays)};
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

double secondsOfLines(const PairNumbers& pairs, bool is_open) {
  return is_open ? secondsInOpen(pairs) : secondsInClosed(pairs);
}

double secondsWithDirections(const LineWork& work, const LineMixture& mixture, uint32_t replicates) {
  return secondsOfFew(work.pairs, secondsInClosed(work.pairs), work.pairs.large) +
         countedPairs(work, mixture, replicates) * kSecondsOfCount;
}

double secondsWithRays(const PairNumbers& pairs, double rays, bool is_open) {
  return secondsOfFew(pairs, secondsOfLines(pairs, is_open), pairs.large + pairs.small_of_parts) + kSecondsOfRay * rays;
}

bool areLinesQuick(const PairNumbers& pairs) { return mayFindAll(pairs) && secondsInClosed(pairs) <= kSoon; }

bool paysLinesForAll(const LineWork& work, const LineMixture& mixture, uint32_t replicates) {
  return areLinesQuick(work.pairs) ||
         (mayFindAll(work.pairs) &&
          secondsInClosed(work.pairs) <= kWorth * secondsWithDirections(work, mixture, replicates));
}

bool paysRays(const PairNumbers& pairs, double rays, bool may_promise, bool is_open) {
  const double of_mixture = (may_promise ? kPromiseWorth : kWorthBesideRays) * secondsWithRays(pairs, rays, is_open);
  return !mayFindAll(pairs) || secondsOfLines(pairs, is_open) > std::max(kSoon, of_mixture);
}

double secondsOfRays(double rays) { return kSecondsOfRay * rays; }

bool paysRaysAlone(const PairNumbers& pairs, size_t face_count, double rays_alone, double rays_beside) {
  return kWorth * kSecondsOfRay * rays_alone < kSecondsOfRay * rays_beside + secondsBesideRays(pairs, face_count);
}

bool paysRaysAloneForRms(size_t face_count, double rays) {
  return kSecondsOfRay * rays < double(face_count) * kSecondsOfFaceBesideRays;
}

bool mayPayDirectionsAlone(size_t face_count, double seconds) {
  return double(pairCount(face_count)) * kSecondsOfBlocked > std::max(kSoon, kWorthBesideRays * seconds);
}

double mostSecondsOfDirectionsAlone(const PairNumbers& pairs, size_t face_count, bool is_open, bool is_large,
                                    bool may_promise) {
  // In a closed scene common directions would count the small pairs of a mixture. Form factors between surfaces, which
  // are sums of many such pairs, then hardly reach a goal. So the alternative there is lines for all pairs.
  if (is_open && is_large) return secondsBesideRays(pairs, face_count) / kWorth;
  const double all = secondsOfLines(pairs, is_open);
  return all > kSoon ? all / (may_promise ? kPromiseWorth : kWorthBesideRays) : 0;
}

double countedPairs(const LineWork& work, const LineMixture& mixture, uint32_t replicates) {
  return work.pairs_of_direction * mixture.directions * replicates;
}

}  // namespace viewpeel
