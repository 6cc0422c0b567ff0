// Writes a generated scene as binary PLY: make_scene room|triangles|city|sizes N FILE.ply
#include <bit>
#include <chrono>
#include <cstring>
#include <fstream>
#include <unordered_map>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/support/measure.h"

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
  if (!out.flush()) throw Error(ErrorCode::output, fmt::format("{}: cannot be written; choose another place", file));
}

int makeScene(const std::string& kind, uint32_t n, const std::string& file) {
  Clock::time_point start = Clock::now();
  const InputScene input = kind == "room"        ? roomWithBoxes(n)
                           : kind == "triangles" ? randomTriangles(n)
                           : kind == "sizes"     ? spreadOfSizes()
                                                 : city(n);
  const double generate_s = secondsSince(start);
  start = Clock::now();
  writePly(input, file);
  const double write_s = secondsSince(start);
  start = Clock::now();
  const Scene scene = loadScene(file);
  const double load_s = secondsSince(start);
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "{}\n", warning);
  fmt::print(
      "{}: {}, {} polygons in {} surfaces, {} planes; generated in {:.2f} s, written in {:.2f} s, loaded in {:.2f} s\n",
      file, input.file, input.faces.size(), input.surface_names.size(), scene.planes.size(), generate_s, write_s,
      load_s);
  if (scene.faces.size() != input.faces.size() || scene.polygons.size() != input.faces.size())
    throw Error(ErrorCode::check,
                fmt::format("{}: {} faces and {} polygons read back", file, scene.faces.size(), scene.polygons.size()));
  return 0;
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  std::string kind, file;
  uint32_t n = 0;
  CLI::App app("Writes a generated scene as binary PLY and reads it back. Surfaces have no names in PLY.");
  app.add_option("kind", kind)->required()->check(CLI::IsMember({"room", "triangles", "city", "sizes"}));
  app.add_option("n", n, "polygons; of the room: cuts of each quad's side")->required()->check(CLI::PositiveNumber);
  app.add_option("file", file)->required();
  CLI11_PARSE(app, argc, argv);
  try {
    return viewpeel::bench::makeScene(kind, n, file);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
