#include "bench/rivals/embree_rivals.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "engines/pair_table.h"
#include <viewpeel/error.h>
#include "facing.h"

namespace viewpeel::bench {
namespace {

constexpr float kStart = -1.001f;          // start of a line, outside the unit ball
constexpr float kAwayFromPolygon = 1e-5f;  // distance of a ray's start from its polygon, unit-ball units
constexpr uint32_t kCosineCount = 4096;
constexpr uint64_t kMostDenseBytes = 16u << 20;  // the limit of the host engine

struct Random {  // splitmix64 takes far less time than a ray
  uint64_t state;
  uint64_t next() {
    uint64_t z = state += 0x9E3779B97F4A7C15ull;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ z >> 27) * 0x94D049BB133111EBull;
    return z ^ z >> 31;
  }
};

// Returns directions of Lambert's cosine law. The table spares every ray two square roots, a sine and a cosine.
std::array<glm::vec3, kCosineCount> cosineDirections() {
  std::array<glm::vec3, kCosineCount> table;
  const double golden_angle_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  for (uint32_t k = 0; k < kCosineCount; ++k) {
    const double squared = (k + 0.5) / kCosineCount, r = std::sqrt(squared);
    table[k] = {r * std::cos(golden_angle_rad * k), r * std::sin(golden_angle_rad * k), std::sqrt(1 - squared)};
  }
  return table;
}

// Emitter is a parallelogram or triangle from which rays start.
struct Emitter {
  glm::vec3 origin, a, b;  // sides
  glm::vec3 x, y, normal;  // orthonormal
  uint32_t id;
  bool triangle;
};

// LineContext collects the hits of a group of lines, by a filter. A hit has distance and primitive in one word, for
// positive floats sort like integers.
struct LineContext {
  RTCIntersectContext context;
  std::array<std::vector<uint64_t>, kRayGroup> hits;
};

// Records every hit and rejects it, so that the traversal goes on to the next.
void recordHit(const RTCFilterFunctionNArguments* args) {
  auto* lines = reinterpret_cast<LineContext*>(args->context);
  for (uint32_t k = 0; k < args->N; ++k) {
    if (args->valid[k] != -1) continue;
    const float distance = RTCRayN_tfar(args->ray, args->N, k);
    lines->hits[RTCRayN_id(args->ray, args->N, k)].push_back(uint64_t(std::bit_cast<uint32_t>(distance)) << 32 |
                                                             RTCHitN_primID(args->hit, args->N, k));
    args->valid[k] = 0;
  }
}

}  // namespace

struct EmbreeRivals::State {
  const Ids& ids;
  EmbreeScene scene;
  std::vector<Emitter> emitters;  // one for each polygon
  std::optional<SharedPairs> shared;
  std::vector<PairTable> tables;  // one for each thread
  std::array<glm::vec3, kCosineCount> cosine_directions = cosineDirections();
  uint64_t polygons_shot = 0;

  State(const Scene& the_scene, const Ids& the_ids) : ids(the_ids), scene(the_scene) {}

  static void countGap(PairTable& table, uint32_t gap, uint32_t lower, uint32_t upper) {
    if (gap == kGapFacingPair) table.add(std::min(lower, upper), std::max(lower, upper), 1);
    else if (gap == kGapLowerEnvironment) table.add(lower, kEnvironment, 1);
    else if (gap == kGapUpperEnvironment) table.add(upper, kEnvironment, 1);
    else if (gap == kGapLowerLeak) table.add(lower, kLeak, 1);
    else if (gap == kGapUpperLeak) table.add(upper, kLeak, 1);
  }

  // Returns the number of facing pairs.
  uint32_t countLine(PairTable& table, std::vector<uint64_t>& hits, const glm::vec3& u) const {
    std::sort(hits.begin(), hits.end());
    uint32_t lower_side = kSideNone, lower = 0, last = UINT32_MAX, pairs = 0;
    for (const uint64_t hit : hits) {
      // A polygon may occur twice, if the tree holds it twice or a line hits the diagonal along which it was cut.
      const uint32_t polygon = scene.polygonOf(static_cast<uint32_t>(hit));
      if (polygon == last) continue;
      last = polygon;
      const uint32_t id = ids.of_polygon[polygon];
      const bool front_up = glm::dot(scene.normal(polygon), u) > 0;
      const uint32_t gap = classifyGap(lower_side, sideTowardsGap(front_up, ids.two_sided, false));
      pairs += gap == kGapFacingPair;
      countGap(table, gap, lower, id);
      lower_side = sideTowardsGap(front_up, ids.two_sided, true);
      lower = id;
    }
    countGap(table, classifyGap(lower_side, kSideNone), lower, 0);
    return pairs;
  }

  Ray rayFrom(const Emitter& emitter, Random& random) const {
    const uint64_t bits = random.next(), more = random.next();
    float s = float(bits & 0xFFFFFF) * 0x1p-24f, t = float(bits >> 24 & 0xFFFFFF) * 0x1p-24f;
    if (emitter.triangle && s + t > 1) s = 1 - s, t = 1 - t;
    const glm::vec3 local = cosine_directions[more % kCosineCount];
    const glm::vec3 normal = ids.two_sided && more >> 63 ? -emitter.normal : emitter.normal;
    return {emitter.origin + s * emitter.a + t * emitter.b,
            local.x * emitter.x + local.y * emitter.y + local.z * normal, kAwayFromPolygon, 4};
  }
};

EmbreeRivals::EmbreeRivals(const Scene& scene, const Ids& ids) : state_(std::make_unique<State>(scene, ids)) {
  for (uint32_t index = 0; index < scene.polygons.size(); ++index) {
    const Polygon& polygon = scene.polygons[index];
    const glm::dvec3* corners = &scene.corners[polygon.first_corner];
    const bool triangle = polygon.corner_count == 3;
    if (!triangle &&
        (polygon.corner_count != 4 || glm::length(corners[0] + corners[2] - corners[1] - corners[3]) > 1e-12))
      throw Error(ErrorCode::bad_input,
                  fmt::format("{}: a polygon is neither triangle nor parallelogram; choose another scene", scene.file));
    const glm::vec3 a = corners[1] - corners[0], b = corners[polygon.corner_count - 1] - corners[0],
                    x = glm::normalize(a), normal = state_->scene.normal(index);
    state_->emitters.push_back({corners[0], a, b, x, glm::cross(normal, x), normal, ids.of_polygon[index], triangle});
  }
  const bool is_dense = PairTable::denseBytes(ids.count(), false) <= kMostDenseBytes;
  if (!is_dense) state_->shared.emplace(ids.count(), false, UINT64_MAX);
  state_->tables.reserve(threadCount());
  for (size_t k = 0; k < threadCount(); ++k)
    state_->tables.push_back(is_dense ? PairTable(ids.count(), false) : PairTable(*state_->shared));
}

EmbreeRivals::~EmbreeRivals() = default;

uint64_t EmbreeRivals::countLines(Trace trace, std::span<const Direction> directions, int resolution) {
  const int tiles_per_side = 2 * ((resolution / 2 + 2 + 7) / 8);
  const uint64_t rows = directions.size() * tiles_per_side;
  std::atomic<uint64_t> next_row = 0, pairs = 0;
  runOnAllCores([&](uint32_t thread) {
    PairTable& table = state_->tables[thread];
    LineContext lines;
    rtcInitIntersectContext(&lines.context);
    lines.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    lines.context.filter = recordHit;
    std::vector<Ray> rays;
    std::array<bool, kRayGroup> blocked;  // stays false, for every hit is rejected
    uint64_t local_pairs = 0;
    for (uint64_t row; (row = next_row++) < rows;) {
      const Direction& direction = directions[row / tiles_per_side];
      const glm::vec3 u = direction.u;
      const int first_y = (int(row % tiles_per_side) - tiles_per_side / 2) * 8;
      for (int tile = 0; tile < tiles_per_side; ++tile) {
        const int first_x = (tile - tiles_per_side / 2) * 8;
        rays.clear();
        for (int y = first_y; y < first_y + 8; y += 2)  // packets of 4 x 2 points
          for (int x = first_x; x < first_x + 8; x += 4)
            for (int k = 0; k < 8; ++k) {
              const glm::dvec2 p = (glm::dvec2(x + k % 4, y + k / 4) - direction.offset) * (2.0 / resolution);
              if (glm::dot(p, p) >= 1) continue;
              rays.push_back(
                  {p.x * direction.x_axis + p.y * direction.y_axis + double(kStart) * direction.u, u, 0, -2 * kStart});
            }
        if (rays.empty()) continue;
        for (size_t k = 0; k < rays.size(); ++k) lines.hits[k].clear();
        state_->scene.findBlocked(trace, lines.context, rays, std::span(blocked).first(rays.size()));
        for (size_t k = 0; k < rays.size(); ++k)
          if (!lines.hits[k].empty()) local_pairs += state_->countLine(table, lines.hits[k], u);
      }
    }
    pairs += local_pairs;
  });
  return pairs;
}

RayCount EmbreeRivals::shootRays(Trace trace, uint64_t ray_count, uint64_t seed) {
  const uint64_t groups = (ray_count + kRayGroup - 1) / kRayGroup, first_group = state_->polygons_shot;
  state_->polygons_shot += groups;
  std::atomic<uint64_t> next = 0, samples = 0;
  runOnAllCores([&](uint32_t thread) {
    constexpr uint64_t kAtOnce = 64;
    PairTable& table = state_->tables[thread];
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    std::array<Ray, kRayGroup> rays;
    std::array<uint32_t, kRayGroup> hit;
    uint64_t local_samples = 0;
    for (uint64_t begin; (begin = next.fetch_add(kAtOnce)) < groups;)
      for (uint64_t group = begin; group < std::min(begin + kAtOnce, groups); ++group) {
        Random random{seed ^ (first_group + group) * 0xD1342543DE82EF95ull};
        const Emitter& emitter = state_->emitters[(first_group + group) % state_->emitters.size()];
        for (uint32_t k = 0; k < kRayGroup; ++k) rays[k] = state_->rayFrom(emitter, random);
        state_->scene.findFirst(trace, context, rays, hit);
        const uint32_t from = emitter.id;
        for (uint32_t k = 0; k < kRayGroup; ++k) {
          if (hit[k] == UINT32_MAX) {
            table.add(from, kEnvironment, 1);
          } else if (state_->ids.two_sided || glm::dot(state_->scene.normal(hit[k]), rays[k].direction) < 0) {
            const uint32_t to = state_->ids.of_polygon[hit[k]];
            table.add(std::min(from, to), std::max(from, to), 1);
            ++local_samples;
          } else {
            table.add(from, kLeak, 1);
          }
        }
      }
    samples += local_samples;
  });
  return {groups * kRayGroup, samples};
}

PairCounts EmbreeRivals::takeCounts() {
  std::vector<PairTable>& tables = state_->tables;
  if (state_->shared) {
    for (PairTable& table : tables) table.flush();
    return state_->shared->takeAll(tables.size());
  }
  for (size_t k = 1; k < tables.size(); ++k) tables[k].moveInto(tables[0]);
  return tables[0].take();
}

}  // namespace viewpeel::bench
