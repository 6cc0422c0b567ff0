#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>
#include "scene/coincident.h"
#include "scene/face_names.h"
#include "scene/group_planes.h"
#include "scene/join_scenes.h"
#include "scene/overlaps.h"
#include "scene/perimeter.h"
#include "scene/precision.h"
#include <viewpeel/scene.h>
#include "scene/shells.h"
#include "scene/sight.h"
#include "scene/split_face.h"

namespace viewpeel {
namespace {

// With a radius in this range, input units, areas and their squares neither overflow nor vanish in double. This holds
// even for polygons of 1e-32 of the radius squared.
constexpr double kLargestRadius = 1e60, kSmallestRadius = 1e-60;

// Sets the centre and the scale of the scene: the ball around the bounding box, which holds every corner.
void fitUnitBall(const InputScene& input, Scene& scene) {
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const InputFace& face : input.faces)
    for (const glm::dvec3& corner : face.corners) {
      if (!std::isfinite(corner.x) || !std::isfinite(corner.y) || !std::isfinite(corner.z))
        throw Error(ErrorCode::bad_input,
                    fmt::format("{}: a coordinate is not a finite number; correct it", placeOfFace(input, face)));
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  scene.centre = low / 2.0 + high / 2.0;
  double squared = 0;
  // Coordinates are scaled first, so that squares neither overflow nor vanish.
  const glm::dvec3 half = high / 2.0 - low / 2.0;
  const double largest = std::max({half.x, half.y, half.z});
  if (largest == 0 || !std::isnormal(largest))
    throw Error(ErrorCode::bad_input,
                fmt::format("{}: no usable polygon: all corners lie at one point; check the file", input.file));
  for (const InputFace& face : input.faces)
    for (const glm::dvec3& corner : face.corners) {
      const glm::dvec3 v = (corner - scene.centre) / largest;
      squared = std::max(squared, glm::dot(v, v));
    }
  scene.scale = std::sqrt(squared) * largest * (1 + 1e-15);
  if (scene.scale > kLargestRadius || scene.scale < kSmallestRadius)
    throw Error(ErrorCode::bad_input, fmt::format("{}: the scene's radius of {:.3g} is beyond {:g} to {:g}: areas "
                                                  "would not be numbers; take another unit of length",
                                                  input.file, scene.scale, kSmallestRadius, kLargestRadius));
}

// Returns the corners of a face, without corners that repeat the corner before.
std::vector<glm::dvec3> distinctCorners(const InputFace& face, const Scene& scene) {
  std::vector<glm::dvec3> corners;
  for (const glm::dvec3& input : face.corners) corners.push_back((input - scene.centre) / scene.scale);
  return withoutRepeats(std::move(corners));
}

// Returns whether a face is wider than the rounding of its coordinates in a cross product of edges. A coordinate is
// rounded to 2^-53 of itself in the file, and once more in the unit ball.    In: corners: in unit-ball units
bool hasArea(const std::vector<glm::dvec3>& corners, const Scene& scene) {
  const double farthest = glm::length(scene.centre) / scene.scale;  // from the file's origin
  return glm::length(twiceVectorArea(corners)) > 8 * 0x1p-53 * (1 + farthest) * perimeterOf(corners);
}

// Returns why a face takes no part, and gets an empty row; nullptr where it takes part.
const char* reasonToDrop(const std::vector<glm::dvec3>& corners, const Scene& scene) {
  if (corners.size() < 3) return "fewer than three different corners";
  return hasArea(corners, scene) ? nullptr : "zero area";
}

// Dropped collects the warnings about faces that are left out.
class Dropped {
 public:
  void count(const char* reason, const std::string& where) {
    auto& [number, first] = reasons_[reason];
    if (number++ == 0) first = where;
  }
  std::vector<std::string> warnings() const {
    std::vector<std::string> lines;
    for (const auto& [reason, counted] : reasons_) {
      const bool is_one = counted.first == 1;
      lines.push_back(fmt::format("{}: {} {} dropped: {}; {}, and later numbers do not shift", counted.second,
                                  counted.first, is_one ? "face" : "faces, this one first,", reason,
                                  is_one ? "its row stays, empty" : "their rows stay, empty"));
    }
    return lines;
  }

 private:
  std::map<std::string, std::pair<uint64_t, std::string>> reasons_;
};

// Gives every face and surface of the file its row. Surfaces that take no part get empty rows.
//   In: is_left_out: bool[face of the file]
void addRows(const InputScene& input, const std::vector<bool>& is_left_out, Scene& scene) {
  constexpr uint32_t kNone = UINT32_MAX;
  const std::vector<std::string> names = nameFaces(input);
  std::vector<bool> is_used(input.surface_names.size(), false);
  for (uint32_t row = 0; row < input.faces.size(); ++row)
    if (!is_left_out[row]) is_used[input.faces[row].surface] = true;
  std::vector<uint32_t> surface_of_input(is_used.size(), kNone), counts(is_used.size(), 0);
  uint32_t surface_row = 0;
  for (uint32_t row = 0; row < input.faces.size(); ++row) {
    const uint32_t of_input = input.faces[row].surface;
    const uint32_t number = ++counts[of_input];
    uint32_t& surface = surface_of_input[of_input];
    if (number == 1 && !is_used[of_input]) scene.empty_surfaces.push_back({surface_row, input.surface_names[of_input]});
    if (number == 1) ++surface_row;
    if (is_used[of_input] && surface == kNone) {
      surface = static_cast<uint32_t>(scene.surfaces.size());
      scene.surfaces.push_back({input.surface_names[of_input], 0});
    }
    if (is_used[of_input]) ++scene.surfaces[surface].face_count;
    if (is_left_out[row]) scene.empty_faces.push_back({row, names[row]});
    else scene.faces.push_back({surface, number, row});
  }
}

// Adds a convex piece of a face to the scene, as quadrilaterals and triangles that share its first corner.
void addPiece(const std::vector<glm::dvec3>& corners, const std::vector<uint32_t>& piece, uint32_t face, Scene& scene) {
  for (size_t k = 1; k + 1 < piece.size(); k += 2) {
    std::vector<glm::dvec3> polygon_corners = {corners[piece[0]], corners[piece[k]], corners[piece[k + 1]]};
    if (k + 2 < piece.size()) polygon_corners.push_back(corners[piece[k + 2]]);
    if (piece.size() > 4 && !hasArea(polygon_corners, scene)) continue;  // its corners lie on one edge
    Polygon polygon;
    polygon.first_corner = static_cast<uint32_t>(scene.corners.size());
    polygon.corner_count = static_cast<uint32_t>(polygon_corners.size());
    polygon.face = face;
    polygon.area = glm::length(twiceVectorArea(polygon_corners)) / 2;
    scene.polygons.push_back(polygon);
    scene.corners.insert(scene.corners.end(), polygon_corners.begin(), polygon_corners.end());
  }
}

// Makes a scene in which coincident polygons have no order yet.
//   In: repeats: faces that repeat others, and are left out
Scene splitFaces(const InputScene& input, const std::vector<Duplicate>& repeats) {
  Scene scene;
  scene.file = input.file;
  scene.warnings = input.warnings;
  scene.blockers = input.blockers;
  scene.is_outside = input.is_outside;
  if (std::string coarse = describeCoarseSteps(input); !coarse.empty()) scene.warnings.push_back(std::move(coarse));
  fitUnitBall(input, scene);
  std::vector<bool> is_left_out(input.faces.size(), false);
  Dropped dropped;
  for (size_t row = 0; row < input.faces.size(); ++row) {
    const char* reason = reasonToDrop(distinctCorners(input.faces[row], scene), scene);
    if (reason) dropped.count(reason, placeOfFace(input, input.faces[row]));
    is_left_out[row] = reason != nullptr;
  }
  for (const Duplicate& repeat : repeats) is_left_out[repeat.face] = true;
  addRows(input, is_left_out, scene);
  for (uint32_t face = 0; face < scene.faces.size(); ++face) {
    const InputFace& of_file = input.faces[scene.faces[face].row];
    const std::vector<glm::dvec3> corners = distinctCorners(of_file, scene);
    const std::optional<Pieces> pieces = splitFace(corners);
    // A file without lines is searched for the face by name.
    const auto refuse = [&](const std::string& what) {
      const std::string name = of_file.line ? "the face" : fmt::format("face '{}'", faceName(scene, face));
      throw Error(ErrorCode::bad_input, fmt::format("{}: {} {}", placeOfFace(input, of_file), name, what));
    };
    if (!pieces)
      refuse(fmt::format("has {} corners, too many to cut it into convex pieces in seconds; split it into several",
                         corners.size()));
    if (pieces->empty()) refuse("crosses itself; split it into simple ones");
    for (const std::vector<uint32_t>& piece : *pieces) addPiece(corners, piece, face, scene);
  }
  for (std::string& line : dropped.warnings()) scene.warnings.push_back(std::move(line));
  if (scene.polygons.empty())
    throw Error(ErrorCode::bad_input, fmt::format("{}: no usable polygon; all {} faces have no area, check the export",
                                                  input.file, input.faces.size()));
  groupPlanes(scene);
  return scene;
}

std::string describeRepeats(const InputScene& input, const std::vector<Duplicate>& repeats) {
  const std::vector<std::string> names = nameFaces(input);
  const auto nameOf = [&](uint32_t face) {
    const uint32_t line = input.faces[face].line;
    if (!input.files.empty()) return fmt::format("{} ({})", names[face], placeOfFace(input, input.faces[face]));
    return line ? fmt::format("{} (line {})", names[face], line)
                : fmt::format("{} (face {} of the file)", names[face], face + 1);
  };
  const Duplicate& first = repeats.front();
  const bool is_one = repeats.size() == 1;
  return fmt::format(
      "{}: {} there already, facing alike: {}{} is {} again; {}; remove {} from the file", input.file,
      is_one ? "1 face is" : fmt::format("{} faces are", repeats.size()), is_one ? "" : "the first, ",
      nameOf(first.face), nameOf(first.of),
      is_one ? "it is left out and its row stays, empty" : "they are left out and their rows stay, empty",
      is_one ? "it" : "them");
}

Scene assemble(const InputScene& input, const SceneOptions& options) {
  const double rounding = roundingOf(input);
  std::vector<Duplicate> repeats;
  for (;;) {
    Scene scene = splitFaces(input, repeats);
    const std::vector<AlikeOverlap> alike = orderCoincidentPolygons(scene, options, rounding / scene.scale);
    const std::vector<Duplicate> more = findDuplicates(input, scene, alike, rounding);
    repeats.insert(repeats.end(), more.begin(), more.end());
    if (!more.empty()) continue;  // the scene is made again without these duplicates
    if (!repeats.empty()) scene.warnings.push_back(describeRepeats(input, repeats));
    if (!alike.empty()) scene.warnings.push_back(describeOverlaps(scene, alike));
    return scene;
  }
}

void turnFace(InputFace& face) { std::reverse(face.corners.begin(), face.corners.end()); }

std::vector<uint32_t> findFlipped(const Scene& scene) {
  Sight sight(scene);
  return findFlipped(scene, findShells(scene), sight);
}

std::string describeFixed(const Scene& scene, const std::vector<uint32_t>& flipped) {
  constexpr size_t kMostNamed = 5;
  std::set<uint32_t> surfaces;
  for (uint32_t face : flipped) surfaces.insert(scene.faces[face].surface);
  std::string names;
  size_t named = 0;
  for (uint32_t surface : surfaces)
    if (named++ < kMostNamed) names += fmt::format("{}{}", named > 1 ? ", " : "", scene.surfaces[surface].name);
  return fmt::format("{}: --fix-normals turned {} of {} faces over, of {}{}", scene.file, flipped.size(),
                     scene.faces.size(), names,
                     named > kMostNamed ? fmt::format(" and {} more", named - kMostNamed) : "");
}

}  // namespace

glm::dvec3 frontNormal(const Scene& scene, const Polygon& polygon) {
  const glm::dvec3* corners = &scene.corners[polygon.first_corner];
  glm::dvec3 normal(0);
  for (uint32_t k = 1; k + 1 < polygon.corner_count; ++k)
    normal += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
  return glm::normalize(normal);
}

namespace {

Scene buildInFileUnits(const InputScene& input, const SceneOptions& options) {
  if (input.faces.empty())
    throw Error(ErrorCode::bad_input,
                fmt::format("{}: no usable polygon; the file has no faces, check the export", input.file));
  requireDistinctNames(input);
  if (options.flip.empty() && !options.fix_normals) return assemble(input, options);
  InputScene turned = input;
  std::set<uint32_t> faces;
  for (const std::string& name : options.flip)
    for (uint32_t face : findFaces(input, name, "--flip")) faces.insert(face);
  for (uint32_t face : faces) turnFace(turned.faces[face]);
  Scene scene = assemble(turned, options);
  if (!options.fix_normals) return scene;
  const std::vector<uint32_t> flipped = findFlipped(scene);
  if (flipped.empty()) return scene;
  const std::string fixed = describeFixed(scene, flipped);
  for (uint32_t face : flipped) turnFace(turned.faces[scene.faces[face].row]);
  scene = assemble(turned, options);
  scene.warnings.push_back(fixed);
  return scene;
}

}  // namespace

// A unit changes only `centre` and `scale`, because all computation happens in unit-ball units.
Scene buildScene(const InputScene& input, const SceneOptions& given) {
  SceneOptions options = given;
  options.solids.insert(options.solids.end(), input.solids.begin(), input.solids.end());
  options.sheets.insert(options.sheets.end(), input.sheets.begin(), input.sheets.end());
  Scene scene = buildInFileUnits(input, options);
  scene.centre *= options.unit_m;
  scene.scale *= options.unit_m;
  return scene;
}

}  // namespace viewpeel
