#include "estimator/environment_rays.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <boost/random/sobol.hpp>
#include <glm/glm.hpp>

#include "directions/random.h"
#include "directions/replicates.h"
#include "directions/sampler.h"
#include "threads.h"

namespace viewpeel {
namespace {

// The numbers of these replicates follow those of the common directions of measureEnvironment().
constexpr uint64_t kFirstReplicate = kEnvironmentReplicates.first + (uint64_t(1) << 20), kReplicatesOfRow = 16;
// About so many quick rays are cast in one call, which takes some seconds. Where time is up, those of the last one are
// lost.
constexpr double kMostRaysAtOnce = 1 << 24;

}  // namespace

bool hasQuickRays(const Scene& scene, double tolerance) {
  return tolerance >= kLeastQuickTolerance && suitsRays(scene);
}

EnvironmentRays::EnvironmentRays(const Scene& scene, const Ids& ids, const glm::dvec3& up, uint64_t seed,
                                 double tolerance, size_t threads, std::function<void()> stop)
    : scene_(scene),
      ids_(ids),
      up_(up),
      seed_(seed),
      threads_(threads),
      stop_(std::move(stop)),
      polygons_(ids.count()) {
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) polygons_[ids.of_polygon[k]].push_back(k);
  if (hasQuickRays(scene, tolerance)) {
    face_ids_ = makeIds(scene, By::polygon, ids.two_sided);
    row_of_face_.resize(face_ids_.count());
    for (uint32_t k = 0; k < scene.polygons.size(); ++k) row_of_face_[face_ids_.of_polygon[k]] = ids.of_polygon[k];
    LatticeOptions options;
    options.thread_count = static_cast<uint32_t>(threads);
    options.stop = stop_;
    engine_ = makeRayEngine(scene, face_ids_, options);
    engine_->setHorizon(up);
    return;
  }
  sight_.emplace(scene);
  for (const std::vector<uint32_t>& of_row : polygons_) area_sums_.push_back(sumAreas(scene, of_row));
}

void EnvironmentRays::cast(std::vector<RowRays>& rows, uint32_t replicates) {
  if (rows.empty()) return;
  if (engine_) {
    for (size_t first = 0; first < rows.size();) {
      size_t end = first;
      for (double all = 0; end < rows.size() && all < kMostRaysAtOnce; ++end)
        all += double(replicates) *
               std::max(rows[end].rays, RayEngine::kLeastRays * uint32_t(polygons_[rows[end].row].size()));
      castQuickly(std::span(rows).subspan(first, end - first), replicates);
      first = end;
    }
    return;
  }
  preparePoints(std::ranges::max(rows, {}, &RowRays::rays).rays);
  shareOut(
      threads_, rows.size(), 1,
      [&](size_t, size_t k) {
        std::vector<RowRays::Shares> shares;
        for (uint32_t r = 0; r < replicates; ++r) shares.push_back(castFrom(rows[k].row, rows[k].rays, r));
        rows[k].rays_cast = rows[k].rays;
        rows[k].replicates = std::move(shares);
      },
      [&](size_t) { stop_(); });
}

void EnvironmentRays::castQuickly(std::span<RowRays> rows, uint32_t replicates) {
  std::vector<uint32_t> of_faces(face_ids_.count(), RayEngine::kLeastRays), blocks(face_ids_.count());
  std::vector<uint32_t> place(ids_.count());  // by row: where it stands among the rows
  for (uint32_t k = 0; k < rows.size(); ++k) {
    const RowRays& of = rows[k];
    place[of.row] = k;
    for (const uint32_t polygon : polygons_[of.row]) {
      const uint32_t face = face_ids_.of_polygon[polygon];
      of_faces[face] = RayEngine::usualRays(of.rays * face_ids_.areas[face] / ids_.areas[of.row]);
      blocks[face] = replicates;
    }
  }
  const uint32_t most = std::ranges::max(of_faces);
  engine_->setRays(of_faces);
  const std::vector<PairCounts> counts =
      engine_->countOutside(sampleReplicates(Sampler::iid, most, seed_, kFirstReplicate, replicates), most, blocks);
  const double exchange_of_count = 2 * engine_->unitArea() * scene_.scale * scene_.scale / most;
  for (RowRays& of : rows) {
    of.replicates.resize(replicates);
    double squares = 0;  // of the areas that rays stand for, summed
    for (const uint32_t polygon : polygons_[of.row]) {
      const double area = scene_.polygons[polygon].area, rays = of_faces[face_ids_.of_polygon[polygon]];
      squares += area * area / rays;
      of.rays_cast += rays;
    }
    const double area = ids_.areas[of.row] / (ids_.sides() * scene_.scale * scene_.scale);
    of.rays = static_cast<uint32_t>(std::max(1.0, std::min(area * area / squares, of.rays_cast)));
  }
  for (uint32_t r = 0; r < replicates; ++r)
    for (const PairCount& count : counts[r]) {
      const uint32_t row = row_of_face_[count.i];
      RowRays::Shares& shares = rows[place[row]].replicates[r];
      (count.j == kEnvironment ? shares.up : shares.down) += double(count.count) * exchange_of_count / ids_.areas[row];
    }
}

void EnvironmentRays::preparePoints(uint32_t rays) {
  if (rays <= points_.size()) return;
  boost::random::sobol sequence(kDimensions);
  points_.resize(rays);
  for (auto& point : points_)
    for (double& x : point) x = double(sequence()) / (double(boost::random::sobol::max()) + 1);
}

// Returns the shares of one replicate of a row, in double precision.
EnvironmentRays::RowRays::Shares EnvironmentRays::castFrom(uint32_t row, uint32_t rays, uint32_t replicate) const {
  Random random(seed_, kFirstReplicate + kReplicatesOfRow * row + replicate);
  std::array<double, kDimensions> shift{};
  for (double& x : shift) x = random.uniform();
  uint64_t up = 0, down = 0;
  for (uint32_t ray = 0; ray < rays; ++ray) {
    std::array<double, kDimensions> x = points_[ray];
    for (uint32_t k = 0; k < kDimensions; ++k) x[k] = x[k] + shift[k] < 1 ? x[k] + shift[k] : x[k] + shift[k] - 1;
    bool from_front = true;
    if (ids_.two_sided) {
      from_front = x[4] < 0.5;
      x[4] = from_front ? 2 * x[4] : 2 * x[4] - 1;
    }
    const std::vector<double>& sums = area_sums_[row];
    const uint32_t polygon = polygons_[row][pickBySums(sums, x[4] * sums.back())];
    const glm::dvec3 direction = sight_->directionFrom(polygon, from_front, x[2], x[3]);
    if (sight_->look(polygon, sight_->pointOn(polygon, x[0], x[1]), direction).polygon != Sight::kNothing) continue;
    ++(glm::dot(direction, up_) > 0 ? up : down);
  }
  return {double(up) / rays, double(down) / rays};
}

}  // namespace viewpeel
