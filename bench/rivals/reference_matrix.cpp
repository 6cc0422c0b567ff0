#include "bench/rivals/reference_matrix.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "bench/rivals/methods.h"
#include "reference/closed_forms/contour_integral.h"

namespace viewpeel::bench {
namespace {

// Of a kept file; the values follow.
struct Header {
  uint64_t version = 1, fingerprint = 0, count = 0;
  double seconds = 0;
  MatrixError error;
};

std::vector<double> areasOf(const Scene& scene) {
  std::vector<double> areas;
  for (const Polygon& polygon : scene.polygons) areas.push_back(polygon.area);
  return areas;
}

bool readKept(const std::string& file, uint64_t scene_fingerprint, double seconds, ReferenceMatrix& reference) {
  std::ifstream in(file, std::ios::binary);
  Header header;
  if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  if (header.version != Header{}.version || header.fingerprint != scene_fingerprint || header.seconds < seconds ||
      header.count != reference.exchange.count())
    return false;
  std::vector<double>& values = reference.exchange.values();
  if (!in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(8 * values.size()))) return false;
  reference.error = header.error;
  reference.seconds = header.seconds;
  return true;
}

}  // namespace

ReferenceMatrix referenceByClosedForms(const Scene& scene) {
  const auto count = static_cast<uint32_t>(scene.polygons.size());
  ReferenceMatrix reference{ExchangeMatrix(count), {}, 0, "closed forms"};
  std::vector<std::vector<glm::dvec3>> corners;
  for (const Polygon& p : scene.polygons)
    corners.emplace_back(scene.corners.begin() + p.first_corner,
                         scene.corners.begin() + p.first_corner + p.corner_count);
  ErrorSums sums;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; ++j) {
      reference.exchange.at(i, j) = scene.polygons[i].area * reference::formFactor(corners[i], corners[j]);
      sums.add(reference.exchange.at(i, j), reference::kContourError * scene.polygons[i].area, scene.polygons[i].area,
               scene.polygons[j].area);
    }
  reference.error = sums.over(count);
  return reference;
}

ReferenceMatrix referenceByLongRun(const Device& device, const Scene& scene, const std::string& name, double seconds,
                                   const std::string& directory) {
  const auto count = static_cast<uint32_t>(scene.polygons.size());
  const uint64_t print = fingerprint(scene);
  const std::string file = fmt::format("{}/{}-{:016x}.bin", directory, name, print);
  ReferenceMatrix reference{ExchangeMatrix(count), {}, seconds, {}};
  if (!readKept(file, print, seconds, reference)) {
    LongRun run = runLong(device, scene, seconds);
    reference.exchange = std::move(run.exchange);
    ErrorSums sums;
    const std::vector<double> areas = areasOf(scene);
    for (uint32_t i = 0; i < count; ++i)
      for (uint32_t j = i + 1; j < count; ++j)
        sums.add(reference.exchange.at(i, j), run.standard_errors.at(i, j), areas[i], areas[j]);
    reference.error = sums.over(count);
    std::filesystem::create_directories(directory);
    std::ofstream out(file, std::ios::binary);
    const Header header{.fingerprint = print, .count = count, .seconds = seconds, .error = reference.error};
    out.write(reinterpret_cast<const char*>(&header), sizeof header);
    out.write(reinterpret_cast<const char*>(reference.exchange.values().data()),
              static_cast<std::streamsize>(8 * reference.exchange.values().size()));
    if (!out.flush())
      throw Error(ErrorCode::output, fmt::format("{}: cannot be written; choose another --cache directory", file));
  }
  reference.source = fmt::format("a run of viewpeel for {:.0f} s with unoccluded form factors", reference.seconds);
  return reference;
}

}  // namespace viewpeel::bench
