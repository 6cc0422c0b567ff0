// A plan sets the number of directions and the lattices that reach a goal in the least time.
#pragma once
#include <memory>

#include "engines/lattice_options.h"
#include "engines/size_groups.h"
#include "estimator/estimate.h"

namespace viewpeel {

// A Plan holds directions, lattices, and the time and error expected of the run.
struct Plan {
  uint32_t directions = 0;         // per replicate
  int finest = 0;                  // resolution that the neediest polygon gets, at least
  std::vector<SizeGroup> groups;   // one: the same lattice for all
  std::unique_ptr<Engine> engine;  // for these groups
  double seconds = 0;              // of counting all replicates of the request, predicted
  double standard_error = 0;  // largest over all form factors, or of its form factor for a relative goal; predicted
  double pilot_seconds = 0;   // spent on pilots
  std::optional<PairLinesSummary> pair_lines;
  // A plan with unoccluded form factors counts too many pairs at every choice that would reach the goal.
  bool counts_too_large = false;
  // The replicates of the run hit these ids at fewer than 5 lattice points, or scanlines, expected. Even the
  // finest lattice is too coarse for them.
  std::vector<uint32_t> barely_covered;
};

// Lattices says which engines a plan may choose among.
struct Lattices {
  EngineFactory make_engine;
  LatticeOptions lattice;  // of all of them, but for resolution and window
  int resolution = 0;      // 0: to be planned
  bool may_group = false;  // whether small polygons may have lattices of their own
  // Engines count by these ids, blocked pairs too, where unoccluded form factors are used (find_prior.h). With nullptr
  // they count by the ids of the plan. The plan refers to them.
  const Ids* face_ids = nullptr;
};

// Makes the engine that counts all groups.    In: ids: the plan's
std::unique_ptr<Engine> makeEngine(const Lattices& lattices, const Scene& scene, const Ids& ids,
                                   const std::vector<SizeGroup>& groups);

// Plans the replicates of estimateFormFactors for its goal: a tolerance, a relative error, or a time. Without a goal
// the tolerance is 1e-3.
//   The variance of one replicate is eq. (23) of docs/method.md. Pilot replicates measure both parts for the entries
//     with the largest variance, as written there. Every direction is counted on two lattices: the covariance of the
//     two sums over replicates is V_directions, and the rest is V_lattice / N.
//   V_lattice follows eq. (24), which gives the lattice that each polygon needs beside the others
//     (tests/device/lattice_check_test.cpp). V_directions falls with N as the pilots show, or as 1 / N^2 (1 / N for iid
//     directions) where one pilot is enough. The time of a direction is measured as well.
//   The plan takes the least time among powers of sqrt(2) of N and of the resolution, with one lattice or with groups
//     (size_groups.h). Where form factors are visibilities times unoccluded ones, the pilot's largest standard error is
//     computed as the run computes it. Both variances are then scaled to it.
//   Another pilot counts on the plan's lattice where the first one could not separate V_directions from the lattice's
//     part. A lattice much finer than those timed is tried before it is chosen. In eight replicates every id gets 100
//     lattice points, or 100 scanlines, as far as the finest lattice allows.
//   In: options: goal, replicates, sampler, seed, drawn_directions    Out: the plan, with its engine
//   Error: a prediction; the run measures its own errors. Pilots and the run have no directions or lattices in common.
//   Throws: what engines throw.
//   Cost: a pilot takes at most about a tenth of the run, or of the time there is, and half a minute. The first has 512
//     directions, or as many as these limits allow, 16 at least.
Plan planEstimate(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices);

// Groups polygons by the lattice that each needs in a plan with these figures.
//   In: base: the resolution of the whole scene
//   finest: the resolution of the neediest polygon. The others get one that makes the lattice variance of their ids no
//     larger, 2 / h ~ (P / A^2)^(1/3).
//   directions: of a replicate; eight replicates are to give every id 100 lattice points, or 100 scanlines
//   Cost: O(n log n).
std::vector<SizeGroup> planGroups(const Scene& scene, const Ids& ids, Sampling sampling, int base, int finest,
                                  double directions);

}  // namespace viewpeel
