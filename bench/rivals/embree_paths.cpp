// Monte Carlo radiosity: paths of radiation that end where they are absorbed.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>

#include "bench/rivals/embree_rays.h"
#include "directions/random.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kPathsAtOnce = 1u << 14;

// Returns a number in [0, 1) from the upper bits of a word.
float toUnit(uint64_t word) { return float(word >> 40) * 0x1p-24f; }

}  // namespace

std::vector<double> EmbreeRays::tracePaths(Trace trace, const std::vector<double>& power,
                                           const std::vector<double>& absorptivity, uint64_t paths,
                                           uint64_t seed) const {
  const auto polygon_count = static_cast<uint32_t>(emitters_.size());
  std::vector<double> up_to;  // sums of the sizes of `power`
  double total = 0;
  for (const double of_polygon : power) up_to.push_back(total += std::abs(of_polygon));
  std::atomic<uint64_t> next = 0;
  std::vector<std::vector<int64_t>> arrivals(threadCount(), std::vector<int64_t>(polygon_count));
  const uint64_t parts = (paths + kPathsAtOnce - 1) / kPathsAtOnce;
  runOnAllCores([&](uint32_t thread) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    std::array<Ray, kRayGroup> rays;
    std::array<uint32_t, kRayGroup> from, hit;
    std::array<bool, kRayGroup> is_negative;
    for (uint64_t part; (part = next++) < parts;) {
      Random random(seed, part);
      uint64_t path = part * kPathsAtOnce;
      const uint64_t end = std::min(path + kPathsAtOnce, paths);
      // Sends a ray by the cosine law from a point uniform on a polygon.
      const auto send = [&](uint32_t k, uint32_t polygon) {
        const Emitter& emitter = emitters_[polygon];
        const uint64_t point = random.word();
        const float squared = toUnit(random.word()), radius = std::sqrt(squared),
                    angle_rad = float(2 * std::numbers::pi) * toUnit(random.word());
        from[k] = polygon;
        rays[k] = {pointOn(emitter, uint32_t(point), uint32_t(point >> 32)),
                   radius * (std::cos(angle_rad) * emitter.x + std::sin(angle_rad) * emitter.y) +
                       std::sqrt(1 - squared) * emitter.normal,
                   emitter.away, 4};
      };
      // Begins the next path, at even steps of the emitted power.
      const auto begin = [&](uint32_t k) {
        if (path == end) return false;
        const double at = (double(path++) + toUnit(random.word())) / double(paths) * total;
        const auto place = std::min(std::upper_bound(up_to.begin(), up_to.end(), at), up_to.end() - 1);
        const auto polygon = static_cast<uint32_t>(place - up_to.begin());
        is_negative[k] = power[polygon] < 0;
        send(k, polygon);
        return true;
      };
      uint32_t count = 0;
      while (count < kRayGroup && begin(count)) ++count;
      while (count > 0) {
        embree_.findFirst(trace, context, std::span(rays).first(count), hit);
        for (uint32_t k = 0; k < count;) {
          const uint32_t to = hit[k];
          const bool arrives = to != UINT32_MAX && to != from[k] && glm::dot(embree_.normal(to), rays[k].direction) < 0;
          if (arrives) arrivals[thread][to] += is_negative[k] ? -1 : 1;
          if (arrives && toUnit(random.word()) >= absorptivity[to]) {
            send(k++, to);
          } else if (begin(k)) {
            ++k;
          } else {
            --count;
            rays[k] = rays[count], from[k] = from[count], hit[k] = hit[count], is_negative[k] = is_negative[count];
          }
        }
      }
    }
  });
  std::vector<double> arriving(polygon_count);
  for (const auto& of_thread : arrivals)
    for (uint32_t i = 0; i < polygon_count; ++i) arriving[i] += double(of_thread[i]) * total / double(paths);
  return arriving;
}

}  // namespace viewpeel::bench
