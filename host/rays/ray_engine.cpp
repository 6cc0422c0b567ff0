#include "rays/ray_engine.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "rays/ray_tree.h"
#include "hash.h"
#include "pair_lines/sobol_points.h"
#include "scene/coincident.h"
#include "scene/perimeter.h"
#include "scene/polygon_tree.h"
#include "scene/sight.h"
#include "sums/pair_count.h"
#include "threads.h"

namespace viewpeel {
namespace {

using glm::dvec3;
using Point = LaneVector<float>;

// Rays from polygons up to the width kNarrow, some 30 times kRayReach, start in double precision, which takes ten times
// as long. At most the share kMostNarrow of a scene's polygons may be so narrow.
constexpr double kNarrow = 1e-5, kMostNarrow = 0.05;
constexpr double kLeastSize = 1e-6;        // root of the least area of a polygon: counts of smaller ones might overflow
constexpr size_t kMostPolygons = 1 << 24;  // their numbers are exact in single precision
constexpr double kUnitShare = 0x1p-14;     // of the smallest polygon's area: what one count stands for
constexpr size_t kChunk = 16;              // polygons that a thread takes at once
constexpr float kLeastRoot = 1e-12f;       // numbers are raised to it before their root is taken

// Returns the square root of numbers from 0 to 1.
template <class Floats>
VIEWPEEL_INLINE Floats rootOf(const Floats& x) {
  const Floats positive = greatest(x, Floats(kLeastRoot));
  return positive * inverseRoot(positive);
}

// Sets the cosine and the sine of an angle, to 2e-7.    In: turn: the angle over that of a whole turn, in [0, 1)
template <class Floats>
VIEWPEEL_INLINE void turnBy(const Floats& turn, Floats& cosine, Floats& sine) {
  constexpr auto kHalfRoot = static_cast<float>(std::numbers::sqrt2 / 2),
                 kQuarter = static_cast<float>(std::numbers::pi / 2);
  // The angle is a number of quarters, an eighth, and a rest within an eighth, whose series are Taylor's.
  const Floats quarters = wholeOf(4.0f * turn), rest = (4.0f * turn - quarters - 0.5f) * kQuarter, square = rest * rest;
  const Floats s = rest * (1.0f + square * (-1 / 6.0f + square * (1 / 120.0f + square * (-1 / 5040.0f)))),
               c = 1.0f + square * (-0.5f + square * (1 / 24.0f + square * (-1 / 720.0f + square * (1 / 40320.0f))));
  const Floats x = (c - s) * kHalfRoot, y = (c + s) * kHalfRoot;
  const Floats is_odd = quarters - 2.0f * wholeOf(0.5f * quarters),
               sign = ifBelow(Floats(1.5f), quarters, Floats(-1.0f), Floats(1.0f));
  cosine = sign * ifBelow(Floats(0.5f), is_odd, -y, x);
  sine = sign * ifBelow(Floats(0.5f), is_odd, x, y);
}

// An Emitter is a side of a polygon, from which rays start.
struct Emitter {
  Point corner, to_first, along_first, to_second, along_second;  // of the triangles that the polygon consists of
  float first_share;                                             // of the first triangle in the area
  Point axes[3];                                                 // the last one is the side's normal
  std::vector<RayTree::Facet> covers;  // polygons that coincide with this one and hide the side, nearest first
};

bool isNarrow(const Scene& scene, const Polygon& polygon) {
  return 2 * polygon.area <= kNarrow * perimeterOf(scene, polygon);
}

class TreeRayEngine : public RayEngine {
 public:
  TreeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);

  PairCounts count(std::span<const Direction> directions) override { return countFrom(directions, nullptr); }
  PairCounts countOutside(std::span<const Direction> directions, const std::vector<bool>& rows) override {
    return countFrom(directions, &rows);
  }
  void setRays(std::vector<uint32_t> rays) override { rays_ = std::move(rays); }
  const std::vector<uint32_t>& rays() const override { return rays_; }
  double unitArea() const override { return unit_; }
  std::string describePlan() const override { return "rays of each polygon's own\n"; }

 private:
  // Hits are the ends of a polygon's rays.
  struct Hits {
    std::vector<uint32_t> of_polygon;  // by polygon: rays that end on it
    std::vector<uint32_t> polygons;    // with rays, in any order
    uint64_t environment = 0, leak = 0;
  };
  // Points are binary digits of Sobol' points. Sixteen neighbours have nearly the same direction, so that their rays go
  // through the same boxes.
  struct Points {
    explicit Points(uint32_t count);
    uint32_t count;
    std::array<std::vector<uint32_t>, 4> digits;
  };
  Emitter emitterOf(uint32_t polygon, bool from_front, const PolygonTree& near) const;
  uint32_t raysOf(uint32_t id, size_t directions) const {
    return rays_.empty() ? static_cast<uint32_t>(directions) : rays_[id];
  }
  PairCounts countFrom(std::span<const Direction> directions, const std::vector<bool>* rows);
  template <class Floats>
  static Rays<Floats> start(const Emitter& from, uint32_t plane, const Floats* u);
  template <class Types>
  void cast(const Emitter& from, uint32_t plane, const Points& points, const std::array<uint32_t, 4>& scrambles,
            Hits& hits) const;
  template <class Types>
  void castFromNarrow(uint32_t polygon, bool from_front, const Points& points, const std::array<uint32_t, 4>& scrambles,
                      Hits& hits) const;
  void addCounts(uint32_t polygon, size_t directions, double weight, bool outside_alone, Hits& hits,
                 PairCounts& counts) const;

  const Scene& scene_;
  const Ids& ids_;
  const uint32_t sides_;  // number of a polygon's sides that emit: 1 or 2
  const size_t threads_;
  const std::function<void()> stop_;
  const std::function<void(uint64_t)> on_batch_;
  const RayTree tree_;
  double unit_;
  std::vector<Emitter> emitters_;      // by polygon and side
  std::vector<bool> narrow_;           // by polygon, whether it isNarrow()
  std::optional<Sight> sight_;         // where there are narrow polygons
  std::vector<uint32_t> rays_;         // by id, of all sides; empty: as many as directions
  std::map<uint32_t, Points> points_;  // by their number
};

TreeRayEngine::TreeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : scene_(scene),
      ids_(ids),
      sides_(ids.sides()),
      threads_(options.thread_count ? options.thread_count : threadCount()),
      stop_(options.stop),
      on_batch_(options.on_batch),
      tree_(scene, ids.two_sided),
      unit_(kUnitShare * std::ranges::min(scene.polygons, {}, &Polygon::area).area) {
  const PolygonTree near(scene);
  for (uint32_t k = 0; k < scene.polygons.size(); ++k)
    for (uint32_t side = 0; side < sides_; ++side) emitters_.push_back(emitterOf(k, side == 0, near));
  for (const Polygon& polygon : scene.polygons) narrow_.push_back(isNarrow(scene, polygon));
  if (std::ranges::count(narrow_, true) > 0) sight_.emplace(scene);
}

Emitter TreeRayEngine::emitterOf(uint32_t index, bool from_front, const PolygonTree& near) const {
  const Polygon& polygon = scene_.polygons[index];
  const dvec3* const c = &scene_.corners[polygon.first_corner];
  const dvec3& last = c[polygon.corner_count - 1];
  const dvec3 front = frontNormal(scene_, polygon), normal = from_front ? front : -front,
              across = glm::normalize(glm::cross(normal, std::abs(normal.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  Emitter emitter{.corner = pointOf(c[0]),
                  .to_first = pointOf(c[1] - c[0]),
                  .along_first = pointOf(c[2] - c[1]),
                  .to_second = pointOf(c[2] - c[0]),
                  .along_second = pointOf(last - c[2]),
                  .first_share = 1,
                  .axes = {pointOf(across), pointOf(glm::cross(normal, across)), pointOf(normal)},
                  .covers = {}};
  if (polygon.corner_count == 4)
    emitter.first_share = static_cast<float>(glm::length(glm::cross(c[1] - c[0], c[2] - c[0])) / (2 * polygon.area));
  std::vector<std::pair<int, uint32_t>> covers;
  near.forEachNear(index, 0, [&](uint32_t other) {
    const int steps = (levelOf(scene_.polygons[other]) - levelOf(polygon)) *
                      (polygon.front_along_plane_normal == from_front ? 1 : -1);
    if (scene_.polygons[other].plane == polygon.plane && steps > 0) covers.emplace_back(steps, other);
  });
  std::ranges::sort(covers);
  for (const auto& [steps, other] : covers) emitter.covers.push_back(RayTree::facetOf(scene_, other));
  return emitter;
}

// Makes points, and sorts them by direction: along a Z curve of their first two numbers, which are height and turn.
TreeRayEngine::Points::Points(uint32_t number) : count(number) {
  struct Place {
    uint64_t at;
    uint32_t point;
  };
  std::vector<Place> places(count);
  for (uint32_t k = 0; k < count; ++k) {
    const uint32_t height = kSobol.digitsOf(k, 0), turn = kSobol.digitsOf(k, 1);
    places[k] = {0, k};
    for (int bit = 0; bit < 32; ++bit) places[k].at = places[k].at << 2 | (turn >> bit & 1) << 1 | (height >> bit & 1);
  }
  std::ranges::sort(places, {}, &Place::at);
  const size_t whole = (count + kLineLanes - 1) / kLineLanes * kLineLanes;  // the last lanes may be idle
  for (int d = 0; d < 4; ++d) {
    digits[d].assign(whole, 0);
    for (size_t k = 0; k < count; ++k) digits[d][k] = kSobol.digitsOf(places[k].point, d);
  }
}

// Returns sixteen rays.    In: u: four numbers in [0, 1) for each, which give height, turn, and the place of the start
template <class Floats>
VIEWPEEL_INLINE Rays<Floats> TreeRayEngine::start(const Emitter& from, uint32_t plane, const Floats* u) {
  Floats cosine, sine;
  turnBy(u[1], cosine, sine);
  const Floats radius = rootOf(u[0]), x = radius * cosine, y = radius * sine, z = rootOf<Floats>(1.0f - u[0]);
  Rays<Floats> rays;
  const auto along = [&](float a, float b, float c) __attribute__((always_inline)) { return x * a + y * b + z * c; };
  rays.direction = {along(from.axes[0].x, from.axes[1].x, from.axes[2].x),
                    along(from.axes[0].y, from.axes[1].y, from.axes[2].y),
                    along(from.axes[0].z, from.axes[1].z, from.axes[2].z)};
  // The first number chooses a triangle, and then is uniform again.
  const Floats share = from.first_share, rest = greatest(1.0f - share, Floats(kLeastRoot));
  const Floats from_corner = rootOf(ifBelow(u[2], share, u[2] / share, (u[2] - share) / rest));
  const auto place = [&](float corner, float to_first, float along_first, float to_second, float along_second)
      __attribute__((always_inline)) {
    const Floats to = ifBelow(u[2], share, Floats(to_first), Floats(to_second)),
                 further = ifBelow(u[2], share, Floats(along_first), Floats(along_second));
    return corner + from_corner * (to + u[3] * further);
  };
  rays.start = {place(from.corner.x, from.to_first.x, from.along_first.x, from.to_second.x, from.along_second.x),
                place(from.corner.y, from.to_first.y, from.along_first.y, from.to_second.y, from.along_second.y),
                place(from.corner.z, from.to_first.z, from.along_first.z, from.to_second.z, from.along_second.z)};
  rays.plane = plane;
  return rays;
}

// Casts the rays of one side of a polygon.
template <class Types>
[[gnu::always_inline]] inline void TreeRayEngine::cast(const Emitter& from, uint32_t plane, const Points& points,
                                                       const std::array<uint32_t, 4>& scrambles, Hits& hits) const {
  using Floats = typename Types::Floats;
  constexpr float kFarAway = 4;  // the scene lies in the unit ball
  for (size_t first = 0; first < points.count; first += kLineLanes) {
    Floats u[4];
    for (int d = 0; d < 4; ++d)
      u[d] = scrambled(load<typename Types::Words>(points.digits[d].data() + first), scrambles[d]);
    Rays<Floats> rays = start(from, plane, u);
    rays.distance = Floats(kFarAway), rays.facet = Floats{};
    tree_.meet(rays);
    const int lanes = static_cast<int>(std::min<size_t>(kLineLanes, points.count - first));
    for (int lane = 0; lane < lanes; ++lane) {
      const Point at{rays.start.x[lane], rays.start.y[lane], rays.start.z[lane]},
          direction{rays.direction.x[lane], rays.direction.y[lane], rays.direction.z[lane]};
      const auto cover = std::ranges::find_if(
          from.covers, [&](const RayTree::Facet& facet) { return beyond(facet.edges, 4, at) <= 0; });
      const RayTree::Facet* const end = cover != from.covers.end() ? &*cover
                                        : rays.facet[lane] > 0     ? &tree_.facet(rays.facet[lane])
                                                                   : nullptr;
      if (!end) ++hits.environment;
      else if (!ids_.two_sided && dot(end->normal, direction) * end->side > 0) ++hits.leak;
      else if (hits.of_polygon[end->polygon]++ == 0) hits.polygons.push_back(end->polygon);
    }
  }
}

// Casts the rays of one side of a narrow polygon, in double precision.
template <class Types>
[[gnu::always_inline]] inline void TreeRayEngine::castFromNarrow(uint32_t polygon, bool from_front,
                                                                 const Points& points,
                                                                 const std::array<uint32_t, 4>& scrambles,
                                                                 Hits& hits) const {
  using Floats = typename Types::Floats;
  for (size_t first = 0; first < points.count; first += kLineLanes) {
    Floats u[4];
    for (int d = 0; d < 4; ++d)
      u[d] = scrambled(load<typename Types::Words>(points.digits[d].data() + first), scrambles[d]);
    const int lanes = static_cast<int>(std::min<size_t>(kLineLanes, points.count - first));
    for (int lane = 0; lane < lanes; ++lane) {
      const dvec3 direction = sight_->directionFrom(polygon, from_front, 1 - double(u[0][lane]), double(u[1][lane]));
      const Sight::End end =
          sight_->look(polygon, sight_->pointOn(polygon, double(u[2][lane]), double(u[3][lane])), direction);
      if (end.polygon == Sight::kNothing) ++hits.environment;
      else if (!ids_.two_sided && !end.is_front) ++hits.leak;
      else if (hits.of_polygon[end.polygon]++ == 0) hits.polygons.push_back(end.polygon);
    }
  }
}

// Turns the hits of one polygon's rays into counts, and clears them.
//   In: weight: of a direction; outside_alone: whether only environment and leak count
void TreeRayEngine::addCounts(uint32_t polygon, size_t directions, double weight, bool outside_alone, Hits& hits,
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
    if (!outside_alone) add(other, hits.of_polygon[met], 1 / (share / area + shareOf(other) / areaOf(met)));
    hits.of_polygon[met] = 0;
  }
  add(kEnvironment, double(hits.environment), area / share);
  add(kLeak, double(hits.leak), area / share);
  hits.polygons.clear();
  hits.environment = hits.leak = 0;
}

// Counts along the rays of all polygons; with rows, environment and leak alone, of the polygons of these rows.
PairCounts TreeRayEngine::countFrom(std::span<const Direction> directions, const std::vector<bool>* rows) {
  if (directions.empty()) return {};
  const auto raysOfSide = [&](uint32_t id) { return raysOf(id, directions.size()) / sides_; };
  for (const uint32_t id : ids_.of_polygon)
    if (const uint32_t rays = raysOfSide(id); !points_.contains(rays)) points_.emplace(rays, rays);
  Hash series;
  double weight = 0;
  for (const Direction& direction : directions) {
    for (int axis = 0; axis < 3; ++axis) series.add(direction.u[axis]);
    weight += direction.weight;
  }
  weight /= double(directions.size());
  const Vectors vectors = widestVectors();
  std::vector<PairCounts> counts(threads_);
  std::vector<Hits> hits(threads_);
  for (Hits& of_thread : hits) of_thread.of_polygon.resize(scene_.polygons.size());
  shareOut(
      threads_, scene_.polygons.size(), kChunk,
      [&](size_t thread, size_t k) {
        const auto polygon = static_cast<uint32_t>(k);
        const uint32_t id = ids_.of_polygon[polygon];
        if (rows && !(*rows)[id]) return;
        const Points& points = points_.at(raysOfSide(id));
        for (size_t emitter = k * sides_; emitter < (k + 1) * sides_; ++emitter) {
          const std::array<uint32_t, 4> scrambles = scramblesOf({series.value(), uint64_t(emitter)});
          runInLanes(
              vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
                if (narrow_[k]) castFromNarrow<Types>(polygon, emitter == k * sides_, points, scrambles, hits[thread]);
                else cast<Types>(emitters_[emitter], scene_.polygons[k].plane, points, scrambles, hits[thread]);
              });
        }
        addCounts(polygon, directions.size(), weight, rows, hits[thread], counts[thread]);
      },
      [&](size_t) {
        if (stop_) stop_();
      });
  if (on_batch_) on_batch_(directions.size());
  return sortAndJoin(counts, ids_.count());
}

}  // namespace

bool suitsRays(const Scene& scene) {
  const auto narrow = std::ranges::count_if(scene.polygons, [&](const Polygon& of) { return isNarrow(scene, of); });
  return scene.polygons.size() < kMostPolygons && double(narrow) <= kMostNarrow * double(scene.polygons.size()) &&
         std::ranges::min(scene.polygons, {}, &Polygon::area).area > kLeastSize * kLeastSize;
}

uint32_t RayEngine::usualRays(double at_least) {
  const auto rays = std::bit_ceil(std::max(kLeastRays, static_cast<uint32_t>(std::ceil(at_least))));
  // Three quarters of 64 or more are a multiple of the sixteen rays that are cast at a time.
  return rays >= 4 * kLeastRays && rays / 4 * 3 >= at_least ? rays / 4 * 3 : rays;
}

std::unique_ptr<RayEngine> makeRayEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  return std::make_unique<TreeRayEngine>(scene, ids, options);
}

}  // namespace viewpeel
