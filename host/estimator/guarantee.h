// Guarantee mode: every form factor within epsilon with probability 1 - delta, by bounds that hold for every scene,
// rasterisation included.
//
// A direction's estimate of F_ij lies in [0, M_i], i the smaller of the two, M_i = range of i / A_i (bounds.h): 2 for
// exact areas, more on a lattice. The other way F_ji errs by A_i / A_j times as much, so that m bounds do for all:
// unordered pairs of ids, each id with itself where it has several polygons, environment and leak.
//   Hoeffding 1963, theorem 2: the estimates of N independent directions, in strata or not, have a mean that is off by
//   epsilon or more with probability at most
//     2 exp(-2 N epsilon^2 / M^2). With half of delta: N such that the sum over the m bounds is delta / 2.
//   Empirical Bernstein (Maurer & Pontil 2009, theorem 4, both tails): the means of K independent blocks of directions
//   lie in [0, M], too; with sample variance V the
//     mean of all is off by more than sqrt(2 V L / K) + 7 M L / (3 (K - 1)), L = ln(4 / p), with probability at most p.
//     It is looked at after set numbers of blocks, the k-th time with p = delta / (2 k (k + 1) m): all those p of all m
//     bounds together are delta / 2. Blocks of one direction in each of B strata have a V that is far smaller than that
//     of B independent directions.
//   With unoccluded form factors the mean is that of V - b (V + O - F0), whose bounds are in visibility_bounds.h.
//   The run ends when one of the two is at most epsilon for everything; either way the error exceeds epsilon with
//   probability at most delta. Snapping moves corners by at most s = 2^-10 of a spacing h along each axis, to either
//   side alike. An area is linear in each of its corners, so that what is left in the mean are products of two corners'
//   errors, E[e_x e_y'] <= s^2 / 3: at most 4/3 s^2 h^2 for four corners, that is 1.3e-6 M of a form factor (M >= 2 h^2
//   / A), and left out.
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
  double bound = 0;  // Bernstein's, so far; infinite before the first look
};

struct GuaranteeOptions {
  double epsilon = 1e-2;
  double delta = 1e-2;
  Statistic statistic = Statistic::mean;
  Sampler sampler = Sampler::jittered;  // or iid
  uint64_t seed = 1;
  double range = 0;               // that lattices are made for; 0 chooses
  uint32_t block_directions = 0;  // 0 chooses
  bool unoccluded =
      false;  // ids are then by face, all pairs of them few enough (kMostPriorPairs), and engines count blocked pairs
  const Device* device = nullptr;                          // that computes unoccluded form factors; none: the processor
  const RunSums* resumed = nullptr;                        // go on after these blocks, of the same plan; may be nullptr
  std::function<void(const GuaranteeProgress&)> on_block;  // may be empty
  std::function<void(const RunSums& sums, bool last)> on_sums;  // as for estimates; may be empty
};

// The ranges M_i of ids: the most that one direction can contribute to a form factor of id i, or to one with i the
// smaller polygon.
//   A facing pair of polygons is counted on the finer lattice of the two. With an id j of one resolution polygon a of i
//   is so counted on one lattice only, no coarser than its own, whose points in a count once (all windows of a
//   resolution are parts of one lattice). Where j has several, a may be counted on every finer one, too: what that adds
//   is at most the range of the polygons of i on that lattice, and of those of j that have it, the most over all such
//   j.
//   In: resolutions of Scene::polygons, empty for exact areas
std::vector<double> formFactorRanges(const Scene& scene, const Ids& ids, const std::vector<double>& resolutions,
                                     Sampling sampling);

// How many bounds have to hold at once, by id: pairs with larger ids, environment, leak, and itself.
std::vector<double> countBounds(const Ids& ids);

// The least N with sum_i bounds_i 2 exp(-2 N epsilon^2 / ranges_i^2) <= delta.    Throws: Error bad_usage where that is
// above 1e15.    Cost: O(n) a step of bisection.
uint64_t hoeffdingDirections(const std::vector<double>& ranges, const std::vector<double>& bounds, double epsilon,
                             double delta);

// The least N, 1e15 at most, with failure(N) <= delta.    In: failure: falls with N; epsilon, range: for the message
//   Throws: Error bad_usage where there is none.
uint64_t leastDirections(const std::function<double(double)>& failure, double delta, double epsilon, double range);

// sqrt(2 V L / K) + 7 M L / (3 (K - 1)), L = ln(4 / p).
double bernsteinBound(double variance, double range, double blocks, double p);

struct GuaranteePlan : GuaranteeFigures {
  std::vector<double> ranges;  // of ids
  Prior prior;                 // with unoccluded form factors
  std::optional<VisibilityBounds> visibility_bounds;
  std::vector<SizeGroup> groups;
  std::unique_ptr<Engine> engine;
};

// Chooses lattices, fine enough for ranges near 2, and blocks, by their measured cost.
//   In: lattices as for planEstimate, with what they sample; `exact` where areas are exact
//   Throws: Error bad_usage where epsilon or delta is not in (0, 1), or the sampler's directions are not independent;
//   what engines throw.
//   Cost: a pilot of some hundred directions.
GuaranteePlan planGuarantee(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                            const Lattices& lattices, bool exact);

// Carries the plan out.    Out: form factors of which all are within epsilon with probability 1 - delta; standard
// errors are estimates, as ever.
//   Tests: tests/device/guarantee_test.cpp.
Estimate guaranteeFormFactors(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                              const GuaranteePlan& plan);

}  // namespace viewpeel
