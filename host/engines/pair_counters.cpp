#include "engines/pair_counters.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "engines/lattice_options.h"
#include "engines/shared.h"
#include "error.h"

namespace viewpeel {
namespace {

template <class T>
Buffer uploadBuffer(const Device& device, const std::vector<T>& values) {
  Buffer buffer(device, values.size() * sizeof(T), MemoryUse::upload);
  buffer.write<T>(values);
  return buffer;
}

std::vector<device_data::PolygonData> listPolygons(const Scene& scene, const Ids& ids) {
  std::vector<device_data::PolygonData> polygons;
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const Polygon& polygon = scene.polygons[k];
    const Plane& plane = scene.planes[polygon.plane];
    polygons.push_back({polygon.first_corner, polygon.corner_count, ids.of_polygon[k], 0, plane.normal, plane.offset});
  }
  return polygons;
}

}  // namespace

SceneBuffers::SceneBuffers(const Device& device, const Scene& scene, const Ids& ids)
    : polygons(uploadBuffer(device, listPolygons(scene, ids))),
      corners(uploadBuffer(device, scene.corners)),
      polygon_count(static_cast<uint32_t>(scene.polygons.size())),
      corner_count(static_cast<uint32_t>(scene.corners.size())) {}

int chooseFractionBits(int resolution) {
  if (resolution < 1 || resolution > kMaxResolution)
    throw Error(ErrorCode::bad_usage, fmt::format("resolution {} is out of range; choose 1 to {}", resolution, kMaxResolution));
  return device_data::kSnapBits - std::bit_width(static_cast<uint32_t>(resolution / 2 + 1));
}

PairCounters::PairCounters(const Device& device, uint32_t id_count, uint64_t budget_bytes)
    : id_count_(id_count), counter_count_(device_data::counterIndex(id_count - 1, id_count + 1, id_count) + 1) {
  const uint64_t bytes = counter_count_ * sizeof(uint32_t), budget = std::min<uint64_t>(budget_bytes, device.maxAllocationBytes());
  if (bytes > budget)
    throw Error(ErrorCode::limit, fmt::format("counters of all pairs of {} ids need {:.1f} MiB, more than the {:.1f} MiB allowed; "
                                              "try --by surface",
                                              id_count, double(bytes) / 1048576.0, double(budget) / 1048576.0));
  counters_ = Buffer(device, bytes, MemoryUse::device);
  read_back_ = Buffer(device, bytes, MemoryUse::readback);
}

void PairCounters::start(Commands& commands) {
  sums_.assign(counter_count_, 0);
  clear(commands);
}

void PairCounters::makeRoom(Commands& commands, uint64_t most) {
  most_in_counter_ += most;
  if (most_in_counter_ <= 0xFFFFFFFFull) return;
  read(commands);
  clear(commands);
  most_in_counter_ = most;
}

PairCounts PairCounters::finish(Commands& commands) {
  read(commands);
  PairCounts counts;
  uint64_t at = 0;
  for (uint32_t i = 0; i < id_count_; ++i)
    for (uint32_t column = i; column < id_count_ + 2; ++column, ++at)
      if (sums_[at]) counts.push_back({i, column == id_count_ ? kEnvironment : column > id_count_ ? kLeak : column, sums_[at]});
  return counts;
}

void PairCounters::clear(Commands& commands) {
  commands.begin();
  commands.fill(counters_, 0);
  commands.submitAndWait();
  most_in_counter_ = 0;
}

void PairCounters::read(Commands& commands) {
  commands.begin();
  commands.copy(counters_, read_back_, counter_count_ * sizeof(uint32_t));
  commands.submitAndWait();
  const std::span<uint32_t> read = read_back_.mapped<uint32_t>();
  for (uint64_t k = 0; k < counter_count_; ++k) sums_[k] += read[k];
}

}  // namespace viewpeel
