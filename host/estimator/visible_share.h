// Form factors as closed forms times visible shares: only what occlusion makes uncertain is sampled.
//
// For two polygons F0_ij is what F_ij would be with nothing in between. Of the lines on which their fronts look at each
// other, V are facing pairs and O are blocked, and E[V + O] is A_i F0_ij / 2 in the units of areas in P(u). Between
// faces V / (V + O) of the whole run is the share of F0_ij that is visible (share_sums.h). Between surfaces, of many
// pairs each, and for guarantees a share b is fixed beforehand, from a pilot:
//   F_ij = V - b (V + O - F0_ij)       (in F's units)
// is unbiased for any b, and varies least for b = Cov(V, V + O) / Var(V + O), which is near E[V] / E[V + O]: pairs
// never blocked are exact with b = 1, pairs that never see each other with b = 0. Controls are integers and add up in
// any order, as sums of V and O do. What leaves the scene or ends on backs has all lines of its row in the place of V +
// O: rows sum to 1. Row sums stay the sampled ones, whose distance from 1 is a check as ever, and standard errors are
// those of replicates, never less than one line's: no line says that nothing is there. Tests:
// tests/device/visible_share_test.cpp, tests/unit/share_sums_test.cpp.
#pragma once
#include "engines/size_groups.h"
#include "estimator/estimate.h"
#include "estimator/face_exchanges.h"
#include "sums/visible_sums.h"

namespace viewpeel {

// What a pilot and closed forms know of a scene's faces.
struct VisibleShares {
  KnownShares known;
  double pilot_seconds = 0, closed_form_seconds = 0, directed_seconds = 0;
  uint64_t unreached = 0;  // pairs left to sampling alone, as their closed forms were not accurate enough
};

// Of every pair of so many faces the closed form is computed to the last digit, met by a line or not: a pair that none
// has met is uncertain by its own at most. Of more, those that pilots met or the run sees. By polygon, where the run
// makes rows of the others, that is the better from fewer on: office refined to 2,320 polygons, README.
constexpr uint64_t kMostKnownPairs = uint64_t(1) << 22, kMostKnownPairsBesideRows = uint64_t(1) << 18;

// Facing lines over all lines, for every pair with any of them; b = 0 is left out.
std::vector<PairShare> fitShares(const PairCounts& counts);

// Of every face, the engine's counts that one lattice point adds: more than 1 with scanlines, and on the coarser of
// several lattices.
//   In: groups that the engine was made with, its unitArea()
std::vector<uint64_t> countsOfLines(const Ids& face_ids, const std::vector<SizeGroup>& groups, double unit_area);

struct SharePilot {
  uint32_t directions;                          // of all pilots
  uint64_t most_known_pairs = kMostKnownPairs;  // up to which all get their closed forms
};

// As many directions as a replicate where shares are fixed by them or pairs chosen, a quarter where they only stand in
// for pairs that the run does not meet.
//   In: options of a run that makes rows (EstimateOptions::exchanges) where not all pairs have closed forms
SharePilot sharePilot(const EstimateOptions& options);

//   In: an engine for ids by face (By::polygon), of everything, that counts blocked pairs, and its groups; options:
//   sampler, seed; directions: of a
//     replicate of the run
//   Out: shares from pilots, the same for the same options, closed forms, and, with options.pairs and for goals of
//   faces,
//     pairs that get directions of their own (directed_pairs.h)
//   Throws: what the engine and FaceExchanges throw.
//   Cost: the pilots; closed forms: some 0.1 to 3 microseconds a pair.
VisibleShares findVisibleShares(Engine& engine, FaceExchanges& exchanges, const Scene& scene, const Ids& ids,
                                const std::vector<SizeGroup>& groups, const EstimateOptions& options, SharePilot pilot);

}  // namespace viewpeel
