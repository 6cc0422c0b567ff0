#include "bench/rivals/ray_ladders.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "bench/rivals/embree_rays.h"
#include "bench/support/measure.h"

namespace viewpeel::bench {
namespace {

constexpr std::pair<Points, const char*> kPoints[] = {{Points::random, "random"}, {Points::sobol, "sobol"}};

// Returns the way of tracing that is fastest on a small share of the work.
template <class Run>
std::pair<Trace, std::string> fastestTrace(Run run) {
  std::pair<Trace, std::string> best;
  double least_s = INFINITY;
  for (const auto& [trace, name] : {std::pair(Trace::packets_of_8, "packets"), std::pair(Trace::streams, "streams"),
                                    std::pair(Trace::single, "single")}) {
    run(trace);
    double trace_s = INFINITY;
    for (int k = 0; k < 3; ++k) trace_s = std::min(trace_s, secondsOf([&, tried = trace] { run(tried); }));
    if (trace_s < least_s) least_s = trace_s, best = {trace, std::string("trace=") + name};
  }
  return best;
}

}  // namespace

void addRayLadders(const Scene& scene, std::vector<Ladder>& ladders) {
  const double pairs = 0.5 * double(scene.polygons.size()) * (double(scene.polygons.size()) - 1);
  for (const auto& [points, name] : kPoints) {
    const bool stated = points == Points::random;
    ladders.push_back({fmt::format("rays_{}", name), "", "rays_per_polygon", false, climbBy(64, 4, 1u << 30),
                       [&scene, points = points, stated] {
                         Runner runner;
                         std::shared_ptr<EmbreeRays> embree;
                         runner.setup_seconds = secondsOf([&] { embree = std::make_shared<EmbreeRays>(scene); });
                         const uint64_t few = std::clamp<uint64_t>(200'000 / scene.polygons.size(), 64, 1u << 16);
                         const auto [trace, chosen] =
                             fastestTrace([&](Trace form) { embree->shoot(form, points, few, 1); });
                         runner.chosen = chosen;
                         runner.run = [embree, &scene, points, stated, trace = trace](double amount, uint64_t seed) {
                           RayCounts counts;
                           const RunTime time = timeOf(
                               [&] { counts = embree->shoot(trace, points, static_cast<uint64_t>(amount), seed); });
                           RayEstimate estimate = estimateFromRays(counts, scene);
                           return Outcome{std::move(estimate.exchange),
                                          stated ? std::optional(estimate.rms_standard_error) : std::nullopt,
                                          time,
                                          {}};
                         };
                         return runner;
                       }});
    ladders.push_back(
        {fmt::format("double_area_{}", name), "", "samples_per_pair", false, climbBy(pairs < 1e6 ? 4 : 1, 4, 1u << 28),
         [&scene, pairs, points = points, stated] {
           Runner runner;
           std::shared_ptr<EmbreeRays> embree;
           runner.setup_seconds = secondsOf([&] { embree = std::make_shared<EmbreeRays>(scene); });
           const auto few = static_cast<uint32_t>(std::clamp(1e5 / pairs, 1.0, 1e5));
           const auto [trace, chosen] = fastestTrace([&](Trace form) { embree->integrate(form, points, few, 1); });
           runner.chosen = chosen;
           runner.run = [embree, points, stated, trace = trace](double amount, uint64_t seed) {
             RayEstimate estimate;
             const RunTime time =
                 timeOf([&] { estimate = embree->integrate(trace, points, static_cast<uint32_t>(amount), seed); });
             return Outcome{std::move(estimate.exchange),
                            stated && amount > 1 ? std::optional(estimate.rms_standard_error) : std::nullopt,
                            time,
                            {}};
           };
           return runner;
         }});
  }
}

std::vector<RayRival> makeRayRivals(const Scene& scene) {
  const auto embree = std::make_shared<EmbreeRays>(scene);
  std::vector<RayRival> rivals;
  for (const Trace trace : {Trace::packets_of_8, Trace::streams}) {
    const char* form = trace == Trace::streams ? "streams" : "packets";
    for (const auto& [points, word] : kPoints) {
      rivals.push_back(
          {fmt::format("rays_{} in {}", word, form), 4096, [=, &scene, points = points](double rays, uint64_t seed) {
             return estimateFromRays(embree->shoot(trace, points, static_cast<uint64_t>(rays), seed), scene).exchange;
           }});
      rivals.push_back(
          {fmt::format("double_area_{} in {}", word, form), 1024, [=, points = points](double samples, uint64_t seed) {
             return embree->integrate(trace, points, static_cast<uint32_t>(samples), seed).exchange;
           }});
    }
  }
  return rivals;
}

std::string describeRays() { return "Embree " + embreeVersion(); }

}  // namespace viewpeel::bench
