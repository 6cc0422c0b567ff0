// The zones of an EnergyPlus building, seen from within. Zones stay where they are: no zone sees another one, for its
// surfaces enclose it, and two zones' surfaces in one wall are back to back.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <glm/glm.hpp>

#include "scene/cut_away.h"
#include "scene/energyplus.h"
#include "scene/energyplus_objects.h"
#include "scene/readers.h"
#include "scene/split_face.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

using Corners = std::vector<glm::dvec3>;

// Distance of a window's corners from its wall over the wall's size: what is moved without a word, and what is at all.
constexpr double kRounding = 1e-6, kMostMoved = 1e-2;
constexpr double kLeastCosine = 0.999;
// Corners nearer than this, in the unit of the wall's size, are one.
constexpr double kSameCorner = 1e-12;

// Corners in world coordinates, counter-clockwise seen from within the zone.
Corners seenFromWithin(const EnergyPlusSurface& surface, const EnergyPlusZone& zone,
                       const EnergyPlusBuilding& building) {
  Corners corners = surface.corners;
  if (building.is_relative) {
    const double angle = -zone.relative_north_deg * std::numbers::pi / 180;
    const double c = std::cos(angle), s = std::sin(angle);
    for (glm::dvec3& p : corners)
      p = zone.origin + (zone.relative_north_deg == 0 ? p : glm::dvec3(p.x * c - p.y * s, p.x * s + p.y * c, p.z));
  }
  if (!building.is_clockwise) std::reverse(corners.begin(), corners.end());
  return corners;
}

double sizeOf(const Corners& corners) {
  double size = 0;
  for (const glm::dvec3& corner : corners) size = std::max(size, glm::distance(corner, corners[0]));
  return size;
}

// Moves a window into the plane of its wall. Returns by how much, over the wall's size.
double moveIntoPlane(Corners& window, const Corners& wall, const FilePlace& place, const std::string& name) {
  const glm::dvec3 up = twiceAreaNormal(wall), of_window = twiceAreaNormal(window);
  const double size = sizeOf(wall);
  if (!(glm::length(up) > 0) || !(glm::length(of_window) > 0))
    place.refuse(fmt::format("window '{}' or its wall has no area; correct it", printable(name)));
  const glm::dvec3 n = glm::normalize(up);
  if (glm::dot(n, glm::normalize(of_window)) < kLeastCosine)
    place.refuse(fmt::format("window '{}' does not face as its wall does; reverse its vertices", printable(name)));
  double largest = 0;
  for (glm::dvec3& corner : window) {
    const double off = glm::dot(n, corner - wall[0]);
    largest = std::max(largest, std::abs(off) / size);
    corner -= off * n;
  }
  if (largest > kMostMoved)
    place.refuse(fmt::format("window '{}' does not lie in the plane of its wall; correct it", printable(name)));
  return largest;
}

// A wall without its windows, in convex pieces.
std::vector<Corners> piecesOf(Corners wall, const std::vector<Corners>& holes, const FilePlace& place,
                              const std::string& name) {
  if (holes.empty()) return {std::move(wall)};
  const double least = kSameCorner * sizeOf(wall);
  Corners distinct;
  for (const glm::dvec3& corner : wall)
    if (distinct.empty() || glm::distance(corner, distinct.back()) > least) distinct.push_back(corner);
  while (distinct.size() > 1 && glm::distance(distinct.front(), distinct.back()) <= least) distinct.pop_back();
  const glm::dvec3 normal = glm::normalize(twiceAreaNormal(wall));
  double hole_area = 0, cut_area = 0;
  for (const Corners& hole : holes) hole_area += glm::length(twiceAreaNormal(hole)) / 2;
  std::vector<Corners> pieces;
  const Pieces convex = distinct.size() < 3 ? Pieces{} : splitFace(distinct).value_or(Pieces{});
  if (convex.empty())
    place.refuse(fmt::format("surface '{}' crosses itself, or has too many corners; correct it", printable(name)));
  for (const std::vector<uint32_t>& piece : convex) {
    Corners corners;
    for (uint32_t k : piece) corners.push_back(distinct[k]);
    cut_area += glm::length(twiceAreaNormal(corners)) / 2;
    for (Corners& left : cutAway(corners, normal, holes)) {
      cut_area -= glm::length(twiceAreaNormal(left)) / 2;
      pieces.push_back(std::move(left));
    }
  }
  if (std::abs(cut_area - hole_area) > kMostMoved * hole_area)
    place.refuse(fmt::format("windows of '{}' overlap, or are not within it; correct them", printable(name)));
  if (pieces.empty()) place.refuse(fmt::format("windows leave nothing of '{}'; correct them", printable(name)));
  return pieces;
}

}  // namespace

InputScene readEnergyPlusZones(const std::filesystem::path& file) {
  const EnergyPlusBuilding building = readEnergyPlus(file);
  const std::vector<uint32_t> zones = zonesOf(building);
  const auto count = static_cast<uint32_t>(building.surfaces.size());
  std::map<std::string, uint32_t> by_name;
  std::vector<Corners> corners(count);
  for (uint32_t k = 0; k < count; ++k) {
    by_name.emplace(lowerCase(building.surfaces[k].name), k);
    corners[k] = seenFromWithin(building.surfaces[k], building.zones[zones[k]], building);
  }
  InputScene scene{building.file, {}, {}};
  std::vector<std::vector<Corners>> holes(count);
  uint64_t moved = 0, multiplied = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const EnergyPlusSurface& surface = building.surfaces[k];
    if (surface.base.empty()) continue;
    const uint32_t base = by_name.at(lowerCase(surface.base));
    const double off = moveIntoPlane(corners[k], corners[base], FilePlace{building.file, surface.line}, surface.name);
    moved += off > kRounding;
    multiplied += surface.multiplier != 1;
    holes[base].push_back(corners[k]);
  }
  for (uint32_t k = 0; k < count; ++k) {
    const EnergyPlusSurface& surface = building.surfaces[k];
    scene.surface_names.push_back(surface.name);
    for (Corners& piece : piecesOf(corners[k], holes[k], FilePlace{building.file, surface.line}, surface.name))
      scene.faces.push_back({std::move(piece), k, surface.line});
  }
  scene.sheets = scene.surface_names;
  const auto warn = [&](uint64_t number, const char* what) {
    if (number) scene.warnings.push_back(fmt::format("{}: {} {}", building.file, number, what));
  };
  warn(moved, "windows were moved into the planes of their walls");
  warn(multiplied, "windows have a multiplier; each counts once here, as it is drawn");
  warn(building.internal_masses, "InternalMass have no geometry, and get no view factors");
  return scene;
}

}  // namespace viewpeel
