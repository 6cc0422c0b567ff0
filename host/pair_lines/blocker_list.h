// A BlockerList holds the bounding boxes of blockers in groups of eight, one coordinate after the other, so that one
// vector instruction tests eight boxes.
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pair_lines/blockers.h"
#include "lanes.h"

namespace viewpeel {

class BlockerList {
 public:
  // A Group has the boxes of eight blockers; the last group's places after the end are empty boxes beyond everything.
  struct alignas(64) Group {
    // low x, y, z, then high x, y, z
    double bounds[6][kBlockerLanes];
    uint32_t indices[kBlockerLanes];
  };

  // Removes all members and makes room for this many.
  void clear(size_t most) {
    size_ = 0;
    if (groups_.size() < most / kBlockerLanes + 1) groups_.resize(most / kBlockerLanes + 1);
  }
  void add(uint32_t index, const Blocker& blocker) {
    Group& group = groups_[size_ / kBlockerLanes];
    const size_t at = size_++ % kBlockerLanes;
    group.indices[at] = index;
    for (int axis = 0; axis < 3; ++axis)
      group.bounds[axis][at] = blocker.low[axis], group.bounds[3 + axis][at] = blocker.high[axis];
  }
  // Appends the blocker in one lane of another list's group.
  VIEWPEEL_INLINE void add(const Group& from, int lane) {
    Group& group = groups_[size_ / kBlockerLanes];
    const size_t at = size_++ % kBlockerLanes;
    group.indices[at] = from.indices[lane];
    for (int bound = 0; bound < 6; ++bound) group.bounds[bound][at] = from.bounds[bound][lane];
  }
  // Fills the free places of the last group with empty boxes; it is called after the last add().
  void close();

  size_t size() const { return size_; }
  size_t groupCount() const { return (size_ + kBlockerLanes - 1) / kBlockerLanes; }
  const Group& group(size_t k) const { return groups_[k]; }
  uint32_t operator[](size_t k) const { return groups_[k / kBlockerLanes].indices[k % kBlockerLanes]; }

 private:
  size_t size_ = 0;
  std::vector<Group> groups_;
};

// Returns the heights of eight points over a blocker's plane.    In: points: their x, y and z
template <class Doubles>
VIEWPEEL_INLINE Doubles heightsOverPlane(const Doubles* points, const Blocker& blocker) {
  return points[0] * blocker.normal.x + points[1] * blocker.normal.y + points[2] * blocker.normal.z - blocker.offset;
}

// Calls is_last(index) for each blocker whose box the line from p to q meets, until it returns true.
//   In: touching: a box counts as met where the line passes it by this share of the line's length; is_last: an
//   always_inline lambda    Template: Doubles: LaneTypes::Doubles
template <class Doubles, class IsLast>
VIEWPEEL_INLINE void forEachOnLine(const BlockerList& list, const glm::dvec3& p, const glm::dvec3& q, double touching,
                                   const IsLast& is_last) {
  constexpr double kLeast = 1e-300;
  double per_length[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double length = q[axis] - p[axis];
    per_length[axis] = 1 / (std::abs(length) > kLeast ? length : kLeast);
  }
  for (size_t g = 0; g < list.groupCount(); ++g) {
    const BlockerList::Group& group = list.group(g);
    Doubles enters = 0, leaves = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const Doubles one = (load<Doubles>(group.bounds[axis]) - p[axis]) * per_length[axis],
                    other = (load<Doubles>(group.bounds[3 + axis]) - p[axis]) * per_length[axis];
      enters = greatest(enters, least(one, other)), leaves = least(leaves, greatest(one, other));
    }
    for (uint32_t met = bitsAtMost<Doubles>(enters - leaves, touching); met; met &= met - 1) {
      const uint32_t index = group.indices[std::countr_zero(met)];
      if (index != UINT32_MAX && is_last(index)) return;
    }
  }
}

}  // namespace viewpeel
