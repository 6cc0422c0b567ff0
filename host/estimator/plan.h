// A plan sets the number of directions and the lattices that reach a goal in the least time.
#pragma once
#include <memory>
#include <optional>

#include "engines/lattice_options.h"
#include "engines/size_groups.h"
#include "estimator/estimate.h"

namespace viewpeel {

// A Plan holds directions, lattices, and the time and error expected of the run.
struct Plan {
  uint32_t directions = 0;         // per replicate
  int finest = 0;                  // resolution of the finest lattice, for the polygon that needs it most
  std::vector<SizeGroup> groups;   // a single group: all polygons share one lattice
  std::unique_ptr<Engine> engine;  // for these groups
  double seconds = 0;              // predicted time to count all replicates of the request
  double standard_error = 0;  // predicted largest over all form factors; a share of the form factor for relative goals
  double pilot_seconds = 0;   // spent on pilots
  std::optional<PairLinesSummary> pair_lines;
  // It is true where every choice that reaches the goal would overflow the sums of unoccluded form factors.
  bool counts_too_large = false;
  // All replicates together are expected to hit these ids at fewer than 5 lattice points, or scanlines. Even the finest
  // lattice is too coarse for such an id.
  std::vector<uint32_t> barely_covered;
};

// DirectionCosts predict the processor seconds of a direction.
struct DirectionCosts {
  double of_group = 0, of_point = 0;  // for each group of polygons, and for each lattice point or scanline
};

// Lattices describes the engines that a plan may choose among.
struct Lattices {
  EngineFactory make_engine;
  LatticeOptions lattice;  // options of every engine; the plan sets resolution and window
  int resolution = 0;      // 0: the plan chooses it
  bool may_group = false;  // whether small polygons may have lattices of their own
  // Where unoccluded form factors are used (find_prior.h), engines count by these ids, and count blocked pairs, too.
  // With nullptr engines count by the ids of the plan. The ids must outlive the plan.
  const Ids* face_ids = nullptr;
  // Where costs are given, the plan depends on the scene and the seed alone. Else the pilots measure times.
  std::optional<DirectionCosts> costs{};
};

// Makes the engine that counts all groups.    In: ids: the plan's
std::unique_ptr<Engine> makeEngine(const Lattices& lattices, const Scene& scene, const Ids& ids,
                                   const std::vector<SizeGroup>& groups);

// Plans the replicates of estimateFormFactors for its goal: a tolerance, a relative error, a root mean square, or a
// time. Without a goal the tolerance is 1e-3.
//   The variance of one replicate is eq. (23) of docs/method.md. Pilot replicates measure both parts for the entries
//     with the largest variance, as written there. Every direction is counted on two lattices: the covariance of the
//     two sums over replicates is V_directions, and the rest is V_lattice / N.
//   V_lattice follows eq. (24), which gives the lattice that each polygon needs (tests/device/lattice_check_test.cpp).
//     V_directions falls with N by eq. (23a), or as 1 / N for iid directions. The pilots also measure the time of a
//     direction.
//   The plan tries powers of sqrt(2) for N and for the resolution, with one lattice or with groups (size_groups.h), and
//     takes the choice of least time. Where form factors are visibilities times unoccluded form factors, the pilot's
//     largest standard error is computed as the run computes it. Both variances are then scaled to it.
//   If the first pilot could not separate V_directions from V_lattice, another pilot counts on the plan's lattice. A
//     lattice much finer than every timed lattice is timed before it is chosen. In eight replicates every id gets 100
//     lattice points, or 100 scanlines, as far as the finest lattice allows.
//   In: options: goal, replicates, sampler, seed, drawn_directions; most_seconds: a run that takes longer is not
//     planned
//   Out: the plan, with its engine; without an engine where the run would take longer than most_seconds
//   Error: time and error are predictions; the run measures its own errors. The run uses no direction and no lattice of
//     a pilot.
//   Throws: whatever engines throw.
//   Cost: a pilot takes at most half a minute, and about a tenth of the run or of the given time. The first has 512
//     directions, or as many as these limits allow, but at least 16.
Plan planEstimate(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices,
                  double most_seconds = INFINITY);

// Groups polygons by the lattice that each needs.
//   In: base: the resolution of the whole scene's lattice
//     finest: the resolution of the polygon that needs the finest lattice. Every other polygon gets a resolution 2 / h
//     ~ (P / A^2)^(1/3), with P and A the perimeter and area of its id. Then the lattice variance of this id is no
//     larger.
//     directions: the directions of a replicate. Eight replicates are to give every id 100 lattice points, or 100
//     scanlines.
//   Cost: O(n log n).
std::vector<SizeGroup> planGroups(const Scene& scene, const Ids& ids, Sampling sampling, int base, int finest,
                                  double directions);

}  // namespace viewpeel
