// An estimate adds replicates of random directions until it reaches a standard error, a time, or a number of
// replicates.
#pragma once
#include <functional>
#include <optional>

#include <viewpeel/result.h>

#include "directions/drawn_directions.h"
#include "directions/sampler.h"
#include <viewpeel/engine.h>
#include "sums/run_sums.h"

namespace viewpeel {

class FaceExchanges;
class PairSampler;

// A callback of an engine (on_batch) or of the estimator throws this to stop a run. The replicate in progress is
// dropped.
struct Interrupted {};

struct EstimateProgress {
  uint64_t replicates = 0;
  // It is the largest over all form factors up to now. It is infinite without a goal, and before the least number of
  // replicates is done.
  double largest_standard_error = 0;
};

struct EstimateOptions {
  Sampler sampler = Sampler::fibonacci;
  uint32_t directions = 400;  // per replicate
  uint32_t replicates = 8;    // at least
  bool is_exact = false;      // no more than `replicates`, even short of a goal
  // The run ends where the largest standard error is this. Replicates beyond `replicates` are added for it.
  std::optional<double> tolerance;
  // A second goal is the largest standard error relative to the form factor, over form factors of at least
  // `relative_floor`.
  std::optional<double> relative;
  double relative_floor = 0.01;
  // This is the time after which no further replicate ends, even if fewer than `replicates` are done. Two are done at
  // least, and one in this call.
  std::optional<double> seconds;
  uint64_t seed = 1;
  // Draws the `count` directions of a replicate in place of the sampler. If it draws none, every form factor is 0.
  std::function<DrawnDirections(uint32_t count, uint64_t replicate)> drawn_directions;
  uint64_t first_replicate = 0;
  // The run continues from these sums, which count towards `replicates`. They are of first_replicate and its
  // successors, of the same scene, ids and options. May be nullptr.
  const RunSums* resumed = nullptr;
  // The prior (find_prior.h) needs an engine and ids by face; goals and result are for the rows of `by`. May be
  // nullptr.
  const Prior* prior = nullptr;
  // Computes unoccluded form factors of pairs outside the prior; nullptr: such pairs are counted.
  FaceExchanges* exchanges = nullptr;
  By by = By::polygon;  // of the result, and of the goals
  // Counts pairs along separate directions (directed_pairs.h), for the same scene, ids and seed; nullptr: no pair has
  // separate directions.
  PairSampler* pairs = nullptr;
  std::function<void(const EstimateProgress&)> on_replicate;  // may be empty
  // Receives the sums after every replicate, and once more with `last` when the run ends, also by an error; may be
  // empty.
  std::function<void(const RunSums& sums, bool last)> on_sums;
};

// Returns the form factors without entries of 0.
FormFactors keepSeen(FormFactors form_factors);

// Makes the estimate of all replicates counted.    In: row: as in PriorSums    Cost: O(nonzeros).
Estimate makeEstimate(const RunSums& sums, double relative_floor, const ExchangeRow& row = {});
// Makes the same estimate from form factors that sums.formFactors(row) has made already.
Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all);

// Computes F_ij = (2 / A_i) E[A'_ij(u)] for all pairs (Pellegrini 1997, sections 4.3 and 5.1).
//   In: scene and ids as the engine was made with
//   Error: unbiased at any spacing and number of directions, but for unoccluded form factors by polygon. Their small
//     bias is bounded in visibility_sums.h, and pairs that no line hit are guessed from their neighbours
//     (neighbour_visibility.h). The standard error is of independent replicates, or of the guess. Tests:
//     tests/laws/closed_form_test.cpp.
//   Throws: all that the engine and callbacks throw, but for Interrupted; Error bad_usage for zero directions, fewer
//     than 2 replicates, a goal that is not positive, or directed pairs without a sampler of them.
//   Cost: replicates x directions projections; memory O(nonzero pairs) beside the engine's.
Estimate estimateFormFactors(Engine& engine, const Scene& scene, const Ids& ids, const EstimateOptions& options);

}  // namespace viewpeel
