// Pairs of faces that common directions hardly meet, sampled on purpose by further directions inside their anti-convex
// hulls.
//
// All lines between two faces lie along the directions of a region W of the half sphere (findPairRegion). With M
// directions uniform in W, on a lattice of spacing h,
//   C_ij = E[A'_ij(u)] = |W| / (2 pi) E[A'_ij(u) | u in W],
// so that a point counted stands for h^2 |W| / (2 pi M), blocked points as well: V - b (V + O - F0_ij)
// (find_prior.h) is unbiased, whatever W, M, h and b are, as long as they are fixed beforehand. They are: which
// pairs have directions of their own, how many, and their b come from pilots, whose random numbers are none of the
// run's. In the run the form factor of such a pair is made of its own directions alone, in every replicate, and that of
// every other pair of common directions alone: no rule looks at what it then sums. A weighted mean of both would be
// unbiased, too, but of two variances, one of which is many times the other, it gains nothing.
//
// Replicates of a pair are those of the run, with random numbers of their own: counts are a function of seed, pair and
// number of the replicate, and add up as integers. Row sums, environment and leak stay those of common directions.
// Tests: tests/device/directed_pairs_test.cpp; coverage: bench/programs/coverage.cpp, scene `gap`.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "directions/drawn_directions.h"
#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "sums/prior_sums.h"

namespace viewpeel {

struct EstimateOptions;

// Counts pairs along directions of their own. The smaller face of a pair is the emitter: its pairs share an engine,
// whose window is around it.
class PairSampler {
 public:
  //   In: scene, ids by face, without roles: both are referred to; lattice: of all engines, but for resolution, window
  //   and blocked pairs, which are of each pair;
  //     finest: the finest lattice that engines may have
  PairSampler(const Scene& scene, const Ids& face_ids, uint64_t seed, EngineFactory make_engine,
              LatticeOptions lattice = {}, int finest = kMaxWindowResolution);

  // The pair with so many directions a replicate, and a lattice of 16 spacings in the root of the emitter's area; 0
  // directions where no line can tell of it, or where directions decide which of two coincident polygons a line meets
  // first (Coincidences::alike_unordered): those of a pair have no opposite ones to make up for it.
  DirectedPair direct(uint32_t i, uint32_t j, uint32_t directions);
  // Makes what engines are missing, for all these pairs at once, and sets what a count of each stands for.
  void prepare(std::span<DirectedPair> pairs);
  // How many engines pairs need.
  size_t countEngines(std::span<const DirectedPair> pairs) const;
  // What the pair's own directions of one replicate see.    In: as prepared    Throws: what engines throw.
  PairCount count(const DirectedPair& pair, uint64_t replicate);
  // Of all, in their order.
  PairCounts count(std::span<const DirectedPair> pairs, uint64_t replicate);

 private:
  using Key = std::pair<uint32_t, uint32_t>;
  struct Part {
    std::vector<uint32_t> partners;  // sorted
    Ids ids;
    std::unique_ptr<Engine> engine;
  };
  uint32_t emitterOf(uint32_t i, uint32_t j) const { return face_ids_.areas[j] < face_ids_.areas[i] ? j : i; }
  Key partKey(const DirectedPair& pair) const { return {emitterOf(pair.i, pair.j), pair.resolution}; }
  const DirectionRegion& regionOf(Key pair);
  Ids idsOf(uint32_t emitter, const std::vector<uint32_t>& partners) const;

  const Scene& scene_;
  const Ids& face_ids_;
  uint64_t seed_;
  EngineFactory make_engine_;
  LatticeOptions lattice_;
  int finest_;
  std::vector<std::vector<uint32_t>> polygons_;  // of faces
  std::map<Key, DirectionRegion> regions_;       // of pairs
  std::map<Key, Part> parts_;                    // by emitter and resolution
};

// What is known of common directions before the run.
struct CommonPilots {
  const std::vector<PairCounts>&
      counts;               // of each, with rows; half of them and the other half tell visibilities for each other
  uint32_t directions = 0;  // of each
  double count_area = 0;    // input units squared of one count along its direction
};

// The pairs that keep a run from its goal, if directions of their own bring it there sooner.
//   A replicate of N common directions leaves a pair with a variance v, and one line with l, so that R replicates have
//   the error min(most, sqrt(v / R + (l / R)^2)); where no line told, l / R is not less than an unmet pair's error
//   (ControlVariateSums). Of a pair that few directions meet, N F0 / 2 < 3, half of these may see it, whatever pilots
//   saw: v is not less than F0^2 / (4 N F0 / 2). That is looked into also where no polygon of the pair was seen
//   blocked, if it concerns 8 pairs at most. Sorted by the replicates R_k that each needs, the first k get directions
//   of their own, such that
//     max(R_0, R_k) (N w + sum M w') + engines + pilots
//   is least, w and w' being the work of a direction of either kind by numbers of polygons and lattice points, and R_0
//   the replicates asked for. M is what brings a pair below half of the goal in R_0 replicates, by pilots of its own.
//   In: options: goals, replicates, directions, seed
//   Out: sorted; none without a goal, and where that would save less than a fifth of the work. A function of counts and
//   options alone, not of time: parts of a run choose alike.
//   Cost: O(known pairs log) and 128 directions for each pair tried.
std::vector<DirectedPair> chooseDirectedPairs(PairSampler& sampler, const Ids& face_ids, const Prior& prior,
                                              const CommonPilots& pilots, const EstimateOptions& options);

}  // namespace viewpeel
