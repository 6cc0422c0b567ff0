// A leak is a line that leaves a front and ends on a back. Rays find the two polygons and, as far as they can, the
// cause.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A LeakCause says why lines of one surface end on the backs of another.
enum class LeakCause {
  flipped,    // one of the two, or its shell, is turned the wrong way
  overlap,    // the two lie over each other in one plane and look the same way
  enclosed,   // part of the one lies inside a closed solid
  no_bottom,  // part of the one lies under a shell that is open towards it
  one_sided,  // the other one is a sheet that is seen from both sides
  gap,        // none of the other causes
};

struct Leak {
  uint32_t from, onto;  // Scene::surfaces
  LeakCause cause;
  uint32_t culprit;    // the one of the two to change
  double share;        // of all rays that ended on backs
  double hidden_area;  // of `from`, from which rays to all sides end on backs, input units squared
};

// FrontRays counts the ends of rays from fronts.
struct FrontRays {
  uint64_t rays = 0, backs = 0, escaped = 0;
  std::vector<Leak> leaks;  // largest share first
  double backShare() const { return rays ? double(backs) / double(rays) : 0; }
};

// Follows rays from fronts: uniform over them by area, or by weights, such as the counts of leaking lines.
//   In: weights: of Scene::polygons; areas where empty
//   Error: of shares some 1e-2; leaks of less than some 1e-4 of the lines are not found. The same in every run.
//   Cost: O(edges log edges) and some 10^4 rays.
FrontRays followFronts(const Scene& scene, const std::vector<double>& weights = {});

// Describes each cause and culprit in a line, with the option or change that mends it, the largest first.
std::vector<std::string> describeLeaks(const Scene& scene, const std::vector<Leak>& leaks);

// Warns about backs that fronts see, before anything is computed. It warns, too, where no front sees another one. Empty
// where all is well.
std::vector<std::string> warnOfBacks(const Scene& scene);

// Returns "closed" or "open" and "leaking" by a few hundred rays from fronts, and whether edges say otherwise.
//   Cost: O(edges log edges).
std::string describeClosedness(const Scene& scene);

}  // namespace viewpeel
