#include "estimator/plan_rays.h"

#include <algorithm>
#include <cmath>

#include "directions/replicates.h"
#include "directions/sampler.h"
#include "estimator/plan_lines.h"
#include "sums/pair_count.h"

namespace viewpeel {
namespace {

// The standard error of an environment falls as N^-kRayRate with N rays: in a city of 2,892 triangles with 32 to 1,024
// rays in a replicate, as in one of 6,604 with 128 and 1,024.
constexpr double kRayRate = 0.7;
// The pilot gives each row a variance with 7 degrees of freedom. The expected variance counts as much: the row's
// binomial variance, times the ratio of all rows' variances to their binomial variances. Rows of the same environment
// differ from it by 0.35 to 0.8 of its value (a city of 2,892 triangles). No row is taken to vary less, for no standard
// error is stated to be smaller (MixtureEntries).
constexpr double kBinomialDegrees = 7;
constexpr uint32_t kMostRays = 1 << 20;
// No polygon has fewer rays than this share of the most: they count the pairs between polygons, too.
constexpr double kLeastShare = 1.0 / 8;

// A Row sums up what the pilot's rays have found about one row: its environment, or its leak.
struct Row {
  double sum = 0, squares = 0;  // of its shares in each replicate

  double variance() const { return std::max(0.0, squares - sum * sum / kPilotReplicates) / (kPilotReplicates - 1); }
  // Returns the variance of this share by independent rays.    In: rays: of a replicate
  double binomial(double rays) const {
    const double all = rays * kPilotReplicates, share = (sum * rays + 0.5) / (all + 1);
    return share * (1 - share) / rays;
  }
};

}  // namespace

std::vector<uint32_t> planRays(RayEngine& engine, const Scene& scene, const Ids& face_ids,
                               const std::vector<uint32_t>& row_of_face, const EstimateOptions& options) {
  const size_t row_count = *std::ranges::max_element(row_of_face) + size_t{1};
  std::vector<double> areas(row_count), squares(row_count);
  for (size_t face = 0; face < row_of_face.size(); ++face) {
    areas[row_of_face[face]] += face_ids.areas[face];
    squares[row_of_face[face]] += face_ids.areas[face] * face_ids.areas[face];
  }
  const double count_area = 2 * engine.unitArea() * scene.scale * scene.scale / kPilotRays;
  std::vector<Row> environment(row_count), leak(row_count);
  const std::vector<bool> all_faces(row_of_face.size(), true);
  for (uint32_t replicate = 0; replicate < kPilotReplicates; ++replicate) {
    std::vector<double> left(row_count), leaked(row_count);
    for (const PairCount& count : engine.countOutside(
             sampleDirections(Sampler::iid, kPilotRays, options.seed, kRayReplicates.first + replicate), all_faces)) {
      const uint32_t row = row_of_face[count.i];
      (count.j == kLeak ? leaked : left)[row] += double(count.count) * count_area / areas[row];
    }
    for (size_t row = 0; row < row_count; ++row) {
      environment[row].sum += left[row], environment[row].squares += left[row] * left[row];
      leak[row].sum += leaked[row], leak[row].squares += leaked[row] * leaked[row];
    }
  }
  // A row of many faces has rays of all of them, whose shares in it are their areas.
  const auto raysOf = [&](size_t row) { return kPilotRays * areas[row] * areas[row] / squares[row]; };
  double variance = 0, binomial = 0;
  for (const std::vector<Row>* rows : {&environment, &leak})
    for (size_t row = 0; row < row_count; ++row)
      variance += (*rows)[row].variance(), binomial += (*rows)[row].binomial(raysOf(row));
  const double efficiency = variance / binomial, degrees = kPilotReplicates - 1,
               errors_in_goal = kRayMargin * errorsInRowGoal(row_count) / std::sqrt(double(options.replicates));
  const auto needOf = [&](const Row& of, size_t row) {
    const double expected = efficiency * of.binomial(raysOf(row)),
                 likely = (degrees * of.variance() + kBinomialDegrees * expected) / (degrees + kBinomialDegrees);
    const double error = errors_in_goal * std::sqrt(std::max(likely, expected));
    return kPilotRays * std::pow(error / options.allowedError(of.sum / kPilotReplicates), 1 / kRayRate);
  };
  std::vector<double> needs(row_count);
  for (size_t row = 0; row < row_count; ++row)
    needs[row] = std::min(double(kMostRays), std::max(needOf(environment[row], row), needOf(leak[row], row)));
  const double least = kLeastShare * *std::ranges::max_element(needs);
  std::vector<uint32_t> rays;
  for (const uint32_t row : row_of_face) rays.push_back(RayEngine::usualRays(std::max(least, needs[row])));
  return rays;
}

}  // namespace viewpeel
