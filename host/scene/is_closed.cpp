#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include <glm/glm.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {
namespace {

using Key = std::tuple<double, double, double>;
using EdgeCounts = std::map<std::pair<Key, Key>,
                            int>;  // polygons that run along an edge from its smaller end, minus polygons that run back

Key keyOf(const glm::dvec3& p) { return {p.x, p.y, p.z}; }
glm::dvec3 pointOf(const Key& k) { return {std::get<0>(k), std::get<1>(k), std::get<2>(k)}; }

void addEdge(EdgeCounts& counts, const Key& from, const Key& to, int uses) {
  if (from < to) counts[{from, to}] += uses;
  else counts[{to, from}] -= uses;
}

EdgeCounts unmatched(EdgeCounts counts) {
  std::erase_if(counts, [](const auto& edge) { return edge.second == 0; });
  return counts;
}

// Returns whether p lies on the segment between its ends, within the rounding of coordinates.
bool splits(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
  const double along = glm::dot(p - a, b - a) / glm::dot(b - a, b - a);
  return along > 1e-12 && along < 1 - 1e-12 && glm::length(a + along * (b - a) - p) < 1e-12;
}

}  // namespace

bool isClosed(const Scene& scene) {
  EdgeCounts counts;
  for (const Polygon& polygon : scene.polygons)
    for (uint32_t k = 0; k < polygon.corner_count; ++k)
      addEdge(counts, keyOf(scene.corners[polygon.first_corner + k]),
              keyOf(scene.corners[polygon.first_corner + (k + 1) % polygon.corner_count]), 1);
  const EdgeCounts open = unmatched(std::move(counts));
  if (open.empty()) return true;

  // The edges that are still open are cut where the end of another open edge lies on them (T-junctions). The work is
  // quadratic, so it is done only for few edges.
  constexpr size_t kMostOpenEdges = 4000;
  if (open.size() > kMostOpenEdges) return false;
  std::vector<Key> ends;
  for (const auto& [edge, uses] : open) {
    ends.push_back(edge.first);
    ends.push_back(edge.second);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  EdgeCounts pieces;
  for (const auto& [edge, uses] : open) {
    const glm::dvec3 a = pointOf(edge.first), b = pointOf(edge.second);
    std::vector<std::pair<double, Key>> cuts = {{0, edge.first}, {glm::length(b - a), edge.second}};
    for (const Key& end : ends)
      if (splits(a, b, pointOf(end))) cuts.push_back({glm::length(pointOf(end) - a), end});
    std::sort(cuts.begin(), cuts.end());
    for (size_t k = 0; k + 1 < cuts.size(); ++k) addEdge(pieces, cuts[k].second, cuts[k + 1].second, uses);
  }
  return unmatched(std::move(pieces)).empty();
}

}  // namespace viewpeel
