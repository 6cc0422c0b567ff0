// What a run will do: how many directions, how fine a lattice, chosen for the least time to the error asked for.
#pragma once
#include <memory>

#include "engines/lattice_options.h"
#include "engines/size_groups.h"
#include "estimator/estimate.h"

namespace viewpeel {

// The lattice, and what one direction on it takes.
struct Plan {
  uint32_t directions = 0;         // per replicate
  int finest = 0;                  // resolution that the neediest polygon gets, at least
  std::vector<SizeGroup> groups;   // one: the same lattice for all
  std::unique_ptr<Engine> engine;  // for these groups
  double seconds = 0;              // of counting the replicates asked for, predicted
  double standard_error = 0;      // largest over all form factors, or of its form factor for a relative goal; predicted
  double pilot_seconds = 0;       // spent on finding out
  bool counts_too_large = false;  // for closed forms, of all that would get to the goal
  std::vector<uint32_t> barely_met;  // ids that the replicates asked for meet at fewer than 5 lattice points, or
                                     // scanlines, expected: even the finest lattice is too coarse for them
};

// Which engines a plan may choose among.
struct Lattices {
  EngineFactory make_engine;
  LatticeOptions lattice;  // of all of them, but for resolution and window
  int resolution = 0;      // 0: to be planned
  bool may_group = false;  // whether small polygons may have lattices of their own
  // Where closed forms are to be used (visible_share.h) engines count by these, blocked pairs too; nullptr: by the ids
  // that are planned for. Referred to.
  const Ids* face_ids = nullptr;
};

// An engine of these for groups.    In: ids: that are planned for
std::unique_ptr<Engine> makeEngine(const Lattices& lattices, const Scene& scene, const Ids& ids,
                                   const std::vector<SizeGroup>& groups);

// Plans the replicates of estimateFormFactors for its goal: the tolerance, or the relative error, or else the time;
// none of the three: an error of 1e-3.
//   The variance of one replicate is V_directions(N) + V_lattice(h) / N for N directions and spacing h. Pilot
//   replicates measure both: every direction is counted on two lattices, so that the covariance of the two sums over
//   replicates is V_directions and what is left V_lattice / N, for the entries with the largest variance. V_lattice
//   goes with h^3 P / A^2, with scanlines, too (tests/device/lattice_check_test.cpp), which says how fine a lattice
//   each polygon needs beside the others; V_directions falls with N as the pilots show, or as 1 / N^2 (1 / N for iid
//   directions) where one pilot is enough. Time per direction is measured, too. The plan is the least time among powers
//   of sqrt(2) of N and of resolution, with one lattice or groups (size_groups.h). Where form factors are shares of
//   closed forms, made with those of neighbours where few lines tell, the pilot's largest standard error is found as
//   the run does, and both variances are as large together. Where V_directions is not known beside what lattices add,
//   because the pilot's hardly met what the plan's own meets often, another pilot looks on the plan's lattice. Lattices
//   much finer than those timed are tried before they are taken. Every id gets a lattice that it meets at 100 points or
//   more (or 100 scanlines) in eight replicates, so that none goes unseen, as far as the finest lattice there is
//   allows.
//   In: options: goal, replicates, sampler, seed, asked_directions    Out: the plan, with its engine
//   Error: a prediction; what was reached is measured by the run. Directions and lattices of pilots are none of the
//     run's.
//   Throws: what engines throw.
//   Cost: pilots are kept below about a tenth of the run or of the time there is, and half a minute each; the first has
//   512 directions, or what these allow, 16 at least.
Plan planEstimate(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices);

// The groups of polygons that a plan with these figures has.
//   In: base: the resolution of the whole scene; finest: that of the neediest polygon, beside which the others get what
//   makes the lattice variance of their ids
//     no larger, 2 / h ~ (P / A^2)^(1/3); directions: of a replicate, in eight of which every id is to be met at 100
//     lattice points, or by 100 scanlines
//   Cost: O(n log n).
std::vector<SizeGroup> planGroups(const Scene& scene, const Ids& ids, Sampling sampling, int base, int finest,
                                  double directions);

}  // namespace viewpeel
