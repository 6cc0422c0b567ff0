// Guarantee mode by common directions finds every form factor within epsilon with probability 1 - delta. Its bounds
// hold for every scene, and include the error of the lattice.
//
// Derivation: docs/method.md, section 9. A direction's estimate of F_ij lies in [0, M_i], where i is the smaller
// polygon of the pair. M_i is M of eq. (27) or (28), or 2 for exact areas (bounds.h). The m bounds are one for each
// unordered pair of ids, for each id of several polygons with itself, and for each id's environment and leak.
// Hoeffding's bound (29) may fail with probability delta / 2. The empirical Bernstein bound (30) has the other half of
// delta, over all looks and all m bounds. With unoccluded form factors the bounds of visibility_bounds.h take their
// place. The run ends when Hoeffding's or Bernstein's bounds are all at most epsilon. Snapping adds at most 1.3e-6 M to
// the mean (section 2), which the bounds leave out.
#pragma once
#include <functional>
#include <memory>

#include <viewpeel/request.h>
#include <viewpeel/result.h>

#include "engines/lattice_options.h"
#include "estimator/estimate.h"
#include "estimator/plan.h"
#include "estimator/visibility_bounds.h"
#include "vulkan/device.h"

namespace viewpeel {

struct GuaranteeProgress {
  uint64_t blocks = 0, expected_blocks = 0, most_blocks = 0;
  double bound = 0;  // largest of Bernstein's bounds at the last look; infinite before the first look
};

struct GuaranteeOptions {
  double epsilon = 1e-2;
  double delta = 1e-2;
  Statistic statistic = Statistic::mean;
  Sampler sampler = Sampler::jittered;  // jittered or iid, whose directions have a known variance
  uint64_t seed = 1;
  double range = 0;               // largest M_i that the lattices may give; 0: the plan chooses
  uint32_t block_directions = 0;  // directions of a block; 0: the plan chooses
  // With true the run uses unoccluded form factors. Ids must then be by face, with at most kMostPriorPairs pairs, and
  // engines must count blocked pairs.
  bool unoccluded = false;
  const Device* device = nullptr;                          // computes unoccluded form factors; nullptr: the processor
  const RunSums* resumed = nullptr;                        // the run continues after these blocks of the same plan
  std::function<void(const GuaranteeProgress&)> on_block;  // may be empty
  std::function<void(const RunSums& sums, bool last)> on_sums;  // as for estimates; may be empty
};

// Returns the ranges M_i: double[id]. M_i is the most that one direction adds to a form factor between i and an id at
// least as large.
//   A facing pair of polygons is counted on the finer lattice of the two. All windows of one resolution are parts of
//     one lattice, on which a point counts once. If all polygons of j have one resolution, a polygon of i is counted
//     against j on one lattice only, no coarser than its own. If j has several resolutions, the polygon may be counted
//     on each finer lattice as well. Each finer lattice adds at most the range, on that lattice, of the polygons of i.
//     It also adds at most the range of the polygons of j that have this lattice. The largest sum over all j counts.
//   In: resolutions: the resolution of every polygon, double[polygon]; empty for exact areas
std::vector<double> formFactorRanges(const Scene& scene, const Ids& ids, const std::vector<double>& resolutions,
                                     Sampling sampling);

// Returns the number of bounds of each id that have to hold at once: double[id]. An id has one for its pair with every
// larger id, for the environment, for the leak, and for itself where it has several polygons.
std::vector<double> countBounds(const Ids& ids);

// Returns the least number of directions N with sum_i bounds_i 2 exp(-2 N epsilon^2 / ranges_i^2) <= delta: Hoeffding's
// bound for all ids at once.
//   Throws: Error bad_usage where N is above 1e15.
//   Cost: O(n) a step of bisection.
uint64_t hoeffdingDirections(const std::vector<double>& ranges, const std::vector<double>& bounds, double epsilon,
                             double delta);

// Returns the least number of directions N with failure(N) <= delta.
//   In: failure: the probability that a bound fails after N directions, falling with N; epsilon, range: values that the
//     error message shows
//   Throws: Error bad_usage where N would be above 1e15.
uint64_t leastDirections(const std::function<double(double)>& failure, double delta, double epsilon, double range);

// Returns the empirical Bernstein bound, docs/method.md, eq. (30): sqrt(2 V L / K) + 7 M L / (3 (K - 1)), with L =
// ln(4 / p). The mean of K independent values in [0, M], of sample variance V, errs by more with probability at most p.
//   In: variance: V; range: M; blocks: K; p: in (0, 1)
double bernsteinBound(double variance, double range, double blocks, double p);

struct GuaranteePlan : GuaranteeFigures {
  std::vector<double> ranges;  // M_i: double[id], as formFactorRanges() returns them
  Prior prior;                 // empty without unoccluded form factors
  std::optional<VisibilityBounds> visibility_bounds;
  std::vector<SizeGroup> groups;
  std::unique_ptr<Engine> engine;
};

// Chooses the lattices and the directions of a block by their measured cost. The lattices are fine enough for ranges
// near 2, the range of exact areas.
//   In: lattices: as for planEstimate; exact: true where the engine counts exact areas
//   Throws: Error bad_usage where epsilon or delta is not in (0, 1), or the sampler's directions are not independent;
//   whatever engines throw.
//   Cost: a pilot of some hundred directions.
GuaranteePlan planGuarantee(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                            const Lattices& lattices, bool exact);

// Runs the plan to its end.
//   Out: form factors that are all within epsilon with probability 1 - delta. Their standard errors are estimates, and
//     no part of the guarantee.
//   Tests: tests/device/guarantee_test.cpp.
Estimate guaranteeFormFactors(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                              const GuaranteePlan& plan);

}  // namespace viewpeel
