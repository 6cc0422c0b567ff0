#include "pair_lines/blockers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include <glm/glm.hpp>

#include "hash.h"
#include "scene/coincident.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr double kStraight = 1e-12;  // sine of a turn that counts as none

Blocker blockerOf(const std::vector<dvec3>& corners, const Scene& scene, const Polygon& polygon, uint32_t index) {
  Blocker b;
  b.corner_count = static_cast<uint32_t>(corners.size());
  b.plane = polygon.plane;
  b.level = levelOf(polygon);
  b.polygon = index;
  dvec3 area(0);
  for (size_t k = 2; k < corners.size(); ++k) area += glm::cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
  b.normal = corners.size() == polygon.corner_count ? frontNormal(scene, polygon) : glm::normalize(area);
  b.low = dvec3(INFINITY), b.high = dvec3(-INFINITY);
  double offset = 0;
  for (uint32_t k = 0; k < b.corner_count; ++k) {
    b.corners[k] = corners[k];
    b.low = glm::min(b.low, corners[k]), b.high = glm::max(b.high, corners[k]);
    const dvec3& next = corners[(k + 1) % b.corner_count];
    b.edge_normals[k] = glm::normalize(glm::cross(next - corners[k], b.normal));
    b.edge_offsets[k] = glm::dot(b.edge_normals[k], corners[k]);
    offset += glm::dot(b.normal, corners[k]);
  }
  b.offset = offset / b.corner_count;
  return b;
}

// A Joiner joins polygons across common edges as long as the union is convex. Both polygons must have the same plane,
// level and side of their front.
class Joiner {
 public:
  explicit Joiner(const Scene& scene) : scene_(scene) {
    struct SameBits {
      size_t operator()(const std::array<double, 3>& p) const {
        Hash hash;
        for (double x : p) hash.add(x);
        return hash.value();
      }
    };
    std::unordered_map<std::array<double, 3>, uint32_t, SameBits> numbers;
    for (const Polygon& polygon : scene.polygons) {
      std::vector<uint32_t>& loop = loops_.emplace_back();
      for (uint32_t c = 0; c < polygon.corner_count; ++c) {
        const dvec3& p = scene.corners[polygon.first_corner + c];
        const auto [at, is_new] =
            numbers.try_emplace({p.x + 0.0, p.y + 0.0, p.z + 0.0}, static_cast<uint32_t>(points_.size()));
        if (is_new) points_.push_back(p);
        loop.push_back(at->second);
      }
    }
    for (uint32_t k = 0; k < loops_.size(); ++k) enter(k);
    joined_to_.resize(loops_.size());
    std::iota(joined_to_.begin(), joined_to_.end(), 0u);
  }

  void joinAll() {
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (uint32_t k = 0; k < loops_.size(); ++k)
        while (!loops_[k].empty() && extend(k)) is_changed = true;
    }
  }

  // Returns the polygon whose outline a polygon has become a part of.
  uint32_t joinedTo(uint32_t k) const {
    while (joined_to_[k] != k) k = joined_to_[k];
    return k;
  }

  std::vector<dvec3> cornersOf(uint32_t k) const {
    std::vector<dvec3> corners;
    for (uint32_t p : loops_[k]) corners.push_back(points_[p]);
    return corners;
  }

 private:
  using Edge = std::pair<uint32_t, uint32_t>;

  void enter(uint32_t k) {
    for (size_t e = 0; e < loops_[k].size(); ++e) users_[edgeOf(k, e)].insert(k);
  }
  void leave(uint32_t k) {
    for (size_t e = 0; e < loops_[k].size(); ++e) users_[edgeOf(k, e)].erase(k);
  }
  Edge edgeOf(uint32_t k, size_t e) const { return {loops_[k][e], loops_[k][(e + 1) % loops_[k].size()]}; }

  bool areAlike(uint32_t a, uint32_t b) const {
    const Polygon &p = scene_.polygons[a], &q = scene_.polygons[b];
    return p.plane == q.plane && p.front_along_plane_normal == q.front_along_plane_normal && p.tie_rank == q.tie_rank;
  }

  // Returns the outline without corners on straight lines; empty where it is not convex or has too many corners.
  std::vector<uint32_t> tidied(const std::vector<uint32_t>& loop, const dvec3& normal) const {
    std::vector<uint32_t> kept;
    for (size_t k = 0; k < loop.size(); ++k) {
      const dvec3 &before = points_[loop[(k + loop.size() - 1) % loop.size()]], &at = points_[loop[k]],
                  &after = points_[loop[(k + 1) % loop.size()]];
      const double turn = glm::dot(normal, glm::cross(at - before, after - at)),
                   straight = kStraight * glm::length(at - before) * glm::length(after - at);
      if (turn < -straight) return {};
      if (turn > straight) kept.push_back(loop[k]);
    }
    if (kept.size() < 3 || kept.size() > kMostBlockerCorners) return {};
    return kept;
  }

  // Joins one neighbour to a polygon. Returns false where no neighbour can be joined.
  bool extend(uint32_t k) {
    const dvec3 normal = frontNormal(scene_, scene_.polygons[k]);
    for (size_t e = 0; e < loops_[k].size(); ++e) {
      const Edge edge = edgeOf(k, e);
      const auto found = users_.find({edge.second, edge.first});
      if (found == users_.end()) continue;
      for (const uint32_t other : found->second) {
        if (other == k || !areAlike(k, other)) continue;
        const std::vector<uint32_t>&mine = loops_[k], &theirs = loops_[other];
        const size_t at = static_cast<size_t>(std::ranges::find(theirs, edge.second) - theirs.begin());
        std::vector<uint32_t> both;
        for (size_t c = 0; c < mine.size(); ++c) both.push_back(mine[(e + 1 + c) % mine.size()]);
        for (size_t c = 2; c < theirs.size(); ++c) both.push_back(theirs[(at + c) % theirs.size()]);
        if (std::set(both.begin(), both.end()).size() < both.size()) continue;  // they have two edges in common
        both = tidied(both, normal);
        if (both.empty()) continue;
        leave(k), leave(other);
        joined_to_[other] = k;
        loops_[k] = std::move(both), loops_[other].clear();
        enter(k);
        return true;
      }
    }
    return false;
  }

  const Scene& scene_;
  std::vector<dvec3> points_;
  std::vector<std::vector<uint32_t>> loops_;  // of polygons; empty where joined to another
  std::vector<uint32_t> joined_to_;           // of polygons; itself where joined to no other
  std::map<Edge, std::set<uint32_t>> users_;  // of directed edges
};

}  // namespace

std::vector<Blocker> makeBlockers(const Scene& scene, bool join, std::vector<uint32_t>* of_polygon) {
  Joiner joiner(scene);
  if (join) joiner.joinAll();
  std::vector<Blocker> blockers;
  std::vector<uint32_t> numbers(scene.polygons.size());
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const std::vector<dvec3> corners = joiner.cornersOf(k);
    if (corners.empty()) continue;
    numbers[k] = static_cast<uint32_t>(blockers.size());
    blockers.push_back(blockerOf(corners, scene, scene.polygons[k], k));
  }
  if (of_polygon) {
    of_polygon->resize(numbers.size());
    for (uint32_t k = 0; k < numbers.size(); ++k) (*of_polygon)[k] = numbers[joiner.joinedTo(k)];
  }
  return blockers;
}

}  // namespace viewpeel
