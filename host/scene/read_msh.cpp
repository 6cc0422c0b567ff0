// readMsh() reads Gmsh's meshes, .msh 2.2 and 4.1, text and binary.
//   Source: C. Geuzaine & J.-F. Remacle, Gmsh reference manual 4.11, section 10, file formats.
#include <array>
#include <map>
#include <unordered_map>
#include <vector>

#include "scene/file_cursor.h"
#include "scene/readers.h"

namespace viewpeel {
namespace {

// A FaceType is a type of element that is a face: `order` gives its corners and mid nodes around the polygon; inner
// nodes are left out.
struct FaceType {
  int type;
  std::vector<uint32_t> order;
};
const std::array<FaceType, 5> kFaceTypes = {{{2, {0, 1, 2}},
                                             {3, {0, 1, 2, 3}},
                                             {9, {0, 3, 1, 4, 2, 5}},
                                             {16, {0, 4, 1, 5, 2, 6, 3, 7}},
                                             {10, {0, 4, 1, 5, 2, 6, 3, 7}}}};
// Element types 0 to 31 have these numbers of nodes; 0 stands for an unknown type.
constexpr uint32_t kNodeCounts[] = {0, 2,  3,  4,  4, 8,  6,  5,  3,  6,  9, 10, 27, 18, 14, 1,
                                    8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5,  6,  20, 35, 56};
// Triangles of these types have more nodes than corners and mid nodes.
constexpr std::array kCurvedTypes = {20, 21, 22, 23, 24, 25};

class MshReader {
 public:
  explicit MshReader(const std::filesystem::path& file) : cursor_(file) { scene_.file = file.string(); }

  InputScene read() {
    while (!cursor_.isAtEnd()) {
      const std::string section(cursor_.word());
      if (!section.starts_with("$"))
        cursor_.refuse(fmt::format("'{}' begins no section of a Gmsh mesh", printable(section)));
      cursor_.line();
      if (version_ == 0 && section != "$MeshFormat" && section != "$Comments")
        cursor_.refuse("not a Gmsh mesh: $MeshFormat comes first; save it as .msh again");
      readSection(section);
      cursor_.skipPast("$End" + section.substr(1));
    }
    if (version_ == 0) cursor_.refuse("not a Gmsh mesh: it has no $MeshFormat; save it as .msh again");
    return finish();
  }

 private:
  void readSection(const std::string& section) {
    if (section == "$MeshFormat") readFormat();
    else if (section == "$PhysicalNames") readNames();
    else if (section == "$Entities") readEntities();
    else if (section == "$Nodes") version_ == 4 ? readNodes4() : readNodes2();
    else if (section == "$Elements") version_ == 4 ? readElements4() : readElements2();
    else if (section == "$PartitionedEntities")
      cursor_.refuse("partitioned meshes are not read; save the mesh without partitions");
  }

  void readFormat() {
    const std::string version(cursor_.word());
    if (version != "2.2" && version != "4.1")
      cursor_.refuse(fmt::format("version {} is not read; save as 2.2 or 4.1", printable(version)));
    version_ = version == "4.1" ? 4 : 2;
    is_binary_ = cursor_.number<int>("the file type") != 0;
    if (cursor_.number<int>("the size of numbers") != 8)
      cursor_.refuse("numbers are not of 8 bytes; save the mesh again");
    cursor_.line();
    if (is_binary_ && cursor_.raw<int32_t>("the mark of byte order") != 1)
      cursor_.refuse("the mesh is big-endian; save it as text");
  }

  template <class T>
  T next(const char* what) {
    return is_binary_ ? cursor_.raw<T>(what) : cursor_.number<T>(what);
  }

  void readNames() {
    const auto count = cursor_.number<uint64_t>("the number of names");
    for (uint64_t k = 0; k < count; ++k) {
      const int dimension = cursor_.number<int>("a dimension"), tag = cursor_.number<int>("a tag");
      std::string name = joinWords(cursor_.line());
      if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
      if (dimension == 2 && !name.empty()) names_[tag] = name;
    }
  }

  // Reads entities. Only physical groups of surfaces are used.
  void readEntities() {
    std::array<uint64_t, 4> counts;
    for (uint64_t& count : counts) count = next<uint64_t>("a number of entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (uint64_t k = 0; k < counts[dimension]; ++k) {
        const auto tag = next<int32_t>("an entity's tag");
        for (int c = 0; c < (dimension == 0 ? 3 : 6); ++c) next<double>("an entity's box");
        const auto groups = next<uint64_t>("a number of groups");
        for (uint64_t g = 0; g < groups; ++g) {
          const int group = std::abs(static_cast<int>(next<int32_t>("a group")));
          if (dimension != 2) continue;
          if (g == 0) group_of_[tag] = group;
          else ++others_;
        }
        if (dimension == 0) continue;
        const auto bounds = next<uint64_t>("a number of bounds");
        for (uint64_t b = 0; b < bounds; ++b) next<int32_t>("a bound");
      }
  }

  glm::dvec3 readPoint() {
    glm::dvec3 point;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = next<double>("a coordinate");
      if (!std::isfinite(point[axis])) cursor_.refuse("a coordinate is not a finite number; correct it");
    }
    return point;
  }

  void readNodes2() {
    const auto count = cursor_.number<uint64_t>("the number of nodes");
    cursor_.line();
    for (uint64_t k = 0; k < count; ++k) {
      const auto tag =
          static_cast<uint64_t>(is_binary_ ? cursor_.raw<int32_t>("a node") : cursor_.number<int64_t>("a node"));
      nodes_[tag] = readPoint();
    }
  }

  void readNodes4() {
    const auto blocks = next<uint64_t>("the number of blocks");
    for (int k = 0; k < 3; ++k) next<uint64_t>("the number of nodes");
    for (uint64_t b = 0; b < blocks; ++b) {
      const auto dimension = next<int32_t>("a dimension");
      next<int32_t>("an entity");
      const bool is_parametric = next<int32_t>("a mark of parameters") != 0;
      const auto count = next<uint64_t>("a number of nodes");
      std::vector<uint64_t> tags;
      for (uint64_t k = 0; k < count; ++k) tags.push_back(next<uint64_t>("a node"));
      for (uint64_t tag : tags) {
        nodes_[tag] = readPoint();
        for (int p = 0; is_parametric && p < dimension; ++p) next<double>("a parameter");
      }
    }
  }

  uint32_t nodeCount(int type) const {
    if (type < 1 || type >= static_cast<int>(std::size(kNodeCounts)) || kNodeCounts[type] == 0)
      cursor_.refuse(fmt::format("element type {} is not known; save the mesh with elements of order 1 or 2", type));
    return kNodeCounts[type];
  }

  void readElements2() {
    const auto count = cursor_.number<uint64_t>("the number of elements");
    cursor_.line();
    for (uint64_t k = 0; k < count;) {
      if (is_binary_) {
        const auto type = cursor_.raw<int32_t>("an element type"), in_block = cursor_.raw<int32_t>("a block");
        const auto tag_count = cursor_.raw<int32_t>("a number of tags");
        if (in_block < 1) cursor_.refuse("a block of elements is empty; save the mesh again");
        for (int32_t e = 0; e < in_block; ++e, ++k) {
          cursor_.raw<int32_t>("an element");
          readElement2(type, tag_count);
        }
      } else {
        cursor_.number<int64_t>("an element");
        const int type = cursor_.number<int>("an element type");
        readElement2(type, cursor_.number<int>("a number of tags"));
        ++k;
      }
    }
  }

  void readElement2(int type, int tag_count) {
    int group = 0, entity = 0;
    for (int t = 0; t < tag_count; ++t) {
      const int tag = next<int32_t>("a tag");
      if (t == 0) group = tag;
      if (t == 1) entity = tag;
    }
    std::vector<uint64_t> nodes;
    for (uint32_t left = nodeCount(type); left > 0; --left)
      nodes.push_back(static_cast<uint64_t>(next<int32_t>("a node of an element")));
    addFace(type, nodes, group, entity);
  }

  void readElements4() {
    const auto blocks = next<uint64_t>("the number of blocks");
    for (int k = 0; k < 3; ++k) next<uint64_t>("the number of elements");
    for (uint64_t b = 0; b < blocks; ++b) {
      next<int32_t>("a dimension");  // the dimension follows from the type, so it is ignored
      const auto entity = next<int32_t>("an entity"), type = next<int32_t>("an element type");
      const auto count = next<uint64_t>("a number of elements");
      const uint32_t node_count = nodeCount(type);
      const auto group = group_of_.find(entity);
      for (uint64_t k = 0; k < count; ++k) {
        next<uint64_t>("an element");
        std::vector<uint64_t> nodes;
        for (uint32_t n = 0; n < node_count; ++n) nodes.push_back(next<uint64_t>("a node of an element"));
        addFace(type, nodes, group == group_of_.end() ? 0 : group->second, entity);
      }
    }
  }

  void addFace(int type, const std::vector<uint64_t>& nodes, int group, int entity) {
    if (std::ranges::find(kCurvedTypes, type) != kCurvedTypes.end())
      cursor_.refuse(fmt::format("element type {} is of order 3 or more; save the mesh with order 1 or 2", type));
    const auto of_type = std::ranges::find(kFaceTypes, type, &FaceType::type);
    if (of_type == kFaceTypes.end()) return;  // points, edges and volumes are ignored
    InputFace face{{}, surfaceOf(group, entity), 0};
    for (uint32_t k : of_type->order) {
      const auto node = nodes_.find(nodes[k]);
      if (node == nodes_.end()) cursor_.refuse(fmt::format("there is no node {}; save the mesh again", nodes[k]));
      face.corners.push_back(node->second);
    }
    scene_.faces.push_back(std::move(face));
  }

  // Returns the surface of an element: its physical group, or the elementary entity where it has no group.
  uint32_t surfaceOf(int group, int entity) {
    std::string name = group ? fmt::format("physical {}", group) : fmt::format("entity {}", entity);
    if (const auto named = names_.find(group); group && named != names_.end()) name = named->second;
    const auto [at, is_new] = surfaces_.try_emplace(name, static_cast<uint32_t>(scene_.surface_names.size()));
    if (is_new) scene_.surface_names.push_back(name);
    return at->second;
  }

  InputScene finish() {
    if (others_)
      scene_.warnings.push_back(
          fmt::format("{}: {} times a surface is in more than one physical group; the first one "
                      "names its faces",
                      scene_.file, others_));
    return std::move(scene_);
  }

  FileCursor cursor_;
  InputScene scene_;
  int version_ = 0;
  bool is_binary_ = false;
  std::map<int, std::string> names_;  // of physical groups of surfaces
  std::map<int, int> group_of_;       // of entities of dimension 2
  std::unordered_map<uint64_t, glm::dvec3> nodes_;
  std::map<std::string, uint32_t> surfaces_;
  uint64_t others_ = 0;
};

}  // namespace

InputScene readMsh(const std::filesystem::path& file) { return MshReader(file).read(); }

}  // namespace viewpeel
