// Engine `rays` counts along rays of each polygon's own. Common directions say little of a polygon that few of their
// lines meet, such as a small triangle in a city. Polygons may have different numbers of rays: more where more of what
// leaves the scene is in doubt (plan_rays.h).
//
// A ray starts at a random point of its polygon's front, in a random direction of the cosine law, and ends on the first
// polygon that it meets. Of n_i rays of polygon i the share that ends on fronts of j has the expectation F_ij. Rays of
// i and of j both estimate A_i F_ij = A_j F_ji, with variances near A_i / n_i and A_j / n_j times the same number. The
// mean of least variance is reciprocal: every ray between the two adds 1 / (n_i / A_i + n_j / A_j) to the pair
// (docs/method.md, section 13, rays). Two-sided polygons emit and receive on both sides, whose areas add up.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"

namespace viewpeel {

// Returns whether a scene's polygons are neither too many nor too different in size for rays: numbers of rays times
// areas must fit into counts.
bool suitsRays(const Scene& scene);

// Returns the time that a ray of this polygon takes, over that of others: more than 1 for a sliver, whose rays are in
// double precision.
double costOfRay(const Scene& scene, const Polygon& polygon);

// A RayEngine is an engine that counts along rays.
class RayEngine : public Engine {
 public:
  // Returns the least usual number of rays of a polygon: 2^k or 3 x 2^(k - 1), and at least kLeastRays. Sobol' points
  // are most even for such numbers.
  static uint32_t usualRays(double at_least);
  static constexpr uint32_t kLeastRays = 16;

  // Sets how many rays each polygon has in a call of count(). Of a two-sided polygon one half starts on either side.
  //   In: rays: uint32_t[ids], from usualRays(); count() then must be given as many directions as the largest of them
  virtual void setRays(std::vector<uint32_t> rays) = 0;
  virtual const std::vector<uint32_t>& rays() const = 0;  // as set; empty: as many as directions
  // Returns the number of rays of all polygons in a call of count().
  virtual double raysOfReplicate(size_t directions) const = 0;
  // Lets countOutside() count rays that leave the scene above the horizon as environment, and below it as leak. Rays
  // that end on backs then count for nothing.    In: up: of any length above 0
  virtual void setHorizon(const glm::dvec3& up) = 0;
  // Counts environment and leak alone, as countBlocks() does.
  //   In: blocks: uint32_t[ids], in how many of the first blocks polygons of an id have rays
  virtual std::vector<PairCounts> countOutside(std::span<const Direction> directions, size_t block_directions,
                                               const std::vector<uint32_t>& blocks) = 0;
};

// Returns by id in how many blocks its polygons have rays, as countOutside() takes it: all of them for requested rows,
// and none for others.    In: blocks: their number
std::vector<uint32_t> blocksOfRequested(const Ids& ids, size_t blocks);

// Makes the engine. For each of N directions that it is given, each polygon has one ray, unless setRays() says
// otherwise; N is even where polygons are two-sided. The directions themselves are seeds alone: the same ones give the
// same counts, and other ones independent counts.
//   In: scene, ids: that suitsRays(), of the whole matrix; both are kept by reference; options: it reads thread_count,
//     stop and on_batch
//   Method: Sobol' points in four dimensions, scrambled for each polygon and each call of count() apart
//   Error: counts are unbiased but for rays that start or end within reach of an edge (ray_tree.h): up to 2^-12 of a
//     polygon's rays at each edge (tests/unit/ray_engine_test.cpp)
//   Cost: counting takes some 0.1 to 0.3 us a ray, and less for several blocks at once.
std::unique_ptr<RayEngine> makeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);

}  // namespace viewpeel
