#include "bench/rivals/view3d.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel::bench {

void writeView3d(const Scene& scene, double epsilon, std::ostream& out) {
  out << fmt::format("T {}\nC eps={:g} encl=0 emit=0 list=0 row=0 col=0\nF 3\n", scene.surfaces.front().name, epsilon);
  for (size_t k = 0; k < scene.corners.size(); ++k) {
    const glm::dvec3 p = scene.centre + scene.scale * scene.corners[k];
    out << fmt::format("V {} {:.17g} {:.17g} {:.17g}\n", k + 1, p.x, p.y, p.z);
  }
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const Polygon& polygon = scene.polygons[k];
    const uint32_t first = polygon.first_corner + 1;
    out << fmt::format("S {} {} {} {} {} 0 0 0.9 polygon_{}\n", k + 1, first, first + 1, first + 2,
                       polygon.corner_count == 4 ? first + 3 : 0, k + 1);
  }
  out << "End\n";
}

ExchangeMatrix readView3d(std::istream& in, uint32_t polygon_count, const std::string& name) {
  const auto refuse = [&](const std::string& what) {
    return Error(ErrorCode::bad_input, fmt::format("{}: {}; give View3D's own text output", name, what));
  };
  std::string line, word, version;
  std::getline(in, line);
  std::istringstream head(line);
  uint32_t out_format = 0, enclosure = 0, emissivity = 0, count = 0;
  if (!(head >> word >> version >> out_format >> enclosure >> emissivity >> count) || word != "View3D")
    throw refuse("the first line is not `View3D version out encl emit N`");
  if (count != polygon_count) throw refuse(fmt::format("{} surfaces in place of {}", count, polygon_count));
  const auto read = [&](const char* what) {
    double value = 0;
    if (!(in >> value)) throw refuse(fmt::format("{} missing or no number", what));
    return value;
  };
  std::vector<double> areas(count);
  for (double& area : areas) area = read("an area is");
  ExchangeMatrix exchange(count);
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = 0; j < count; ++j)
      if (const double factor = read("a form factor is"); i != j) exchange.at(i, j) += areas[i] * factor / 2;
  for (uint32_t i = 0; i < count; ++i) read("an emissivity is");
  return exchange;
}

View3dRun runView3d(const std::string& program, const Scene& scene, double epsilon, const std::string& directory) {
  const std::string input = directory + "/view3d.vs3", output = directory + "/view3d.txt";
  {
    std::ofstream file(input);
    writeView3d(scene, epsilon, file);
    if (!file.flush())
      throw Error(ErrorCode::output, fmt::format("{}: cannot be written; choose another --work directory", input));
  }
  std::remove(output.c_str());
  // View3D leaves a log in its working directory.
  const auto absolute = [](const std::string& file) { return std::filesystem::absolute(file).string(); };
  const std::string command = fmt::format("cd '{}' && '{}' '{}' '{}' >/dev/null 2>&1", directory,
                                          program.find('/') == std::string::npos ? program : absolute(program),
                                          absolute(input), absolute(output));
  int status = 0;
  const RunTime time = timeOf([&] { status = std::system(command.c_str()); });
  if (status != 0)
    throw Error(
        ErrorCode::bad_usage,
        fmt::format(
            "{}: ends with status {}; give the path of View3D's program, which takes an input and an output file",
            program, WEXITSTATUS(status)));
  std::ifstream file(output);
  return {readView3d(file, static_cast<uint32_t>(scene.polygons.size()), output), time};
}

}  // namespace viewpeel::bench
