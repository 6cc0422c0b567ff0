// This file makes scenes of EnergyPlus buildings. All zones form one scene: no zone sees another one, for its surfaces
// enclose it, and a wall's surfaces in two zones are back to back. In the scene outside the zones fronts look outward,
// so that these two surfaces are face to face.
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

// A window's distance from its wall's plane, over the wall's size, up to which it is moved silently, and moved at all.
constexpr double kRounding = 1e-6, kMostMoved = 1e-2;
constexpr double kLeastWindowCosine = 0.999;
// Corners nearer to each other than this, over the wall's size, are the same.
constexpr double kSameCorner = 1e-12;

// Turns corners clockwise about the z axis, seen from above, then adds the origin.
Corners turned(Corners corners, double clockwise_deg, const glm::dvec3& origin = glm::dvec3(0)) {
  const double angle = -clockwise_deg * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  for (glm::dvec3& p : corners)
    p = origin + (clockwise_deg == 0 ? p : glm::dvec3(p.x * c - p.y * s, p.x * s + p.y * c, p.z));
  return corners;
}

// Returns corners in the building's coordinates, counter-clockwise seen from within the zone or from outside.
Corners seenFrom(bool outside, const EnergyPlusSurface& surface, const EnergyPlusZone& zone,
                 const EnergyPlusBuilding& building) {
  Corners corners =
      building.is_relative ? turned(surface.corners, zone.relative_north_deg, zone.origin) : surface.corners;
  if (building.is_clockwise == outside) std::reverse(corners.begin(), corners.end());
  return corners;
}

// Returns the corners of a shading surface in the building's coordinates. Shading of the site is in world coordinates,
// in which the building is turned by its north axis.
Corners placed(const EnergyPlusShading& shading, const EnergyPlusBuilding& building) {
  if (!building.is_relative || shading.of == EnergyPlusShading::Of::building) return shading.corners;
  if (shading.of == EnergyPlusShading::Of::site) return turned(shading.corners, -building.north_axis_deg);
  const std::vector<uint32_t> zones = zonesOf(building);
  for (size_t k = 0; k < building.surfaces.size(); ++k)
    if (lowerCase(building.surfaces[k].name) == lowerCase(shading.base)) {
      const EnergyPlusZone& zone = building.zones[zones[k]];
      return turned(shading.corners, zone.relative_north_deg, zone.origin);
    }
  FilePlace{building.file, shading.line}.refuse(fmt::format("shading surface '{}' has no base surface '{}'; correct it",
                                                            printable(shading.name), printable(shading.base)));
}

double sizeOf(const Corners& corners) {
  double size = 0;
  for (const glm::dvec3& corner : corners) size = std::max(size, glm::distance(corner, corners[0]));
  return size;
}

// Moves a window into the plane of its wall. Returns the largest distance that a corner moved, over the wall's size.
double moveIntoPlane(Corners& window, const Corners& wall, const FilePlace& place, const std::string& name) {
  const glm::dvec3 up = twiceAreaNormal(wall), of_window = twiceAreaNormal(window);
  const double size = sizeOf(wall);
  if (!(glm::length(up) > 0) || !(glm::length(of_window) > 0))
    place.refuse(fmt::format("window '{}' or its wall has no area; correct it", printable(name)));
  const glm::dvec3 n = glm::normalize(up);
  if (glm::dot(n, glm::normalize(of_window)) < kLeastWindowCosine)
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

// Returns a wall without its windows, in convex pieces.
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

// Adds surfaces in the order of the file, with the windows cut out of them.
//   In: is_there: by surface, whether to add it; a window is added with its base
void addSurfaces(const EnergyPlusBuilding& building, bool outside, const std::vector<bool>& is_there,
                 InputScene& scene) {
  const std::vector<uint32_t> zones = zonesOf(building);
  const auto count = static_cast<uint32_t>(building.surfaces.size());
  std::map<std::string, uint32_t> by_name;
  std::vector<Corners> corners(count);
  for (uint32_t k = 0; k < count; ++k) {
    by_name.emplace(lowerCase(building.surfaces[k].name), k);
    corners[k] = seenFrom(outside, building.surfaces[k], building.zones[zones[k]], building);
  }
  std::vector<std::vector<Corners>> holes(count);
  uint64_t moved = 0, multiplied = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const EnergyPlusSurface& surface = building.surfaces[k];
    if (surface.base.empty() || !is_there[k]) continue;
    const uint32_t base = by_name.at(lowerCase(surface.base));
    const double off = moveIntoPlane(corners[k], corners[base], FilePlace{building.file, surface.line}, surface.name);
    moved += off > kRounding;
    multiplied += surface.multiplier != 1;
    holes[base].push_back(corners[k]);
  }
  for (uint32_t k = 0; k < count; ++k) {
    const EnergyPlusSurface& surface = building.surfaces[k];
    if (!is_there[k]) continue;
    const auto number = static_cast<uint32_t>(scene.surface_names.size());
    scene.surface_names.push_back(surface.name);
    for (Corners& piece : piecesOf(corners[k], holes[k], FilePlace{building.file, surface.line}, surface.name))
      scene.faces.push_back({std::move(piece), number, surface.line});
  }
  const auto warn = [&](uint64_t number, const char* what) {
    if (number) scene.warnings.push_back(fmt::format("{}: {} {}", building.file, number, what));
  };
  warn(moved, "windows were moved into the planes of their walls");
  warn(multiplied, "windows have a multiplier; each counts once here, as it is drawn");
  warn(outside ? 0 : building.internal_masses, "InternalMass have no geometry, and get no view factors");
}

// Returns for each surface whether it is in a zone with one of these names.
std::vector<bool> areIn(const EnergyPlusBuilding& building, const std::vector<std::string>& names) {
  std::vector<bool> is_chosen(building.zones.size(), names.empty());
  for (const std::string& name : names) {
    const auto zone =
        std::ranges::find(building.zones, lowerCase(name), [](const EnergyPlusZone& of) { return lowerCase(of.name); });
    if (zone == building.zones.end())
      throw Error(ErrorCode::bad_usage,
                  fmt::format("--zone: {} has no zone '{}'; take one of its zones", building.file, printable(name)));
    is_chosen[static_cast<size_t>(zone - building.zones.begin())] = true;
  }
  std::vector<bool> is_there;
  for (const uint32_t zone : zonesOf(building)) is_there.push_back(is_chosen[zone]);
  return is_there;
}

}  // namespace

InputScene readEnergyPlusZones(const std::filesystem::path& file, const std::vector<std::string>& zones) {
  const EnergyPlusBuilding building = readEnergyPlus(file);
  InputScene scene{building.file, {}, {}};
  const std::vector<bool> is_there = areIn(building, zones);
  if (!std::ranges::count(is_there, true))
    FilePlace{building.file}.refuse("there are no surfaces in these zones; take other ones");
  addSurfaces(building, false, is_there, scene);
  scene.sheets = scene.surface_names;
  return scene;
}

InputScene readEnergyPlusOutside(const std::filesystem::path& file) {
  const EnergyPlusBuilding building = readEnergyPlus(file);
  for (const auto& [place, object] : building.simple_shadings)
    place.refuse(
        fmt::format("{} is given by lengths, which is not read; give it as Shading:Site:Detailed or "
                    "Shading:Zone:Detailed",
                    printable(object)));
  InputScene scene{building.file, {}, {}};
  scene.is_outside = true;
  addSurfaces(building, true, std::vector<bool>(building.surfaces.size(), true), scene);
  for (const EnergyPlusSurface& surface : building.surfaces)
    if (surface.boundary != "outdoors") scene.blockers.push_back(surface.name);
  if (scene.blockers.size() == building.surfaces.size())
    FilePlace{building.file}.refuse("no surface has the outside boundary condition Outdoors; there is nothing outside");
  scene.solids = scene.surface_names;
  for (const EnergyPlusShading& shading : building.shadings) {
    Corners corners = placed(shading, building);
    const auto number = static_cast<uint32_t>(scene.surface_names.size());
    scene.surface_names.push_back(shading.name);
    scene.sheets.push_back(shading.name);
    scene.faces.push_back({corners, number, shading.line});
    std::reverse(corners.begin(), corners.end());
    scene.faces.push_back({std::move(corners), number, shading.line});
  }
  return scene;
}

}  // namespace viewpeel
