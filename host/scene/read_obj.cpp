// readObj() reads Wavefront OBJ: v, f, o and g, and usemtl where the file has neither o nor g.
#include <algorithm>
#include <fstream>
#include <map>
#include <unordered_map>
#include <utility>

#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

// These statements carry no polygons, so they are ignored.
constexpr std::string_view kIgnored[] = {"vt",       "vn",       "vp",         "s",         "mtllib", "l",
                                         "p",        "mg",       "lod",        "end",       "bevel",  "usemap",
                                         "c_interp", "d_interp", "shadow_obj", "trace_obj", "maplib"};

class ObjReader {
 public:
  explicit ObjReader(const std::filesystem::path& file) : file_(file) { scene_.file = file.string(); }

  InputScene read() {
    std::ifstream in(file_, std::ios::binary);
    std::string line, more;
    for (uint32_t number = 1; std::getline(in, line); ++number) {
      line_ = number;
      while (chompContinuation(line) && std::getline(in, more)) {
        line += more;
        ++number;
      }
      readStatement(number == 1 ? skipByteOrderMark(line) : line);
    }
    return finish();
  }

 private:
  [[noreturn]] void refuse(const std::string& what, uint32_t line) const { FilePlace{scene_.file, line}.refuse(what); }

  // Removes the end of line and a continuation mark; true where there was one.
  static bool chompContinuation(std::string& line) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.pop_back();
    if (line.empty() || line.back() != '\\') return false;
    line.back() = ' ';
    return true;
  }

  void readStatement(std::string_view rest) {
    if (const size_t comment = rest.find('#'); comment != std::string_view::npos) rest = rest.substr(0, comment);
    const std::string_view keyword = nextWord(rest);
    if (keyword.empty()) return;
    if (keyword == "v") readVertex(rest);
    else if (keyword == "f" || keyword == "fo") readFace(rest);
    else if (keyword == "o") object_ = name_ = joinWords(rest), has_names_ |= !name_.empty();
    else if (keyword == "g") name_ = joinWords(rest), has_names_ |= !name_.empty();
    else if (keyword == "usemtl") material_ = joinWords(rest);
    else if (std::find(std::begin(kIgnored), std::end(kIgnored), keyword) == std::end(kIgnored))
      refuse(fmt::format("'{}' is not a statement that is understood; export polygons as OBJ text", printable(keyword)),
             line_);
  }

  void readVertex(std::string_view rest) {
    glm::dvec3 vertex;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = nextWord(rest);
      if (word.empty()) refuse("a vertex needs three coordinates; complete it", line_);
      vertex[axis] = parseFinite(word, {scene_.file, line_});
    }
    vertices_.push_back(vertex);
  }

  void readFace(std::string_view rest) {
    Face face{{}, surfaceInForce(), materialInForce(), line_};
    for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
      int64_t index = 0;
      const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (failure != std::errc() || (end != word.data() + word.size() && *end != '/'))
        refuse(fmt::format("'{}' is not a vertex index; correct it", printable(word)), line_);
      // A negative index counts back from the last vertex. A positive index may be of a later vertex, and is checked at
      // the end.
      const int64_t absolute = index < 0 ? int64_t(vertices_.size()) + index + 1 : index;
      if (absolute < 1) refuse(fmt::format("vertex index {} is out of range; indices start at 1", index), line_);
      face.vertices.push_back(static_cast<uint64_t>(absolute));
    }
    if (face.vertices.size() < 3) refuse("a face needs three corners or more; complete or remove it", line_);
    faces_.push_back(std::move(face));
  }

  // Returns the surface of a face: the latest `o` or `g` names it, after a nameless `g` the object, without names the
  // file.
  uint32_t surfaceInForce() {
    const std::string& name = !name_.empty() ? name_ : object_;
    const std::string surface = name.empty() ? file_.stem().string() : name;
    const auto [at, is_new] = surfaces_.try_emplace(std::pair(surface == object_ ? std::string() : object_, surface),
                                                    uint32_t(scene_.surface_names.size()));
    if (is_new) scene_.surface_names.push_back(surface);
    return at->second;
  }

  uint32_t materialInForce() {
    const auto [at, is_new] =
        materials_.try_emplace(material_.empty() ? file_.stem().string() : material_, uint32_t(material_names_.size()));
    if (is_new) material_names_.push_back(at->first);
    return at->second;
  }

  // Lets materials name surfaces in a file without objects and groups. In other files materials say how a surface
  // looks, and would only cut named surfaces into parts.
  void nameByMaterials() {
    if (has_names_) return;
    scene_.surface_names = material_names_;
    for (Face& face : faces_) face.surface = face.material;
  }

  // Makes groups of one name in different objects different surfaces, with the objects' names in front.
  void separateGroups() {
    std::unordered_map<std::string, uint32_t> uses;
    for (const std::string& name : scene_.surface_names) ++uses[name];
    const std::vector<std::string> names = scene_.surface_names;
    std::string first;
    uint32_t count = 0;
    for (const auto& [key, surface] : surfaces_) {
      const auto& [object, group] = key;
      if (object.empty() || uses[group] < 2) continue;
      scene_.surface_names[surface] = object + "/" + group;
      if (uses.count(scene_.surface_names[surface]))
        refuse(fmt::format("group '{}' of object '{}' cannot be told from surface '{}'; rename one of them", group,
                           object, scene_.surface_names[surface]),
               0);
      ++uses[scene_.surface_names[surface]];
      if (count++ == 0) first = scene_.surface_names[surface];
    }
    if (count > 0)
      scene_.warnings.push_back(
          fmt::format("{}: {} groups share their names with others in other objects and have the objects' names before "
                      "their own, as '{}'; "
                      "rename groups that are to have names of their own",
                      scene_.file, count, first));
  }

  InputScene finish() {
    separateGroups();
    nameByMaterials();
    for (const Face& face : faces_) {
      InputFace input{{}, face.surface, face.line};
      for (uint64_t index : face.vertices) {
        if (index > vertices_.size())
          refuse(fmt::format("vertex index {} is out of range; the file has {} vertices", index, vertices_.size()),
                 face.line);
        input.corners.push_back(vertices_[index - 1]);
      }
      scene_.faces.push_back(std::move(input));
    }
    return std::move(scene_);
  }

  struct Face {
    std::vector<uint64_t> vertices;  // indices from 1
    uint32_t surface, material, line;
  };
  std::filesystem::path file_;
  InputScene scene_;
  uint32_t line_ = 0;
  std::string object_, name_, material_;
  bool has_names_ = false;  // whether there are objects or groups
  std::map<std::pair<std::string, std::string>, uint32_t>
      surfaces_;  // by object and name; the object is empty if it names the surface
  std::map<std::string, uint32_t> materials_;
  std::vector<std::string> material_names_;  // in the order of their first faces
  std::vector<glm::dvec3> vertices_;
  std::vector<Face> faces_;
};

}  // namespace

InputScene readObj(const std::filesystem::path& file) { return ObjReader(file).read(); }

}  // namespace viewpeel
