#include "scene/energyplus.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>

#include "scene/energyplus_objects.h"

namespace viewpeel {
namespace {

using Json = nlohmann::ordered_json;

// These objects describe surfaces by azimuth, tilt and length, without corners.
constexpr const char* kSimpleSurfaces[] = {"wall:exterior",
                                           "wall:adiabatic",
                                           "wall:underground",
                                           "wall:interzone",
                                           "roof",
                                           "ceiling:adiabatic",
                                           "ceiling:interzone",
                                           "floor:groundcontact",
                                           "floor:adiabatic",
                                           "floor:interzone",
                                           "window",
                                           "door",
                                           "glazeddoor",
                                           "window:interzone",
                                           "door:interzone",
                                           "glazeddoor:interzone"};

// These objects describe shading surfaces by lengths, without corners.
constexpr const char* kSimpleShadings[] = {
    "shading:site",          "shading:building", "shading:overhang", "shading:fin", "shading:overhang:projection",
    "shading:fin:projection"};

void refuseSimple(const FilePlace& place, const std::string& type) {
  place.refuse(
      fmt::format("{} is given by azimuth and length, which is not read; give it as BuildingSurface:Detailed or "
                  "FenestrationSurface:Detailed",
                  type));
}

bool isSimpleShading(const std::string& type) {
  return std::ranges::find(kSimpleShadings, type) != std::end(kSimpleShadings);
}
std::optional<EnergyPlusShading::Of> shadingOf(const std::string& type) {
  if (type == "shading:site:detailed") return EnergyPlusShading::Of::site;
  if (type == "shading:building:detailed") return EnergyPlusShading::Of::building;
  if (type == "shading:zone:detailed") return EnergyPlusShading::Of::zone;
  return std::nullopt;
}

bool isSimple(const std::string& type) { return std::ranges::find(kSimpleSurfaces, type) != std::end(kSimpleSurfaces); }

// Returns whether a field is an outside boundary condition. If so, the file leaves out the space before it (version
// 9.6).
bool isBoundaryCondition(const std::string& field) {
  const std::string word = lowerCase(field);
  for (const char* whole : {"adiabatic", "surface", "zone", "space", "foundation", "outdoors"})
    if (word == whole) return true;
  return word.starts_with("ground") || word.starts_with("otherside");
}

double numberOf(const std::string& field, const FilePlace& place) {
  return field.empty() ? 0 : parseFinite(field, place);
}

// Reads corners from field `first` to the end of the object.
std::vector<glm::dvec3> cornersOf(const IdfObject& object, size_t first) {
  size_t end = object.fields.size();
  while (end > first && object.fields[end - 1].empty()) --end;
  if (end <= first || (end - first) % 3 || (end - first) / 3 < 3)
    object.place.refuse("the coordinates are not three for each of at least three vertices; correct them");
  std::vector<glm::dvec3> corners;
  for (size_t k = first; k < end; k += 3)
    corners.emplace_back(numberOf(object.fields[k], object.place), numberOf(object.fields[k + 1], object.place),
                         numberOf(object.fields[k + 2], object.place));
  return corners;
}

void requireCount(const std::string& field, size_t corners, const FilePlace& place) {
  if (field.empty() || lowerCase(field) == "autocalculate") return;
  if (numberOf(field, place) != double(corners))
    place.refuse(fmt::format("the number of vertices is {}, and {} are given; correct it", printable(field), corners));
}

void setRules(EnergyPlusBuilding& building, const std::string& entry, const std::string& system,
              const FilePlace& place) {
  const std::string direction = lowerCase(entry), coordinates = lowerCase(system);
  if (direction != "clockwise" && direction != "counterclockwise")
    place.refuse("the vertex entry direction is neither Counterclockwise nor Clockwise; correct it");
  building.is_clockwise = direction == "clockwise";
  building.is_relative = coordinates.starts_with("rel");
  if (!building.is_relative && !coordinates.starts_with("world") && !coordinates.starts_with("abs"))
    place.refuse("the coordinate system is neither World nor Relative; correct it");
}

void addWall(const IdfObject& object, size_t zone, EnergyPlusBuilding& building) {
  const bool has_space = !isBoundaryCondition(object.field(zone + 1));
  if (has_space && !isBoundaryCondition(object.field(zone + 2)))
    object.place.refuse("there is no outside boundary condition after the zone; correct it");
  // The fields before the coordinates are: condition, its object, sun, wind, view factor to ground, number of vertices.
  const size_t first = zone + (has_space ? 8 : 7);
  EnergyPlusSurface surface{object.field(0),
                            object.field(zone),
                            "",
                            cornersOf(object, first),
                            1,
                            object.place.line,
                            lowerCase(object.field(zone + (has_space ? 2 : 1)))};
  requireCount(object.field(first - 1), surface.corners.size(), object.place);
  building.surfaces.push_back(std::move(surface));
}

// Reads a window. Up to version 8.9 it has one more field before the frame, a shading control.
void addWindow(const IdfObject& object, EnergyPlusBuilding& building) {
  size_t end = object.fields.size();
  while (end > 0 && object.fields[end - 1].empty()) --end;
  const size_t first = end >= 10 && (end - 10) % 3 == 0 ? 10 : 9;
  EnergyPlusSurface surface{object.field(0), "", object.field(3), cornersOf(object, first), 1, object.place.line};
  requireCount(object.field(first - 1), surface.corners.size(), object.place);
  if (const std::string& multiplier = object.field(first - 2); !multiplier.empty())
    surface.multiplier = numberOf(multiplier, object.place);
  building.surfaces.push_back(std::move(surface));
}

void addShading(const IdfObject& object, EnergyPlusShading::Of of, EnergyPlusBuilding& building) {
  // The fields before the coordinates are: name, base (of a zone's shading), transmittance, number of vertices.
  const size_t first = of == EnergyPlusShading::Of::zone ? 4 : 3;
  EnergyPlusShading shading{object.field(0), of, first == 4 ? object.field(1) : "", cornersOf(object, first),
                            object.place.line};
  requireCount(object.field(first - 1), shading.corners.size(), object.place);
  building.shadings.push_back(std::move(shading));
}

EnergyPlusBuilding fromIdf(const std::filesystem::path& file) {
  EnergyPlusBuilding building{file.string()};
  bool has_rules = false;
  for (const IdfObject& object : readIdf(file)) {
    if (object.type == "globalgeometryrules") {
      setRules(building, object.field(1), object.field(2), object.place);
      has_rules = true;
    } else if (object.type == "zone") {
      EnergyPlusZone zone{object.field(0)};
      zone.relative_north_deg = numberOf(object.field(1), object.place);
      for (int axis = 0; axis < 3; ++axis)
        zone.origin[axis] = numberOf(object.field(2 + static_cast<size_t>(axis)), object.place);
      building.zones.push_back(std::move(zone));
    } else if (object.type == "buildingsurface:detailed") {
      addWall(object, 3, building);
    } else if (object.type == "wall:detailed" || object.type == "roofceiling:detailed" ||
               object.type == "floor:detailed") {
      addWall(object, 2, building);
    } else if (object.type == "fenestrationsurface:detailed") {
      addWindow(object, building);
    } else if (object.type == "internalmass") {
      ++building.internal_masses;
    } else if (object.type == "version") {
      building.version = object.field(0);
    } else if (object.type == "building") {
      building.north_axis_deg = numberOf(object.field(1), object.place);
    } else if (const auto of = shadingOf(object.type)) {
      addShading(object, *of, building);
    } else if (isSimpleShading(object.type)) {
      building.simple_shadings.emplace_back(object.place, object.type);
    } else if (isSimple(object.type)) {
      refuseSimple(object.place, object.type);
    }
  }
  if (!has_rules && !building.surfaces.empty())
    FilePlace{building.file}.refuse("there is no GlobalGeometryRules; add it, so that fronts are known");
  return building;
}

// A JsonObject is an object of epJSON with its place for messages: file: Class 'name'.
class JsonObject {
 public:
  JsonObject(const std::string& file, const std::string& type, const std::string& name, const Json& object)
      : place_{file}, what_(fmt::format("{} '{}'", printable(type), printable(name))), object_(object) {
    if (!object.is_object()) refuse("is no object; correct it");
  }
  [[noreturn]] void refuse(const std::string& what) const { place_.refuse(what_ + " " + what); }
  std::string text(const char* key, bool is_needed = false) const {
    const auto member = object_.find(key);
    if (member != object_.end() && member->is_string()) return member->get<std::string>();
    if (is_needed || member != object_.end()) refuse(fmt::format("has no text '{}'; correct it", key));
    return "";
  }
  std::optional<double> number(const std::string& key) const {
    const auto member = object_.find(key);
    if (member == object_.end()) return std::nullopt;
    if (!member->is_number()) refuse(fmt::format("has no number '{}'; correct it", key));
    return member->get<double>();
  }
  const Json& json() const { return object_; }

 private:
  FilePlace place_;
  std::string what_;
  const Json& object_;
};

std::vector<glm::dvec3> cornersOfWall(const JsonObject& object, const std::string& file) {
  const auto vertices = object.json().find("vertices");
  if (vertices == object.json().end() || !vertices->is_array()) object.refuse("has no 'vertices'; correct it");
  std::vector<glm::dvec3> corners;
  for (const Json& vertex : *vertices) {
    const JsonObject of_vertex(file, "a vertex", std::to_string(corners.size() + 1), vertex);
    corners.emplace_back(of_vertex.number("vertex_x_coordinate").value_or(0),
                         of_vertex.number("vertex_y_coordinate").value_or(0),
                         of_vertex.number("vertex_z_coordinate").value_or(0));
  }
  if (corners.size() < 3) object.refuse("has fewer than three vertices; correct it");
  return corners;
}

std::vector<glm::dvec3> cornersOfWindow(const JsonObject& object) {
  std::vector<glm::dvec3> corners;
  for (int k = 1; k <= 4; ++k) {
    const auto coordinate = [&](char axis) { return object.number(fmt::format("vertex_{}_{}_coordinate", k, axis)); };
    const auto x = coordinate('x'), y = coordinate('y'), z = coordinate('z');
    if (x || y || z) corners.emplace_back(x.value_or(0), y.value_or(0), z.value_or(0));
  }
  if (corners.size() < 3) object.refuse("has fewer than three vertices; correct it");
  if (const auto count = object.number("number_of_vertices"); count && *count != double(corners.size()))
    object.refuse(fmt::format("has {} vertices in place of {}; correct it", corners.size(), *count));
  return corners;
}

EnergyPlusBuilding fromEpJson(const std::filesystem::path& file) {
  EnergyPlusBuilding building{file.string()};
  const Json document = readEpJson(file);
  const FilePlace place{building.file};
  if (!document.is_object()) place.refuse("not epJSON: there is no object; export it again");
  bool has_rules = false;
  for (const auto& classes : document.items()) {
    const std::string& type = classes.key();
    const std::string small = lowerCase(type);
    const bool is_wall = small == "buildingsurface:detailed" || small == "wall:detailed" ||
                         small == "roofceiling:detailed" || small == "floor:detailed";
    const std::optional<EnergyPlusShading::Of> shading = shadingOf(small);
    const bool is_used = is_wall || shading || small == "globalgeometryrules" || small == "zone" ||
                         small == "fenestrationsurface:detailed" || small == "internalmass" || small == "version" ||
                         small == "building" || isSimple(small) || isSimpleShading(small);
    if (!is_used) continue;
    if (!classes.value().is_object()) place.refuse(fmt::format("{} is no object; correct it", printable(type)));
    for (const auto& member : classes.value().items()) {
      const JsonObject object(building.file, type, member.key(), member.value());
      if (isSimple(small)) refuseSimple(place, type);
      if (small == "internalmass") ++building.internal_masses;
      if (small == "version") building.version = object.text("version_identifier");
      if (small == "building") building.north_axis_deg = object.number("north_axis").value_or(0);
      if (isSimpleShading(small)) building.simple_shadings.emplace_back(place, type);
      if (shading)
        building.shadings.push_back(
            {member.key(), *shading, object.text("base_surface_name"), cornersOfWall(object, building.file)});
      if (small == "globalgeometryrules") {
        setRules(building, object.text("vertex_entry_direction", true), object.text("coordinate_system", true), place);
        has_rules = true;
      }
      if (small == "zone")
        building.zones.push_back({member.key(),
                                  {object.number("x_origin").value_or(0), object.number("y_origin").value_or(0),
                                   object.number("z_origin").value_or(0)},
                                  object.number("direction_of_relative_north").value_or(0)});
      if (is_wall)
        building.surfaces.push_back({member.key(), object.text("zone_name", true), "",
                                     cornersOfWall(object, building.file), 1, 0,
                                     lowerCase(object.text("outside_boundary_condition"))});
      if (small == "fenestrationsurface:detailed")
        building.surfaces.push_back({member.key(), "", object.text("building_surface_name", true),
                                     cornersOfWindow(object), object.number("multiplier").value_or(1)});
    }
  }
  if (!has_rules && !building.surfaces.empty())
    place.refuse("there is no GlobalGeometryRules; add it, so that fronts are known");
  return building;
}

// Gives each window the zone and the boundary condition of its base.
void findZones(EnergyPlusBuilding& building) {
  std::map<std::string, const EnergyPlusSurface*> by_name;
  for (const EnergyPlusSurface& surface : building.surfaces) {
    const FilePlace place{building.file, surface.line};
    if (surface.name.empty()) place.refuse("a surface has no name; give it one");
    if (!by_name.emplace(lowerCase(surface.name), &surface).second)
      place.refuse(fmt::format("a second surface is called '{}'; rename one of the two", printable(surface.name)));
  }
  for (EnergyPlusSurface& surface : building.surfaces) {
    if (surface.base.empty() && !surface.zone.empty()) continue;
    const auto base = by_name.find(lowerCase(surface.base));
    if (base == by_name.end() || !base->second->base.empty())
      FilePlace{building.file, surface.line}.refuse(
          fmt::format("surface '{}' has no base '{}'; correct it", printable(surface.name), printable(surface.base)));
    surface.zone = base->second->zone;
    surface.boundary = base->second->boundary;
  }
}

}  // namespace

bool isEnergyPlus(const std::filesystem::path& file) {
  const std::string extension = lowerCase(file.extension().string());
  return extension == ".idf" || extension == ".epjson";
}

EnergyPlusBuilding readEnergyPlus(const std::filesystem::path& file) {
  char first = 0;
  std::ifstream(file, std::ios::binary) >> first;
  const bool is_json = first == '{' || lowerCase(file.extension().string()) == ".epjson";
  EnergyPlusBuilding building = is_json ? fromEpJson(file) : fromIdf(file);
  if (building.surfaces.empty())
    FilePlace{building.file}.refuse("there is no BuildingSurface:Detailed; give a building with surfaces");
  findZones(building);
  zonesOf(building);
  return building;
}

bool isBeforeSpaces(const EnergyPlusBuilding& building) {
  const char *at = building.version.data(), *const end = at + building.version.size();
  uint32_t number[2] = {0, 0};
  for (uint32_t& part : number) {
    const auto [next, failure] = std::from_chars(at, end, part);
    if (failure != std::errc()) break;
    at = next != end && *next == '.' ? next + 1 : end;
  }
  return number[0] > 0 && std::pair(number[0], number[1]) < std::pair(9u, 6u);
}

std::vector<uint32_t> zonesOf(const EnergyPlusBuilding& building) {
  std::map<std::string, uint32_t> zones;
  for (uint32_t k = 0; k < building.zones.size(); ++k) zones.emplace(lowerCase(building.zones[k].name), k);
  std::vector<uint32_t> of_surfaces;
  for (const EnergyPlusSurface& surface : building.surfaces) {
    const auto zone = zones.find(lowerCase(surface.zone));
    if (zone == zones.end())
      FilePlace{building.file, surface.line}.refuse(
          fmt::format("surface '{}' has no zone '{}'; correct it", printable(surface.name), printable(surface.zone)));
    of_surfaces.push_back(zone->second);
  }
  return of_surfaces;
}

}  // namespace viewpeel
