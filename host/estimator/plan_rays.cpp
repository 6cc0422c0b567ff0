#include "estimator/plan_rays.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "directions/replicates.h"
#include "directions/sampler.h"
#include "estimator/plan_lines.h"
#include "sums/replicate_sums.h"

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

// Returns by row the sum of its faces' areas, and the sum of their squares.
std::pair<std::vector<double>, std::vector<double>> sumAreas(const Ids& face_ids,
                                                             const std::vector<uint32_t>& row_of_face) {
  const size_t row_count = *std::ranges::max_element(row_of_face) + size_t{1};
  std::vector<double> areas(row_count), squares(row_count);
  for (size_t face = 0; face < row_of_face.size(); ++face) {
    areas[row_of_face[face]] += face_ids.areas[face];
    squares[row_of_face[face]] += face_ids.areas[face] * face_ids.areas[face];
  }
  return {std::move(areas), std::move(squares)};
}

// Returns the largest form factor of each row to a row of at least its area, or to itself. Smaller rows do not count,
// because the error of a form factor counts from the smaller of its two surfaces.
//   In: counts: by face; areas: by row; count_area: exchange area of a count
std::vector<double> largestShares(const PairCounts& counts, const std::vector<uint32_t>& row_of_face,
                                  const std::vector<double>& areas, double count_area) {
  std::vector<double> largest(areas.size());
  for (const PairCount& pair : mergeIds(counts, row_of_face)) {
    if (pair.j >= kEnvironment) continue;
    const double ways = pair.i == pair.j ? 2 : 1;
    const uint32_t row = areas[pair.i] <= areas[pair.j] ? pair.i : pair.j;
    largest[row] = std::max(largest[row], ways * double(pair.count) * count_area / areas[row]);
  }
  return largest;
}

}  // namespace

bool mayHaveRaysAlone(const EstimateOptions& options) {
  return options.by == By::surface && options.tolerance && !options.relative;
}

double guessRaysAlone(const Ids& face_ids, const EstimateOptions& options) {
  const auto [areas, squares] = sumAreas(face_ids, face_ids.surface);
  std::vector<double> polygons(areas.size());
  for (const uint32_t face : face_ids.of_polygon) ++polygons[face_ids.surface[face]];
  const double of_one = 0.25 * std::pow(kRayMargin * kErrorsInGoal / *options.tolerance, 2);
  double all = 0;
  for (size_t row = 0; row < areas.size(); ++row)
    all += polygons[row] * std::max(double(RayEngine::kLeastRays) * options.replicates,
                                    of_one * squares[row] / (areas[row] * areas[row]));
  return all;
}

double RayPlanner::Row::variance() const {
  return std::max(0.0, squares - sum * sum / kRayPilotReplicates) / (kRayPilotReplicates - 1);
}

// Returns the variance of this share by independent rays.    In: rays: of a replicate
double RayPlanner::Row::binomial(double rays) const {
  const double all = rays * kRayPilotReplicates, share = (sum * rays + 0.5) / (all + 1);
  return share * (1 - share) / rays;
}

RayPlanner::RayPlanner(RayEngine& engine, const Scene& scene, const Ids& face_ids, std::vector<uint32_t> row_of_face,
                       uint64_t seed, bool counts_pairs)
    : row_of_face_(std::move(row_of_face)) {
  std::tie(areas_, square_areas_) = sumAreas(face_ids, row_of_face_);
  const size_t row_count = areas_.size();
  environment_.resize(row_count), leak_.resize(row_count);
  const double count_area = 2 * engine.unitArea() * scene.scale * scene.scale / kPilotRays;
  const std::vector<Direction> directions =
      sampleReplicates(Sampler::iid, kPilotRays, seed, kRayReplicates.first, kRayPilotReplicates);
  if (counts_pairs)
    largest_ = largestShares(engine.count(std::span(directions).first(kPilotRays)), row_of_face_, areas_, count_area);
  const std::vector<uint32_t> all_blocks(row_of_face_.size(), kRayPilotReplicates);
  for (const PairCounts& counts : engine.countOutside(directions, kPilotRays, all_blocks)) {
    std::vector<double> left(row_count), leaked(row_count);
    for (const PairCount& count : counts) {
      const uint32_t row = row_of_face_[count.i];
      (count.j == kLeak ? leaked : left)[row] += double(count.count) * count_area / areas_[row];
    }
    for (size_t row = 0; row < row_count; ++row) {
      environment_[row].sum += left[row], environment_[row].squares += left[row] * left[row];
      leak_[row].sum += leaked[row], leak_[row].squares += leaked[row] * leaked[row];
    }
  }
  double variance = 0, binomial = 0;
  for (const std::vector<Row>* rows : {&environment_, &leak_})
    for (size_t row = 0; row < row_count; ++row)
      variance += (*rows)[row].variance(), binomial += (*rows)[row].binomial(raysOf(row));
  efficiency_ = variance / binomial;
}

// Returns the number of rays, all of equal weight, that would give a row's share with the pilot's variance. Rays of a
// row's larger faces weigh more, for every face has the same number of rays.
double RayPlanner::raysOf(size_t row) const { return kPilotRays * areas_[row] * areas_[row] / square_areas_[row]; }

PlannedRays RayPlanner::plan(const EstimateOptions& options) const {
  const size_t row_count = areas_.size();
  const bool may_be_alone = !largest_.empty();
  const double degrees = kRayPilotReplicates - 1, margin = kRayMargin / std::sqrt(double(options.replicates)),
               errors_in_goal = margin * errorsInRowGoal(row_count);
  const auto needOf = [&](const Row& of, size_t row) {
    const double expected = efficiency_ * of.binomial(raysOf(row)),
                 likely = (degrees * of.variance() + kBinomialDegrees * expected) / (degrees + kBinomialDegrees);
    const double error = errors_in_goal * std::sqrt(std::max(likely, expected));
    return kPilotRays * std::pow(error / options.allowedError(of.sum / kRayPilotReplicates), 1 / kRayRate);
  };
  // Errors of form factors between surfaces are taken to be those of independent rays.
  const auto needOfPairs = [&](size_t row) {
    const double share = std::min(0.5, (largest_[row] * raysOf(row) + 0.5) / (raysOf(row) + 1)),
                 error = margin * kErrorsInGoal * std::sqrt(share * (1 - share) / raysOf(row));
    return kPilotRays * std::pow(error / *options.tolerance, 2);
  };
  const auto raysOfFaces = [&](const std::vector<double>& needs, double least_share) {
    const double least = least_share * *std::ranges::max_element(needs);
    std::vector<uint32_t> rays;
    for (const uint32_t row : row_of_face_) rays.push_back(RayEngine::usualRays(std::max(least, needs[row])));
    return rays;
  };
  std::vector<double> outside(row_count), alone(row_count);
  for (size_t row = 0; row < row_count; ++row) {
    outside[row] = std::min(double(kMostRaysOfRow), std::max(needOf(environment_[row], row), needOf(leak_[row], row)));
    if (may_be_alone) alone[row] = std::min(double(kMostRaysOfRow), std::max(outside[row], needOfPairs(row)));
  }
  return {raysOfFaces(outside, kLeastShareOfRays), may_be_alone ? raysOfFaces(alone, 0) : std::vector<uint32_t>()};
}

}  // namespace viewpeel
