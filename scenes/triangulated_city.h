// triangulatedCity() makes city models like the ones that urban climate research uses.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>
#include "scenes/plan_polygon.h"

namespace viewpeel::bench {

// A plot is the ground behind one kerb. It carries a building, two buildings that share a wall, or a park.
struct CityPlot {
  PlanPolygon outline;
  std::vector<PlanPolygon> footprints;  // footprints of buildings, trunks and hedges; there is no pavement below them
};

struct TriangulatedCity {
  InputScene scene;  // surfaces: ground, then plot_k, building_k, trees_k
  PlanPolygon rim;   // of the ground
  std::vector<CityPlot> plots;
  std::vector<double> heights;  // of buildings, above their pavement
};

constexpr double kKerbHeight = 0.12;  // least height, metres
constexpr double kMostCityArea = 70;  // of a triangle that is not ground, square metres
constexpr double kLeastCityArea = 5e-3;

// Makes about n triangles, to 2 %. Between streets lie plots of irregular shape, each behind a kerb with rounded
// corners. Buildings have convex, L-shaped and turned footprints, are 3 to 80 m high, and may share a wall with a
// higher neighbour. Roofs are flat with boxes on them, or tents. Trees are boxes on trunks; there are hedges.
// Coordinates are rounded to single precision, so walls in pieces are not quite plane. Walls, roofs and pavements are
// constrained Delaunay triangles of 0.005 to 70 m2; streets are one constrained triangulation without further points.
// Every edge but the rim's belongs to two triangles, so no line leaks.
//   In: n: 1,000 or more; seed: every seed makes another city    Out: the same scene on every machine, except for the
//     last bit of sines
//   Throws: Error check where trees to make up n find no place.    Cost: O(n) memory, some milliseconds
TriangulatedCity triangulatedCity(uint32_t n, uint64_t seed = 1);

}  // namespace viewpeel::bench
