// This program writes a generated scene: make_scene room|triangles|city|triangulated_city|sizes N FILE.ply|FILE.stl
#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "scenes/triangulated_city.h"
#include "scenes/write_scene.h"
#include "bench/support/measure.h"

namespace viewpeel::bench {
namespace {

InputScene generate(const std::string& kind, uint32_t n, uint64_t seed) {
  if (kind == "room") return roomWithBoxes(n);
  if (kind == "triangles") return randomTriangles(n);
  if (kind == "sizes") return spreadOfSizes();
  if (kind == "triangulated_city") return triangulatedCity(n, seed).scene;
  return city(n);
}

int makeScene(const std::string& kind, uint32_t n, uint64_t seed, const std::string& file) {
  Clock::time_point start = Clock::now();
  const InputScene input = generate(kind, n, seed);
  const double generate_s = secondsSince(start);
  start = Clock::now();
  file.ends_with(".stl") ? writeStl(input, file) : writePly(input, file);
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
  uint64_t seed = 1;
  CLI::App app("Writes a generated scene as binary PLY or STL and reads it back. Surfaces lose their names.");
  app.add_option("kind", kind)
      ->required()
      ->check(CLI::IsMember({"room", "triangles", "city", "triangulated_city", "sizes"}));
  app.add_option("n", n, "polygons; of the room: cuts of each quad's side")->required()->check(CLI::PositiveNumber);
  app.add_option("file", file, "single precision where it ends in .stl, double where not")->required();
  app.add_option("--seed", seed, "of the triangulated city")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return viewpeel::bench::makeScene(kind, n, seed, file);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
