// findPrior() makes the prior of a run: unoccluded form factors, and visibilities from pilots. The run then samples
// only the occlusion.
//
// Derivation: docs/method.md, section 6. By polygon the run's own lines give the visibility of a pair
// (visibility_sums.h). Between surfaces, and for guarantees, a pilot fixes a visibility b before the run, and eq. (17)
// is unbiased for any b. A pair's control variate takes T = V + O, its facing and blocked lines. For environment and
// leak T is all lines of the row, because rows sum to 1. Control variates are integers, so they add up to the same bits
// in any order. Standard errors come from replicates. They are at least the error of one line, since no number of lines
// proves that nothing is visible. Tests: tests/device/find_prior_test.cpp, tests/unit/visibility_sums_test.cpp.
#pragma once
#include "engines/size_groups.h"
#include "estimator/estimate.h"
#include "estimator/face_exchanges.h"
#include "sums/prior_sums.h"

namespace viewpeel {

// A FoundPrior holds what the pilots found, and the time that they took.
struct FoundPrior {
  Prior prior;
  double pilot_seconds = 0, unoccluded_seconds = 0, directed_seconds = 0;
  uint64_t unreached = 0;  // pairs without an accurate unoccluded form factor; the run samples them without a prior
};

// Up to kMostPriorPairs pairs of faces, every pair gets an accurate unoccluded form factor. Beyond this number, only
// pairs that a line of a pilot or of the run hits get one. By polygon the limit is kMostPriorPairsBesideRows, because
// the run computes the other pairs as whole rows in single precision. The second limit was measured with the office
// refined to 2,320 polygons (docs/speed.md).
constexpr uint64_t kMostPriorPairs = uint64_t(1) << 22, kMostPriorPairsBesideRows = uint64_t(1) << 18;

// Returns the visibility of every pair that a facing line hit: its facing lines over all its lines, blocked or not.
std::vector<PairVisibility> fitVisibilities(const PairCounts& counts);

// Returns the counts that one line of each face adds: uint64_t[face]. It is more than 1 with scanlines, and for faces
// on the coarser of several lattices.
//   In: groups: of the engine; unit_area: the engine's unitArea()
std::vector<uint64_t> countsOfLines(const Ids& face_ids, const std::vector<SizeGroup>& groups, double unit_area);

// Returns lineStep() of each id: double[ids].    In: groups, unit_area, sampling: of the engine
std::vector<double> meanStepsOfLines(const Scene& scene, const Ids& ids, const std::vector<SizeGroup>& groups,
                                     double unit_area, Sampling sampling);

struct PriorPilot {
  uint32_t directions;                          // of all pilots
  uint64_t most_prior_pairs = kMostPriorPairs;  // up to this number, all pairs get unoccluded form factors
};

// Chooses the pilot of a run. A pilot that fixes visibilities or chooses directed pairs has as many directions as a
// replicate. A pilot that only serves pairs that no line of the run hits has a quarter of them.
//   In: options: of a run that computes rows (EstimateOptions::exchanges) where some pairs have no accurate unoccluded
//     form factor
PriorPilot choosePriorPilot(const EstimateOptions& options);

// Runs the pilot and computes unoccluded form factors.
//   In: engine: counts all ids by face (By::polygon), and blocked pairs, too; groups: the engine's; options: the
//     sampler and the seed; pilot: as choosePriorPilot() returns it
//   Out: visibilities from pilots, the same for the same options, and unoccluded form factors. With options.pairs, and
//     for goals by face, also the directed pairs (directed_pairs.h).
//   Throws: whatever the engine and FaceExchanges throw.
//   Cost: the pilots, and 0.1 to 3 microseconds for the unoccluded form factor of each pair.
FoundPrior findPrior(Engine& engine, FaceExchanges& exchanges, const Scene& scene, const Ids& ids,
                     const std::vector<SizeGroup>& groups, const EstimateOptions& options, PriorPilot pilot);

}  // namespace viewpeel
