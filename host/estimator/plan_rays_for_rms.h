// An RmsRayPlanner says how many rays of its own each polygon needs (ray_engine.h) where the goal is the root mean
// square of all errors.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>
#include "estimator/estimate.h"
#include "rays/ray_engine.h"

namespace viewpeel {

// Lines may have this part of the sum of squares of all errors, and rays the rest.
constexpr double kLinesOfSquares = 0.1;

class RmsRayPlanner {
 public:
  // Casts a pilot of a few rays of each polygon.
  //   In: engine: counts by face; face_ids: kept by reference; seed: of the run
  RmsRayPlanner(RayEngine& engine, const Scene& scene, const Ids& face_ids, uint64_t seed);
  // Returns what environments add to the sum of form factors that rays count (raysForRms). The goal does not say how
  // much an environment may err. Its square is taken to be one more among those of its row.
  double environments() const;
  // Returns how many rays each face has in a replicate.
  //   In: with_lines: pairs that rays do not count, sorted; options: rms, replicates
  //   Out: a function of scene, seed, pairs and options
  //   Method: the number of rays is least where one ray more lessens the sum of squares by the same for all faces:
  //     docs/method.md, eq. (48c).
  std::vector<uint32_t> plan(const std::vector<LinePair>& with_lines, const EstimateOptions& options) const;

 private:
  // A Square is what one ray for each unit of area would leave of the squares of the errors of F_ij and F_ji.
  struct Square {
    uint32_t i, j;
    double size;
  };
  double sum(const std::vector<Square>& pairs, const std::vector<double>& rays) const;
  std::vector<double> gains(const std::vector<Square>& pairs, const std::vector<double>& rays) const;
  double densityOf(const Square& of, const std::vector<double>& rays) const {
    return rays[of.i] / polygon_areas_[of.i] + rays[of.j] / polygon_areas_[of.j];
  }

  const Ids& face_ids_;
  std::vector<double> polygon_areas_;  // by face, mean area of its polygons
  std::vector<Square> squares_;        // of pairs, sorted
  std::vector<double> environments_;   // by face, what one ray of each polygon would leave of the square
};

}  // namespace viewpeel
