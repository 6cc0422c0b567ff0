#include "rays/ray_engine.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "rays/emitter.h"
#include "rays/ray_bundle.h"
#include "rays/ray_tree.h"
#include "hash.h"
#include "scene/perimeter.h"
#include "scene/sight.h"
#include "sums/pair_count.h"
#include "threads.h"

namespace viewpeel {
namespace {

using glm::dvec3;
using Point = LaneVector<float>;

// A polygon narrower than this share of half its perimeter is a sliver: single precision would move starts by more than
// 1e-3 of its width. Slivers have rays in double precision, which take kCostOfSliver times as long.
constexpr double kSliver = 1e-4, kCostOfSliver = 10;
constexpr size_t kMostPolygons = 1 << 24;  // their numbers are exact in single precision
// One count stands for kUnitShare of the smallest polygon's area, or for kUnitOfLargest of the largest one's where this
// is more: then 2^20 rays are less than 2^61 counts. At most it is kMostUnitShare of the smallest one's.
constexpr double kUnitShare = 0x1p-14, kUnitOfLargest = 0x1p-42, kMostUnitShare = 0x1p-4;
// Where at most one of so many rays leaves the scene, or one in all, these rays are cast again in double precision, and
// so are rays that end on backs. This takes some 13 times as long, so that it adds a tenth at most to the time of many
// rays.
constexpr size_t kRaysOfStray = 256, kMostStrays = 64;
constexpr size_t kChunk = 16;          // polygons that a thread takes at once
constexpr double kMostHits = 1 << 24;  // numbers of hits that threads keep, by block and polygon

bool isSliver(const Scene& scene, const Polygon& polygon) {
  const double perimeter = perimeterOf(scene, polygon);
  return 2 * polygon.area <= kSliver * perimeter * perimeter / 2;
}

// Returns the share of the smallest polygon's area for which one count stands.
double unitShareOf(const Scene& scene) {
  const auto [least, most] = std::ranges::minmax(scene.polygons, {}, &Polygon::area);
  return std::max(kUnitShare, kUnitOfLargest * most.area / least.area);
}

class TreeRayEngine : public RayEngine {
 public:
  TreeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);

  PairCounts count(std::span<const Direction> directions) override {
    return directions.empty() ? PairCounts{} : std::move(countFrom(directions, directions.size(), nullptr).front());
  }
  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override;
  std::vector<PairCounts> countOutside(std::span<const Direction> directions, size_t block_directions,
                                       const std::vector<uint32_t>& blocks) override {
    return countFrom(directions, block_directions, &blocks);
  }
  void setRays(std::vector<uint32_t> rays) override { rays_ = std::move(rays); }
  void setHorizon(const dvec3& up) override { up_ = pointOf(up); }
  const std::vector<uint32_t>& rays() const override { return rays_; }
  double raysOfReplicate(size_t directions) const override {
    double rays = 0;
    for (const uint32_t id : ids_.of_polygon) rays += raysOf(id, directions);
    return rays;
  }
  double unitArea() const override { return unit_; }

 private:
  struct Hits;
  // A Stray is a ray that leaves the scene or ends on a back: its four numbers, where it starts, and where it counts.
  struct Stray {
    std::array<float, RayBundle::kNumbers> u;
    bool from_front;
    uint64_t Hits::*counted = nullptr;  // null: nowhere
  };
  // Hits are the ends of a polygon's rays of one block.
  struct Hits {
    std::vector<uint32_t> of_polygon;      // by polygon: rays that end on it; empty where only the outside counts
    std::vector<uint32_t> polygons;        // with rays, in any order
    uint64_t environment = 0, leak = 0;    // with a horizon: the environment above and below it
    std::vector<Stray> outside, on_backs;  // strays in single precision, as long as they are few
  };
  // A Worker is what one thread needs, and what it has counted.
  struct Worker {
    RayBundle bundle;
    std::vector<Hits> hits;          // by block, of one polygon
    std::vector<PairCounts> counts;  // by block
  };
  // A Series is what the directions of a block say: which random numbers its rays take.
  struct Series {
    uint64_t seed;
    double weight;  // mean weight of a direction
  };
  uint32_t raysOf(uint32_t id, size_t directions) const {
    return rays_.empty() ? static_cast<uint32_t>(directions) : rays_[id];
  }
  std::vector<PairCounts> countFrom(std::span<const Direction> directions, size_t block_directions,
                                    const std::vector<uint32_t>* blocks);
  void drawDigits(uint32_t points);
  void castFrom(size_t emitter, uint32_t rays, std::span<const Series> blocks, Worker& worker) const;
  void castBundle(size_t emitter, Worker& worker) const;
  template <class Floats>
  void cast(size_t emitter, const RayBundle& bundle, std::vector<Hits>& hits) const;
  // These return where a ray counts that leaves the scene, or ends on a back.
  uint64_t Hits::*placeOutside(const Point& direction) const {
    return up_ && dot(direction, *up_) <= 0 ? &Hits::leak : &Hits::environment;
  }
  uint64_t Hits::*placeOnBack() const { return up_ ? nullptr : &Hits::leak; }
  static void addHit(uint32_t polygon, Hits& hits) {
    if (!hits.of_polygon.empty() && hits.of_polygon[polygon]++ == 0) hits.polygons.push_back(polygon);
  }
  void castFromSliver(uint32_t polygon, bool from_front, const RayBundle& bundle, std::vector<Hits>& hits) const;
  void castInDouble(uint32_t polygon, const Stray& ray, Hits& hits) const;
  void castStraysAgain(uint32_t polygon, size_t directions, Hits& hits) const;
  const Sight& sight() const {
    std::call_once(sight_is_made_, [this] { sight_.emplace(scene_); });
    return *sight_;
  }
  void addCounts(uint32_t polygon, size_t directions, double weight, Hits& hits, PairCounts& counts) const;

  const Scene& scene_;
  const Ids& ids_;
  const uint32_t sides_;  // number of a polygon's sides that emit: 1 or 2
  const size_t threads_;
  const std::function<void()> stop_;
  const std::function<void(uint64_t)> on_batch_;
  const Vectors vectors_ = widestVectors();
  const RayTree tree_;
  double unit_;
  const std::vector<Emitter> emitters_;  // by polygon and side
  std::vector<bool> slivers_;            // by polygon, whether it isSliver()
  mutable std::once_flag sight_is_made_;
  mutable std::optional<Sight> sight_;  // where a ray is cast in double precision
  std::vector<uint32_t> rays_;          // by id, of all sides; empty: as many as directions
  std::optional<Point> up_;             // where there is a horizon
  RayBundle::Digits digits_;            // of as many Sobol' points as a side has had rays at most
};

TreeRayEngine::TreeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : scene_(scene),
      ids_(ids),
      sides_(ids.sides()),
      threads_(options.thread_count ? options.thread_count : threadCount()),
      stop_(options.stop),
      on_batch_(options.on_batch),
      tree_(scene, ids.two_sided),
      unit_(unitShareOf(scene) * std::ranges::min(scene.polygons, {}, &Polygon::area).area),
      emitters_(makeEmitters(scene, sides_)) {
  for (const Polygon& polygon : scene.polygons) slivers_.push_back(isSliver(scene, polygon));
}

void TreeRayEngine::drawDigits(uint32_t points) {
  const size_t whole = (size_t{points} + kLineLanes - 1) / kLineLanes * kLineLanes;
  for (int d = 0; d < RayBundle::kNumbers; ++d)
    for (size_t k = digits_[d].size(); k < whole; ++k)
      digits_[d].push_back(kSobol.digitsOf(static_cast<uint32_t>(k), d));
}

// Casts the rays of one side of a polygon, of all these blocks.    In: rays: of a block
void TreeRayEngine::castFrom(size_t emitter, uint32_t rays, std::span<const Series> blocks, Worker& worker) const {
  RayBundle& bundle = worker.bundle;
  for (uint32_t block = 0; block < blocks.size(); ++block) {
    const std::array<uint32_t, 4> scrambles = scramblesOf({blocks[block].seed, uint64_t(emitter)});
    for (uint32_t first = 0; first < rays; first += RayBundle::kFull) {
      const uint32_t count = std::min(rays - first, RayBundle::kFull);
      runInLanes(
          vectors_, [&]<class Types>(Types) __attribute__((always_inline)) {
            bundle.add<typename Types::Words>(digits_, first, count, scrambles, block);
          });
      if (bundle.size() >= RayBundle::kFull) castBundle(emitter, worker);
    }
  }
  if (bundle.size() > 0) castBundle(emitter, worker);
}

// Casts the rays of a bundle, and clears it.
void TreeRayEngine::castBundle(size_t emitter, Worker& worker) const {
  const auto polygon = static_cast<uint32_t>(emitter / sides_);
  worker.bundle.sort();
  if (slivers_[polygon]) castFromSliver(polygon, emitter % sides_ == 0, worker.bundle, worker.hits);
  else
    runInLanes(
        vectors_, [&]<class Types>(Types) __attribute__((always_inline)) {
          cast<typename Types::Floats>(emitter, worker.bundle, worker.hits);
        });
  worker.bundle.clear();
}

template <class Floats>
[[gnu::always_inline]] inline void TreeRayEngine::cast(size_t emitter, const RayBundle& bundle,
                                                       std::vector<Hits>& hits) const {
  constexpr float kFarAway = 4;  // the scene lies in the unit ball
  const Emitter& from = emitters_[emitter];
  const uint32_t plane = scene_.polygons[emitter / sides_].plane;
  for (uint32_t first = 0; first < bundle.size(); first += kLineLanes) {
    Floats u[RayBundle::kNumbers];
    for (int d = 0; d < RayBundle::kNumbers; ++d) u[d] = bundle.numbersOf<Floats>(first, d);
    Rays<Floats> rays = startRays(from, plane, u);
    rays.distance = Floats(kFarAway), rays.facet = Floats{};
    tree_.meet(rays);
    const int lanes = static_cast<int>(std::min<uint32_t>(kLineLanes, bundle.size() - first));
    for (int lane = 0; lane < lanes; ++lane) {
      const Point at{rays.start.x[lane], rays.start.y[lane], rays.start.z[lane]},
          direction{rays.direction.x[lane], rays.direction.y[lane], rays.direction.z[lane]};
      const auto cover = std::ranges::find_if(from.covers, [&](const RayTree::Facet& facet) {
        float offsets[5];
        facet.setOffsets(from.corner, offsets);
        return facet.beyondEdges(offsets, at) <= 0;
      });
      const RayTree::Facet* const end = cover != from.covers.end() ? &*cover
                                        : rays.facet[lane] > 0     ? &tree_.facet(rays.facet[lane])
                                                                   : nullptr;
      Hits& of_block = hits[bundle.blockOf(first + static_cast<uint32_t>(lane))];
      if (end && (ids_.two_sided || dot(end->normal, direction) * end->side <= 0)) {
        addHit(end->polygon, of_block);
        continue;
      }
      uint64_t Hits::*const counted = end ? placeOnBack() : placeOutside(direction);
      if (counted) ++(of_block.*counted);
      std::vector<Stray>& strays = end ? of_block.on_backs : of_block.outside;
      if (strays.size() < kMostStrays)
        strays.push_back({{u[0][lane], u[1][lane], u[2][lane], u[3][lane]}, emitter % sides_ == 0, counted});
    }
  }
}

// Casts the rays of one side of a sliver, in double precision.
void TreeRayEngine::castFromSliver(uint32_t polygon, bool from_front, const RayBundle& bundle,
                                   std::vector<Hits>& hits) const {
  for (uint32_t ray = 0; ray < bundle.size(); ++ray) {
    Stray of_ray{.u = {}, .from_front = from_front, .counted = nullptr};
    for (int d = 0; d < RayBundle::kNumbers; ++d) of_ray.u[d] = bundle.numberOf(ray, d);
    castInDouble(polygon, of_ray, hits[bundle.blockOf(ray)]);
  }
}

void TreeRayEngine::castInDouble(uint32_t polygon, const Stray& ray, Hits& hits) const {
  const dvec3 direction = sight().directionFrom(polygon, ray.from_front, 1 - double(ray.u[0]), double(ray.u[1]));
  const Sight::End end = sight().look(polygon, sight().pointOn(polygon, double(ray.u[2]), double(ray.u[3])), direction);
  const bool is_outside = end.polygon == Sight::kNothing;
  if (!is_outside && (ids_.two_sided || end.is_front)) return addHit(end.polygon, hits);
  uint64_t Hits::*const counted = is_outside ? placeOutside(pointOf(direction)) : placeOnBack();
  if (counted) ++(hits.*counted);
}

// Casts the strays of one polygon's rays again in double precision, where they are so few that they may have passed
// between two polygons that touch.    In: directions: of the block
void TreeRayEngine::castStraysAgain(uint32_t polygon, size_t directions, Hits& hits) const {
  const size_t few =
      std::clamp<size_t>(raysOf(ids_.of_polygon[polygon], directions) / kRaysOfStray, 1, kMostStrays - 1);
  for (std::vector<Stray>* const strays : {&hits.outside, &hits.on_backs}) {
    for (size_t k = 0; k < strays->size() && strays->size() <= few; ++k) {
      const Stray& stray = (*strays)[k];
      if (stray.counted) --(hits.*stray.counted);
      castInDouble(polygon, stray, hits);
    }
    strays->clear();
  }
}

// Turns the hits of one polygon's rays into counts, and clears them.    In: weight: of a direction
void TreeRayEngine::addCounts(uint32_t polygon, size_t directions, double weight, Hits& hits,
                              PairCounts& counts) const {
  const auto areaOf = [&](uint32_t of) { return sides_ * scene_.polygons[of].area; };
  const double area = areaOf(polygon);
  const uint32_t id = ids_.of_polygon[polygon];
  const auto shareOf = [&](uint32_t of) { return raysOf(of, directions) / double(directions); };
  const double share = shareOf(id);
  // A_i F_ij is twice the count times unitArea(), over the number of directions.
  const auto add = [&](uint32_t other, double rays, double area_of_ray) {
    const auto count = static_cast<uint64_t>(std::llround(rays * weight * area_of_ray / (2 * unit_)));
    if (count > 0) counts.push_back({std::min(id, other), std::max(id, other), count});
  };
  for (const uint32_t met : hits.polygons) {
    const uint32_t other = ids_.of_polygon[met];
    add(other, hits.of_polygon[met], 1 / (share / area + shareOf(other) / areaOf(met)));
    hits.of_polygon[met] = 0;
  }
  add(kEnvironment, double(hits.environment), area / share);
  add(kLeak, double(hits.leak), area / share);
  hits.polygons.clear();
  hits.environment = hits.leak = 0;
}

// Counts along the rays of all polygons. Few blocks are counted at once where polygons are many.
std::vector<PairCounts> TreeRayEngine::countBlocks(std::span<const Direction> directions, size_t block_directions) {
  const auto at_once =
      static_cast<size_t>(std::max(1.0, kMostHits / (double(threads_) * double(scene_.polygons.size()))));
  std::vector<PairCounts> counts;
  for (size_t first = 0; first < directions.size(); first += at_once * block_directions) {
    const size_t count = std::min(at_once * block_directions, directions.size() - first);
    std::ranges::move(countFrom(directions.subspan(first, count), block_directions, nullptr),
                      std::back_inserter(counts));
  }
  return counts;
}

// Counts blocks of directions.    In: blocks: as countOutside() takes it; null: all, and polygons met count
std::vector<PairCounts> TreeRayEngine::countFrom(std::span<const Direction> directions, size_t block_directions,
                                                 const std::vector<uint32_t>* blocks) {
  const auto raysOfSide = [&](uint32_t id) { return raysOf(id, block_directions) / sides_; };
  uint32_t most_rays = 0;
  for (const uint32_t id : ids_.of_polygon) most_rays = std::max(most_rays, raysOfSide(id));
  drawDigits(most_rays);
  std::vector<Series> series;
  for (size_t first = 0; first < directions.size(); first += block_directions) {
    Hash hash;
    double weight = 0;
    for (const Direction& direction : directions.subspan(first, block_directions)) {
      for (int axis = 0; axis < 3; ++axis) hash.add(direction.u[axis]);
      weight += direction.weight;
    }
    series.push_back({hash.value(), weight / double(block_directions)});
  }
  std::vector<Worker> workers(threads_);
  for (Worker& worker : workers) {
    worker.counts.resize(series.size());
    worker.hits.resize(series.size());
    for (Hits& hits : worker.hits) hits.of_polygon.resize(blocks ? 0 : scene_.polygons.size());
  }
  shareOut(
      threads_, scene_.polygons.size(), kChunk,
      [&](size_t thread, size_t k) {
        const auto polygon = static_cast<uint32_t>(k);
        const uint32_t id = ids_.of_polygon[polygon];
        const auto of_polygon = std::span(series).first(blocks ? (*blocks)[id] : series.size());
        Worker& worker = workers[thread];
        for (uint32_t side = 0; side < sides_; ++side) castFrom(k * sides_ + side, raysOfSide(id), of_polygon, worker);
        for (size_t block = 0; block < of_polygon.size(); ++block) {
          castStraysAgain(polygon, block_directions, worker.hits[block]);
          addCounts(polygon, block_directions, series[block].weight, worker.hits[block], worker.counts[block]);
        }
      },
      [&](size_t) {
        if (stop_) stop_();
      });
  if (on_batch_) on_batch_(directions.size());
  std::vector<PairCounts> counts;
  for (size_t block = 0; block < series.size(); ++block) {
    std::vector<PairCounts> of_threads;
    for (Worker& worker : workers) of_threads.push_back(std::move(worker.counts[block]));
    counts.push_back(sortAndJoin(of_threads, ids_.count()));
  }
  return counts;
}

}  // namespace

bool suitsRays(const Scene& scene) {
  return scene.polygons.size() < kMostPolygons && unitShareOf(scene) <= kMostUnitShare;
}

double costOfRay(const Scene& scene, const Polygon& polygon) { return isSliver(scene, polygon) ? kCostOfSliver : 1; }

uint32_t RayEngine::usualRays(double at_least) {
  const auto rays = std::bit_ceil(std::max(kLeastRays, static_cast<uint32_t>(std::ceil(at_least))));
  // Three quarters of 64 or more are a multiple of the sixteen rays that are cast at a time.
  return rays >= 4 * kLeastRays && rays / 4 * 3 >= at_least ? rays / 4 * 3 : rays;
}

std::vector<uint32_t> blocksOfRequested(const Ids& ids, size_t blocks) {
  std::vector<uint32_t> of_ids(ids.count());
  for (uint32_t id = 0; id < ids.count(); ++id)
    if (ids.isRequested(id)) of_ids[id] = static_cast<uint32_t>(blocks);
  return of_ids;
}

std::unique_ptr<RayEngine> makeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  return std::make_unique<TreeRayEngine>(scene, ids, options);
}

}  // namespace viewpeel
