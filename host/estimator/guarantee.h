// Guarantee mode finds every form factor within epsilon with probability 1 - delta. Its bounds hold for every scene,
// and for the lattice.
//
// Derivation: docs/method.md, section 9. A direction's estimate of F_ij lies in [0, M_i], i the smaller of the two,
// with M_i of eq. (27) or (28), 2 for exact areas (bounds.h). The m bounds are those of unordered pairs of ids, each id
// with itself where it has several polygons, environment and leak. Hoeffding's bound (29) has half of delta. The
// empirical Bernstein bound (30) has the other half, over all looks at it and all bounds. With unoccluded form factors
// the bounds are those of visibility_bounds.h. The run ends when one of the two is at most epsilon for everything, so
// the error exceeds epsilon with probability at most delta. Snapping adds at most 1.3e-6 M to the mean (section 2),
// which is left out.
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
  double bound = 0;  // Bernstein's, up to now; infinite before the first look
};

struct GuaranteeOptions {
  double epsilon = 1e-2;
  double delta = 1e-2;
  Statistic statistic = Statistic::mean;
  Sampler sampler = Sampler::jittered;  // or iid
  uint64_t seed = 1;
  double range = 0;               // the lattices are made for it; 0 chooses
  uint32_t block_directions = 0;  // 0 chooses
  bool unoccluded =
      false;  // ids are then by face, all pairs of them few enough (kMostPriorPairs), and engines count blocked pairs
  // Ids are then by face, all pairs of them few enough (kMostPriorPairs), and engines count blocked pairs.
  const Device* device = nullptr;
  const RunSums* resumed = nullptr;                        // go on after these blocks, of the same plan; may be nullptr
  std::function<void(const GuaranteeProgress&)> on_block;  // may be empty
  std::function<void(const RunSums& sums, bool last)> on_sums;  // as for estimates; may be empty
};

// Returns the ranges M_i of ids: the most that one direction adds to a form factor of id i, or to one with i the
// smaller polygon.
//   A facing pair of polygons is counted on the finer lattice of the two. All windows of a resolution are parts of one
//     lattice, and a point counts once. Against an id j of one resolution polygon a of i is counted on one lattice
//     only, no coarser than its own. Where j has several, polygon a may be counted on every finer one, too. This adds
//     at most the range of the polygons of i on the finer lattice, and of those polygons of j that have it, the most
//     over all such j.
//   In: resolutions of Scene::polygons, empty for exact areas
std::vector<double> formFactorRanges(const Scene& scene, const Ids& ids, const std::vector<double>& resolutions,
                                     Sampling sampling);

// Returns how many bounds have to hold at once, by id: pairs with larger ids, environment, leak, and itself.
std::vector<double> countBounds(const Ids& ids);

// Returns the least N with sum_i bounds_i 2 exp(-2 N epsilon^2 / ranges_i^2) <= delta.
//   Throws: Error bad_usage where N is above 1e15.
//   Cost: O(n) a step of bisection.
uint64_t hoeffdingDirections(const std::vector<double>& ranges, const std::vector<double>& bounds, double epsilon,
                             double delta);

// Returns the least N, 1e15 at most, with failure(N) <= delta.
//   In: failure: falls with N; epsilon, range: for the message
//   Throws: Error bad_usage where there is none.
uint64_t leastDirections(const std::function<double(double)>& failure, double delta, double epsilon, double range);

// Returns sqrt(2 V L / K) + 7 M L / (3 (K - 1)), L = ln(4 / p): eq. (30).
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

// Carries the plan out.
//   Out: form factors that are all within epsilon with probability 1 - delta; standard errors are estimates, as ever.
//   Tests: tests/device/guarantee_test.cpp.
Estimate guaranteeFormFactors(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                              const GuaranteePlan& plan);

}  // namespace viewpeel
