// These functions cut and measure the plan polygons of generated cities. Corners run counter-clockwise; lengths are in
// metres.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

namespace viewpeel::bench {

using PlanPolygon = std::vector<glm::dvec2>;

double areaOf(const PlanPolygon& polygon);  // positive where corners run counter-clockwise
bool contains(const PlanPolygon& polygon, glm::dvec2 point);
double distanceTo(const PlanPolygon& polygon, glm::dvec2 point);  // distance of a point from the outline
glm::dvec2 meanOf(const PlanPolygon& polygon);                    // mean of the corners

// Returns the polygon with every side moved inwards by `distance`.    In: convex, with a larger inscribed circle
PlanPolygon inset(const PlanPolygon& polygon, double distance);

// Returns a rectangle about a centre, turned.
PlanPolygon rectangle(glm::dvec2 centre, glm::dvec2 half_size, double turned_rad);

// Cuts off corner k. The cut meets the side before the corner at share a of its length, and the side after it at share
// b.
PlanPolygon cutCorner(const PlanPolygon& polygon, size_t k, double a, double b);

// Takes a parallelogram out of corner k, with shares a and b of the two sides. A quadrilateral becomes an L.
PlanPolygon notchCorner(const PlanPolygon& polygon, size_t k, double a, double b);

// Rounds every corner, as kerbs do: it becomes `sides` short sides of this length.
PlanPolygon roundCorners(const PlanPolygon& polygon, uint32_t sides, double length);

// Returns constrained Delaunay triangles of the region inside the first loop and outside the others. Triangles larger
// than most_area are divided at their centroids; sides of loops are never divided, so that neighbours fit.
//   In: points, and loops as indices into them; loops neither cross nor touch    Out: triangles, counter-clockwise; new
//     points are appended to `points`
//   Throws: CGAL's exception where loops cross.    Cost: O(n log n).
//   Source: CGAL, Constrained_Delaunay_triangulation_2.
std::vector<std::array<uint32_t, 3>> triangulate(PlanPolygon& points, const std::vector<std::vector<uint32_t>>& loops,
                                                 double most_area);

}  // namespace viewpeel::bench
