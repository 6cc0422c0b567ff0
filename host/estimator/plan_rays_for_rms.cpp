#include "estimator/plan_rays_for_rms.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "directions/replicates.h"
#include "directions/sampler.h"
#include "estimator/plan_rays.h"
#include "sums/pair_walk.h"

namespace viewpeel {
namespace {

// Environments vary so much less than by independent rays: some 1.0 n^-0.4 for n rays in a replicate (plan_rays.cpp),
// here 100 to 200.
constexpr double kEnvironmentEfficiency = 0.15;
// The squares of pairs add up to so much less than by independent rays, for n rays of a polygon in a replicate:
// kOfOneRay n^-kEvenness. In two closed rooms, an office and three cities, with 17 to 1,400 rays, they were 0.7 to 1.2
// times that.
constexpr double kOfOneRay = 1.45, kEvenness = 0.2;
constexpr int kStepsToEqualGains = 8;
// Usual numbers of rays are 4/3 or 3/2 of each other. Below 1 / kRoundedUp of a number the next smaller one is taken.
constexpr double kRoundedUp = 0.85, kScaleStep = 1.05;
constexpr int kScaleSteps = 228;  // from RayEngine::kLeastRays to kMostRaysOfRow

}  // namespace

RmsRayPlanner::RmsRayPlanner(RayEngine& engine, const Scene& scene, const Ids& face_ids, uint64_t seed)
    : face_ids_(face_ids), polygon_areas_(face_ids.areas), environments_(face_ids.count()) {
  std::vector<double> polygons(face_ids.count());
  for (const uint32_t face : face_ids.of_polygon) ++polygons[face];
  for (size_t face = 0; face < polygons.size(); ++face) polygon_areas_[face] /= polygons[face];
  engine.setRays({});
  const double count_area = 2 * engine.unitArea() * scene.scale * scene.scale / kPilotRays;
  for (const PairCount& count : engine.count(sampleDirections(Sampler::iid, kPilotRays, seed, kRayReplicates.first))) {
    const double exchange = double(count.count) * count_area, area = face_ids.areas[count.i];
    if (count.j < kEnvironment && count.i != count.j)
      squares_.push_back({count.i, count.j, (std::pow(area, -2) + std::pow(face_ids.areas[count.j], -2)) * exchange});
    if (count.j == kEnvironment)
      environments_[count.i] =
          kEnvironmentEfficiency * std::max(0.0, exchange / area * (1 - exchange / area)) / polygons[count.i];
  }
}

double RmsRayPlanner::environments() const {
  double all = 0;
  for (const double of_face : environments_) all += of_face;
  return all;
}

// Returns the sum of squares.    In: rays: by face, of each polygon
double RmsRayPlanner::sum(const std::vector<Square>& pairs, const std::vector<double>& rays) const {
  double all = 0;
  for (const Square& pair : pairs) all += pair.size / densityOf(pair, rays);
  for (size_t face = 0; face < rays.size(); ++face) all += environments_[face] / rays[face];
  return all;
}

// Returns by how much the sum falls for one ray more of each polygon of a face.
std::vector<double> RmsRayPlanner::gains(const std::vector<Square>& pairs, const std::vector<double>& rays) const {
  std::vector<double> all(rays.size());
  for (size_t face = 0; face < rays.size(); ++face) all[face] = environments_[face] / (rays[face] * rays[face]);
  for (const Square& pair : pairs) {
    const double of_density = pair.size / std::pow(densityOf(pair, rays), 2);
    for (const uint32_t id : {pair.i, pair.j}) all[id] += of_density / polygon_areas_[id];
  }
  return all;
}

std::vector<uint32_t> RmsRayPlanner::plan(const std::vector<LinePair>& with_lines,
                                          const EstimateOptions& options) const {
  std::vector<Square> pairs;
  PairWalk walk(with_lines);
  for (const Square& pair : squares_)
    if (!walk.find(pair)) pairs.push_back(pair);
  const size_t face_count = face_ids_.count();
  std::vector<double> rays(face_count, 1);
  for (int step = 0; step < kStepsToEqualGains; ++step) {
    const std::vector<double> gained = gains(pairs, rays);
    for (size_t face = 0; face < face_count; ++face) rays[face] *= std::sqrt(gained[face]);
    const double most = *std::ranges::max_element(rays);
    for (double& of_face : rays) of_face = most > 0 ? std::max(of_face / most, kLeastShareOfRays) : 1;
  }
  // Numbers of rays are rounded to usual ones, so the least scale is looked for among steps.
  const double of_rays = with_lines.empty() ? 1 : 1 - kLinesOfSquares,
               allowed = of_rays * std::pow(*options.rms * double(face_count), 2) * options.replicates;
  const auto scaled = [&](int step) {
    const double scale = RayEngine::kLeastRays * std::pow(kScaleStep, step);
    std::vector<uint32_t> usual(face_count);
    for (size_t face = 0; face < face_count; ++face)
      usual[face] = RayEngine::usualRays(kRoundedUp * std::min(double(kMostRaysOfRow), scale * rays[face]));
    return usual;
  };
  const auto isTooFew = [&](int step) {
    const std::vector<uint32_t> usual = scaled(step);
    const double mean = std::accumulate(usual.begin(), usual.end(), 0.0) / double(face_count),
                 efficiency = std::min(1.0, kOfOneRay * std::pow(mean, -kEvenness));
    return efficiency * sum(pairs, {usual.begin(), usual.end()}) > allowed;
  };
  int least = 0, most = kScaleSteps;
  while (least < most) {
    const int middle = (least + most) / 2;
    if (isTooFew(middle)) least = middle + 1;
    else most = middle;
  }
  return scaled(least);
}

}  // namespace viewpeel
