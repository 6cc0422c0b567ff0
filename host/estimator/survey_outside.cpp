#include "estimator/survey_outside.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "directions/replicates.h"
#include "directions/sampler.h"

namespace viewpeel {
namespace {

// Rows have the shares of their rays that leave the scene, and that end on backs.
struct RowShares {
  std::vector<double> environment, leak;
};

// Casts rays from the rows where `casts` is 1. It is 0 elsewhere.
RowShares castFrom(RayEngine& engine, const Scene& scene, const Ids& ids, const std::vector<uint32_t>& casts,
                   uint32_t rays, uint64_t seed, uint64_t replicate) {
  const double count_area = 2 * engine.unitArea() * scene.scale * scene.scale / rays;
  RowShares shares{std::vector<double>(ids.count()), std::vector<double>(ids.count())};
  for (const PairCounts& counts :
       engine.countOutside(sampleDirections(Sampler::iid, rays, seed, replicate), rays, casts))
    for (const PairCount& count : counts)
      (count.j == kLeak ? shares.leak : shares.environment)[count.i] +=
          double(count.count) * count_area / ids.areas[count.i];
  return shares;
}

std::vector<bool> isAbove0(const std::vector<double>& shares) {
  std::vector<bool> is_above(shares.size());
  for (size_t k = 0; k < shares.size(); ++k) is_above[k] = shares[k] > 0;
  return is_above;
}

// Returns 1 for the rows of largest shares above 0, else 0.    In: count: most rows
std::vector<uint32_t> rowsOfLargest(const std::vector<double>& shares, size_t count) {
  std::vector<uint32_t> rows;
  for (uint32_t k = 0; k < shares.size(); ++k)
    if (shares[k] > 0) rows.push_back(k);
  if (rows.size() > count) {
    std::ranges::nth_element(rows, rows.begin() + static_cast<std::ptrdiff_t>(count), [&](uint32_t a, uint32_t b) {
      return shares[a] != shares[b] ? shares[a] > shares[b] : a < b;
    });
    rows.resize(count);
  }
  std::vector<uint32_t> is_of_largest(shares.size());
  for (const uint32_t row : rows) is_of_largest[row] = 1;
  return is_of_largest;
}

constexpr double kSureRays = 3, kRounding = 0.5;  // counts are rounded to a small part of a ray

// Returns the largest share of which the row has three rays or more.
double largestSure(const std::vector<double>& shares, uint32_t rays) {
  const double largest = std::ranges::max(shares);
  return largest * rays > kSureRays - kRounding ? largest : 0;
}

// Returns whether more rays left the scene or ended on backs than may have grazed edges: three, and four times as many
// as the most that did so in any scene measured (survey_outside.h).
//   In: rays: of each row that casts
bool hasOutside(const RowShares& shares, const std::vector<uint32_t>& casts, uint32_t rays) {
  constexpr double kMostGrazed = 4 / 80'000.0;
  const double all = rays * std::accumulate(casts.begin(), casts.end(), 0.0);
  double outside = 0;
  for (const std::vector<double>* of : {&shares.environment, &shares.leak})
    outside += rays * std::accumulate(of->begin(), of->end(), 0.0);
  return outside > kSureRays - kRounding + kMostGrazed * all;
}

}  // namespace

OutsideShares surveyOutside(RayEngine& engine, const Scene& scene, const Ids& ids, uint32_t rays, uint32_t further_rays,
                            uint64_t seed) {
  constexpr size_t kMostFurtherRows = 512, kMostRaysOfAll = 1 << 22;
  const std::vector<uint32_t> casts = blocksOfRequested(ids, 1);
  const RowShares first = castFrom(engine, scene, ids, casts, rays, seed, kRayReplicates.end - 2);
  OutsideShares shares{.largest_environment = largestSure(first.environment, rays),
                       .has_outside = hasOutside(first, casts, rays),
                       .has_leak = isAbove0(first.leak)};
  if (std::ranges::count(shares.has_leak, true) == 0) return shares;
  const size_t most_rows = std::clamp<size_t>(kMostRaysOfAll / further_rays, 1, kMostFurtherRows);
  const RowShares further =
      castFrom(engine, scene, ids, rowsOfLargest(first.leak, most_rows), further_rays, seed, kRayReplicates.end - 1);
  shares.largest_leak = largestSure(further.leak, further_rays);
  return shares;
}

std::vector<bool> findLeakingRows(RayEngine& engine, const Scene& scene, const Ids& ids, uint32_t rays, uint64_t seed) {
  return isAbove0(castFrom(engine, scene, ids, blocksOfRequested(ids, 1), rays, seed, kRayReplicates.end - 3).leak);
}

}  // namespace viewpeel
