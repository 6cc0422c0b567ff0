#include "scenes/write_scene.h"

#include <bit>
#include <fstream>
#include <unordered_map>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>

namespace viewpeel::bench {
namespace {

struct HashCorner {
  size_t operator()(const glm::dvec3& p) const {
    uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis)
      hash = (hash ^ std::bit_cast<uint64_t>(p[axis])) * 0x9E3779B97F4A7C15ull, hash ^= hash >> 29;
    return hash;
  }
};

class Bytes {
 public:
  template <class T>
  void append(const T& value) {
    static_assert(std::endian::native == std::endian::little);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  const std::string& string() const { return bytes_; }

 private:
  std::string bytes_;
};

void flush(std::ofstream& out, const std::string& file) {
  if (!out.flush()) throw Error(ErrorCode::output, fmt::format("{}: cannot be written; choose another place", file));
}

}  // namespace

void writePly(const InputScene& scene, const std::string& file) {
  std::unordered_map<glm::dvec3, int32_t, HashCorner> index_of;
  index_of.reserve(2 * scene.faces.size());
  Bytes vertices, faces;
  for (const InputFace& face : scene.faces) {
    faces.append(static_cast<uint8_t>(face.corners.size()));
    for (const glm::dvec3& corner : face.corners) {
      const auto [at, is_new] = index_of.emplace(corner, static_cast<int32_t>(index_of.size()));
      if (is_new)
        for (int axis = 0; axis < 3; ++axis) vertices.append(corner[axis]);
      faces.append(at->second);
    }
  }
  std::ofstream out(file, std::ios::binary);
  out << fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty double x\nproperty double "
      "y\nproperty double z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      scene.file, index_of.size(), scene.faces.size());
  out << vertices.string() << faces.string();
  flush(out, file);
}

void writeStl(const InputScene& scene, const std::string& file) {
  constexpr size_t kHeaderBytes = 80;
  Bytes facets;
  for (const InputFace& face : scene.faces) {
    if (face.corners.size() != 3)
      throw Error(ErrorCode::bad_input, fmt::format("{}: STL has triangles only; choose .ply", file));
    const glm::dvec3 normal =
        glm::normalize(glm::cross(face.corners[1] - face.corners[0], face.corners[2] - face.corners[0]));
    for (const glm::dvec3& p : {normal, face.corners[0], face.corners[1], face.corners[2]})
      for (int axis = 0; axis < 3; ++axis) facets.append(float(p[axis]));
    facets.append(uint16_t{0});
  }
  std::string header = scene.file.substr(0, kHeaderBytes);
  header.resize(kHeaderBytes, ' ');
  Bytes count;
  count.append(static_cast<uint32_t>(scene.faces.size()));
  std::ofstream out(file, std::ios::binary);
  out << header << count.string() << facets.string();
  flush(out, file);
}

}  // namespace viewpeel::bench
