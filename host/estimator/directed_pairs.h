// Directed pairs are pairs of faces that common directions hardly hit. They are sampled by further directions, along
// which a line can reach one face from the other.
//
// All lines between two faces lie along the directions of a region W of the half sphere (findPairRegion). Eq. (10) of
// docs/method.md estimates the exchange area from directions uniform in W, and eq. (25) gives the area that one counted
// point stands for, facing or blocked. With this area eq. (17) is unbiased if W, the number of directions, the spacing
// and the visibility b are fixed beforehand. Pilots fix them, with other random numbers than the run. In the run the
// form factor of a directed pair comes from its directions alone, in every replicate; every other pair uses common
// directions alone. So no choice depends on the run's counts.
//
// A directed pair has the run's replicates and separate random numbers. Counts are a function of seed, pair and
// replicate number, and add up as integers. Row sums, environment and leak stay with the common directions. Tests:
// tests/device/directed_pairs_test.cpp; coverage: bench/programs/coverage.cpp, scene `gap`.
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

constexpr double kEmitterSpacings = 16;  // lattice spacings in the square root of the emitter's area

struct EstimateOptions;

// A PairSampler counts directed pairs. The smaller face of a pair is the emitter. Pairs of one emitter and resolution
// share an engine, whose window is around the emitter.
class PairSampler {
 public:
  // Makes a sampler without engines, which prepare() makes as pairs need them.
  //   In: scene, face_ids: kept by reference; face_ids: by face, without roles; lattice: for all engines, but
  //     resolution, window and blocked pairs depend on the pair; finest: finest resolution of an engine
  PairSampler(const Scene& scene, const Ids& face_ids, uint64_t seed, EngineFactory make_engine,
              LatticeOptions lattice = {}, int finest = kMaxWindowResolution);

  // Returns the pair with this number of directions a replicate, and a lattice of 16 spacings in the root of the
  // emitter's area. It has 0 directions where no line can reach one face from the other. It has 0, too, where the
  // direction of a line decides which of two coincident polygons comes first (Coincidences::alike_unordered).
  // Directions of a pair come without their opposites, which would make up for such an order.
  DirectedPair direct(uint32_t i, uint32_t j, uint32_t directions);
  // Makes the engines that these pairs need and that do not exist yet, and sets the area that one count stands for.
  void prepare(std::span<DirectedPair> pairs);
  // Returns the number of engines that the pairs need.
  size_t countEngines(std::span<const DirectedPair> pairs) const;
  // Counts a pair along its directions in one replicate.    In: pair: prepared    Throws: as its engine.
  PairCount count(const DirectedPair& pair, uint64_t replicate);
  // Counts all pairs, in their order.
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
  std::vector<std::vector<uint32_t>> polygons_;  // by face
  std::map<Key, DirectionRegion> regions_;       // by pair
  std::map<Key, Part> parts_;                    // by emitter and resolution
};

// CommonPilots holds the counts of the pilots along common directions, before the run.
struct CommonPilots {
  // Counts of each pilot, with rows. Visibilities from one half of the pilots are used for the other half.
  const std::vector<PairCounts>& counts;
  uint32_t directions = 0;  // of each pilot
  double count_area = 0;    // area, input units squared, that one count stands for along its direction
};

// Returns the pairs that prevent a run from reaching its goal, if it gets there sooner with them as directed pairs
// (docs/method.md, section 8).
//   The text before eq. (26) gives the error of a pair after R replicates, and the least variance of a pair that few
//     directions hit. Where no line counted, the error is at least that of an unmet pair (ControlVariateSums). Pairs of
//     polygons that were never seen blocked are treated in the same way, if there are at most 8 of them. Eq. (26) gives
//     the number of pairs, and pilots of each pair give its number of directions M.
//   In: options: goals, replicates, directions, seed
//   Out: sorted by pair; none without a goal, and where it would save less than a fifth of the work. The choice is a
//     function of counts and options, not of time, so parts of a run choose alike.
//   Cost: O(pairs of the prior log) and 128 directions for each pair tried.
std::vector<DirectedPair> chooseDirectedPairs(PairSampler& sampler, const Ids& face_ids, const Prior& prior,
                                              const CommonPilots& pilots, const EstimateOptions& options);

}  // namespace viewpeel
