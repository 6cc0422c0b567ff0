// A shaft is the space that all lines between two ends run through; it tells which blockers may lie between the ends.
//
// The shaft of two convex ends is their convex hull: all lines between them run inside it (E. Haines, J. Wallace, Shaft
// culling for efficient ray-cast radiosity, 1991). A blocker beyond one plane of the shaft is in no line's way. A
// blocker hides all of one end from the other where it meets every line between their corners. Proof: a line between
// any two points crosses the blocker's plane at a convex combination of the points where the corners' lines cross it.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pair_lines/blocker_list.h"
#include "lanes.h"
#include "pair_lines/patches.h"
#include "vectorised.h"

namespace viewpeel {

// Blockers that reach less deep than this into a shaft only touch it and do not block; in units of the radius.
constexpr double kTouchingShaft = 1e-9;

struct Box {
  glm::dvec3 low{0}, high{0};
};

// Returns one of the eight corners of a box.
inline glm::dvec3 cornerOf(const Box& box, int k) {
  return glm::dvec3(k & 1 ? box.high.x : box.low.x, k & 2 ? box.high.y : box.low.y, k & 4 ? box.high.z : box.low.z);
}

// A Shaft is bounded by planes around all lines between two ends: a box or a patch, and a box.
class Shaft {
 public:
  Shaft(const Box& a, const Box& b);
  Shaft(const Patch& a, const Box& b);
  // Copies the blockers of `from` that may reach into the shaft, in their order.
  //   Out: to: closed    Cost: O(from).
  void keepInside(const BlockerList& from, BlockerList& to, Vectors vectors) const;
  // Returns whether no line between the ends of the shaft meets an edge with these two ends.
  bool isOutside(const std::array<glm::dvec3, 2>& edge) const;

 private:
  void addPlane(const glm::dvec3& normal, double offset);
  template <class Doubles>
  void keepInsideAll(const BlockerList& from, BlockerList& to) const;
  struct OutwardPlane {
    double normal[3];
    double offset;
    int bounds[3];  // by axis: index into BlockerList::Group::bounds of the box's corner that is farthest inwards
  };
  Box both_;
  OutwardPlane planes_[17];  // twelve around two boxes, or a patch's plane and four through its edges
  int plane_count_ = 0;
};

// A PatchShaft is the shaft of two patches that do not lie in one plane.
class PatchShaft {
 public:
  //   In: a, b: kept by reference
  PatchShaft(const Patch& a, const Patch& b);
  // Returns whether one blocker hides b from a.
  bool isHiddenBy(const Blocker& blocker, Vectors vectors) const;
  // Finds the blockers between the patches. Returns whether one of them hides b from a.
  //   In: from: blockers to try; blockers of the patches' planes are passed over
  //   Out: between: blockers that some line may meet are appended; where it returns true the last one hides b from a
  //   Cost: O(from).
  bool isHidden(const std::vector<Blocker>& blockers, const BlockerList& from, std::vector<uint32_t>& between,
                Vectors vectors);
  // Returns whether no line between the patches meets an edge with these ends. Call isHidden() first.
  bool isOutside(const std::array<glm::dvec3, 2>& ends) const;
  // Returns whether each of eight lines between the patches meets one of these blockers.
  bool areLinesBlocked(const std::vector<Blocker>& blockers, std::span<const uint32_t> between, Vectors vectors) const;

 private:
  void findPlanes();
  template <class Doubles>
  bool isHiddenByOne(const std::vector<Blocker>& blockers, const BlockerList& from,
                     std::vector<uint32_t>& between) const;
  void addPlane(const glm::dvec3& normal, double offset);
  template <class Doubles>
  bool isOutside(const Blocker& blocker) const;
  template <class Doubles>
  Doubles heightsOver(const Blocker& blocker) const;
  template <class Doubles>
  bool hides(const Blocker& blocker, const Doubles& heights) const;

  const Patch &a_, &b_;
  alignas(64) double corners_[3][8];  // four of a, four of b
  int plane_count_ = 0, used_planes_ = 0;
  alignas(64) double planes_[4][16];  // by plane: outward normal and minus its offset; unused planes repeat the first
};

}  // namespace viewpeel
