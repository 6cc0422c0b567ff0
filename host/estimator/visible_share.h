// Form factors as closed forms times visible shares: only what occlusion makes uncertain is sampled.
//
// For two polygons F0_ij is what F_ij would be with nothing in between. Of the lines on which their fronts look at each other, V are facing pairs and O are blocked, and
// E[V + O] is A_i F0_ij / 2 in the units of areas in P(u). With a share b from a pilot,
//   F_ij = V - b (V + O - F0_ij)       (in F's units)
// is unbiased for any b, and varies least for b = Cov(V, V + O) / Var(V + O), which is near E[V] / E[V + O]: pairs never blocked are exact with b = 1, pairs that never
// see each other with b = 0. b is fixed before the run, so controls are integers and add up in any order.
#pragma once
#include "closed_forms/unoccluded.h"
#include "estimator/estimate.h"
#include "matrix/control_sums.h"

namespace viewpeel {

// What a pilot and closed forms know of a scene's faces.
struct VisibleShares {
  std::vector<PairShare> shares;              // of pairs of faces, sorted
  std::vector<KnownExchange> exchanges;       // of the same pairs
  // Of those of them that are of use in sums between surfaces.
  std::vector<PairShare> surface_shares;
  std::vector<KnownExchange> surface_exchanges;  // of surfaces
  double pilot_seconds = 0, closed_form_seconds = 0;
  uint64_t unreached = 0;                     // pairs left to sampling alone, as their closed forms were not accurate enough
};

// Facing lines over all lines, for every pair with any of them; b = 0 is left out.
std::vector<PairShare> fitShares(const PairCounts& counts);

//   In: an engine for ids by face (By::polygon), of everything, that counts blocked pairs; options: directions, sampler, seed
//   Out: shares from pilots with one replicate's directions in all, the same for the same options, and the closed forms of their pairs
//   Error: of exchange areas: kUnoccludedRelativeError or kUnoccludedAbsoluteError for each pair of polygons.
//   Throws: what the engine and the device throw.
//   Cost: one replicate; closed forms: some 0.1 to 3 microseconds a pair.
VisibleShares findVisibleShares(Engine& engine, const Device& device, const Scene& scene, const Ids& ids, const EstimateOptions& options);

// As estimateFormFactors, with shares. Goals are those of `by`: form factors of polygons or between surfaces, which then are the result.
//   In: engine and ids as above    Out: row sums are the sampled ones: their distance from 1 is a check, as ever
//   Error: unbiased but for the clamp to [0, F0]. Standard errors are those of replicates, and never less than one line's. Tests: tests/visible_share_test.cpp.
Estimate estimateVisibleShares(Engine& engine, const Scene& scene, const Ids& ids, By by, const EstimateOptions& options, const VisibleShares& known);

}  // namespace viewpeel
