// readFoam() makes a scene of an OpenFOAM case. Faces of the mesh look outward, so corners are reversed to look inward.
#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

#include "scene/cut_away.h"
#include "scene/foam_case.h"
#include "scene/foam_file.h"
#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

constexpr double kFlatness = 1e-6;  // largest distance of a corner from a flat face's mean plane, over its size

// A Mesh holds the points and faces of one rank's mesh.
class Mesh {
 public:
  explicit Mesh(const fs::path& folder)
      : file_((folder / "polyMesh" / "faces").string()),
        points_(FoamFile(folder / "polyMesh" / "points").points()),
        faces_(FoamFile(folder / "polyMesh" / "faces").faces()) {}

  // Returns the corners of a face, counter-clockwise seen from within the mesh.
  std::vector<glm::dvec3> corners(uint64_t face) const {
    if (face >= faces_.count())
      FilePlace{file_}.refuse(fmt::format("there is no face {}, which a patch has; make the mesh again", face));
    std::vector<glm::dvec3> corners;
    for (uint64_t k = faces_.size(face); k-- > 0;) {
      const int64_t point = faces_.begin(face)[k];
      if (point < 0 || static_cast<uint64_t>(point) >= points_.size() / 3)
        FilePlace{file_}.refuse(
            fmt::format("face {} has point {}, which is not there; make the mesh again", face, point));
      const double* p = &points_[3 * static_cast<size_t>(point)];
      corners.emplace_back(p[0], p[1], p[2]);
    }
    return corners;
  }

 private:
  std::string file_;
  std::vector<double> points_;
  FoamLists faces_;
};

bool isCurved(const std::vector<InputFace>& faces, size_t first) {
  glm::dvec3 normal(0);
  for (size_t k = first; k < faces.size(); ++k) normal += twiceAreaNormal(faces[k].corners);
  const double size = std::sqrt(glm::length(normal));
  if (!(size > 0)) return false;
  for (size_t k = first; k < faces.size(); ++k)
    for (const glm::dvec3& corner : faces[k].corners)
      if (std::abs(glm::dot(normal, corner - faces[first].corners[0])) > kFlatness * size * size * size) return true;
  return false;
}

}  // namespace

InputScene readFoam(const fs::path& folder) {
  InputScene scene{folder.string(), {}, {}};
  uint64_t curved_count = 0;
  std::string first_curved;
  for (const FoamRank& rank : readFoamCase(folder)) {
    const Mesh mesh(rank.folder);
    for (const FoamRank::CoarseFace& coarse : rank.coarse_faces) {
      const size_t first = scene.faces.size();
      for (uint64_t face : coarse.of_mesh)
        scene.faces.push_back({mesh.corners(face), static_cast<uint32_t>(scene.surface_names.size())});
      if (isCurved(scene.faces, first) && curved_count++ == 0) first_curved = coarse.name;
      scene.surface_names.push_back(coarse.name);
    }
  }
  if (curved_count)
    scene.warnings.push_back(
        fmt::format("{}: {} of {} coarse faces are curved, {} first; OpenFOAM from v2206 on "
                    "leaves out what such a face sends to itself",
                    scene.file, curved_count, scene.surface_names.size(), first_curved));
  return scene;
}

}  // namespace viewpeel
