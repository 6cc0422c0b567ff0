#include "pair_lines/line_ends.h"

#include <glm/glm.hpp>

namespace viewpeel {
namespace {

using glm::dvec3;

template <class Number>
void store(const dvec3& v, Number* to) {
  for (int axis = 0; axis < 3; ++axis) to[axis] = static_cast<Number>(v[axis]);
}

}  // namespace

dvec3 acrossOf(const Patch& patch) {
  // The diagonals give it, for three of a quadrilateral's corners may lie on one line.
  const dvec3* const c = patch.corners;
  const dvec3 last = patch.corner_count == 3 ? c[0] : c[3];
  return glm::normalize(glm::cross(c[2] - c[0], last - c[1]));
}

BlockerPlace placeFrom(BlockerPlace place, bool is_swapped) {
  if (place == BlockerPlace::between || !is_swapped) return place;
  return place == BlockerPlace::over_first ? BlockerPlace::over_second : BlockerPlace::over_first;
}

template <class Number>
LineEnd<Number> makeLineEnd(const Patch& patch, const dvec3& origin, bool folds) {
  LineEnd<Number> end{};
  end.is_folded = patch.corner_count == 3 && folds;
  // A triangle that is not folded is a square whose last side is collapsed: its last corner is its first one again.
  const dvec3* const c = patch.corners;
  const dvec3 last = patch.corner_count == 3 ? c[0] : c[3];
  const dvec3 side_a = c[1] - c[0], side_b = (end.is_folded ? c[2] : last) - c[0],
              twist = end.is_folded ? dvec3(0) : c[0] - c[1] + c[2] - last;
  store(c[0] - origin, end.corner);
  store(side_a, end.side_a), store(side_b, end.side_b), store(twist, end.twist);
  const dvec3 across = acrossOf(patch);
  end.density[0] = static_cast<Number>(glm::dot(across, glm::cross(side_a, side_b)) / (end.is_folded ? 2 : 1));
  end.density[1] = static_cast<Number>(glm::dot(across, glm::cross(side_a, twist)));
  end.density[2] = static_cast<Number>(glm::dot(across, glm::cross(twist, side_b)));
  store(patch.normal, end.normal);
  end.offset = static_cast<Number>(patch.offset - glm::dot(patch.normal, origin));
  end.edge_count = patch.corner_count;
  for (uint32_t e = 0; e < patch.corner_count; ++e) {
    store(patch.edge_normals[e], end.edges[e]);
    end.edges[e][3] = static_cast<Number>(glm::dot(patch.edge_normals[e], origin) - patch.edge_offsets[e]);
  }
  return end;
}

template <class Number>
std::vector<Obstacle<Number>> makeObstacles(const std::vector<Blocker>& blockers,
                                            std::span<const PlacedBlocker> between, const dvec3& origin,
                                            bool is_swapped) {
  std::vector<Obstacle<Number>> obstacles;
  obstacles.reserve(between.size());
  for (const PlacedBlocker& placed : between) {
    const Blocker& blocker = blockers[placed.blocker];
    Obstacle<Number>& obstacle = obstacles.emplace_back();
    obstacle.place = placeFrom(placed.place, is_swapped);
    obstacle.edge_count = blocker.corner_count;
    store(blocker.normal, obstacle.plane);
    obstacle.plane[3] = static_cast<Number>(glm::dot(blocker.normal, origin) - blocker.offset);
    for (uint32_t e = 0; e < blocker.corner_count; ++e) {
      store(blocker.edge_normals[e], obstacle.edges[e]);
      obstacle.edges[e][3] = static_cast<Number>(glm::dot(blocker.edge_normals[e], origin) - blocker.edge_offsets[e]);
    }
  }
  return obstacles;
}

template LineEnd<float> makeLineEnd(const Patch&, const dvec3&, bool);
template LineEnd<double> makeLineEnd(const Patch&, const dvec3&, bool);
template std::vector<Obstacle<float>> makeObstacles(const std::vector<Blocker>&, std::span<const PlacedBlocker>,
                                                    const dvec3&, bool);
template std::vector<Obstacle<double>> makeObstacles(const std::vector<Blocker>&, std::span<const PlacedBlocker>,
                                                     const dvec3&, bool);

}  // namespace viewpeel
