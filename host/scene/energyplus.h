// EnergyPlus's input, IDF or epJSON, as far as surfaces of zones go.
//   Source: EnergyPlus Input Output Reference: GlobalGeometryRules, Zone, BuildingSurface:Detailed,
//   FenestrationSurface:Detailed.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/words.h"

namespace viewpeel {

struct EnergyPlusZone {
  std::string name;
  glm::dvec3 origin{0};
  double relative_north_deg = 0;  // clockwise, seen from above
};

// A wall, floor, ceiling or roof of a zone, or a window or door in one.
struct EnergyPlusSurface {
  std::string name, zone;  // of a window the zone is its base's
  std::string base;        // empty where it is none's subsurface
  std::vector<glm::dvec3> corners;
  double multiplier = 1;
  uint32_t line = 0;
  std::string boundary;  // outside boundary condition, in small letters; of a window its base's
};

// A shading surface stands outside: a tree, a neighbour, an overhang.
struct EnergyPlusShading {
  enum class Of { site, building, zone };
  std::string name;
  Of of = Of::site;  // the coordinates of its corners, where these are relative
  std::string base;  // of a zone's: the surface whose zone it is
  std::vector<glm::dvec3> corners;
  uint32_t line = 0;
};

struct EnergyPlusBuilding {
  std::string file;
  std::string version;        // "9.6"; empty where the file does not say
  double north_axis_deg = 0;  // of the building, clockwise, seen from above
  bool is_clockwise = false;  // corners, seen from outside the zone
  bool is_relative = false;   // coordinates are from the zone's origin
  std::vector<EnergyPlusZone> zones;
  std::vector<EnergyPlusSurface> surfaces;  // in the order of the file
  std::vector<EnergyPlusShading> shadings;
  // Shading surfaces given by lengths are not read: their places and objects.
  std::vector<std::pair<FilePlace, std::string>> simple_shadings;
  uint64_t internal_masses = 0;
};

// True where the name ends in .idf or .epjson, in either case.
bool isEnergyPlus(const std::filesystem::path& file);

// Reads a building. Zones of all surfaces exist, and bases of all windows.
//   Throws: Error bad_input, naming file and line (epJSON: the object) for surfaces that are given by azimuth and
//     length.
//   Cost: O(size of the file).
EnergyPlusBuilding readEnergyPlus(const std::filesystem::path& file);

// Returns true for versions before 9.6, which know no spaces. Files without a version are taken for newer ones.
bool isBeforeSpaces(const EnergyPlusBuilding& building);

// Returns the index of the zone of each surface, by names without regard to case.    Cost: O(n log n).
std::vector<uint32_t> zonesOf(const EnergyPlusBuilding& building);

}  // namespace viewpeel
