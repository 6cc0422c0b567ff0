// Scenes: what is read from a file (InputScene) and what everything else works on (Scene).
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel {

// One face as the file has it: any simple polygon, its corners counter-clockwise seen from its front.
struct InputFace {
  std::vector<glm::dvec3> corners;  // input units
  uint32_t surface = 0;             // index into InputScene::surface_names
  uint32_t line = 0;                // in the file; 0 where the format has no lines
};

struct InputScene {
  std::string file;  // named in messages
  std::vector<std::string> surface_names;
  std::vector<InputFace> faces;
};

// Where several polygons lie in one plane a line meets all of them at one depth, and their tie ranks order them: a place
// among kTieRanks along the normal of the polygon's own front. Two polygons that look opposite ways face each other where
// both have kContactRank, as touching solids do, and turn their backs to each other where both have kSheetRank.
constexpr uint32_t kTieRanks = 8;
constexpr uint32_t kContactRank = 3;
constexpr uint32_t kSheetRank = 4;

// A convex planar piece of an input face, a triangle or a quadrilateral. Its front is the side from which its corners run counter-clockwise.
struct Polygon {
  uint32_t first_corner = 0;  // into Scene::corners
  uint32_t corner_count = 0;  // 3 or 4
  uint32_t face = 0;          // into Scene::faces
  uint32_t plane = 0;         // into Scene::planes
  bool front_along_plane_normal = true;
  uint32_t tie_rank = kContactRank;
  double area = 0;            // unit-ball units squared
};

// A face keeps one identity however many polygons it was split into.
struct Face {
  uint32_t surface = 0;  // into Scene::surfaces
  uint32_t number = 0;   // within its surface, from 1
};

struct Surface {
  std::string name;
  uint32_t face_count = 0;
};

// Coplanar polygons share one plane, whichever way they face, so that their depths along a line tie exactly.
struct Plane {
  glm::dvec3 normal{0};  // unit length
  double offset = 0;     // dot(normal, x) = offset on the plane, unit-ball units
};

// Pairs of polygons that look opposite ways and coincide over some area (coincident.h), by how they are ordered.
struct Coincidences {
  uint64_t sheets = 0;    // back to back: nothing passes between them
  uint64_t contacts = 0;  // face to face: touching solids
  uint64_t in_doubt = 0;  // among both: what lies around them contradicts itself
};

// All lengths are in unit-ball units: the input is moved by -centre and divided by scale so that every corner is
// within distance 1 of the origin. x_input = centre + scale * x.
struct Scene {
  std::string file;
  std::vector<glm::dvec3> corners;
  std::vector<Polygon> polygons;
  std::vector<Face> faces;
  std::vector<Surface> surfaces;
  std::vector<Plane> planes;
  glm::dvec3 centre{0};
  double scale = 1;
  Coincidences coincidences;
  std::vector<std::string> warnings;  // one line each, counted: "3 faces of zero area dropped"
};

// What a file leaves open. Names are of surfaces.
struct SceneOptions {
  std::vector<std::string> sheets;  // coincident faces of these are back to back
  std::vector<std::string> solids;  // coincident faces of these are face to face
};

// Validates, drops degenerate faces, splits the rest into convex planar polygons, moves and scales to the unit ball
// groups coplanar polygons into planes and orders the coincident ones.
//   In: faces in input units, any size and offset.
//   Error: corners to 1 ulp of the unit ball after the subtraction of the centre in double; tests/scene_test.cpp.
//   Throws: Error bad_input (NaN or infinite coordinates, no usable polygon), naming file and line.
//   Cost: O(corners log corners) work and memory.
Scene buildScene(const InputScene& input, const SceneOptions& options = {});

// Reads .obj, .stl (both kinds) or .ply and calls buildScene. Surfaces are the `o` and `g` names of .obj, the solids
// of .stl; a file without names has one surface, named after the file.
//   Throws: Error bad_input, naming file, line where the format has lines, and remedy.
Scene loadScene(const std::filesystem::path& file, const SceneOptions& options = {});

// The unit normal of a polygon's own corners, on the side of its front.
glm::dvec3 frontNormal(const Scene& scene, const Polygon& polygon);

// True where every edge of every polygon is met by an opposite edge of another polygon, the way the walls of a room do.
// Touching of edges in part (T-junctions) counts. An estimate of intent for the summary, never used in numerics.
bool isClosed(const Scene& scene);

// 64 bits of all that a count can depend on: geometry to the last bit, order, names; not the file's place.    Cost: O(corners).
uint64_t fingerprint(const Scene& scene);

}  // namespace viewpeel
