// judge() counts a random scene that is hard on a rasteriser with both engines, and compares the counts with exact
// areas. A quick test and the bench `stress` use it.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel::stress {

enum class Kind {
  soup,     // convex polygons of 3 to 64 corners and sizes from 1 to 1e-3 in disjoint balls
  slivers,  // as soup, with aspect ratios up to 1e6
  // A closed room with boxes that touch its walls and one another: T-junctions, shared edges, coplanar neighbours.
  boxes,
  turned,   // as boxes, rotated at random, so that every corner is rounded, and moved by 1e4 times its size
  sheets,   // parallel squares above one another, with gaps of 1 to 1e-7 of their size, that look up or down
  doubles,  // coincident squares that look the same way or opposite ways, parts of them, and coplanar neighbours
};
inline constexpr std::array kKinds = {Kind::soup,   Kind::slivers, Kind::boxes,
                                      Kind::turned, Kind::sheets,  Kind::doubles};
const char* nameOf(Kind kind);
inline bool isClosed(Kind kind) { return kind == Kind::boxes || kind == Kind::turned; }

InputScene makeScene(Kind kind, uint64_t seed);

struct Tally {
  uint64_t scenes = 0, directions = 0, regions = 0, polygons = 0;
  uint64_t lines = 0, lost_lines = 0;  // in closed scenes: lines that left a front, and lines that then hit no front
  uint64_t unequal = 0;                // counts in which the two engines differ
  double worst = 0;                    // largest |counted area - exact area| over its bound
  std::string worst_case;              // kind, seed, direction, pair
  void add(const Tally& other);
};

// Counts one scene along some directions: random ones, axes and diagonals, directions along edges, and directions
// almost in the plane of a polygon. For each direction it takes 32 random lattices, and compares the area of every
// pair, environment and leak with the exact area.
//   In: shrunk: compare with the exact areas of another scene, whose largest polygon is half as wide; this must fail
//   Method: the mean of a count is the exact area A. Its variance is taken to be at most V = h^2 A + 4 kLatticeVariance
//     h^3 P for a perimeter P. The first term is the variance of independent points, the second is four times the
//     variance of a boundary on a lattice. Bernstein's inequality then bounds the error of the mean with probability 1
//     - kFalseAlarmRate. Where a region is thinner than half a spacing, rows of P / (2h) points are independent.
//     Corners are snapped to 2^-24, which may add 2^-24 P.
Tally judge(const Device& device, Kind kind, uint64_t seed, bool shrunk = false);

constexpr double kFalseAlarmRate = 1e-12;  // for one region; some million regions are compared

}  // namespace viewpeel::stress
