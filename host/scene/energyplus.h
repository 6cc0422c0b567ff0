// readEnergyPlus() reads the surfaces of an EnergyPlus input, IDF or epJSON.
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

// An EnergyPlusSurface is a wall, floor, ceiling or roof of a zone, or a window or door in such a surface.
struct EnergyPlusSurface {
  std::string name, zone;  // zone: a window has the zone of its base
  std::string base;        // surface that a window or door lies in; empty for others
  std::vector<glm::dvec3> corners;
  double multiplier = 1;
  uint32_t line = 0;
  std::string boundary;  // outside boundary condition, in small letters; a window has its base's condition
};

// A shading surface stands outside: a tree, a neighbour, an overhang.
struct EnergyPlusShading {
  enum class Of { site, building, zone };
  std::string name;
  Of of = Of::site;  // whose coordinate system its corners use, if coordinates are relative
  std::string base;  // of a zone's shading: a surface of this zone
  std::vector<glm::dvec3> corners;
  uint32_t line = 0;
};

struct EnergyPlusBuilding {
  std::string file;
  std::string version;        // "9.6"; empty where the file has none
  double north_axis_deg = 0;  // of the building, clockwise, seen from above
  bool is_clockwise = false;  // whether corners run clockwise, seen from outside the zone
  bool is_relative = false;   // whether coordinates are relative to the zone's origin
  std::vector<EnergyPlusZone> zones;
  std::vector<EnergyPlusSurface> surfaces;  // in the order of the file
  std::vector<EnergyPlusShading> shadings;
  // Shading surfaces that are described by lengths are not read. This list has their places and object types.
  std::vector<std::pair<FilePlace, std::string>> simple_shadings;
  uint64_t internal_masses = 0;
};

// Returns whether the name ends in .idf or .epJSON, in any case.
bool isEnergyPlus(const std::filesystem::path& file);

// Reads a building, and checks that each surface's zone and each window's base exist.
//   Throws: Error bad_input, naming file and line (in epJSON the object), for surfaces that are described by azimuth
//     and length.
//   Cost: O(size of the file).
EnergyPlusBuilding readEnergyPlus(const std::filesystem::path& file);

// Returns true for versions before 9.6, which have no spaces. A file without a version counts as newer.
bool isBeforeSpaces(const EnergyPlusBuilding& building);

// Returns the index of the zone of each surface, by names without regard to case.    Cost: O(n log n).
std::vector<uint32_t> zonesOf(const EnergyPlusBuilding& building);

}  // namespace viewpeel
