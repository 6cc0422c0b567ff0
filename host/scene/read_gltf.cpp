// readGltf() reads glTF 2.0: text (.gltf) with its buffers in other files or inside, and single binary files (.glb).
//   Source: Khronos Group, glTF 2.0 Specification, 2021.
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <nlohmann/json.hpp>

#include "scene/json_text.h"
#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;
constexpr int kMostDepth = 64;                 // of nodes
constexpr uint64_t kMostTriangles = 1u << 28;  // of all nodes together: a small file may repeat a mesh many times
constexpr int64_t kFloat = 5126, kByte = 5121, kShort = 5123, kInt = 5125;

uint32_t wordAt(const std::string& bytes, size_t at) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

std::string decodeBase64(std::string_view text, const FilePlace& place) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  uint32_t bits = 0;
  int count = 0;
  for (char c : text) {
    if (c == '=') break;
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) place.refuse("a buffer within the file is not base64; export it again");
    bits = bits << 6 | static_cast<uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xFF);
  }
  return bytes;
}

class GltfReader {
 public:
  explicit GltfReader(const fs::path& file) : file_(file), place_{file.string()}, scene_{file.string(), {}, {}} {}

  InputScene read() {
    readDocument();
    const auto required = document_.find("extensionsRequired");
    if (required != document_.end() && !required->empty())
      place_.refuse(fmt::format("needs the extension {}; export it without compression and extensions",
                                printable(required->front().is_string() ? required->front().get<std::string>() : "")));
    const Json& nodes = list("nodes");
    for (uint64_t root : roots(nodes)) addNode(nodes, root, glm::dmat4(1), 0);
    if (passed_over_)
      scene_.warnings.push_back(
          fmt::format("{}: {} primitives that are no triangles were passed over", place_.file, passed_over_));
    return std::move(scene_);
  }

 private:
  void readDocument() {
    std::ifstream in(file_, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}}, text = bytes;
    if (bytes.size() >= 12 && wordAt(bytes, 0) == kMagic) {
      text.clear();
      for (size_t at = 12; at < bytes.size();) {
        if (bytes.size() - at < 8 || wordAt(bytes, at) > bytes.size() - at - 8)
          place_.refuse("the file ends within a chunk; export it again");
        const uint32_t length = wordAt(bytes, at), kind = wordAt(bytes, at + 4);
        if (kind == kJsonChunk && text.empty()) text = bytes.substr(at + 8, length);
        if (kind == kBinChunk && binary_.empty()) binary_ = bytes.substr(at + 8, length);
        at += 8 + length;
      }
    }
    requireShallow(text, place_);
    document_ = Json::parse(text, nullptr, false);
    if (!document_.is_object()) place_.refuse("not glTF: there is no JSON object; export it again");
    if (!document_.contains("asset")) place_.refuse("not glTF: there is no 'asset'; export it again");
  }

  const Json& list(const char* name) const {
    const auto found = document_.find(name);
    if (found == document_.end() || !found->is_array() || found->empty())
      place_.refuse(fmt::format("there are no {}; export the file again", name));
    return *found;
  }
  const Json& element(const char* name, uint64_t index) const {
    const Json& elements = list(name);
    if (index >= elements.size() || !elements[index].is_object())
      place_.refuse(fmt::format("there is no element {} of {}; export the file again", index, name));
    return elements[index];
  }
  // Returns a whole number of an object; `otherwise` where the object has none.
  uint64_t whole(const Json& object, const char* key, uint64_t otherwise) const {
    const auto found = object.find(key);
    if (found == object.end()) return otherwise;
    if (!found->is_number_unsigned()) place_.refuse(fmt::format("'{}' is no whole number; export the file again", key));
    return found->get<uint64_t>();
  }
  uint64_t needed(const Json& object, const char* key) const {
    if (!object.contains(key)) place_.refuse(fmt::format("'{}' is missing; export the file again", key));
    return whole(object, key, 0);
  }
  // Sets `values` to numbers of an object; they stay as they are where the object has none.
  template <size_t N>
  void numbers(const Json& object, const char* key, std::array<double, N>& values) const {
    const auto found = object.find(key);
    if (found == object.end()) return;
    if (!found->is_array() || found->size() != N)
      place_.refuse(fmt::format("'{}' has not {} numbers; export the file again", key, N));
    for (size_t k = 0; k < N; ++k) {
      if (!(*found)[k].is_number() || !std::isfinite((*found)[k].get<double>()))
        place_.refuse(fmt::format("'{}' has not {} numbers; export the file again", key, N));
      values[k] = (*found)[k].get<double>();
    }
  }
  std::vector<uint64_t> indices(const Json& object, const char* key) const {
    std::vector<uint64_t> all;
    const auto found = object.find(key);
    if (found == object.end()) return all;
    if (!found->is_array()) place_.refuse(fmt::format("'{}' is no list; export the file again", key));
    for (const Json& one : *found) {
      if (!one.is_number_unsigned()) place_.refuse(fmt::format("'{}' has no index; export the file again", key));
      all.push_back(one.get<uint64_t>());
    }
    return all;
  }

  // Returns the root nodes of the default scene; without scenes the nodes that are no node's children.
  std::vector<uint64_t> roots(const Json& nodes) const {
    if (document_.contains("scenes")) return indices(element("scenes", whole(document_, "scene", 0)), "nodes");
    std::vector<bool> is_child(nodes.size(), false);
    for (uint64_t k = 0; k < nodes.size(); ++k)
      for (uint64_t child : indices(element("nodes", k), "children"))
        if (child < nodes.size()) is_child[child] = true;
    std::vector<uint64_t> found;
    for (uint64_t k = 0; k < nodes.size(); ++k)
      if (!is_child[k]) found.push_back(k);
    return found;
  }

  glm::dmat4 transformOf(const Json& node) const {
    if (node.contains("matrix")) {
      std::array<double, 16> m{};
      numbers(node, "matrix", m);
      glm::dmat4 matrix;
      for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) matrix[column][row] = m[static_cast<size_t>(4 * column + row)];
      return matrix;
    }
    std::array<double, 3> translation{0, 0, 0}, scale{1, 1, 1};
    std::array<double, 4> rotation{0, 0, 0, 1};
    numbers(node, "translation", translation);
    numbers(node, "rotation", rotation);
    numbers(node, "scale", scale);
    glm::dquat quaternion(rotation[3], rotation[0], rotation[1], rotation[2]);
    const double length = glm::length(quaternion);
    if (!(length > 0)) place_.refuse("'rotation' has no length; export the file again");
    glm::dmat4 matrix = glm::mat4_cast(quaternion / length);
    for (int axis = 0; axis < 3; ++axis) matrix[axis] *= scale[static_cast<size_t>(axis)];
    matrix[3] = glm::dvec4(translation[0], translation[1], translation[2], 1);
    return matrix;
  }

  void addNode(const Json& nodes, uint64_t index, const glm::dmat4& outer, int depth) {
    if (depth > kMostDepth || ++visited_ > kMostNodes)
      place_.refuse("nodes are nested too deeply, or in a circle; export the file again");
    const Json& node = element("nodes", index);
    const glm::dmat4 transform = outer * transformOf(node);
    if (node.contains("mesh")) {
      const Json& mesh = element("meshes", whole(node, "mesh", 0));
      addMesh(mesh, nameOf(node, mesh, index), transform);
    }
    for (uint64_t child : indices(node, "children")) addNode(nodes, child, transform, depth + 1);
  }

  // Returns the name of a node's surface. The second node of one name becomes NAME#2.
  std::string nameOf(const Json& node, const Json& mesh, uint64_t index) {
    std::string name = fmt::format("node {}", index);
    for (const Json* object : {&mesh, &node})
      if (const auto found = object->find("name");
          found != object->end() && found->is_string() && !found->get<std::string>().empty())
        name = found->get<std::string>();
    const uint32_t use = ++uses_[name];
    return use == 1 ? name : fmt::format("{}#{}", name, use);
  }

  void addMesh(const Json& mesh, const std::string& name, const glm::dmat4& transform) {
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end() || !primitives->is_array())
      place_.refuse(fmt::format("mesh '{}' has no primitives; export the file again", printable(name)));
    const auto surface = static_cast<uint32_t>(scene_.surface_names.size());
    scene_.surface_names.push_back(name);
    const bool is_mirrored = glm::determinant(glm::dmat3(transform)) < 0;
    for (const Json& primitive : *primitives) {
      if (!primitive.is_object()) place_.refuse("a primitive is no object; export the file again");
      const uint64_t mode = whole(primitive, "mode", 4);
      if (mode < 4 || mode > 6) {
        ++passed_over_;
        continue;
      }
      const auto attributes = primitive.find("attributes");
      if (attributes == primitive.end() || !attributes->is_object())
        place_.refuse("a primitive has no attributes; export the file again");
      const std::vector<glm::dvec3> points = positions(needed(*attributes, "POSITION"));
      std::vector<uint64_t> corners;
      if (primitive.contains("indices")) corners = cornerIndices(whole(primitive, "indices", 0), points.size());
      else
        for (uint64_t k = 0; k < points.size(); ++k) corners.push_back(k);
      addTriangles(points, corners, mode, surface, transform, is_mirrored);
    }
  }

  void addTriangles(const std::vector<glm::dvec3>& points, const std::vector<uint64_t>& corners, uint64_t mode,
                    uint32_t surface, const glm::dmat4& transform, bool is_mirrored) {
    if (mode == 4 && corners.size() % 3) place_.refuse("a triangle has no three corners; export the file again");
    for (size_t k = 0; k + 2 < corners.size(); k += mode == 4 ? 3 : 1) {
      // Every second triangle of a strip is turned over; all triangles of a fan share the first corner.
      std::array<uint64_t, 3> at = {corners[mode == 6 ? 0 : k], corners[k + 1], corners[k + 2]};
      if ((mode == 5 && k % 2 == 1) != is_mirrored) std::swap(at[1], at[2]);
      if (scene_.faces.size() >= kMostTriangles) place_.refuse("there are too many triangles; cut the scene down");
      InputFace face{{}, surface};
      for (uint64_t corner : at) face.corners.push_back(glm::dvec3(transform * glm::dvec4(points[corner], 1)));
      scene_.faces.push_back(std::move(face));
    }
  }

  // A View is the bytes of an accessor: element k begins at `at` + k `stride`.
  struct View {
    const std::string* bytes;
    uint64_t at, stride, count;
  };
  View viewOf(const Json& accessor, uint64_t element_bytes) {
    if (accessor.contains("sparse")) place_.refuse("sparse accessors are not read; export the file again without them");
    const Json& view = element("bufferViews", needed(accessor, "bufferView"));
    const std::string& bytes = buffer(needed(view, "buffer"));
    const uint64_t count = needed(accessor, "count"), stride = whole(view, "byteStride", element_bytes);
    const uint64_t start = whole(view, "byteOffset", 0), length = needed(view, "byteLength");
    const uint64_t offset = whole(accessor, "byteOffset", 0);
    const bool is_within =
        start <= bytes.size() && length <= bytes.size() - start && offset <= length && stride >= element_bytes &&
        stride <= 252 &&
        (count == 0 || (length - offset >= element_bytes && count - 1 <= (length - offset - element_bytes) / stride));
    if (!is_within) place_.refuse("an accessor goes beyond its buffer; export the file again");
    return {&bytes, start + offset, stride, count};
  }
  void requireType(const Json& accessor, const char* type) const {
    const auto found = accessor.find("type");
    if (found == accessor.end() || !found->is_string() || found->get<std::string>() != type)
      place_.refuse(fmt::format("an accessor is not of type {}; export the file again", type));
  }

  std::vector<glm::dvec3> positions(uint64_t index) {
    const Json& accessor = element("accessors", index);
    requireType(accessor, "VEC3");
    if (whole(accessor, "componentType", 0) != kFloat)
      place_.refuse("positions are not of single precision; export the file again without quantization");
    const View view = viewOf(accessor, 12);
    std::vector<glm::dvec3> points;
    for (uint64_t k = 0; k < view.count; ++k) {
      std::array<float, 3> p;
      std::memcpy(p.data(), view.bytes->data() + view.at + k * view.stride, sizeof p);
      points.emplace_back(p[0], p[1], p[2]);
    }
    return points;
  }

  std::vector<uint64_t> cornerIndices(uint64_t index, uint64_t point_count) {
    const Json& accessor = element("accessors", index);
    requireType(accessor, "SCALAR");
    const uint64_t type = whole(accessor, "componentType", 0);
    const size_t size = type == kByte ? 1 : type == kShort ? 2 : type == kInt ? 4 : 0;
    if (size == 0) place_.refuse("indices are not whole numbers; export the file again");
    const View view = viewOf(accessor, size);
    std::vector<uint64_t> corners;
    for (uint64_t k = 0; k < view.count; ++k) {
      uint32_t corner = 0;
      std::memcpy(&corner, view.bytes->data() + view.at + k * view.stride, size);
      if (corner >= point_count) place_.refuse(fmt::format("there is no point {}; export the file again", corner));
      corners.push_back(corner);
    }
    return corners;
  }

  const std::string& buffer(uint64_t index) {
    const auto found = buffers_.find(index);
    if (found != buffers_.end()) return found->second;
    const Json& object = element("buffers", index);
    const auto uri = object.find("uri");
    if (uri == object.end() || !uri->is_string()) {
      if (index != 0) place_.refuse(fmt::format("buffer {} has no 'uri'; export the file again", index));
      return buffers_[0] = binary_;
    }
    const std::string name = uri->get<std::string>();
    if (name.starts_with("data:")) {
      const size_t comma = name.find(";base64,");
      if (comma == std::string::npos) place_.refuse("a buffer within the file is not base64; export it again");
      return buffers_[index] = decodeBase64(std::string_view(name).substr(comma + 8), place_);
    }
    const fs::path beside = file_.parent_path() / decodePercent(name);
    std::error_code failure;
    std::ifstream in(beside, std::ios::binary);
    if (!fs::is_regular_file(beside, failure) || !in)
      place_.refuse(fmt::format("its buffer '{}' cannot be read; keep it beside the file", printable(name)));
    return buffers_[index] = std::string{std::istreambuf_iterator<char>(in), {}};
  }

  static std::string decodePercent(const std::string& name) {
    std::string plain;
    for (size_t k = 0; k < name.size(); ++k) {
      unsigned code = 0;
      const bool is_escape =
          name[k] == '%' && k + 2 < name.size() &&
          std::from_chars(name.data() + k + 1, name.data() + k + 3, code, 16).ptr == name.data() + k + 3 && code;
      plain += is_escape ? static_cast<char>(code) : name[k];
      if (is_escape) k += 2;
    }
    return plain;
  }

  static constexpr uint64_t kMostNodes = 1u << 20;
  fs::path file_;
  FilePlace place_;
  Json document_;
  std::string binary_;
  std::map<uint64_t, std::string> buffers_;
  std::map<std::string, uint32_t> uses_;
  InputScene scene_;
  uint64_t passed_over_ = 0, visited_ = 0;
};

}  // namespace

InputScene readGltf(const fs::path& file) { return GltfReader(file).read(); }

}  // namespace viewpeel
