// A RayPlanner says how many rays of its own each polygon needs (ray_engine.h).
//
// Rays mostly go into the environment. How much a row's environment errs depends on the row: that of a roof without a
// taller neighbour is nearly certain. A pilot of a few rays measures these errors.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>
#include "estimator/estimate.h"
#include "rays/ray_engine.h"

namespace viewpeel {

// The pilot has kRayPilotReplicates of kPilotRays rays of each polygon.
constexpr uint32_t kPilotRays = 32, kRayPilotReplicates = 8;

// Standard errors of environments by rays come from few replicates, and every row just keeps to the goal. So the
// tolerance holds this multiple of the errors that it would hold if they were certain and normal: with 1, it was
// exceeded in 6 and 9 of 100 runs of a city of 2,892 triangles, at 0.1 and 0.03.
constexpr double kRayMargin = 1.15;

// No face has more rays in a replicate, nor fewer than this share of the most: its rays count its pairs and see its
// environment, whatever the goal is about.
constexpr uint32_t kMostRaysOfRow = 1 << 20;
constexpr double kLeastShareOfRays = 1.0 / 8;

// PlannedRays are numbers of rays in a replicate, uint32_t[faces] as RayEngine::setRays() takes them.
struct PlannedRays {
  std::vector<uint32_t> outside;  // so that most rows have their environment and leak within the goals
  // These numbers keep form factors between surfaces within the goals, too, where rays count all pairs. Empty unless
  // mayHaveRaysAlone().
  std::vector<uint32_t> alone;
};

// Returns whether rays may count all pairs: the goal is a tolerance between surfaces, which are sums of many pairs.
bool mayHaveRaysAlone(const EstimateOptions& options);

// Guesses how many rays PlannedRays::alone has of all polygons in all replicates, without a pilot: the largest form
// factor of each surface is taken to be a half, and environments to need no more rays.
//   In: options: mayHaveRaysAlone() is true of them
//   Error: in three cities at 0.03 to 0.003 the guess was 1 to 1.5 times the number then planned
double guessRaysAlone(const Ids& face_ids, const EstimateOptions& options);

class RayPlanner {
 public:
  // Casts the pilot.
  //   In: engine: counts by face, all faces with equal numbers of rays; row_of_face: uint32_t[faces], the row of
  //     the result; seed: of the run; counts_pairs: whether PlannedRays::alone is wanted
  RayPlanner(RayEngine& engine, const Scene& scene, const Ids& face_ids, std::vector<uint32_t> row_of_face,
             uint64_t seed, bool counts_pairs);
  // Returns how many rays each face has in a replicate.
  //   In: options: goals, replicates    Out: a function of scene, seed and options
  //   Error: the pilot is rough, so that some rows need more replicates.
  PlannedRays plan(const EstimateOptions& options) const;

 private:
  // A Row sums up what the pilot's rays have found about one row: its environment, or its leak.
  struct Row {
    double sum = 0, squares = 0;  // of its shares in each replicate

    double variance() const;
    double binomial(double rays) const;
  };
  double raysOf(size_t row) const;

  std::vector<uint32_t> row_of_face_;
  std::vector<double> areas_, square_areas_;  // by row: sums of its faces' areas, and of their squares
  std::vector<Row> environment_, leak_;       // by row
  std::vector<double> largest_;               // by row: its largest form factor to a row of at least its area; or none
  double efficiency_ = 1;                     // variances of environments and leaks, over those of independent rays
};

}  // namespace viewpeel
