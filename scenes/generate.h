// Benches make these scenes of any size, deterministic and the same on every machine.
#pragma once
#include <cstdint>

#include <viewpeel/scene.h>

namespace viewpeel::bench {

// Makes a closed room, 8 x 8 quads a wall, with ten boxes of 2 x 2 quads a face that hover just above its floor. These
// 624 quads are each cut into refine x refine. Nothing touches or crosses, so that no line leaks and layers never tie.
InputScene roomWithBoxes(uint32_t refine);

// Makes n triangles of random shape and direction with centres uniform in a ball. Their size shrinks as n^(-1/3), as
// their distances do; at n = 100,000 a line hits 20 to 60 of them but near the rim. They may cross. A hundred surfaces
// take them in turn.
InputScene randomTriangles(uint32_t n);

// Makes a city of about n quads: buildings 7 bays wide and 2 to 12 floors high, some towers up to 40, on a square grid
// of streets. There is a wall and a window quad for every bay and floor. Surfaces: `streets`, and for each building its
// walls with the roof, and its windows. It grows by whole buildings, so that a larger city has more of the same. Ground
// ends where a building stands; nothing crosses.
InputScene city(uint32_t n);

// Makes squares of areas from 1 to 1e-8 above a floor. For every edge length 1, 0.1, ... 1e-4 two squares face each
// other at this distance (surfaces near_k_down, near_k_up, F = 0.19982). Two more do so at ten times the distance
// (far_k_down, far_k_up, F = 0.0031620).
InputScene spreadOfSizes();

// Makes two unit squares that face each other at distance 1, each cut into cuts x cuts.
InputScene twoPlates(uint32_t cuts);

// Makes the inside of a unit cube as one surface; each of its sides has cuts x cuts squares.
InputScene cubeOfPatches(uint32_t cuts);

// Cuts every polygon of a scene into refine x refine faces: quadrilaterals along lines between opposite sides,
// triangles into similar ones.
InputScene refined(const Scene& scene, uint32_t refine);

}  // namespace viewpeel::bench
