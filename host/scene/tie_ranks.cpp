#include "scene/tie_ranks.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

namespace viewpeel {
namespace {

using Pairs = std::vector<std::pair<uint32_t, uint32_t>>;
using Levels = std::map<uint32_t, uint32_t>;  // by polygon: place along the plane's normal, from 0

// Returns levels in which every polygon is above all polygons below it. In a cycle the first polygon counts as the
// lowest.
Levels levelsOf(const Pairs& below, uint64_t& cycles) {
  struct Node {
    std::vector<uint32_t> above;
    uint32_t below_count = 0, level = 0;
    bool is_done = false;
  };
  std::map<uint32_t, Node> nodes;
  for (const auto& [lower, upper] : below) {
    nodes[lower].above.push_back(upper);
    ++nodes[upper].below_count;
  }
  std::vector<uint32_t> ready;
  for (const auto& [polygon, node] : nodes)
    if (node.below_count == 0) ready.push_back(polygon);
  Levels levels;
  auto next = nodes.begin();
  while (levels.size() < nodes.size()) {
    if (ready.empty()) {
      while (next->second.is_done) ++next;
      ready.push_back(next->first);
      next->second.below_count = 0;
      ++cycles;
    }
    const uint32_t polygon = ready.back();
    ready.pop_back();
    Node& node = nodes[polygon];
    node.is_done = true;
    levels[polygon] = node.level;
    for (uint32_t upper : node.above) {
      Node& other = nodes[upper];
      if (other.is_done || other.below_count == 0) continue;
      other.level = std::max(other.level, node.level + 1);
      if (--other.below_count == 0) ready.push_back(upper);
    }
  }
  return levels;
}

std::map<uint32_t, std::vector<uint32_t>> neighboursIn(const Pairs& pairs) {
  std::map<uint32_t, std::vector<uint32_t>> neighbours;
  for (const auto& [a, b] : pairs) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  return neighbours;
}

// Moves polygons up so that two that look the same way never share a level. Orders between levels are kept.
Levels partAlike(const Scene& scene, const TieOrders& orders, Levels levels) {
  if (orders.alike.empty()) return levels;
  for (const auto& [a, b] : orders.alike) {
    levels.try_emplace(a, 0);
    levels.try_emplace(b, 0);
  }
  std::map<uint32_t, uint32_t> colours;  // of polygons of one level: the smaller, the farther in front
  for (const auto& [polygon, others] : neighboursIn(orders.alike)) {
    std::set<uint32_t> taken;
    for (uint32_t other : others)
      if (other < polygon && levels[other] == levels[polygon]) taken.insert(colours[other]);
    uint32_t colour = 0;
    while (taken.count(colour)) ++colour;
    colours[polygon] = colour;
  }
  const auto placeOf = [&](uint32_t polygon) {
    const auto at = colours.find(polygon);
    const int64_t colour = at == colours.end() ? 0 : at->second;
    return std::pair(levels.at(polygon), scene.polygons[polygon].front_along_plane_normal ? -colour : colour);
  };
  Pairs rising;
  for (const Pairs* pairs : {&orders.below, &orders.alike})
    for (const auto& [a, b] : *pairs) {
      if (placeOf(a) < placeOf(b)) rising.emplace_back(a, b);
      if (pairs == &orders.alike && placeOf(b) < placeOf(a)) rising.emplace_back(b, a);
    }
  std::sort(rising.begin(), rising.end(), [&](const auto& p, const auto& q) {
    return std::tuple(placeOf(p.first), p) < std::tuple(placeOf(q.first), q);
  });
  Levels parted;
  for (const auto& entry : levels) parted[entry.first] = 0;
  for (const auto& [lower, upper] : rising) parted[upper] = std::max(parted[upper], parted[lower] + 1);
  return parted;
}

// Returns for each polygon the number of levels in its group: polygons that overlap, directly or through others.
std::map<uint32_t, uint32_t> heightsOf(const TieOrders& orders, const Levels& levels) {
  Pairs all = orders.below;
  all.insert(all.end(), orders.alike.begin(), orders.alike.end());
  const auto neighbours = neighboursIn(all);
  std::map<uint32_t, uint32_t> heights;
  for (const auto& entry : neighbours) {
    if (heights.count(entry.first)) continue;
    std::vector<uint32_t> group = {entry.first};
    heights[entry.first] = 0;
    uint32_t height = 0;
    for (size_t k = 0; k < group.size(); ++k) {
      height = std::max(height, levels.at(group[k]) + 1);
      for (uint32_t other : neighbours.at(group[k]))
        if (heights.try_emplace(other, 0).second) group.push_back(other);
    }
    for (uint32_t polygon : group) heights[polygon] = height;
  }
  return heights;
}

}  // namespace

uint64_t rankCoincidentPolygons(Scene& scene, TieOrders orders) {
  uint64_t cycles = 0;
  const Levels of_below = levelsOf(orders.below, cycles);
  Levels levels = partAlike(scene, orders, of_below);
  std::map<uint32_t, uint32_t> heights = heightsOf(orders, levels);
  const auto isTooHigh = [&](uint32_t polygon) { return heights.at(polygon) > kTieRanks; };
  std::set<uint32_t> too_high;
  for (const auto& entry : levels)
    if (isTooHigh(entry.first)) too_high.insert(entry.first);
  // Contacts of solids matter more than the order of two faces that look the same way.
  if (std::erase_if(orders.alike, [&](const auto& pair) { return isTooHigh(pair.first); }) > 0) {
    levels = partAlike(scene, orders, of_below);
    heights = heightsOf(orders, levels);
  }
  for (const auto& [polygon, its_level] : levels) {
    // The polygons of a group are put in the middle of all ranks.
    const int level =
        static_cast<int>(its_level) + static_cast<int>(kTieRanks) / 2 - static_cast<int>(heights.at(polygon)) / 2;
    const auto along_normal = static_cast<uint32_t>(std::clamp(level, 0, static_cast<int>(kTieRanks) - 1));
    Polygon& p = scene.polygons[polygon];
    p.tie_rank = p.front_along_plane_normal ? along_normal : kTieRanks - 1 - along_normal;
  }
  if (!too_high.empty())
    scene.warnings.push_back(
        fmt::format("{}: {} polygons lie in stacks of more than {} coincident polygons, too many to order; "
                    "remove repeated faces",
                    scene.file, too_high.size(), kTieRanks));
  return cycles;
}

}  // namespace viewpeel
