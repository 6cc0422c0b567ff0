// Estimate mode: replicates of random directions until the standard error asked for, or the number of replicates asked
// for.
#pragma once
#include <functional>
#include <optional>

#include <viewpeel/result.h>

#include "directions/asked_directions.h"
#include "directions/sampler.h"
#include <viewpeel/engine.h>
#include "sums/run_sums.h"

namespace viewpeel {

class FaceExchanges;
class PairSampler;

// What a callback of an engine (on_batch) or of the estimator throws to stop a run: the replicate in progress is
// dropped.
struct Interrupted {};

struct EstimateProgress {
  uint64_t replicates = 0;
  double largest_standard_error = 0;  // over all form factors so far; infinite where there is no goal, or before as
                                      // many replicates as there are to be at least
};

struct EstimateOptions {
  Sampler sampler = Sampler::fibonacci;
  uint32_t directions = 400;  // per replicate
  uint32_t replicates = 8;    // at least
  // Go on after `replicates` until the largest standard error is at most this.
  std::optional<double> tolerance;
  // Go on after `replicates` until the largest standard error relative to its form factor, over form factors of at
  // least `relative_floor`, is at most this.
  std::optional<double> relative;
  double relative_floor = 0.01;
  // Stop before the replicate that would end later than this, `replicates` or not, but not before the second, nor
  // before the first of this call.
  std::optional<double> seconds;
  uint64_t seed = 1;
  // In place of the sampler: `count` directions of a replicate. None: nothing can be seen, every form factor is 0.
  std::function<AskedDirections(uint32_t count, uint64_t replicate)> asked_directions;
  uint64_t first_replicate = 0;
  // Go on after these, which count towards `replicates`: first_replicate and those that follow it, of the same scene,
  // ids and options. May be nullptr.
  const RunSums* resumed = nullptr;
  // Closed forms times visible shares (visible_share.h), which need an engine and ids by face; goals and the result are
  // those of `by`. May be nullptr.
  const KnownShares* known = nullptr;
  // For pairs that pilots did not meet; nullptr: they are sampled alone.
  FaceExchanges* exchanges = nullptr;
  By by = By::polygon;  // of the result, and of the goals
  // For pairs that common directions hardly meet (directed_pairs.h), of the same scene, ids and seed; nullptr: they
  // have no directions of their own.
  PairSampler* pairs = nullptr;
  std::function<void(const EstimateProgress&)> on_replicate;  // may be empty
  // Told the sums after every replicate, and once more with `last` when there will be no further one, be it for an
  // error; may be empty.
  std::function<void(const RunSums& sums, bool last)> on_sums;
};

// Without entries of 0.
FormFactors keepSeen(FormFactors form_factors);

// The form factors and errors of what was counted.    In: row: as in VisibleSums    Cost: O(nonzeros).
Estimate makeEstimate(const RunSums& sums, double relative_floor, const ExchangeRow& row = {});
// The same of those that sums.formFactors(row) made.
Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all);

// Computes F_ij = (2 / A_i) E[A'_ij(u)] for all pairs (Pellegrini 1997, sections 4.3 and 5.1).
//   In: scene and ids as the engine was made with
//   Error: unbiased at any spacing and number of directions, but for closed forms by polygon: share_sums.h bounds their
//   small bias, and pairs that no
//     line met are guessed from their neighbours (neighbour_shares.h). The standard error is that of independent
//     replicates, or of the guess. Tests: tests/laws/closed_form_test.cpp.
//   Throws: what the engine and callbacks throw, but for Interrupted; Error bad_usage for zero directions, fewer than 2
//   replicates, a goal that is not positive, or directed pairs
//     without what samples them.
//   Cost: replicates x directions projections; memory O(nonzero pairs) beside the engine's.
Estimate estimateFormFactors(Engine& engine, const Scene& scene, const Ids& ids, const EstimateOptions& options);

}  // namespace viewpeel
