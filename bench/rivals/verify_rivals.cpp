#include "bench/rivals/verify_rivals.h"

#include <cmath>
#include <functional>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "bench/rivals/hemicube.h"
#include "bench/rivals/ray_ladders.h"
#include "reference/closed_forms/contour_integral.h"
#include "reference/closed_forms/past_blocker.h"

namespace viewpeel::bench {
namespace {

constexpr uint32_t kSeeds = 16;
// A Student's t of 15 degrees of freedom is beyond 6 in 1 of 40,000 cases. So one of the 18 comparisons fails by chance
// in one of 2,000 sets of seeds, and the seeds are fixed.
constexpr double kMostStandardErrors = 6;
// Four times the number of independent samples halve the error, and sixteen times the number leave 1/4. The ratio of
// two rms errors from 16 seeds each has a relative spread of 1 / sqrt(16), so 1/4 (1 +- 0.25). The bound of 1/2 is four
// spreads away. Rivals that converge faster leave less.
constexpr double kMostLeft = 0.5;
constexpr double kMoreWork = 16;

struct Spread {
  double mean_error = 0, standard_error = 0, rms = 0;
};

using Rival = std::function<ExchangeMatrix(double work, uint64_t seed)>;

Spread spreadOf(const Rival& rival, double work, double area, double truth) {
  double sum = 0, squares = 0;
  for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const double error = rival(work, seed).at(0, 1) / area - truth;
    sum += error;
    squares += error * error;
  }
  const double mean = sum / kSeeds;
  return {mean, std::sqrt((squares / kSeeds - mean * mean) / (kSeeds - 1)), std::sqrt(squares / kSeeds)};
}

//   In: bias: bound on the mean error of the method at the larger work
void verify(const std::string& scene, const std::string& name, const Rival& rival, double work, double area,
            double truth, double bias) {
  const Spread few = spreadOf(rival, work, area, truth), more = spreadOf(rival, work * kMoreWork, area, truth);
  fmt::print(
      "# verify {} {}: form factor {:.6f}, mean error {:+.1e} +- {:.1e}, rms error of {} samples {:.1e}, of {} "
      "{:.1e}\n",
      scene, name, truth, more.mean_error, more.standard_error, work, few.rms, work * kMoreWork, more.rms);
  if (!(std::abs(more.mean_error) <= kMostStandardErrors * more.standard_error + bias) ||
      !(more.rms <= kMostLeft * few.rms))
    throw Error(ErrorCode::check,
                fmt::format("{} does not converge to the closed form {} of {}; its rows would mean nothing", name,
                            truth, scene));
}

std::vector<glm::dvec3> cornersOf(const Scene& scene, uint32_t polygon_index) {
  const Polygon& polygon = scene.polygons[polygon_index];
  return {scene.corners.begin() + polygon.first_corner,
          scene.corners.begin() + polygon.first_corner + polygon.corner_count};
}

// Returns a bound on the mean error of a hemicube. It decides coverage at the middle of a pixel and counts the whole
// weight. Where an edge crosses a pixel at random, the mean error of the weight is at most its change across the pixel.
// This is |grad w| p^2 / 12 per length of edge, with p = 2 / resolution and |grad w| <= 0.33. The outline of a convex
// polygon on the faces of a hemicube of half width 1 is at most 16 long. There are two outlines, of plate and blocker.
double hemicubeBias(uint32_t resolution) { return 2 * 16 * 0.33 * 4 / (12.0 * resolution * resolution); }

void verifyOn(const Device& device, const std::string& name, const Scene& scene, double truth) {
  const double area = scene.polygons[0].area;
  for (const RayRival& rays : makeRayRivals(scene)) verify(name, rays.name, rays.run, rays.work, area, truth, 0);
  constexpr uint32_t kResolution = 128;
  Hemicube hemicube(device, scene, kResolution);
  verify(
      name, "hemicube", [&](double eyes, uint64_t seed) { return hemicube.compute(static_cast<uint32_t>(eyes), seed); },
      4, area, truth, hemicubeBias(kResolution));
}

}  // namespace

void verifyRivals(const Device& device) {
  InputScene input = twoPlates(1);
  const Scene plates = buildScene(input);
  verifyOn(device, "plates", plates, reference::formFactor(cornersOf(plates, 0), cornersOf(plates, 1)));
  input.surface_names.push_back("blocker");
  input.faces.push_back({{{0.2, 0.3, 0.4}, {0.8, 0.3, 0.4}, {0.8, 0.9, 0.6}, {0.2, 0.9, 0.6}}, 2, 0});
  const Scene blocked = buildScene(input);
  verifyOn(device, "plates past a blocker", blocked,
           reference::formFactorPastBlocker(cornersOf(blocked, 0), cornersOf(blocked, 1), cornersOf(blocked, 2)).value);
}

}  // namespace viewpeel::bench
