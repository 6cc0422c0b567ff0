#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include "scenes/plan_polygon.h"

namespace viewpeel::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<uint32_t, Kernel>;  // index of the point
using FaceBase = CGAL::Triangulation_face_base_with_info_2<uint32_t, Kernel,       // whether in an odd number of loops
                                                           CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::No_constraint_intersection_tag>;
constexpr uint32_t kUnknown = ~0u;

// Marks the faces inside an odd number of loops, which form the region.
void markFaces(Triangulation& triangulation) {
  for (auto face : triangulation.all_face_handles()) face->info() = kUnknown;
  std::vector<Triangulation::Face_handle> reached{triangulation.infinite_face()};
  reached.front()->info() = 0;
  while (!reached.empty()) {
    const auto face = reached.back();
    reached.pop_back();
    for (int edge = 0; edge < 3; ++edge) {
      const auto next = face->neighbor(edge);
      if (next->info() != kUnknown) continue;
      next->info() = face->info() ^ (triangulation.is_constrained({face, edge}) ? 1 : 0);
      reached.push_back(next);
    }
  }
}

bool isInside(const Triangulation& triangulation, Triangulation::Face_handle face) {
  return !triangulation.is_infinite(face) && face->info() == 1;
}

Triangulation::Face_handle findLargest(const Triangulation& triangulation, double most_area) {
  Triangulation::Face_handle largest;
  double area = most_area;
  for (const auto face : triangulation.finite_face_handles())
    if (const double found = triangulation.triangle(face).area(); isInside(triangulation, face) && found > area)
      area = found, largest = face;
  return largest;
}

}  // namespace

std::vector<std::array<uint32_t, 3>> triangulate(PlanPolygon& points, const std::vector<std::vector<uint32_t>>& loops,
                                                 double most_area) {
  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> vertices(points.size());
  for (const std::vector<uint32_t>& loop : loops)
    for (const uint32_t k : loop) {
      vertices[k] = triangulation.insert({points[k].x, points[k].y});
      vertices[k]->info() = k;
    }
  for (const std::vector<uint32_t>& loop : loops)
    for (size_t k = 0; k < loop.size(); ++k)
      triangulation.insert_constraint(vertices[loop[k]], vertices[loop[(k + 1) % loop.size()]]);
  markFaces(triangulation);
  for (auto largest = findLargest(triangulation, most_area); largest != Triangulation::Face_handle();
       largest = findLargest(triangulation, most_area)) {
    const auto centroid = CGAL::centroid(triangulation.triangle(largest));
    triangulation.insert(centroid, largest)->info() = static_cast<uint32_t>(points.size());
    points.emplace_back(centroid.x(), centroid.y());
    markFaces(triangulation);
  }
  std::vector<std::array<uint32_t, 3>> triangles;
  for (const auto face : triangulation.finite_face_handles())
    if (isInside(triangulation, face))
      triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  return triangles;
}

}  // namespace viewpeel::bench
