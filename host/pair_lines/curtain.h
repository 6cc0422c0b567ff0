// A Curtain is a surface of blockers that share edges. Its rim is the edges with the surface on one side only. It hides
// two convex ends of lines from each other where three things hold: no line between the ends meets the rim, no end
// touches the curtain, and one line crosses it an odd number of times. Proof: any line between the ends can be moved
// into any other without a jump. While it moves, the number of its crossings with the curtain changes by two at a time.
// A change by one would need a line that meets the rim, or an end that meets the curtain. So every line crosses it an
// odd number of times, at least once. Two walls that meet at a corner, or a wall in pieces, are such surfaces.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "pair_lines/blocker_mesh.h"
#include "pair_lines/blockers.h"
#include "pair_lines/shafts.h"

namespace viewpeel {

class Curtain {
 public:
  //   In: blockers, mesh: kept by reference
  Curtain(const std::vector<Blocker>& blockers, const BlockerMesh& mesh)
      : blockers_(blockers), mesh_(mesh), is_odd_(mesh.edgeCount()) {}

  // Returns whether blockers that share edges hide two patches from each other.
  //   In: shaft: of the two patches, after isHidden(); between: the blockers that it found
  //   Cost: some 8 tests of lines against blockers, and O(edges) where all of these lines are blocked.
  bool hides(const Patch& a, const Patch& b, const PatchShaft& shaft, std::span<const uint32_t> between,
             Vectors vectors);

  // Returns whether blockers that share edges hide a patch from all points of a box in front of it.
  //   In: shaft: of the two; between: the blockers that reach into it
  //   Cost: of one line through the list where this line is clear, of 17 lines and O(edges) where all are blocked.
  bool hides(const Patch& a, const Box& b, const Shaft& shaft, const BlockerList& between, Vectors vectors);

  // Adds neighbours to a first blocker until no line between the two ends meets the rim.
  //   In: is_outside(ends of an edge): whether no line between the two ends meets the edge; is_apart(blocker): whether
  //   neither end touches the blocker
  //   Out: false: some line meets the rim, or an end touches the curtain, or the curtain has too many blockers
  //   Cost: O(edges).
  template <class IsOutside, class IsApart>
  bool grow(uint32_t first, const IsOutside& is_outside, const IsApart& is_apart);

  // Returns whether the line from p to q crosses the curtain an odd number of times, away from all edges.
  bool isCrossedBy(const glm::dvec3& p, const glm::dvec3& q) const;

 private:
  static constexpr size_t kMostBlockers = 32, kMostEdges = 256;

  const std::vector<Blocker>& blockers_;
  const BlockerMesh& mesh_;
  std::vector<uint32_t> members_, edges_;
  std::vector<bool> is_odd_;  // by edge: whether an odd number of members have it, so that it is on the rim
};

template <class IsOutside, class IsApart>
bool Curtain::grow(uint32_t first, const IsOutside& is_outside, const IsApart& is_apart) {
  members_.clear(), edges_.clear();
  const auto add = [&](uint32_t blocker) {
    members_.push_back(blocker);
    for (const uint32_t edge : mesh_.edgesOf(blocker)) {
      edges_.push_back(edge);
      is_odd_[edge] = !is_odd_[edge];
    }
  };
  const auto closeRim = [&] {
    for (size_t k = 0; k < edges_.size(); ++k) {
      const uint32_t edge = edges_[k];
      if (!is_odd_[edge] || is_outside(mesh_.endsOf(edge))) continue;
      bool is_found = false;
      for (const uint32_t user : mesh_.usersOf(edge)) {
        if (std::ranges::find(members_, user) != members_.end() || !is_apart(blockers_[user])) continue;
        add(user);
        is_found = true;
        break;
      }
      if (!is_found || members_.size() > kMostBlockers || edges_.size() > kMostEdges) return false;
    }
    return true;
  };
  bool is_closed = is_apart(blockers_[first]);
  if (is_closed) {
    add(first);
    is_closed = closeRim();
  }
  for (const uint32_t edge : edges_) is_odd_[edge] = false;
  return is_closed;
}

}  // namespace viewpeel
