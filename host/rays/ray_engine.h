// Engine `rays` counts along rays of each polygon's own. Common directions say little of a polygon that few of their
// lines meet, such as a small triangle in a city; each polygon has the same number of rays.
//
// A ray starts at a random point of its polygon, in a random direction of the cosine law, and ends on the first polygon
// that it meets. Of N rays of polygon i the share that ends on fronts of j has the expectation F_ij. Rays of i and of j
// both estimate A_i F_ij = A_j F_ji, with variances near A_i and A_j times the same number. The mean of the two with
// weights A_j and A_i has the least variance, and is reciprocal: every ray between the two adds A_i A_j / (A_i + A_j) /
// N to the pair (docs/method.md, section 13, rays).
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"

namespace viewpeel {

// Returns whether rays may be used: polygons emit on one side, and are not too small for single precision.
bool suitsRays(const Scene& scene, const Ids& ids);

// Makes the engine. For each of N directions that it is given, each polygon has one ray. The directions themselves are
// seeds alone: the same ones give the same counts, and other ones independent counts.
//   In: scene, ids: that suitsRays(), of the whole matrix; both are kept by reference; options: it reads thread_count,
//     stop and on_batch
//   Method: Sobol' points in four dimensions, scrambled for each polygon and each call of count() apart
//   Error: counts are unbiased but for rounding to single precision, which moves starts and edges by up to kRayReach
//   Cost: count() of N directions takes some 0.1 to 0.3 us a ray.
std::unique_ptr<Engine> makeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);

}  // namespace viewpeel
