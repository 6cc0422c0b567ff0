#include "engines/size_groups.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "engines/work.h"
#include "sums/pair_count.h"

namespace viewpeel {
namespace {

constexpr double kUsualWindowPoints = 2048;

struct Box {
  glm::dvec3 low{2}, high{-2};
  void add(const glm::dvec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  void add(const Box& box) {
    low = glm::min(low, box.low);
    high = glm::max(high, box.high);
  }
  glm::dvec3 middle() const { return 0.5 * (low + high); }
  double radius() const { return 0.5 * glm::length(high - low); }
};

Box boxOf(const Scene& scene, uint32_t polygon_index) {
  const Polygon& polygon = scene.polygons[polygon_index];
  Box box;
  for (uint32_t k = 0; k < polygon.corner_count; ++k) box.add(scene.corners[polygon.first_corner + k]);
  return box;
}

Box boxOf(const Scene& scene, const std::vector<uint32_t>& polygons) {
  Box box;
  for (uint32_t k : polygons) box.add(boxOf(scene, k));
  return box;
}

// Halves the polygons by place until each half has a window of at most kUsualWindowPoints, or is one polygon. Appends a
// group for each.
void split(const Scene& scene, std::vector<uint32_t> polygons, int resolution, std::vector<SizeGroup>& groups) {
  const Box box = boxOf(scene, polygons);
  if (box.radius() * resolution <= kUsualWindowPoints || polygons.size() == 1) {
    groups.push_back({resolution, windowAround(scene, polygons), std::move(polygons)});
    return;
  }
  const glm::dvec3 size = box.high - box.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middleOf = [&](uint32_t k) { return boxOf(scene, k).middle()[axis]; };
  auto half = std::stable_partition(polygons.begin(), polygons.end(),
                                    [&](uint32_t k) { return middleOf(k) < box.middle()[axis]; });
  if (half == polygons.begin() || half == polygons.end())
    half = polygons.begin() + static_cast<std::ptrdiff_t>(polygons.size() / 2);
  split(scene, {polygons.begin(), half}, resolution, groups);
  split(scene, {half, polygons.end()}, resolution, groups);
}

class GroupedEngine : public Engine {
 public:
  GroupedEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids, const LatticeOptions& options,
                const std::vector<SizeGroup>& groups) {
    if (!ids.roles.empty())
      throw Error(ErrorCode::bad_usage,
                  "windows on small polygons need the whole matrix; leave out --from, --pair and --blocker, or give "
                  "--resolution");
    for (size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].polygons.empty()) continue;
      Part part{nullptr, groups[g].resolution, groups[g].polygons.size(), 1};
      Ids roles = ids;
      roles.roles.assign(scene.polygons.size(), 0);
      for (size_t earlier = 0; earlier <= g; ++earlier)
        for (uint32_t k : groups[earlier].polygons) roles.roles[k] = earlier == g ? kEmits | kReceives : kReceives;
      if (groups.size() == 1) roles.roles.clear();
      LatticeOptions part_options = options;
      part_options.resolution = part.resolution;
      part_options.window = groups[g].window;
      const size_t index = parts_.size(), all = groups.size();
      if (options.on_batch)
        part_options.on_batch = [on_batch = options.on_batch, index, all, this](uint64_t done) {
          on_batch((index * requested_ + done) / all);
        };
      part.engine = make_engine(scene, roles, part_options);
      finest_ = std::max(finest_, part.resolution);
      parts_.push_back(std::move(part));
    }
    for (Part& part : parts_) part.weight = uint64_t(finest_ / part.resolution) * uint64_t(finest_ / part.resolution);
  }

  PairCounts count(std::span<const Direction> directions) override {
    requested_ = directions.size();
    PairCounts sum;
    for (const Part& part : parts_) {
      PairCounts counts = part.engine->count(directions);
      weigh(counts, part, directions.size());
      sum = addCounts(sum, counts);
    }
    return sum;
  }

  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override {
    requested_ = directions.size();
    std::vector<PairCounts> sums(directions.size() / block_directions);
    for (const Part& part : parts_) {
      std::vector<PairCounts> blocks = part.engine->countBlocks(directions, block_directions);
      for (size_t k = 0; k < sums.size(); ++k) {
        weigh(blocks[k], part, block_directions);
        sums[k] = addCounts(sums[k], blocks[k]);
      }
    }
    return sums;
  }

  double unitArea() const override {
    for (const Part& part : parts_)
      if (part.resolution == finest_) return part.engine->unitArea();
    return 1;
  }

  const Work* work() const override {
    work_ = {};
    for (const Part& part : parts_) {
      const Work* part_work = part.engine->work();
      if (!part_work) return nullptr;
      addWork(*part_work, work_);
    }
    return &work_;
  }

  std::string describePlan() const override {
    std::string text;
    for (const Part& part : parts_)
      text += fmt::format("lattice    {} across, for {} polygon{}\n{}", part.resolution, part.polygons,
                          part.polygons == 1 ? "" : "s", part.engine->describePlan());
    return text;
  }

 private:
  struct Part {
    std::unique_ptr<Engine> engine;
    int resolution;
    size_t polygons;
    uint64_t weight;  // one of its counts is worth this many counts of the finest lattice
  };
  void weigh(PairCounts& counts, const Part& part, size_t directions) const {
    for (PairCount& count : counts) {
      // In counts of the finest lattice, the windows' counts of a pair add up to little more than the coarsest lattice
      // alone would count. So their sum fits 64 bits where the counts of each window fit 63.
      if (std::max(count.count, count.blocked) > UINT64_MAX / 2 / part.weight)
        throw Error(ErrorCode::bad_usage, fmt::format("{} directions at resolutions of {} and {} are too many to count "
                                                      "in 64 bits; ask for fewer --directions and more --replicates, "
                                                      "or a coarser --finest",
                                                      directions, part.resolution, finest_));
      count.count *= part.weight;
      count.blocked *= part.weight;
    }
  }
  std::vector<Part> parts_;
  int finest_ = 1;
  uint64_t requested_ = 0;
  mutable Work work_;
};

}  // namespace

std::vector<SizeGroup> groupBySize(const Scene& scene, const std::vector<double>& needed, int base, int finest) {
  for (;; finest /= kGroupStep) {
    std::vector<SizeGroup> groups{{base, {}, {}}};
    std::map<int, std::vector<uint32_t>> fine;
    for (uint32_t k = 0; k < needed.size(); ++k) {
      const double radius = boxRadius(scene, k);
      int resolution = base;
      while (resolution < needed[k] * kEnough && resolution <= finest / kGroupStep &&
             radius * resolution * kGroupStep <= kMostWindowPoints)
        resolution *= kGroupStep;
      (resolution == base ? groups[0].polygons : fine[resolution]).push_back(k);
    }
    for (auto& [resolution, polygons] : fine) split(scene, std::move(polygons), resolution, groups);
    if (groups.size() <= kMostWindows + 1 || fine.empty()) return groups;
  }
}

std::vector<SizeGroup> groupAsOne(const Scene& scene, int resolution) {
  SizeGroup whole{resolution, {}, std::vector<uint32_t>(scene.polygons.size())};
  std::iota(whole.polygons.begin(), whole.polygons.end(), 0u);
  return {std::move(whole)};
}

size_t countWindows(const Scene& scene, std::vector<uint32_t> polygons, int resolution) {
  std::vector<SizeGroup> groups;
  split(scene, std::move(polygons), resolution, groups);
  return groups.size();
}

Window windowAround(const Scene& scene, const std::vector<uint32_t>& polygons) {
  const Box box = boxOf(scene, polygons);
  const Window window{box.middle(), box.radius() * (1 + 1e-9) + 1e-12};
  return window.radius < 1 ? window : Window{};
}

double boxRadius(const Scene& scene, uint32_t polygon_index) { return boxOf(scene, polygon_index).radius(); }

std::unique_ptr<Engine> makeGroupedEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids,
                                          const LatticeOptions& options, const std::vector<SizeGroup>& groups) {
  return std::make_unique<GroupedEngine>(make_engine, scene, ids, options, groups);
}

}  // namespace viewpeel
