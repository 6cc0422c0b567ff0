// A line end is a patch on which lines start or end; an obstacle may block them. The same formulas serve for sixteen
// lines in single precision and for one line in double precision.
//
// All coordinates are relative to an origin near the smaller patch, and rounding errors are relative to the distance
// from it.
#pragma once
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "pair_lines/blockers.h"
#include "lanes.h"
#include "pair_lines/patches.h"

namespace viewpeel {

// A blocker that covers an end of lines lies in the end's plane; all others lie between the ends.
enum class BlockerPlace : uint8_t { between, over_first, over_second };

struct PlacedBlocker {
  uint32_t blocker;
  BlockerPlace place;
};

// Returns the place with first and second exchanged where is_swapped.
BlockerPlace placeFrom(BlockerPlace place, bool is_swapped);

// Returns the normal of a patch's corners, counter-clockwise, unit length.
glm::dvec3 acrossOf(const Patch& patch);

// A point is corner + s side_a + t side_b + s t twist for s, t in [0, 1]; on a folded triangle s + t <= 1.
template <class Number>
struct LineEnd {
  Number corner[3], side_a[3], side_b[3], twist[3];
  Number density[3];  // area per ds dt is density[0] + density[1] s + density[2] t; constant on a folded triangle
  Number normal[3], offset;
  bool is_folded;
  uint32_t edge_count;
  Number edges[4][4];  // outward normals and minus their offsets
};

// Makes an end of lines of a patch.    In: folds: how the unit square of s and t becomes a triangle: folded along its
// diagonal, or else with one side collapsed to a corner
template <class Number>
LineEnd<Number> makeLineEnd(const Patch& patch, const glm::dvec3& origin, bool folds);

template <class Number>
struct Obstacle {
  BlockerPlace place;
  uint32_t edge_count;
  Number plane[4];  // normal and minus its offset
  Number edges[kMostBlockerCorners][4];
};

// Makes obstacles of blockers.    In: is_swapped: whether `between` exchanges the names of first and second end
template <class Number>
std::vector<Obstacle<Number>> makeObstacles(const std::vector<Blocker>& blockers,
                                            std::span<const PlacedBlocker> between, const glm::dvec3& origin,
                                            bool is_swapped);

template <class Lanes>
struct LaneVector {
  Lanes x, y, z;
};

// Returns a point in single precision.
inline LaneVector<float> pointOf(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

template <class Number, class Lanes>
VIEWPEEL_INLINE Lanes dot(const Number* n, const LaneVector<Lanes>& v) {
  return n[0] * v.x + n[1] * v.y + n[2] * v.z;
}
template <class Lanes>
VIEWPEEL_INLINE Lanes dot(const LaneVector<Lanes>& a, const LaneVector<Lanes>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Returns points on a patch.    In: s, t: in [0, 1]    Out: density: area per ds dt at each point
template <class Number, class Lanes>
VIEWPEEL_INLINE LaneVector<Lanes> pointOn(const LineEnd<Number>& of, Lanes s, Lanes t, Lanes& density) {
  if (of.is_folded) {
    // This map folds the square onto the triangle and keeps areas in proportion (E. Heitz, A low-distortion map between
    // triangle and square, 2019).
    const Lanes half_s = 0.5f * s, half_t = 0.5f * t, folded_s = ifBelow(s, t, half_s, s - half_t);
    t = ifBelow(s, t, t - half_s, half_t);
    s = folded_s;
  }
  const Lanes st = s * t;
  density = of.density[0] + of.density[1] * s + of.density[2] * t;
  return {of.corner[0] + of.side_a[0] * s + of.side_b[0] * t + of.twist[0] * st,
          of.corner[1] + of.side_a[1] * s + of.side_b[1] * t + of.twist[1] * st,
          of.corner[2] + of.side_a[2] * s + of.side_b[2] * t + of.twist[2] * st};
}

// Returns the distance of a point of the plane beyond the polygon's farthest edge; at most 0 inside.
template <class Number, class Lanes>
VIEWPEEL_INLINE Lanes beyond(const Number (*edges)[4], uint32_t count, const LaneVector<Lanes>& at) {
  Lanes most = dot(edges[0], at) + edges[0][3];
  for (uint32_t e = 1; e < count; ++e) most = greatest(most, dot(edges[e], at) + edges[e][3]);
  return most;
}

}  // namespace viewpeel
