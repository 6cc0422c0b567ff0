// Makes random scenes that are hard on a rasteriser, counted by both engines and judged by exact areas. Shared by a
// quick test and bench/stress.
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
  slivers,  // the same with aspects up to 1e6
  // Makes a closed room with boxes that touch its walls and one another: T-junctions, shared edges, coplanar
  // neighbours.
  boxes,
  turned,   // the same turned at random, so that every corner is rounded, and moved by 1e4 of its size
  sheets,   // parallel squares one above another at gaps of 1 to 1e-7 of their size, facing either way
  doubles,  // coincident squares facing alike and oppositely, parts of them, and coplanar neighbours
};
inline constexpr std::array kKinds = {Kind::soup,   Kind::slivers, Kind::boxes,
                                      Kind::turned, Kind::sheets,  Kind::doubles};
const char* nameOf(Kind kind);
inline bool isClosed(Kind kind) { return kind == Kind::boxes || kind == Kind::turned; }

InputScene makeScene(Kind kind, uint64_t seed);

struct Tally {
  uint64_t scenes = 0, directions = 0, regions = 0, polygons = 0;
  uint64_t lines = 0, lost_lines = 0;  // of closed scenes: that left a front, and that ended on a back or nowhere
  uint64_t unequal = 0;                // counts of the two engines
  double worst = 0;                    // largest |counted area - exact area| over its bound
  std::string worst_case;              // kind, seed, direction, pair
  void add(const Tally& other);
};

// Counts one scene along some directions: random ones, axes and diagonals, along edges, and almost in the plane of a
// polygon. It takes 32 random lattices each, and compares the area of every pair, environment and leak with the exact
// one.
//   In: shrunk: compares with the exact areas of the scene with its largest polygon half as wide, which must fail
//   Method: counts have the exact area A as mean. Their variance is taken to be at most V = h^2 A + 4 kLatticeVariance
//     h^3 P for a perimeter P. This is the variance of as many independent points, and four times a boundary's on a
//     lattice. Bernstein's inequality then bounds the error of a mean but for kFalseAlarmRate, points being
//     independent. Where a region is thinner than half a spacing, rows of P / (2h) points are independent. Corners are
//     snapped to 2^-24, which may add 2^-24 P.
Tally judge(const Device& device, Kind kind, uint64_t seed, bool shrunk = false);

constexpr double kFalseAlarmRate = 1e-12;  // of one region; some million are compared

}  // namespace viewpeel::stress
