// Plans: the number of directions and the lattices that reach a goal in the least time.
#pragma once
#include <memory>

#include "engines/lattice_options.h"
#include "engines/size_groups.h"
#include "estimator/estimate.h"

namespace viewpeel {

// A plan: directions, lattices, and what the run is expected to take.
struct Plan {
  uint32_t directions = 0;         // per replicate
  int finest = 0;                  // resolution that the neediest polygon gets, at least
  std::vector<SizeGroup> groups;   // one: the same lattice for all
  std::unique_ptr<Engine> engine;  // for these groups
  double seconds = 0;              // of counting the replicates asked for, predicted
  double standard_error = 0;  // largest over all form factors, or of its form factor for a relative goal; predicted
  double pilot_seconds = 0;   // spent on finding out
  std::optional<PairLinesSummary> pair_lines;
  bool counts_too_large = false;         // for unoccluded form factors, of all that would get to the goal
  std::vector<uint32_t> barely_covered;  // ids that the replicates asked for meet at fewer than 5 lattice points, or
                                         // scanlines, expected: even the finest lattice is too coarse for them
};

// Which engines a plan may choose among.
struct Lattices {
  EngineFactory make_engine;
  LatticeOptions lattice;  // of all of them, but for resolution and window
  int resolution = 0;      // 0: to be planned
  bool may_group = false;  // whether small polygons may have lattices of their own
  // Where unoccluded form factors are to be used (find_prior.h) engines count by these, blocked pairs too; nullptr: by
  // the ids that are planned for. Referred to.
  const Ids* face_ids = nullptr;
};

// Makes the engine that counts all groups.    In: ids: those planned for
std::unique_ptr<Engine> makeEngine(const Lattices& lattices, const Scene& scene, const Ids& ids,
                                   const std::vector<SizeGroup>& groups);

// Plans the replicates of estimateFormFactors for its goal: a tolerance, a relative error, or a time; without any of
// them an error of 1e-3.
//   The variance of one replicate is V_directions(N) + V_lattice(h) / N for N directions and spacing h. Pilot
//   replicates measure both for the entries with the largest variance. Every direction is counted on two lattices: the
//   covariance of the two sums over replicates is V_directions, and the rest is V_lattice / N.
//   V_lattice is proportional to h^3 P / A^2, with scanlines, too (tests/device/lattice_check_test.cpp). This gives the
//   lattice that each polygon needs beside the others. V_directions falls with N as the pilots show, or as 1 / N^2 (1 /
//   N for iid directions) where one pilot is enough. The time of a direction is measured as well.
//   The plan takes the least time among powers of sqrt(2) of N and of the resolution, with one lattice or with groups
//   (size_groups.h). Where form factors are visibilities times unoccluded ones, the pilot's largest standard error is
//   computed as the run computes it, and both variances are scaled to it.
//   Another pilot counts on the plan's lattice where the first one could not separate V_directions from the lattice's
//   part. A lattice much finer than those timed is tried before it is chosen. In eight replicates every id gets 100
//   lattice points, or 100 scanlines, as far as the finest lattice allows.
//   In: options: goal, replicates, sampler, seed, drawn_directions    Out: the plan, with its engine
//   Error: a prediction; the run measures its own errors. Pilots and the run have no directions or lattices in common.
//   Throws: what engines throw.
//   Cost: a pilot takes at most about a tenth of the run, or of the time there is, and half a minute. The first has 512
//   directions, or what these limits allow, 16 at least.
Plan planEstimate(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices);

// Groups polygons by the lattice that each needs in a plan with these figures.
//   In: base: the resolution of the whole scene
//     finest: that of the neediest polygon; the others get what makes the lattice variance of their ids no larger,
//       2 / h ~ (P / A^2)^(1/3)
//     directions: of a replicate; eight replicates are to give every id 100 lattice points, or 100 scanlines
//   Cost: O(n log n).
std::vector<SizeGroup> planGroups(const Scene& scene, const Ids& ids, Sampling sampling, int base, int finest,
                                  double directions);

}  // namespace viewpeel
