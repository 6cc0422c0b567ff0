// An Emitter is a side of a polygon, from which sixteen rays start at a time.
#pragma once
#include <cstdint>
#include <numbers>
#include <vector>

#include <glm/vec3.hpp>
#include <viewpeel/scene.h>

#include "lanes.h"
#include "rays/ray_tree.h"

namespace viewpeel {

struct Emitter {
  glm::dvec3 corner;  // of the polygon, which consists of one triangle or two. From it run sides of these triangles.
  LaneVector<float> corners[3];  // the others, relative to the first; the last two of a triangle are the same
  LaneVector<float> along_first, along_second;
  float first_share;                   // of the first triangle in the area
  float reach;                         // of the polygon
  LaneVector<float> axes[3];           // the last one is the side's normal
  std::vector<RayTree::Facet> covers;  // polygons that coincide with this one and hide the side, nearest first
};

// Returns the sides of all polygons, from which rays start.
//   In: sides: 1, the front alone, or 2    Out: Emitter[polygons x sides], of each polygon the front first
std::vector<Emitter> makeEmitters(const Scene& scene, uint32_t sides);

constexpr float kLeastRooted = 1e-12f;  // numbers are raised to it before their root is taken

// Returns the square root of numbers from 0 to 1.
template <class Floats>
VIEWPEEL_INLINE Floats rootOfShare(const Floats& x) {
  const Floats positive = greatest(x, Floats(kLeastRooted));
  return positive * inverseRoot(positive);
}

// Sets the cosine and the sine of an angle, to 2e-7.    In: turn: the angle over that of a whole turn, in [0, 1)
template <class Floats>
VIEWPEEL_INLINE void turnBy(const Floats& turn, Floats& cosine, Floats& sine) {
  constexpr auto kHalfRoot = static_cast<float>(std::numbers::sqrt2 / 2),
                 kQuarter = static_cast<float>(std::numbers::pi / 2);
  // The angle is a number of quarters, an eighth, and a rest within an eighth, whose series are Taylor's.
  const Floats quarters = wholeOf(4.0f * turn), rest = (4.0f * turn - quarters - 0.5f) * kQuarter, square = rest * rest;
  const Floats s = rest * (1.0f + square * (-1 / 6.0f + square * (1 / 120.0f + square * (-1 / 5040.0f)))),
               c = 1.0f + square * (-0.5f + square * (1 / 24.0f + square * (-1 / 720.0f + square * (1 / 40320.0f))));
  const Floats x = (c - s) * kHalfRoot, y = (c + s) * kHalfRoot;
  const Floats is_odd = quarters - 2.0f * wholeOf(0.5f * quarters),
               sign = ifBelow(Floats(1.5f), quarters, Floats(-1.0f), Floats(1.0f));
  cosine = sign * ifBelow(Floats(0.5f), is_odd, -y, x);
  sine = sign * ifBelow(Floats(0.5f), is_odd, x, y);
}

// Returns sixteen rays.
//   In: plane: of the polygon; u: four numbers in [0, 1) for each ray, which give height, turn, and the place of its
//     start
template <class Floats>
VIEWPEEL_INLINE Rays<Floats> startRays(const Emitter& from, uint32_t plane, const Floats* u) {
  Floats cosine, sine;
  turnBy(u[1], cosine, sine);
  const Floats radius = rootOfShare(u[0]), x = radius * cosine, y = radius * sine, z = rootOfShare<Floats>(1.0f - u[0]);
  Rays<Floats> rays;
  rays.origin = from.corner, rays.corners = from.corners, rays.reach = from.reach;
  const auto along = [&](float a, float b, float c) __attribute__((always_inline)) { return x * a + y * b + z * c; };
  rays.direction = {along(from.axes[0].x, from.axes[1].x, from.axes[2].x),
                    along(from.axes[0].y, from.axes[1].y, from.axes[2].y),
                    along(from.axes[0].z, from.axes[1].z, from.axes[2].z)};
  // The first number chooses a triangle, and then is uniform again.
  const Floats share = from.first_share, rest = greatest(1.0f - share, Floats(kLeastRooted));
  const Floats from_corner = rootOfShare(ifBelow(u[2], share, u[2] / share, (u[2] - share) / rest));
  const auto place = [&](float to_first, float along_first, float to_second, float along_second)
      __attribute__((always_inline)) {
    const Floats to = ifBelow(u[2], share, Floats(to_first), Floats(to_second)),
                 further = ifBelow(u[2], share, Floats(along_first), Floats(along_second));
    return from_corner * (to + u[3] * further);
  };
  rays.start = {place(from.corners[0].x, from.along_first.x, from.corners[1].x, from.along_second.x),
                place(from.corners[0].y, from.along_first.y, from.corners[1].y, from.along_second.y),
                place(from.corners[0].z, from.along_first.z, from.corners[1].z, from.along_second.z)};
  rays.plane = plane;
  return rays;
}

}  // namespace viewpeel
