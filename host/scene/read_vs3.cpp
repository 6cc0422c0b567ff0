#include "scene/read_vs3.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <glm/glm.hpp>

#include "scene/cut_away.h"
#include "scene/face_names.h"
#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

// View3D allows these deviations: distance from the base's plane over the subsurface's radius, and cosine of the
// normals.
constexpr double kPlaneTolerance = 1e-5, kLeastCosine = 0.999;
constexpr double kOutsideTolerance = 1e-6;  // distance outside the base over its size

glm::dvec3 centreOf(const std::vector<glm::dvec3>& corners) {
  glm::dvec3 sum(0);
  for (const glm::dvec3& corner : corners) sum += corner;
  return sum / double(corners.size());
}

double radiusOf(const std::vector<glm::dvec3>& corners) {
  double radius = 0;
  for (const glm::dvec3& corner : corners) radius = std::max(radius, glm::distance(corner, centreOf(corners)));
  return radius;
}

class SceneMaker {
 public:
  SceneMaker(const Vs3File& file, bool merges)
      : file_(file), merges_(merges), holes_(file.surfaces.size()), surface_of_(file.surfaces.size(), 0) {
    scene_.file = file.file;
    scene_.warnings = file.warnings;
  }

  Vs3Scene make() {
    for (const Vs3Surface& surface : file_.surfaces)
      if (surface.base) addHole(surface);
    nameSurfaces();
    for (const bool blocks : {false, true})
      for (uint32_t k = 0; k < file_.surfaces.size(); ++k)
        if ((file_.surfaces[k].kind == 'O' || file_.surfaces[k].kind == 'N') == blocks) addSurface(k);
    return {std::move(scene_), std::move(surface_of_)};
  }

 private:
  // Cuts the part of a subsurface out of its base. A mask only hides its part, so nothing is cut out for it.
  void addHole(const Vs3Surface& surface) {
    const FilePlace place{file_.file, surface.line};
    const Vs3Surface& base = file_.surfaces[surface.base - 1];
    const glm::dvec3 base_normal = twiceAreaNormal(base.corners), normal = twiceAreaNormal(surface.corners);
    if (!(glm::length(base_normal) > 0) || !(glm::length(normal) > 0))
      place.refuse("the surface or its base has no area");
    const glm::dvec3 n = glm::normalize(base_normal);
    const double cosine = glm::dot(n, glm::normalize(normal));
    for (const glm::dvec3& corner : surface.corners)
      if (std::abs(glm::dot(n, corner - base.corners[0])) > kPlaneTolerance * radiusOf(surface.corners))
        place.refuse(fmt::format("the surface does not lie in the plane of its base {}; correct it", surface.base));
    if (surface.kind == 'S' && cosine < kLeastCosine)
      place.refuse(fmt::format("a subsurface faces as its base {} does; reverse its vertices", surface.base));
    if (surface.kind != 'S' && cosine > -kLeastCosine)
      place.refuse(fmt::format("a mask or null surface faces its base {}; reverse its vertices", surface.base));
    for (size_t k = 0; k < base.corners.size(); ++k) {
      const glm::dvec3 &a = base.corners[k], &b = base.corners[(k + 1) % base.corners.size()];
      const glm::dvec3 inward = glm::cross(n, b - a);
      for (const glm::dvec3& corner : surface.corners)
        if (glm::dot(inward, corner - a) < -kOutsideTolerance * glm::length(inward) * radiusOf(base.corners))
          place.refuse(fmt::format("the surface is not within its base {}; correct it", surface.base));
    }
    if (surface.kind != 'M') holes_[surface.base - 1].push_back(surface.corners);
  }

  // Gives each surface a different name.
  void nameSurfaces() {
    std::map<std::string, uint32_t> uses;
    for (const Vs3Surface& surface : file_.surfaces)
      if (!isMerged(surface)) ++uses[surface.name];
    for (uint32_t k = 0; k < file_.surfaces.size(); ++k) {
      const Vs3Surface& surface = file_.surfaces[k];
      const char* kind = surface.kind == 'O' ? "obstruction" : surface.kind == 'N' ? "null" : "surface";
      const bool is_taken = isReservedName(surface.name);
      std::string name = surface.name.empty() ? kind : surface.name;
      if (surface.name.empty() || uses[surface.name] > 1 || is_taken) name += fmt::format("#{}", k + 1);
      names_.push_back(std::move(name));
    }
  }

  bool isMerged(const Vs3Surface& surface) const { return merges_ && surface.merged_into; }

  void addSurface(uint32_t k) {
    const Vs3Surface& surface = file_.surfaces[k];
    uint32_t number = static_cast<uint32_t>(scene_.surface_names.size());
    if (isMerged(surface)) {
      number = surface_of_[surface.merged_into - 1];
    } else {
      scene_.surface_names.push_back(names_[k]);
      if (surface.kind == 'O' || surface.kind == 'N') scene_.blockers.push_back(names_[k]);
      if (surface.kind == 'M') scene_.solids.push_back(names_[k]);
    }
    surface_of_[k] = number;
    std::vector<glm::dvec3> corners = surface.corners;
    // A null surface looks the same way as its base.
    if (surface.kind == 'N') std::reverse(corners.begin(), corners.end());
    const glm::dvec3 normal = twiceAreaNormal(corners);
    std::vector<std::vector<glm::dvec3>> pieces = {corners};
    if (!holes_[k].empty()) pieces = cutAway(corners, glm::normalize(normal), holes_[k]);
    if (pieces.empty())
      FilePlace{file_.file, surface.line}.refuse(
          "its subsurfaces leave nothing of the surface; give it as O, or drop it");
    for (std::vector<glm::dvec3>& piece : pieces) scene_.faces.push_back({std::move(piece), number, surface.line});
  }

  const Vs3File& file_;
  bool merges_;
  InputScene scene_;
  std::vector<std::vector<std::vector<glm::dvec3>>> holes_;  // by surface
  std::vector<std::string> names_;
  std::vector<uint32_t> surface_of_;
};

}  // namespace

Vs3Scene makeScene(const Vs3File& file, bool merges) { return SceneMaker(file, merges).make(); }

InputScene readVs3(const std::filesystem::path& file) { return makeScene(parseVs3(file)).input; }

}  // namespace viewpeel
