// triangulatedCity() makes city models like those of urban climate.
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

constexpr double kKerbHeight = 0.12;  // at least, metres
constexpr double kMostCityArea = 70;  // of a triangle that is not ground, square metres
constexpr double kLeastCityArea = 5e-3;

// Makes about n triangles, within 2 %: streets between plots of irregular shape, each behind a kerb with rounded
// corners; buildings with convex, L-shaped and turned footprints, some under one wall with a higher neighbour, 3 to
// 80 m high, under flat roofs with boxes on them or tents; trees as boxes on trunks, hedges. Every coordinate is a
// number of single precision, so that walls in pieces are not quite plane. Walls, roofs and pavements are constrained
// Delaunay triangles of 0.005 to 70 m2; streets are one constrained triangulation without further points. Triangles
// meet edge to edge, every edge in two of them but for the rim's: no line leaks.
//   In: n: 1,000 or more; seed: every seed makes another city    Out: the same scene on every machine, except for the
//     last bit of sines
//   Throws: Error check where trees to make up n find no place.    Cost: O(n) memory, some milliseconds
TriangulatedCity triangulatedCity(uint32_t n, uint64_t seed = 1);

}  // namespace viewpeel::bench
