// loadScene() reads a file into an InputScene. buildScene() makes a Scene of it, on which everything else works.
#pragma once
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel {

// An InputFace is a face of the file: a simple polygon, whose corners run counter-clockwise seen from its front.
struct InputFace {
  std::vector<glm::dvec3> corners;  // input units
  uint32_t surface = 0;             // index into InputScene::surface_names
  uint32_t line = 0;                // line in the file; 0 where the format has no lines
};

// An InputFile is one of several files that make a scene.
struct InputFile {
  std::string file;         // as the user names it
  uint32_t first_face = 0;  // index into InputScene::faces
};

struct InputScene {
  std::string file;  // name that messages show
  std::vector<std::string> surface_names;
  std::vector<InputFace> faces;
  std::vector<std::string> warnings{};  // warnings of the reader, one line each
  // The file says that these surfaces only block, as Question::blockers does.
  std::vector<std::string> blockers{};
  // The file says that coincident faces of these surfaces are face to face, as SceneOptions::solids does.
  std::vector<std::string> solids{};
  // The file says that coincident faces of these surfaces are back to back, as SceneOptions::sheets does.
  std::vector<std::string> sheets{};
  bool is_outside = false;         // as Scene::is_outside
  std::vector<InputFile> files{};  // where several files make the scene, in the order of their faces; otherwise empty
};

// A line hits coplanar polygons at the same depth, and tie ranks decide their order. A rank is a position, from 0 to
// kTieRanks - 1, along the normal of the polygon's front. Take two polygons that look opposite ways. If both have
// kContactRank they face each other, as the walls of touching solids do. If both have kSheetRank they turn their backs
// to each other. Of two polygons that look the same way, the one of higher rank hides the other.
constexpr uint32_t kTieRanks = 8;
constexpr uint32_t kContactRank = 3;
constexpr uint32_t kSheetRank = 4;

// A Polygon is a convex planar piece of an input face: a triangle or a quadrilateral. Seen from its front, its corners
// run counter-clockwise.
struct Polygon {
  uint32_t first_corner = 0;  // index into Scene::corners
  uint32_t corner_count = 0;  // 3 or 4
  uint32_t face = 0;          // index into Scene::faces
  uint32_t plane = 0;         // index into Scene::planes
  bool front_along_plane_normal = true;
  uint32_t tie_rank = kContactRank;
  double area = 0;  // unit-ball units squared
};

// A Face is a face of the file that takes part in the computation. It may have been split into several polygons.
struct Face {
  uint32_t surface = 0;  // index into Scene::surfaces
  uint32_t number = 0;   // number within its surface, from 1, with empty rows
  uint32_t row = 0;      // number in the file, from 0, with empty rows
};

struct Surface {
  std::string name;
  uint32_t face_count = 0;  // faces in the file, with empty rows
};

// An EmptyRow is a face or surface of the file that takes no part: it has no area, or repeats another one. It keeps its
// name and its place among the rows of results, so that row k of results is face k of the file.
struct EmptyRow {
  uint32_t row = 0;  // counted from 0
  std::string name;
  bool operator==(const EmptyRow&) const = default;
};

// A Plane is shared by all coplanar polygons, whichever way they face. So a line hits them at exactly the same depth.
struct Plane {
  glm::dvec3 normal{0};  // unit length
  double offset = 0;     // dot(normal, x) = offset on the plane, unit-ball units
};

// Coincidences counts the pairs of polygons that coincide over some area, by their order (coincident.h).
struct Coincidences {
  uint64_t sheets = 0;    // pairs that lie back to back, as the two sides of a thin wall
  uint64_t contacts = 0;  // pairs that lie face to face, as the walls of touching solids
  uint64_t in_doubt = 0;  // sheets and contacts for which the polygons around them give contradictory answers
  // Pairs of polygons that look the same way, where the direction of a line decides which of the two it hits first.
  // Their planes cross within rounding, or they lie in a stack of more than kTieRanks polygons.
  uint64_t alike_unordered = 0;
};

// A Scene is the geometry that everything else works on. Its lengths are in unit-ball units: every corner is within
// distance 1 of the origin. A point x of the scene is centre + scale * x in input units.
struct Scene {
  std::string file;
  std::vector<glm::dvec3> corners;
  std::vector<Polygon> polygons;
  std::vector<Face> faces;
  std::vector<Surface> surfaces;                      // in the order in which the file first uses them
  std::vector<EmptyRow> empty_faces, empty_surfaces;  // in ascending order of rows
  std::vector<Plane> planes;
  glm::dvec3 centre{0};
  double scale = 1;
  Coincidences coincidences;
  // Each warning is one line: a fault of the file, how often it occurs, and how it was treated (docs/meshes.md).
  std::vector<std::string> warnings;
  // The file says that these surfaces only block. Every run adds them to Question::blockers.
  std::vector<std::string> blockers;
  bool is_outside = false;  // an EnergyPlus building seen from outside, by SceneOptions::outside
};

// SceneOptions answer questions that a file leaves open.
struct SceneOptions {
  std::vector<std::string> sheets;  // coincident faces of these surfaces are back to back
  std::vector<std::string> solids;  // coincident faces of these surfaces are face to face
  std::vector<std::string> flip;    // surfaces ("desk") and faces ("desk[3]") to turn over
  bool fix_normals = false;         // turn over the shells whose backs lines hit (shells.h)
  double unit_m = 1;                // metres in one unit of the file; all results are then in metres
  std::vector<std::string> zones;   // zones of an EnergyPlus building to read; empty: all
  bool outside = false;             // read an EnergyPlus building from outside, without its zones
  double lod = INFINITY;            // the highest level of detail to read of a city model's objects
};

// Makes a scene. It checks the faces, leaves out degenerate and repeated ones, and splits the rest into convex planar
// polygons. Then it scales them to the unit ball, groups coplanar polygons into planes, and orders coincident polygons.
//   In: input: faces in input units, of any size and offset    Out: the scene, in unit-ball units
//   Error: 1 ulp of the unit ball in each coordinate, after the centre is subtracted in double. Tests:
//     tests/unit/build_scene_test.cpp.
//   Throws: Error bad_input (NaN or infinite coordinates, no usable polygon, names that collide), naming file and line;
//     bad_usage for options that name absent surfaces or faces.
//   Cost: O(corners log corners) work and memory. With fix_normals it also casts some thousand rays for each pass over
//     the shells.
Scene buildScene(const InputScene& input, const SceneOptions& options = {});

// Reads a file of any format of docs/formats.md, and calls buildScene(). The end of the file's name chooses the format.
// A folder is read as an OpenFOAM case. Where the file names no surface, all its faces are one surface with the file's
// name.
//   In: file: any name; options: as for buildScene    Out, Error, Cost: as buildScene. Tests: tests/unit/load_test.cpp.
//   Throws: as buildScene; Error bad_input for a file that cannot be read, naming file, line and remedy.
Scene loadScene(const std::filesystem::path& file, const SceneOptions& options = {});

// Reads several files into one scene, each with some of its parts. Rows are in the order of the files. A surface name
// that occurs in several files has the name of its file and a slash before it: "inner/wall". All files have the same
// unit of length and the same axes. Scene::file names the files without their folders.
//   In: files: .obj, .stl, .ply, .gltf, .glb, .msh, .vtp, .vtu, .json or .jsonl; a single file may have any format
//   Out, Error, Cost: as buildScene. Tests: tests/unit/join_scenes_test.cpp.
//   Throws: as loadScene; Error bad_usage for no file, for a file that is named twice, and for another format.
Scene loadScene(const std::vector<std::filesystem::path>& files, const SceneOptions& options = {});

// Returns the name of a face: "desk[3]", or "desk" where the surface has only one face.
//   In: face_index: index into Scene::faces    Cost: O(1).
std::string faceName(const Scene& scene, uint32_t face_index);

// Returns the unit normal of a polygon, on the side of its front. It is computed from the polygon's own corners, not
// from its shared plane.
//   In: polygon: of the scene    Cost: O(1).
glm::dvec3 frontNormal(const Scene& scene, const Polygon& polygon);

// Returns true if every edge of every polygon has an opposite edge of another polygon, as in the walls of a room. Edges
// that touch only in part (T-junctions) count. The answer is a guess for the summary, and no number depends on it.
// Whether lines end on fronts is a different question (leaks.h).
//   Cost: O(edges log edges).
bool isClosed(const Scene& scene);

// Returns a 64-bit hash of everything that a count can depend on: the geometry to the last bit, the order of faces, and
// the names. The path of the file does not matter.
//   Cost: O(corners).
uint64_t fingerprint(const Scene& scene);

}  // namespace viewpeel
