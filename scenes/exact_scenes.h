// The tests of the exact path use these small scenes. Their corners are written down in unit-ball units.
#pragma once
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel::tests {

// A SceneBuilder makes one surface per polygon, named by the caller, so that messages name polygons.
struct SceneBuilder {
  Scene scene;

  SceneBuilder() { scene.file = "test"; }
  void addPolygon(const std::string& name, const std::vector<glm::dvec3>& corners);
  // Adds six quads with fronts outwards, or inwards for a room.
  void addBox(const std::string& name, const glm::dvec3& low, const glm::dvec3& high, bool inwards = false);
};

// Returns the scene rotated. Rounding then moves corners off their planes, and edges off their neighbours, by about
// 1e-16.
Scene turn(const Scene& scene, const glm::dmat3& rotation);

// Returns the scene with the corners of one polygon in reverse order, so that its front becomes its back.
Scene flip(const Scene& scene, uint32_t polygon_index);

Scene makeRoom();                                        // the inside of a cube
Scene makeCubeInCube();                                  // a solid cube within it
Scene makeTwoPlates();                                   // parallel squares of different size
Scene makeStaircase();                                   // steps of different width in a room: T-junctions
Scene makeStack();                                       // three boxes that touch, in a room: zero gaps
Scene makeTiles();                                       // coplanar neighbours, regular and shifted, under a plate
Scene makeDuplicates();                                  // coincident polygons, equally and oppositely facing
Scene makeCreases();                                     // several polygons on one edge, folded over each other
Scene makeSoup(uint32_t triangle_count, uint32_t seed);  // random triangles in disjoint balls
// Makes a room with desks of five boxes each on a grid, cut so that every quad of a box or a wall is subdivided.
Scene makeOffice(uint32_t desks_per_side, uint32_t subdivision);

}  // namespace viewpeel::tests
