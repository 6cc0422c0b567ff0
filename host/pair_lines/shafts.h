// Shafts: what lies between two ends of lines, and what cannot.
//
// The shaft of two convex ends is their convex hull: all lines between them run inside it (E. Haines, J. Wallace, Shaft
// culling for efficient ray-cast radiosity, 1991). A blocker beyond one plane of the shaft is in no line's way. A
// blocker that every line between corners passes through hides all of one end from the other, for where a line between
// two points crosses the blocker's plane is a convex combination of where lines between corners do.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "engines/vectorised.h"
#include "pair_lines/blockers.h"
#include "pair_lines/lanes.h"
#include "pair_lines/patches.h"

namespace viewpeel {

// A blocker that reaches less deep than this into a shaft touches it and is not in the way; unit-ball units.
constexpr double kTouchingShaft = 1e-9;

struct Box {
  glm::dvec3 low{0}, high{0};
};

// Blockers' boxes, a coordinate after the other, for tests of eight at once.
class BlockerList {
 public:
  void clear();
  void add(uint32_t index, const Blocker& blocker);
  // Copies entry k of another list.
  void add(const BlockerList& from, size_t k);
  size_t size() const { return indices.size(); }
  // Appends entries that nothing reads up to a multiple of eight.
  void pad();

  std::vector<uint32_t> indices;
  std::vector<double> low[3], high[3];
};

// The planes of a shaft between two boxes.
class BoxShaft {
 public:
  BoxShaft(const Box& a, const Box& b);
  // Appends those of `from` that may reach into the shaft.    In: from: padded    Cost: O(from).
  void keepInside(const BlockerList& from, BlockerList& to, Vectors vectors) const;

 private:
  void keepInsideAll(const BlockerList& from, BlockerList& to) const;
  struct OutwardPlane {
    glm::dvec3 normal{0};
    double offset = 0;
  };
  OutwardPlane planes_[18];
  int plane_count_ = 0;
};

// Whether the blocker hides all of one box from all of the other.
bool hidesBox(const Blocker& blocker, const Box& a, const Box& b);

// What is between two patches that do not lie in one plane.
class PatchShaft {
 public:
  PatchShaft(const Patch& a, const Patch& b);
  //   In: from: indices of blockers, those of the patches' planes among them are passed over
  //   Out: between: appended to, the blockers that some line may meet; true where the last of them hides all
  //   Cost: O(from).
  bool isHidden(const std::vector<Blocker>& blockers, std::span<const uint32_t> from, std::vector<uint32_t>& between,
                Vectors vectors) const;

 private:
  bool isHiddenByOne(const std::vector<Blocker>& blockers, std::span<const uint32_t> from,
                     std::vector<uint32_t>& between) const;
  void addTangents(const Patch& a, const Patch& b);
  void addPlane(const glm::dvec3& normal, double offset);
  bool isOutside(const Blocker& blocker) const;
  bool hides(const Blocker& blocker, const Doubles& heights) const;

  const Patch &a_, &b_;
  Doubles corners_[3];  // four of a, four of b
  int plane_count_ = 0;
  alignas(64) double planes_[4][16];  // outward normals and minus their offsets
};

}  // namespace viewpeel
