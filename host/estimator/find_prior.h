// This header makes the prior of a run: unoccluded form factors, and visibilities from pilots. Occlusion alone is left
// to sampling.
//
// Derivation: docs/method.md, section 6. By polygon the run's own lines give the visibility of a pair
// (visibility_sums.h). Between surfaces, and for guarantees, a pilot fixes a visibility b beforehand, and eq. (17) is
// unbiased for any b. Environment and leak have all lines of their row in the place of V + O, for rows sum to 1.
// Control variates are integers and add up in any order. Standard errors come from replicates, and are never less than
// one line's: no number of lines proves that nothing is there. Tests: tests/device/find_prior_test.cpp,
// tests/unit/visibility_sums_test.cpp.
#pragma once
#include "engines/size_groups.h"
#include "estimator/estimate.h"
#include "estimator/face_exchanges.h"
#include "sums/prior_sums.h"

namespace viewpeel {

// A FoundPrior holds the results of the pilots, and the time that they took.
struct FoundPrior {
  Prior prior;
  double pilot_seconds = 0, unoccluded_seconds = 0, directed_seconds = 0;
  uint64_t unreached = 0;  // pairs left to sampling alone, as their unoccluded form factors were not accurate enough
};

// Up to this number of pairs of faces, every pair gets an accurate unoccluded form factor. Beyond it, only the pairs do
// that lines of pilots or of the run hit. By polygon the run computes whole rows of the others in single precision, so
// fewer are enough. The second figure was measured with the office refined to 2,320 polygons (docs/speed.md).
constexpr uint64_t kMostPriorPairs = uint64_t(1) << 22, kMostPriorPairsBesideRows = uint64_t(1) << 18;

// Returns the visibility of every pair with facing lines: facing lines over all lines.
std::vector<PairVisibility> fitVisibilities(const PairCounts& counts);

// Returns the counts that one line adds, by face. A line adds more than 1 with scanlines, and on the coarser of several
// lattices.
//   In: groups that the engine was made with, its unitArea()
std::vector<uint64_t> countsOfLines(const Ids& face_ids, const std::vector<SizeGroup>& groups, double unit_area);

struct PriorPilot {
  uint32_t directions;                          // of all pilots
  uint64_t most_prior_pairs = kMostPriorPairs;  // up to which all get their unoccluded form factors
};

// Chooses the pilot of a run. It has as many directions as a replicate where it fixes visibilities or chooses pairs. It
// has a quarter of them where it only stands in for pairs that no line of the run hits.
//   In: options of a run that makes rows (EstimateOptions::exchanges) where not all pairs have unoccluded form factors
PriorPilot choosePriorPilot(const EstimateOptions& options);

// Runs the pilot and computes unoccluded form factors.
//   In: engine: for ids by face (By::polygon), all of them, counting blocked pairs; groups: the engine's; options:
//     sampler, seed; directions: of a replicate of the run
//   Out: visibilities from pilots, the same for the same options, and unoccluded form factors. With options.pairs and
//     for goals of faces also the pairs that get directions of their own (directed_pairs.h).
//   Throws: what the engine and FaceExchanges throw.
//   Cost: the pilots; unoccluded form factors: some 0.1 to 3 microseconds a pair.
FoundPrior findPrior(Engine& engine, FaceExchanges& exchanges, const Scene& scene, const Ids& ids,
                     const std::vector<SizeGroup>& groups, const EstimateOptions& options, PriorPilot pilot);

}  // namespace viewpeel
