#include "bench/rivals/embree_rays.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>

namespace viewpeel::bench {
namespace {

// A ray starts and ends at a distance from its polygons of 0.01 of their size, between these two, in unit-ball units.
// The distance exceeds rounding to 32 bits, and is short beside the distance of small polygons.
constexpr float kMostAway = 1e-5f, kLeastAway = 2e-7f, kAwayPerSize = 0.01f;
constexpr uint64_t kRaysAtOnce = 1u << 14;
constexpr uint32_t kAngles = 4096;

float toUnit(uint32_t word) { return float(word >> 8) * 0x1p-24f; }

// Circle returns cosine and sine of the angle 2 pi 2^-32 x word. It adds to a table a series for the rest of the angle.
// The rest is below 2 pi / kAngles, and its third power below 4e-9.
class Circle {
 public:
  Circle() {
    for (uint32_t k = 0; k < kAngles; ++k)
      table_[k] = {std::cos(2 * std::numbers::pi * k / kAngles), std::sin(2 * std::numbers::pi * k / kAngles)};
  }
  glm::vec2 at(uint32_t word) const {
    const glm::vec2 p = table_[word / (UINT32_MAX / kAngles + 1)];
    const float rest_rad = float(word % (UINT32_MAX / kAngles + 1)) * float(2 * std::numbers::pi * 0x1p-32),
                half = 1 - rest_rad * rest_rad / 2;
    return {p.x * half - p.y * rest_rad, p.y * half + p.x * rest_rad};
  }

 private:
  std::array<glm::vec2, kAngles> table_;
};

const Circle kCircle;

// Returns whether each polygon reaches in front of the other's plane. Corners on the plane, up to rounding, do not
// count as in front.
bool faceEachOther(const Scene& scene, uint32_t i, uint32_t j) {
  const auto reachesInFront = [&](uint32_t of, uint32_t other) {
    const Polygon &polygon = scene.polygons[of], &plane_of = scene.polygons[other];
    const Plane& plane = scene.planes[plane_of.plane];
    for (uint32_t k = 0; k < polygon.corner_count; ++k) {
      const double height = glm::dot(plane.normal, scene.corners[polygon.first_corner + k]) - plane.offset;
      if ((plane_of.front_along_plane_normal ? height : -height) > 1e-12) return true;
    }
    return false;
  };
  return reachesInFront(i, j) && reachesInFront(j, i);
}

}  // namespace

EmbreeRays::EmbreeRays(const Scene& scene) : scene_(scene), embree_(scene) {
  for (uint32_t index = 0; index < scene.polygons.size(); ++index) {
    const Polygon& polygon = scene.polygons[index];
    const glm::dvec3* p = &scene.corners[polygon.first_corner];
    const bool triangle = polygon.corner_count == 3;
    const glm::dvec3 a = p[1] - p[0], b = p[2] - p[0], c = triangle ? b : p[3] - p[0];
    const double first = glm::length(glm::cross(a, b)), second = triangle ? 0 : glm::length(glm::cross(b, c));
    const bool parallelogram = !triangle && glm::length(a + c - b) < 1e-12;
    const glm::vec3 x = glm::normalize(a), normal = embree_.normal(index);
    emitters_.push_back({p[0], a, b, c, float(first / (first + second)), parallelogram, x, glm::cross(normal, x),
                         normal, std::clamp(kAwayPerSize * float(std::sqrt(polygon.area)), kLeastAway, kMostAway)});
  }
}

glm::vec3 EmbreeRays::pointOn(const Emitter& emitter, uint32_t s, uint32_t t) {
  float u = toUnit(s), v = toUnit(t);
  if (emitter.parallelogram) return emitter.origin + u * emitter.a + v * emitter.c;
  // Coordinate u also chooses the triangle, and is then stretched to [0, 1) again. The map from square to triangle has
  // no fold, which would break strata.
  const bool first = u < emitter.share;
  u = first ? u / emitter.share : (u - emitter.share) / (1 - emitter.share);
  const float root = std::sqrt(u);
  return emitter.origin + root * ((1 - v) * (first ? emitter.a : emitter.b) + v * (first ? emitter.b : emitter.c));
}

RayCounts EmbreeRays::shoot(Trace trace, Points points, uint64_t rays_per_polygon, uint64_t seed) const {
  const auto polygon_count = static_cast<uint32_t>(emitters_.size());
  const uint64_t parts = (rays_per_polygon + kRaysAtOnce - 1) / kRaysAtOnce;
  std::atomic<uint64_t> next = 0;
  std::vector<std::vector<RayCounts::Hits>> hits(threadCount());
  runOnAllCores([&](uint32_t thread) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    std::array<Ray, kRayGroup> rays;
    std::array<uint32_t, kRayGroup> hit;
    std::vector<uint32_t> row(polygon_count, 0), hit_polygons;
    for (uint64_t part; (part = next++) < parts * polygon_count;) {
      const auto from = static_cast<uint32_t>(part / parts);
      const uint64_t first = part % parts * kRaysAtOnce, end = std::min(first + kRaysAtOnce, rays_per_polygon);
      const Emitter& emitter = emitters_[from];
      PointSource source(points, seed, from, first);
      for (uint64_t done = first; done < end; done += kRayGroup) {
        const auto count = static_cast<uint32_t>(std::min<uint64_t>(kRayGroup, end - done));
        for (uint32_t k = 0; k < count; ++k) {
          const auto point = source.next();
          const float squared = toUnit(point[2]), radius = std::sqrt(squared);
          const glm::vec2 local = radius * kCircle.at(point[3]);
          rays[k] = {pointOn(emitter, point[0], point[1]),
                     local.x * emitter.x + local.y * emitter.y + std::sqrt(1 - squared) * emitter.normal, emitter.away,
                     4};
        }
        embree_.findFirst(trace, context, std::span(rays).first(count), hit);
        for (uint32_t k = 0; k < count; ++k) {
          const uint32_t to = hit[k];
          if (to == UINT32_MAX || to == from || glm::dot(embree_.normal(to), rays[k].direction) >= 0) continue;
          if (row[to]++ == 0) hit_polygons.push_back(to);
        }
      }
      for (const uint32_t to : hit_polygons) {
        hits[thread].push_back({from, to, row[to]});
        row[to] = 0;
      }
      hit_polygons.clear();
    }
  });
  RayCounts counts{{}, rays_per_polygon};
  for (const auto& of_thread : hits) counts.hits.insert(counts.hits.end(), of_thread.begin(), of_thread.end());
  return counts;
}

RayEstimate estimateFromRays(const RayCounts& counts, const Scene& scene) {
  const auto polygon_count = static_cast<uint32_t>(scene.polygons.size());
  RayEstimate estimate{ExchangeMatrix(polygon_count)};
  for (const RayCounts::Hits& hits : counts.hits) estimate.exchange.at(hits.from, hits.to) += hits.count;
  double squares = 0;
  const auto rays = double(counts.rays_per_polygon);
  for (uint32_t i = 0; i < polygon_count; ++i)
    for (uint32_t j = i + 1; j < polygon_count; ++j) {
      double& value = estimate.exchange.at(i, j);
      if (value == 0) continue;
      const double area_i = scene.polygons[i].area, area_j = scene.polygons[j].area,
                   density = rays / area_i + rays / area_j;
      value /= density;
      const double f_ij = value / area_i, f_ji = value / area_j;
      const double variance = rays * (f_ij * (1 - f_ij) + f_ji * (1 - f_ji)) / (density * density);
      squares += variance / (area_i * area_i) + variance / (area_j * area_j);
    }
  estimate.rms_standard_error = std::sqrt(squares / (double(polygon_count) * (polygon_count - 1.0)));
  return estimate;
}

RayEstimate EmbreeRays::integrate(Trace trace, Points points, uint32_t samples_per_pair, uint64_t seed) const {
  const auto polygon_count = static_cast<uint32_t>(emitters_.size());
  RayEstimate estimate{ExchangeMatrix(polygon_count)};
  std::atomic<uint32_t> next = 0;
  std::vector<double> squares(threadCount(), 0);
  runOnAllCores([&](uint32_t thread) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    struct Sample {
      uint32_t j;
      float kernel;
    };
    std::array<Ray, kRayGroup> rays;
    std::array<Sample, kRayGroup> samples;
    std::array<bool, kRayGroup> blocked;
    std::vector<double> sum(polygon_count), sum_of_squares(polygon_count);
    uint32_t waiting = 0;
    const auto traceWaiting = [&] {
      embree_.findBlocked(trace, context, std::span(rays).first(waiting), blocked);
      for (uint32_t k = 0; k < waiting; ++k) {
        if (blocked[k]) continue;
        sum[samples[k].j] += samples[k].kernel;
        sum_of_squares[samples[k].j] += double(samples[k].kernel) * samples[k].kernel;
      }
      waiting = 0;
    };
    for (uint32_t i; (i = next++) < polygon_count;) {
      const Emitter& from = emitters_[i];
      std::fill(sum.begin() + i, sum.end(), 0);
      std::fill(sum_of_squares.begin() + i, sum_of_squares.end(), 0);
      for (uint32_t j = i + 1; j < polygon_count; ++j) {
        if (!faceEachOther(scene_, i, j)) continue;
        const Emitter& to = emitters_[j];
        PointSource source(points, seed, uint64_t(i) << 32 | j);
        for (uint32_t k = 0; k < samples_per_pair; ++k) {
          const auto point = source.next();
          const glm::vec3 p = pointOn(from, point[0], point[1]), line = pointOn(to, point[2], point[3]) - p;
          const float squared = glm::dot(line, line),
                      cosines = glm::dot(from.normal, line) * -glm::dot(to.normal, line);
          if (glm::dot(from.normal, line) <= 0 || cosines <= 0) continue;
          const float length = std::sqrt(squared);
          rays[waiting] = {p, line / length, from.away, length - to.away};
          samples[waiting] = {j, cosines / (float(std::numbers::pi) * squared * squared)};
          if (++waiting == kRayGroup) traceWaiting();
        }
      }
      traceWaiting();
      for (uint32_t j = i + 1; j < polygon_count; ++j) {
        if (sum[j] == 0) continue;
        const double area_i = scene_.polygons[i].area, area_j = scene_.polygons[j].area, n = samples_per_pair,
                     mean = sum[j] / n;
        estimate.exchange.at(i, j) = area_i * area_j * mean;
        if (samples_per_pair < 2) continue;
        const double variance = std::max(0.0, sum_of_squares[j] / n - mean * mean) / (n - 1);
        squares[thread] += variance * (area_i * area_i + area_j * area_j);
      }
    }
  });
  double sum = 0;
  for (const double s : squares) sum += s;
  estimate.rms_standard_error = std::sqrt(sum / (double(polygon_count) * (polygon_count - 1.0)));
  return estimate;
}

}  // namespace viewpeel::bench
