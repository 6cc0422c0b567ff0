// An InputScene is read from a file; everything else works on a Scene, which buildScene makes of it.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel {

// An InputFace is a face as the file has it: any simple polygon, its corners counter-clockwise seen from its front.
struct InputFace {
  std::vector<glm::dvec3> corners;  // input units
  uint32_t surface = 0;             // index into InputScene::surface_names
  uint32_t line = 0;                // in the file; 0 where the format has no lines
};

struct InputScene {
  std::string file;  // named in messages
  std::vector<std::string> surface_names;
  std::vector<InputFace> faces;
  std::vector<std::string> warnings{};  // of the reader, one line each
  // The file itself says that these surfaces only block: as Question::blockers.
  std::vector<std::string> blockers{};
  // Coincident faces of these surfaces are face to face, by the file itself: as SceneOptions::solids.
  std::vector<std::string> solids{};
  // Coincident faces of these surfaces are back to back, by the file itself: as SceneOptions::sheets.
  std::vector<std::string> sheets{};
};

// A tie rank orders polygons of one plane, which a line hits at one depth. It is a place among kTieRanks along the
// normal of the polygon's own front. Two polygons that look opposite ways face each other where both have kContactRank,
// as touching solids do. They turn their backs to each other where both have kSheetRank. Of two that look the same way
// the one of higher rank hides the other.
constexpr uint32_t kTieRanks = 8;
constexpr uint32_t kContactRank = 3;
constexpr uint32_t kSheetRank = 4;

// A Polygon is a convex planar piece of an input face, a triangle or a quadrilateral. Its front is the side from which
// its corners run counter-clockwise.
struct Polygon {
  uint32_t first_corner = 0;  // into Scene::corners
  uint32_t corner_count = 0;  // 3 or 4
  uint32_t face = 0;          // into Scene::faces
  uint32_t plane = 0;         // into Scene::planes
  bool front_along_plane_normal = true;
  uint32_t tie_rank = kContactRank;
  double area = 0;  // unit-ball units squared
};

// A face keeps one identity however many polygons it was split into.
struct Face {
  uint32_t surface = 0;  // into Scene::surfaces
  uint32_t number = 0;   // within its surface, from 1, empty rows counted
  uint32_t row = 0;      // in the file, from 0, empty rows counted
};

struct Surface {
  std::string name;
  uint32_t face_count = 0;  // in the file, empty rows counted
};

// An EmptyRow is a face or surface of the file that takes no part: it has no area, or repeats another one. It keeps its
// place among the rows of results, so that row k is the file's face k, and its name.
struct EmptyRow {
  uint32_t row = 0;  // from 0
  std::string name;
  bool operator==(const EmptyRow&) const = default;
};

// Coplanar polygons share one plane, whichever way they face, so that their depths along a line tie exactly.
struct Plane {
  glm::dvec3 normal{0};  // unit length
  double offset = 0;     // dot(normal, x) = offset on the plane, unit-ball units
};

// Coincidences counts pairs of polygons that coincide over some area, by how they are ordered (coincident.h).
struct Coincidences {
  uint64_t sheets = 0;    // back to back: nothing passes between them
  uint64_t contacts = 0;  // face to face: touching solids
  uint64_t in_doubt = 0;  // among both: their surroundings contradict themselves
  // In these pairs both polygons look the same way, and the direction of a line decides which of the two it hits first.
  // They lie in planes that cross within rounding, or in stacks of more than kTieRanks.
  uint64_t alike_unordered = 0;
};

// All lengths of a Scene are in unit-ball units. The input is moved by -centre and divided by scale, so that every
// corner is within distance 1 of the origin. x_input = centre + scale * x.
struct Scene {
  std::string file;
  std::vector<glm::dvec3> corners;
  std::vector<Polygon> polygons;
  std::vector<Face> faces;
  std::vector<Surface> surfaces;                      // in the order in which the file first uses them
  std::vector<EmptyRow> empty_faces, empty_surfaces;  // by row
  std::vector<Plane> planes;
  glm::dvec3 centre{0};
  double scale = 1;
  Coincidences coincidences;
  // Each warning is one line with a count: a fault of the file and its treatment (docs/meshes.md).
  std::vector<std::string> warnings;
  std::vector<std::string>
      blockers;  // surfaces that only block, by the file itself: every run adds them to its question
};

// SceneOptions settle questions that a file leaves open.
struct SceneOptions {
  std::vector<std::string> sheets;  // coincident faces of these surfaces are back to back
  std::vector<std::string> solids;  // coincident faces of these surfaces are face to face
  std::vector<std::string> flip;    // surfaces ("desk") and faces ("desk[3]") to turn over
  bool fix_normals = false;         // turns over the shells whose backs lines meet (shells.h)
  double unit_m = 1;                // metres of one unit of the file: Scene, and areas with it, is in metres
};

// Makes a scene: validates, leaves out degenerate and repeated faces, and splits the rest into convex planar polygons.
// Then it scales to the unit ball, groups coplanar polygons into planes and orders the coincident ones.
//   In: faces in input units, any size and offset    Out: the scene, in unit-ball units
//   Error: corners to 1 ulp of the unit ball after the subtraction of the centre in double. Tests:
//     tests/unit/build_scene_test.cpp.
//   Throws: Error bad_input (NaN or infinite coordinates, no usable polygon, names that collide), naming file and line;
//     bad_usage for options that name absent surfaces or faces.
//   Cost: O(corners log corners) work and memory; some thousand rays for each turn of fix_normals.
Scene buildScene(const InputScene& input, const SceneOptions& options = {});

// Reads any format of docs/formats.md, chosen by the end of the file's name, and calls buildScene. A file without names
// of surfaces has one, named after the file. A folder is an OpenFOAM case.
//   In: file: any name; options: as for buildScene    Out, Error, Cost: as buildScene. Tests: tests/unit/load_test.cpp.
//   Throws: Error bad_input, naming file, line where the format has lines, and remedy; as buildScene.
Scene loadScene(const std::filesystem::path& file, const SceneOptions& options = {});

// Returns the name of a face: "desk[3]", or "desk" where the surface has one face only.
//   In: face_index into Scene::faces    Cost: O(1).
std::string faceName(const Scene& scene, uint32_t face_index);

// Returns the normal of a polygon's own corners, of unit length, on the side of its front.
//   In: a polygon of the scene    Cost: O(1).
glm::dvec3 frontNormal(const Scene& scene, const Polygon& polygon);

// Returns true where every edge of every polygon has an opposite edge of another polygon, as in the walls of a room.
// Touching of edges in part (T-junctions) counts. It is an estimate of intent for the summary, never used in numerics.
// Whether lines end on fronts is another question (leaks.h).
//   Cost: O(edges log edges).
bool isClosed(const Scene& scene);

// Returns a hash, 64 bits, of all that a count can depend on: geometry to the last bit, order, names; not the file's
// place.
//   Cost: O(corners).
uint64_t fingerprint(const Scene& scene);

}  // namespace viewpeel
