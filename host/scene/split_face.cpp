#include "scene/split_face.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

namespace viewpeel {
namespace {

using Flat = std::vector<glm::dvec2>;

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }
double turn(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) { return cross(b - a, c - b); }

bool isPlanar(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal) {
  const glm::dvec3 centre = std::accumulate(corners.begin(), corners.end(), glm::dvec3(0)) / double(corners.size());
  return std::all_of(corners.begin(), corners.end(),
                     [&](const glm::dvec3& c) { return std::abs(glm::dot(c - centre, normal)) <= kPlanarTolerance; });
}

// Returns the rounding error of a turn, a sum of products of two lengths with an error of a few ulps of the unit ball.
double turnSlack(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) { return 4e-16 * (glm::length(b - a) + glm::length(c - b)); }

// Returns whether the loop turns left everywhere, and only once around.
bool isConvex(const Flat& flat, const std::vector<uint32_t>& loop) {
  double turned_rad = 0;
  for (size_t k = 0; k < loop.size(); ++k) {
    const glm::dvec2 a = flat[loop[k]], b = flat[loop[(k + 1) % loop.size()]], c = flat[loop[(k + 2) % loop.size()]];
    if (turn(a, b, c) < -turnSlack(a, b, c)) return false;
    turned_rad += std::atan2(turn(a, b, c), glm::dot(b - a, c - b));
  }
  return std::abs(turned_rad - 2 * std::numbers::pi) < 1;
}

// TestsLeft limits the number of tests, so that no face takes minutes.
class TestsLeft {
 public:
  // Takes `count` tests. Returns false where fewer are left.
  bool take(uint64_t count) {
    if (count > left_) return false;
    left_ -= count;
    return true;
  }

 private:
  uint64_t left_ = kMostTests;
};

// Returns whether the face crosses itself; nothing where the tests run out. Edges are in the order of their least x,
// each tested against edges that begin before it ends.
std::optional<bool> crossesItself(const Flat& flat, TestsLeft& left) {
  const size_t m = flat.size();
  const auto sideOf = [&](size_t edge, size_t point) {
    const glm::dvec2 a = flat[edge], b = flat[(edge + 1) % m], p = flat[point % m];
    const double side = turn(a, b, p);
    return std::abs(side) <= turnSlack(a, b, p) ? 0 : side > 0 ? 1 : -1;
  };
  const auto leastOf = [&](size_t edge) { return std::min(flat[edge].x, flat[(edge + 1) % m].x); };
  const auto mostOf = [&](size_t edge) { return std::max(flat[edge].x, flat[(edge + 1) % m].x); };
  std::vector<uint32_t> order(m);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, leastOf);
  for (size_t first = 0; first < m; ++first) {
    const size_t i = order[first];
    size_t second = first + 1;
    for (; second < m && leastOf(order[second]) <= mostOf(i); ++second) {
      const size_t j = order[second];
      if (sideOf(i, j) * sideOf(i, j + 1) < 0 && sideOf(j, i) * sideOf(j, i + 1) < 0) return true;
    }
    if (!left.take(second - first)) return std::nullopt;
  }
  return false;
}

bool isEar(const Flat& flat, const std::vector<uint32_t>& loop, size_t at) {
  const size_t m = loop.size();
  const glm::dvec2 a = flat[loop[(at + m - 1) % m]], b = flat[loop[at]], c = flat[loop[(at + 1) % m]];
  if (turn(a, b, c) <= turnSlack(a, b, c)) return false;
  for (uint32_t index : loop) {
    const glm::dvec2 p = flat[index];
    if (p == a || p == b || p == c) continue;  // a bridge to a hole repeats corners
    if (cross(b - a, p - a) >= 0 && cross(c - b, p - b) >= 0 && cross(a - c, p - c) >= 0) return false;
  }
  return true;
}

// Returns triangles; an empty list where the face crosses itself, nothing where the tests run out.
std::optional<Pieces> clipEars(const Flat& flat, TestsLeft& left) {
  std::vector<uint32_t> loop(flat.size());
  std::iota(loop.begin(), loop.end(), 0u);
  Pieces triangles;
  while (loop.size() >= 3) {
    const size_t m = loop.size();
    size_t at = 0;
    while (at < m && !isEar(flat, loop, at)) {
      ++at;
      if (!left.take(m)) return std::nullopt;
    }
    if (!left.take(m)) return std::nullopt;
    if (at == m) {
      // No ear is left. A corner on a straight edge bounds no area, so it is removed.
      for (at = 0; at < m; ++at) {
        const glm::dvec2 a = flat[loop[(at + m - 1) % m]], b = flat[loop[at]], c = flat[loop[(at + 1) % m]];
        if (std::abs(turn(a, b, c)) <= turnSlack(a, b, c)) break;
      }
      if (at == m) return Pieces{};
    } else {
      triangles.push_back({loop[(at + m - 1) % m], loop[at], loop[(at + 1) % m]});
    }
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return triangles;
}

// Removes each diagonal if the two pieces beside it join to a convex piece.
Pieces mergePieces(const Flat& flat, Pieces pieces) {
  std::map<std::pair<uint32_t, uint32_t>, size_t> owner;  // the piece with this directed edge
  for (size_t p = 0; p < pieces.size(); ++p)
    for (size_t k = 0; k < pieces[p].size(); ++k) owner[{pieces[p][k], pieces[p][(k + 1) % pieces[p].size()]}] = p;
  std::vector<std::pair<uint32_t, uint32_t>> diagonals;
  for (const auto& [edge, piece] : owner)
    if (edge.first < edge.second && owner.count({edge.second, edge.first})) diagonals.push_back(edge);
  for (const auto& [a, b] : diagonals) {
    const size_t p = owner[{a, b}], q = owner[{b, a}];
    std::vector<uint32_t> first = pieces[p], second = pieces[q];
    // The first list becomes b ... a, the second a ... b; the joined list has each of a and b once.
    std::rotate(first.begin(), std::find(first.begin(), first.end(), b), first.end());
    std::rotate(second.begin(), std::find(second.begin(), second.end(), a), second.end());
    first.insert(first.end(), second.begin() + 1, second.end() - 1);
    if (!isConvex(flat, first)) continue;
    for (size_t k = 0; k < first.size(); ++k) owner[{first[k], first[(k + 1) % first.size()]}] = p;
    pieces[p] = std::move(first);
    pieces[q].clear();
  }
  std::erase_if(pieces, [](const auto& piece) { return piece.empty(); });
  return pieces;
}

}  // namespace

std::vector<glm::dvec3> withoutRepeats(std::vector<glm::dvec3> loop) {
  loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
  while (loop.size() > 1 && loop.back() == loop.front()) loop.pop_back();
  return loop;
}

glm::dvec3 twiceVectorArea(const std::vector<glm::dvec3>& corners) {
  glm::dvec3 sum(0);
  for (size_t k = 1; k + 1 < corners.size(); ++k)
    sum += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
  return sum;
}

std::vector<glm::dvec2> flatten(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal) {
  const glm::dvec3 helper = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, normal)), y = glm::cross(normal, x);
  std::vector<glm::dvec2> flat;
  for (const glm::dvec3& corner : corners)
    flat.push_back({glm::dot(corner - corners[0], x), glm::dot(corner - corners[0], y)});
  return flat;
}

std::optional<Pieces> splitFace(const std::vector<glm::dvec3>& corners) {
  if (corners.size() > kMostCorners) return std::nullopt;
  std::vector<uint32_t> whole(corners.size());
  std::iota(whole.begin(), whole.end(), 0u);
  if (corners.size() == 3) return Pieces{whole};
  const glm::dvec3 normal = glm::normalize(twiceVectorArea(corners));
  const Flat flat = flatten(corners, normal);
  const bool planar = isPlanar(corners, normal);
  if (planar && isConvex(flat, whole)) return Pieces{whole};
  TestsLeft left;
  const std::optional<bool> crosses = crossesItself(flat, left);
  if (!crosses) return std::nullopt;
  if (*crosses) return Pieces{};
  std::optional<Pieces> triangles = clipEars(flat, left);
  return planar && triangles ? mergePieces(flat, std::move(*triangles)) : triangles;
}

}  // namespace viewpeel
