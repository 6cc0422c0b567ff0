// A leak is a line that leaves the front of one polygon and ends on the back of another. The functions here find leaks
// by casting rays, and guess their cause.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A LeakCause says why lines of one surface end on the backs of another.
enum class LeakCause {
  flipped,    // one of the two surfaces, or its shell, is turned the wrong way
  overlap,    // the two surfaces overlap in one plane and look the same way
  enclosed,   // a part of `from` lies inside a closed solid
  no_bottom,  // a part of `from` lies under a shell that is open towards it
  one_sided,  // `onto` is a sheet that is visible from both sides
  gap,        // none of the other causes fits
};

struct Leak {
  uint32_t from, onto;  // indices into Scene::surfaces
  LeakCause cause;
  uint32_t culprit;    // the surface, `from` or `onto`, that the user should change
  double share;        // share of this leak in all radiation that ends on backs
  double hidden_area;  // area of `from` from which the rays to all sides end on backs, input units squared
};

// FrontRays says where rays from fronts ended.
struct FrontRays {
  uint64_t rays = 0, backs = 0, escaped = 0;
  std::vector<Leak> leaks;  // largest share first
  double backShare() const { return rays ? double(backs) / double(rays) : 0; }
};

// Casts rays from the fronts of all polygons.
//   In: weights: double[polygon], the share of rays that start on each polygon, such as its count of leaking lines;
//     empty: rays start uniformly over the area. Weights change which leaks are found, and how exactly, but no share
//   Error: shares are good to about 1e-2. A leak of less than about 1e-4 of all lines is not found. Every run casts the
//     same rays.
//   Cost: O(edges log edges) and some 10^4 rays.
FrontRays followFronts(const Scene& scene, const std::vector<double>& weights = {});

// Returns a line for each cause and culprit, with the option or change that mends it. The largest leak comes first.
std::vector<std::string> describeLeaks(const Scene& scene, const std::vector<Leak>& leaks);

// Returns the cause of the largest leak, with its share of the leak and the option or change that mends it. It has no
// file name.    Out: empty where no ray from a front ends on a back
std::string explainLargestLeak(const Scene& scene);

// Returns warnings, one line each, about backs that fronts see, or about a scene in which no front sees another front.
// Callers use it before anything is computed.    Out: empty where all is well
std::vector<std::string> warnOfBacks(const Scene& scene);

// Describes the scene as "closed" or "open", and as "leaking", from a few hundred rays from fronts. It adds a remark
// where the edges of the polygons suggest something else (isClosed).
//   Cost: O(edges log edges).
std::string describeClosedness(const Scene& scene);

}  // namespace viewpeel
