// Corners tell whether a blocker hides a box from another box, or from a patch.
//
// It does where it meets every line between the corners of the two (shafts.h), which are called ends of these lines.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "pair_lines/shafts.h"

namespace viewpeel {

// Corners hold the corners of two convex ends, up to eight each, and tell which blockers hide one end from the other.
// A blocker whose plane an end lies in, but for rounding, does not count.
class Corners {
 public:
  Corners(const Box& a, const Box& b);
  Corners(const Patch& a, const Box& b);

  // Returns whether the blocker hides all of one end from all of the other.
  bool areHidden(const Blocker& blocker, Vectors vectors) const;
  // Finds a blocker that hides one end from the other.    Out: its index, or UINT32_MAX
  uint32_t findHider(const std::vector<Blocker>& blockers, const BlockerList& list, Vectors vectors) const;

 private:
  template <class Doubles>
  bool areHiddenBy(const Blocker& blocker) const;

  int count_ = 0;                                  // of the first end's corners
  alignas(64) double first_[3][8], second_[3][8];  // coordinates of the first and of the second end's corners
  glm::dvec3 middles_[2];
};

// Returns true where a patch and a blocker surely have no point in common, except on the patch's edges. It may return
// false for others that are apart, too.
bool areApart(const Patch& patch, const Blocker& blocker);
// Returns true where a box and a blocker surely have no point in common, by more than patches lie beside their planes.
bool areApart(const Box& box, const Blocker& blocker);

}  // namespace viewpeel
