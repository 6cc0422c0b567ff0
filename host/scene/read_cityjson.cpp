// readCityJson() reads city models: CityJSON 1.0 to 2.0, and sequences of features (CityJSONSeq).
//   Source: H. Ledoux and B. Dukai, CityJSON Specifications 2.0.1, 2024.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "scene/bridge_holes.h"
#include "scene/json_text.h"
#include "scene/readers.h"
#include "scene/split_face.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Points = std::vector<glm::dvec3>;

constexpr double kUsualLevel = 1;        // of a geometry that does not state its level of detail
constexpr double kLeastOfBuildings = 1;  // a building's geometries below this level are footprints and roof outlines

const Json kNull;

// Returns a member of an object; a null where it has none.
const Json& memberOf(const Json& object, const char* name) {
  if (!object.is_object()) return kNull;
  const auto found = object.find(name);
  return found == object.end() ? kNull : *found;
}

std::string textOf(const Json& value) { return value.is_string() ? value.get<std::string>() : std::string(); }

// Returns how many lists a geometry's surfaces lie within; 0 where the geometry has no surfaces.
int depthOf(const std::string& type) {
  if (type == "MultiSurface" || type == "CompositeSurface") return 1;
  if (type == "Solid") return 2;
  return type == "MultiSolid" || type == "CompositeSolid" ? 3 : 0;
}

// Returns whether an object is a building, a bridge or a tunnel, or a part of one.
bool isConstruction(const std::string& type) {
  return type.starts_with("Building") || type.starts_with("Bridge") || type.starts_with("Tunnel");
}

class CityJsonReader {
 public:
  CityJsonReader(const fs::path& file, double most_detail)
      : file_(file), most_detail_(most_detail), place_{file.string()}, scene_{file.string(), {}, {}} {}

  InputScene readFile() {
    std::ifstream in(file_, std::ios::binary);
    readModel(parse({std::istreambuf_iterator<char>(in), {}}));
    return finished();
  }

  // Reads a model on the first line, and a feature on each line after it.
  InputScene readSequence() {
    std::ifstream in(file_, std::ios::binary);
    std::string line;
    while (std::getline(in, line)) {
      ++place_.line;
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      const Json document = parse(line);
      if (has_model_) readFeature(document);
      else readModel(document);
    }
    return finished();
  }

 private:
  // A Frame turns the coordinates of a list of points into the scene's.
  struct Frame {
    glm::dvec3 scale{1}, translate{0};
  };
  // An Instance moves the points of a template to where an object stands.
  struct Instance {
    glm::dmat4 matrix{1};
    glm::dvec3 place{0};
  };

  // Parses a document, and takes its objects out of it: a list of all of them would be searched for each new one.
  //   Out: the document without its objects, which are in objects_
  Json parse(const std::string& text) {
    objects_.clear();
    std::string member, id;  // where the parser is: in which member of the document, and in which object
    return parseJson(text, place_, [&](int depth, Json::parse_event_t event, Json& parsed) {
      if (event == Json::parse_event_t::key && depth == 1) member = parsed.get<std::string>();
      if (member != "CityObjects") return true;
      if (event == Json::parse_event_t::key && depth == 2) id = parsed.get<std::string>();
      if (event != Json::parse_event_t::object_end || depth != 2) return true;
      objects_.emplace_back(id, std::move(parsed));
      return false;
    });
  }

  void readModel(const Json& document) {
    if (textOf(memberOf(document, "type")) != "CityJSON")
      place_.refuse("not CityJSON: its 'type' is not \"CityJSON\"; export the city model again");
    has_model_ = true;
    if (const Json& transform = memberOf(document, "transform"); !transform.is_null())
      frame_ = {threeOf(memberOf(transform, "scale"), "transform"),
                threeOf(memberOf(transform, "translate"), "transform")};
    const Json& templates = memberOf(document, "geometry-templates");
    templates_ = memberOf(templates, "templates");
    if (!templates_.is_null()) template_points_ = pointsOf(memberOf(templates, "vertices-templates"), Frame());
    addObjects(document);
  }

  void readFeature(const Json& document) {
    if (textOf(memberOf(document, "type")) != "CityJSONFeature")
      place_.refuse("this line is no CityJSONFeature; export the file again");
    addObjects(document);
  }

  Points pointsOf(const Json& list, const Frame& frame) const {
    if (!list.is_array()) place_.refuse("there is no list of vertices; export the file again");
    Points points;
    for (const Json& one : list) points.push_back(threeOf(one, "a vertex") * frame.scale + frame.translate);
    return points;
  }

  glm::dvec3 threeOf(const Json& list, const char* what) const {
    glm::dvec3 numbers(0);
    bool is_right = list.is_array() && list.size() == 3;
    for (int k = 0; is_right && k < 3; ++k) {
      const Json& one = list[static_cast<size_t>(k)];
      is_right = one.is_number() && std::isfinite(one.get<double>());
      if (is_right) numbers[k] = one.get<double>();
    }
    if (!is_right) place_.refuse(fmt::format("{} has not three numbers; export the file again", what));
    return numbers;
  }

  // Adds the objects of a model or of a feature, each of which has its own vertices.
  void addObjects(const Json& document) {
    if (!memberOf(document, "CityObjects").is_object())
      place_.refuse("there are no 'CityObjects'; export the file again");
    points_ = pointsOf(memberOf(document, "vertices"), frame_);
    for (const auto& [id, object] : objects_) {
      id_ = id;
      addObject(object);
    }
  }

  // Adds the geometries of the highest level of detail that an object has up to the limit.
  void addObject(const Json& object) {
    const Json& geometries = memberOf(object, "geometry");
    if (!geometries.is_array()) return;
    const double least = isConstruction(textOf(memberOf(object, "type"))) ? kLeastOfBuildings : 0;
    double highest = -1;
    bool has_surfaces = false;
    for (const Json& geometry : geometries) {
      const Json& shape = shapeOf(geometry);
      if (depthOf(textOf(memberOf(shape, "type"))) == 0) continue;
      has_surfaces = true;
      const double level = levelOf(shape);
      if (level < least) continue;
      if (level <= most_detail_) highest = std::max(highest, level);
      least_detail_ = std::min(least_detail_, level);
    }
    if (highest < 0) {
      objects_left_out_ += has_surfaces && memberOf(object, "children").empty();  // its children stand for a parent
      return;
    }
    for (const Json& geometry : geometries)
      if (levelOf(shapeOf(geometry)) == highest) addGeometry(geometry);
  }

  // Returns the level of detail of a geometry, such as 2.2, which files state as a text or as a number.
  double levelOf(const Json& geometry) const {
    const Json& level = memberOf(geometry, "lod");
    if (level.is_number()) return level.get<double>();
    return level.is_string() ? parseFinite(level.get_ref<const std::string&>(), place_) : kUsualLevel;
  }

  // Returns the geometry itself, or for an instance its template.
  const Json& shapeOf(const Json& geometry) const {
    if (textOf(memberOf(geometry, "type")) != "GeometryInstance") return geometry;
    const Json& index = memberOf(geometry, "template");
    if (!index.is_number_unsigned() || index.get<uint64_t>() >= templates_.size())
      refuse("its template is not one of the file's");
    return templates_[index.get<size_t>()];
  }

  void addGeometry(const Json& geometry) {
    const Json& shape = shapeOf(geometry);
    const int depth = depthOf(textOf(memberOf(shape, "type")));
    if (depth == 0) return;
    const Json& semantics = memberOf(shape, "semantics");
    semantic_surfaces_ = &memberOf(semantics, "surfaces");
    instance_ = &shape == &geometry ? std::nullopt : std::optional(instanceOf(geometry));
    addSurfaces(memberOf(shape, "boundaries"), memberOf(semantics, "values"), depth);
  }

  Instance instanceOf(const Json& geometry) const {
    const Json& at = memberOf(geometry, "boundaries");
    const Json& numbers = memberOf(geometry, "transformationMatrix");
    if (!at.is_array() || at.size() != 1) refuse("an instance has not one vertex to stand at");
    Instance instance{.place = pointAt(at.front(), points_)};
    if (numbers.is_null()) return instance;
    bool is_right = numbers.is_array() && numbers.size() == 16;
    for (int k = 0; is_right && k < 16; ++k) {
      const Json& one = numbers[static_cast<size_t>(k)];
      is_right = one.is_number();
      if (is_right) instance.matrix[k % 4][k / 4] = one.get<double>();
    }
    if (!is_right) refuse("a transformationMatrix has not 16 numbers");
    return instance;
  }

  const glm::dvec3& pointAt(const Json& index, const Points& points) const {
    if (!index.is_number_unsigned() || index.get<uint64_t>() >= points.size())
      refuse(fmt::format("{} is not the index of one of {} vertices, counted from 0", printable(index.dump()),
                         points.size()));
    return points[index.get<size_t>()];
  }

  // Returns a corner of the geometry that is read.
  glm::dvec3 cornerAt(const Json& index) const {
    if (!instance_) return pointAt(index, points_);
    return glm::dvec3(instance_->matrix * glm::dvec4(pointAt(index, template_points_), 1)) + instance_->place;
  }

  // Adds the surfaces within lists.    In: values: of the same shape: which semantic surface each is, or null
  void addSurfaces(const Json& boundaries, const Json& values, int depth) {
    if (!boundaries.is_array()) refuse("its boundaries are not lists of lists");
    if (depth == 0) return addSurface(boundaries, values);
    for (size_t k = 0; k < boundaries.size(); ++k)
      addSurfaces(boundaries[k], values.is_array() && k < values.size() ? values[k] : kNull, depth - 1);
  }

  void addSurface(const Json& rings, const Json& value) {
    std::string type;
    if (value.is_number_unsigned() && value.get<uint64_t>() < semantic_surfaces_->size())
      type = textOf(memberOf((*semantic_surfaces_)[value.get<size_t>()], "type"));
    if (type == "ClosureSurface") {
      ++closures_;
      return;
    }
    std::vector<Points> loops;
    for (const Json& ring : rings) {
      if (!ring.is_array()) refuse("a ring is no list of vertices");
      Points& loop = loops.emplace_back();
      for (const Json& index : ring) loop.push_back(cornerAt(index));
    }
    InputFace face{{}, surfaceOf(type.empty() ? id_ : id_ + "/" + type), place_.line};
    if (loops.size() > 1 && glm::length(twiceVectorArea(loops.front())) > 0) {
      BridgedFace bridged = bridgeHoles(loops);
      face.corners = std::move(bridged.corners);
      holes_left_out_ += bridged.holes_outside;
    } else if (!loops.empty()) {
      face.corners = std::move(loops.front());
    }
    scene_.faces.push_back(std::move(face));
  }

  // Returns the index of the surface with this name. The surface is added where the name is new.
  uint32_t surfaceOf(const std::string& name) {
    const auto [found, is_new] = surfaces_.try_emplace(name, static_cast<uint32_t>(scene_.surface_names.size()));
    if (is_new) scene_.surface_names.push_back(name);
    return found->second;
  }

  void warn(uint64_t count, const char* of_one, const char* of_many) {
    if (count > 0)
      scene_.warnings.push_back(fmt::format("{}: {} {}", place_.file, count, count == 1 ? of_one : of_many));
  }

  // Says why there is no face: files whose objects all have other levels of detail are good files.
  void requireFaces() const {
    if (!scene_.faces.empty() || objects_left_out_ == 0) return;
    place_.refuse(
        least_detail_ < INFINITY
            ? fmt::format("no object has a level of detail up to {}; they begin at {}, so give a larger --lod",
                          most_detail_, least_detail_)
            : "buildings have nothing but footprints, of levels of detail below 1; take a model with walls");
  }

  InputScene finished() {
    place_.line = 0;
    requireFaces();
    warn(objects_left_out_, "object has no surfaces at a level of detail that is read, and is left out",
         "objects have no surfaces at a level of detail that is read, and are left out");
    warn(closures_, "surface of type ClosureSurface, which only closes an opening, is left out",
         "surfaces of type ClosureSurface, which only close openings, are left out");
    warn(holes_left_out_, "hole does not lie within its surface, and is left out",
         "holes do not lie within their surfaces, and are left out");
    return std::move(scene_);
  }

  [[noreturn]] void refuse(const std::string& what) const {
    place_.refuse(fmt::format("object '{}': {}; export the file again", withoutControls(id_), what));
  }

  const fs::path file_;
  const double most_detail_;
  FilePlace place_;
  InputScene scene_;
  std::unordered_map<std::string, uint32_t> surfaces_;
  bool has_model_ = false;
  Frame frame_;
  std::vector<std::pair<std::string, Json>> objects_;  // of the document that is read, with their identifiers
  Json templates_;
  Points points_, template_points_;
  std::string id_;                           // of the object that is read
  const Json* semantic_surfaces_ = nullptr;  // of the geometry that is read
  std::optional<Instance> instance_;         // where that geometry is a template
  double least_detail_ = INFINITY;           // of all geometries, footprints of buildings apart
  uint64_t objects_left_out_ = 0, closures_ = 0, holes_left_out_ = 0;
};

}  // namespace

InputScene readCityJson(const fs::path& file, double most_detail) {
  return CityJsonReader(file, most_detail).readFile();
}

InputScene readCityJsonSequence(const fs::path& file, double most_detail) {
  return CityJsonReader(file, most_detail).readSequence();
}

}  // namespace viewpeel
