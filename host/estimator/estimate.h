// An estimate adds replicates of random directions until it reaches a standard error, a time, or a number of
// replicates.
#pragma once
#include <cmath>
#include <functional>
#include <optional>

#include <viewpeel/result.h>

#include "directions/drawn_directions.h"
#include "directions/sampler.h"
#include <viewpeel/engine.h>
#include "interrupted.h"
#include "sums/run_sums.h"

namespace viewpeel {

class FaceExchanges;
class PairSampler;
class RayEngine;

struct EstimateProgress {
  uint64_t replicates = 0;
  // The largest standard error so far is over all form factors. It is infinite without a goal, and before the least
  // number of replicates is done.
  double largest_standard_error = 0;
};

struct EstimateOptions {
  Sampler sampler = Sampler::fibonacci;
  uint32_t directions = 400;  // per replicate; with rays, the most rays of a polygon
  uint32_t replicates = 8;    // the least number of replicates
  bool is_exact = false;      // the run ends after `replicates`, even if its goal is not reached
  // The run adds replicates until the largest standard error is at most this.
  std::optional<double> tolerance;
  // A second goal is the largest standard error relative to the form factor, over form factors of at least
  // `relative_floor`.
  std::optional<double> relative;
  double relative_floor = 0.01;
  // A goal without the others: the root mean square of the errors in sums of all form factors between rows, zeros
  // included.
  std::optional<double> rms;
  // The run starts no replicate that would end after this time, even if fewer than `replicates` are done. A run has two
  // replicates at least, and a resumed run counts one more at least.
  std::optional<double> seconds;
  // Whether the time is the goal: `tolerance` says how fine the lines are, and the run goes on while time is left.
  bool is_timed = false;
  uint64_t seed = 1;
  // The plan takes so few directions that a replicate has about this number of counts at most. A pilot keeps so few
  // pairs that it needs no more memory.
  double most_counts = INFINITY;
  // Draws the `count` directions of a replicate in place of the sampler. If it draws none, every form factor is 0.
  std::function<DrawnDirections(uint32_t count, uint64_t replicate)> drawn_directions;
  uint64_t first_replicate = 0;
  // The run continues from these sums, whose replicates count towards `replicates`. The sums hold first_replicate and
  // the replicates after it, of the same scene, ids and options. May be nullptr.
  const RunSums* resumed = nullptr;
  RayEngine* rays = nullptr;         // the engine, where it counts along rays (ray_engine.h)
  std::vector<double> line_steps{};  // by id, as in ReplicateSums::setLineSteps()
  // With a prior (find_prior.h) the engine and its ids must be by face, and the goals and the result are for the rows
  // of `by`. May be nullptr.
  const Prior* prior = nullptr;
  // Computes the unoccluded form factors of pairs outside the prior. With nullptr these pairs are only counted.
  FaceExchanges* exchanges = nullptr;
  By by = By::polygon;  // of the result, and of the goals
  // Counts directed pairs (directed_pairs.h), for the same scene, ids and seed. With nullptr no pair has directions of
  // its own.
  PairSampler* pairs = nullptr;
  std::function<void(const EstimateProgress&)> on_replicate;  // may be empty
  // Receives the sums after every replicate. When the run ends, even by an error, it receives them once more with
  // `last`. May be empty.
  std::function<void(const RunSums& sums, bool last)> on_sums;

  // Returns whether an error ends the run.
  bool hasErrorGoal() const { return tolerance || relative || rms; }
  // Returns the error that the goals allow a form factor; infinite where they say nothing of it.
  double allowedError(double form_factor) const;
  // Returns the least error that the goals allow any form factor; infinite without a goal.
  double leastAllowedError() const;
};

// Returns the form factors without the entries of blockers (Ids::only_blocks). Lines end on blockers so that the
// environment of a row does not hold them, but blockers have no rows or columns.
FormFactors withoutBlockers(FormFactors form_factors);
// Returns the form factors without the entries that are 0.
FormFactors keepSeen(FormFactors form_factors);

// Makes the estimate from the sums of all replicates.    In: row: as in PriorSums    Cost: O(nonzeros).
Estimate makeEstimate(const RunSums& sums, double relative_floor, const ExchangeRow& row = {});
// Makes the same estimate where sums.formFactors(row) has been computed before, as `all`.
Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all);

// Computes F_ij = (2 / A_i) E[A'_ij(u)] for all pairs (Pellegrini 1997, sections 4.3 and 5.1).
//   In: scene, ids: as the engine has them
//   Error: unbiased at any spacing and number of directions, but for unoccluded form factors by polygon. Their small
//     bias is bounded in visibility_sums.h, and pairs that no line hit are guessed from their neighbours
//     (neighbour_visibility.h). The standard error comes from the spread of independent replicates; a guess brings its
//     own. Tests: tests/laws/closed_form_test.cpp.
//   Throws: whatever the engine and the callbacks throw, except Interrupted; Error bad_usage for zero directions, fewer
//     than 2 replicates, a goal that is not positive, or directed pairs (directed_pairs.h) in options.resumed where
//     options.pairs is nullptr.
//   Cost: replicates x directions projections, and O(nonzero pairs) of memory beside the engine's.
Estimate estimateFormFactors(Engine& engine, const Scene& scene, const Ids& ids, const EstimateOptions& options);

}  // namespace viewpeel
