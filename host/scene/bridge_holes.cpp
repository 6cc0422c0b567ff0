#include "scene/bridge_holes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "scene/split_face.h"

namespace viewpeel {
namespace {

// A Corner is a corner of a ring: in its plane, and in space.
struct Corner {
  glm::dvec2 flat;
  glm::dvec3 point;
};
using Loop = std::vector<Corner>;

double crossProduct(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

double twiceAreaOf(const Loop& loop) {
  double sum = 0;
  for (size_t k = 0; k < loop.size(); ++k)
    sum += crossProduct(loop[k].flat - loop[0].flat, loop[(k + 1) % loop.size()].flat - loop[0].flat);
  return sum;
}

// Returns whether p lies in the angle that the loop's interior has at corner k.
bool isInAngle(const Loop& loop, size_t k, glm::dvec2 p) {
  const glm::dvec2 at = loop[k].flat, before = loop[(k + loop.size() - 1) % loop.size()].flat - at,
                   after = loop[(k + 1) % loop.size()].flat - at, to = p - at;
  const bool is_reflex = crossProduct(after, before) < 0;
  return is_reflex ? crossProduct(after, to) >= 0 || crossProduct(to, before) >= 0
                   : crossProduct(after, to) >= 0 && crossProduct(to, before) >= 0;
}

bool isInTriangle(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, glm::dvec2 p) {
  const double ab = crossProduct(b - a, p - a), bc = crossProduct(c - b, p - b), ca = crossProduct(a - c, p - c);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

// Returns a corner of the loop that a point within the loop sees; nothing where the point is not within it.
std::optional<size_t> seenFrom(const Loop& loop, glm::dvec2 from) {
  // The ray from the point along x leaves the loop where an edge goes upwards, for the loop runs counter-clockwise.
  double nearest = INFINITY;
  size_t seen = 0;
  for (size_t k = 0; k < loop.size(); ++k) {
    const size_t next = (k + 1) % loop.size();
    const glm::dvec2 a = loop[k].flat, b = loop[next].flat;
    if (a.y > from.y || b.y < from.y || a.y == b.y) continue;
    const double x = a.x + (from.y - a.y) / (b.y - a.y) * (b.x - a.x);
    if (x < from.x || x >= nearest) continue;
    nearest = x;
    seen = a.x > b.x ? k : next;
  }
  if (nearest == INFINITY) return std::nullopt;
  // Corners between the ray and the corner found would hide it. Of these the one nearest to the ray is seen.
  const glm::dvec2 exit(nearest, from.y), behind = loop[seen].flat;
  double least = INFINITY, least_x = INFINITY;
  std::optional<size_t> best;
  for (size_t k = 0; k < loop.size(); ++k) {
    const glm::dvec2 p = loop[k].flat;
    if (p.x < from.x || !isInTriangle(from, exit, behind, p) || !isInAngle(loop, k, from)) continue;
    const double slope = p.x > from.x ? std::abs(p.y - from.y) / (p.x - from.x) : p.y == from.y ? 0 : INFINITY;
    if (best && (slope > least || (slope == least && p.x >= least_x))) continue;
    least = slope, least_x = p.x, best = k;
  }
  return best ? *best : seen;
}

// Returns whether p lies on the edge from a to b, but for rounding, and between its ends.
bool isOnEdge(glm::dvec2 a, glm::dvec2 b, glm::dvec2 p) {
  constexpr double kRounding = 1e-12;  // of coordinates, over the edge's length: they have been turned into the plane
  const glm::dvec2 edge = b - a;
  const double squared = glm::dot(edge, edge), along = glm::dot(p - a, edge);
  return along > 0 && along < squared && std::abs(crossProduct(edge, p - a)) <= kRounding * squared;
}

// Puts a hole into the loop where a corner of the hole touches it. Returns false where none does.
bool joinWhereTouching(Loop& loop, Loop& hole) {
  for (size_t h = 0; h < hole.size(); ++h)
    for (size_t k = 0; k < loop.size(); ++k) {
      const glm::dvec2 a = loop[k].flat, b = loop[(k + 1) % loop.size()].flat, p = hole[h].flat;
      const bool is_corner = p == a && isInAngle(loop, k, hole[(h + 1) % hole.size()].flat);
      if (!is_corner && (p == a || p == b || !isOnEdge(a, b, p))) continue;
      std::rotate(hole.begin(), hole.begin() + static_cast<std::ptrdiff_t>(h), hole.end());
      Loop detour(hole.begin() + is_corner, hole.end());
      detour.push_back(hole.front());
      loop.insert(loop.begin() + static_cast<std::ptrdiff_t>(k) + 1, detour.begin(), detour.end());
      return true;
    }
  return false;
}

// Puts a hole into the loop by a bridge from the hole's first corner. Returns false where the hole is not within it.
bool joinByBridge(Loop& loop, const Loop& hole) {
  const std::optional<size_t> seen = seenFrom(loop, hole.front().flat);
  if (!seen) return false;
  Loop detour = hole;
  detour.push_back(hole.front());
  detour.push_back(loop[*seen]);
  loop.insert(loop.begin() + static_cast<std::ptrdiff_t>(*seen) + 1, detour.begin(), detour.end());
  return true;
}

}  // namespace

BridgedFace bridgeHoles(const std::vector<std::vector<glm::dvec3>>& given) {
  std::vector<std::vector<glm::dvec3>> rings;
  for (const std::vector<glm::dvec3>& ring : given) rings.push_back(withoutRepeats(ring));
  std::vector<glm::dvec3> all;
  for (const std::vector<glm::dvec3>& ring : rings) all.insert(all.end(), ring.begin(), ring.end());
  const std::vector<glm::dvec2> flat = flatten(all, glm::normalize(twiceVectorArea(rings.front())));
  std::vector<Loop> loops;
  for (size_t at = 0; const std::vector<glm::dvec3>& ring : rings) {
    Loop& loop = loops.emplace_back();
    for (const glm::dvec3& point : ring) loop.push_back({flat[at++], point});
  }
  Loop face = std::move(loops.front());
  loops.erase(loops.begin());
  std::erase_if(loops, [](const Loop& hole) { return twiceAreaOf(hole) == 0; });
  for (Loop& hole : loops) {
    if (twiceAreaOf(hole) > 0) std::ranges::reverse(hole);
    std::rotate(hole.begin(), std::ranges::max_element(hole, {}, [](const Corner& c) { return c.flat.x; }), hole.end());
  }
  // Holes are joined from right to left. So a ray to the right of a hole meets the outer ring, or holes that are joined
  // already.
  std::ranges::sort(loops, std::greater(), [](const Loop& hole) { return hole.front().flat.x; });
  BridgedFace bridged;
  for (Loop& hole : loops)
    if (!joinWhereTouching(face, hole) && !joinByBridge(face, hole)) ++bridged.holes_outside;
  for (const Corner& corner : face) bridged.corners.push_back(corner.point);
  return bridged;
}

}  // namespace viewpeel
