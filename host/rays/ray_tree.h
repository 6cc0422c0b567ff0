// A RayTree finds the first polygon that each of sixteen rays meets. It is a binary tree of boxes, cut by the surface
// area heuristic (J. Goldsmith, J. Salmon, Automatic creation of object hierarchies for ray tracing, IEEE Comput.
// Graph. Appl. 7(5), 1987).
//
// Coordinates are in single precision. A ray that starts within kRayReach of a polygon's plane, on either side, meets
// the polygon if it arrives on a side that receives. So no ray slips through the edge at which two polygons touch.
#pragma once
#include <cstdint>
#include <vector>

#include "lanes.h"
#include "pair_lines/line_ends.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// Places in single precision err by less than this, in unit-ball units.
constexpr float kRayReach = 3e-7f;

// Rays are sixteen rays from one polygon, and what they meet.
template <class Floats>
struct Rays {
  LaneVector<Floats> start, direction;  // direction: unit length
  uint32_t plane;                       // of the polygon on which they start; its polygons are not met
  Floats distance;                      // to the polygon met; before the search, the largest distance wanted
  Floats facet;                         // 1 + index of the facet met; 0: none
  Floats rank{};                        // of the facet among coincident ones, in the order in which the ray meets them
};

class RayTree {
 public:
  // A Facet is a polygon as rays see it.
  struct Facet {
    float normal[3], offset;  // of the polygon's plane; minus its offset
    float edges[4][4];  // outward normals within the plane, and minus their offsets; a triangle's first edge twice
    float side;         // 1 if the front looks along the plane's normal, else -1
    float level;        // position among the coincident polygons of its plane, along the plane's normal
    uint32_t polygon, plane;
  };

  static Facet facetOf(const Scene& scene, uint32_t polygon);

  // Cost: O(n log^2 n).
  //   In: two_sided: whether backs receive, too
  RayTree(const Scene& scene, bool two_sided);

  const Facet& facet(float number) const { return facets_[static_cast<uint32_t>(number) - 1]; }

  // Finds what the rays meet first.    Cost: some 0.1 us a ray in cities, where rays run side by side
  template <class Floats>
  void meet(Rays<Floats>& rays) const;

 private:
  // A Node is a box around all facets below it. An inner node has two children, next to each other.
  struct Node {
    float low[3], high[3];
    uint32_t first = 0;   // facet, or child
    uint32_t facets = 0;  // number; 0 in an inner node
    int axis = 0;         // of an inner node: the first child lies before the second along it
  };
  struct Item;
  void build(const Scene& scene, std::vector<Item>& items);
  template <class Floats>
  void meetFacet(Rays<Floats>& rays, uint32_t index) const;

  static constexpr int kMostDepth = 256;
  float reach_of_backs_;  // how far a ray may start beyond the plane of a polygon whose back it meets
  std::vector<Node> nodes_;
  std::vector<Facet> facets_;
};

template <class Floats>
VIEWPEEL_INLINE void RayTree::meetFacet(Rays<Floats>& rays, uint32_t index) const {
  const Facet& facet = facets_[index];
  if (facet.plane == rays.plane) return;
  constexpr float kLeastSlope = 1e-12f, kRankStep = 1e-30f, kNumberStep = 3e-38f;
  const Floats none{},
      slope = dot(facet.normal, rays.direction) * facet.side + none;  // + 0: a slope of -0 counts as +0
  // Height of the start above the side on which the ray arrives.
  const Floats height = -withSign((dot(facet.normal, rays.start) + facet.offset) * facet.side, slope);
  const Floats t = height / greatest(sizeOf(slope), Floats(kLeastSlope));
  const LaneVector<Floats> at{rays.start.x + t * rays.direction.x, rays.start.y + t * rays.direction.y,
                              rays.start.z + t * rays.direction.z};
  // A start within rounding of the plane counts as on the side that receives the ray.
  const Floats ahead = height + ifBelow(slope, none, Floats(kRayReach), Floats(reach_of_backs_));
  // Polygons of one plane are met at one distance. The ranks of coincident ones decide, and where two only touch, the
  // numbers of their facets: what a ray meets must not depend on its neighbours, which choose the way through the tree.
  // Distances that differ at all differ by far more than these steps.
  const Floats number(static_cast<float>(index + 1)),
      rank = withSign(Floats(facet.level * facet.side), slope),
      sooner = (rays.distance - t) + (rays.rank - rank) * kRankStep + (rays.facet - number) * kNumberStep;
  const Floats margin = least(least(ahead, sooner), kRayReach - beyond(facet.edges, 4, at));
  rays.distance = ifBelow(none, margin, t, rays.distance);
  rays.rank = ifBelow(none, margin, rank, rays.rank);
  rays.facet = ifBelow(none, margin, number, rays.facet);
}

template <class Floats>
VIEWPEEL_INLINE void RayTree::meet(Rays<Floats>& rays) const {
  constexpr float kLeastPart = 1e-20f;
  const Floats none{}, one(1.0f);
  const auto inverse = [&](const Floats& part) __attribute__((always_inline)) {
    return one / ifBelow(sizeOf(part), Floats(kLeastPart), Floats(kLeastPart), part);
  };
  const LaneVector<Floats> inverses{inverse(rays.direction.x), inverse(rays.direction.y), inverse(rays.direction.z)};
  const bool runs_back[3] = {sumOf(rays.direction.x) < 0, sumOf(rays.direction.y) < 0, sumOf(rays.direction.z) < 0};
  uint32_t waiting[kMostDepth], count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const Node& node = nodes_[waiting[--count]];
    const Floats x0 = (node.low[0] - rays.start.x) * inverses.x, x1 = (node.high[0] - rays.start.x) * inverses.x,
                 y0 = (node.low[1] - rays.start.y) * inverses.y, y1 = (node.high[1] - rays.start.y) * inverses.y,
                 z0 = (node.low[2] - rays.start.z) * inverses.z, z1 = (node.high[2] - rays.start.z) * inverses.z;
    const Floats enter = greatest(greatest(least(x0, x1), least(y0, y1)), greatest(least(z0, z1), none)),
                 leave = least(least(greatest(x0, x1), greatest(y0, y1)), least(greatest(z0, z1), rays.distance));
    if (!isAny(ifAtMost(enter, leave, one, none))) continue;
    for (uint32_t k = node.first; k < node.first + node.facets; ++k) meetFacet(rays, k);
    if (node.facets > 0) continue;
    const uint32_t nearer = runs_back[node.axis] ? 1 : 0;
    waiting[count++] = node.first + 1 - nearer;
    waiting[count++] = node.first + nearer;
  }
}

}  // namespace viewpeel
