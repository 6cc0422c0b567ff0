// A RayTree finds the first polygon that each of sixteen rays meets. It is a binary tree of boxes, cut by the surface
// area heuristic (J. Goldsmith, J. Salmon, Automatic creation of object hierarchies for ray tracing, IEEE Comput.
// Graph. Appl. 7(5), 1987).
//
// Rays are in single precision, relative to a corner of the polygon on which they start. Planes are in double
// precision, so that their offsets from this corner are good to a single-precision rounding of the offset itself. So
// rays from a polygon a hand wide are right in a city of kilometres. A ray that starts behind a plane, but within its
// polygon's reach, meets what lies in the plane. So no ray slips through the edge at which two polygons touch. But
// where all of its polygon lies behind the plane, the ray meets nothing there: the outer sides of a thin wedge see
// nothing of each other.
#pragma once
#include <cstdint>
#include <vector>

#include "lanes.h"
#include "pair_lines/line_ends.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// Places in the unit ball err by less than kRayReach in single precision. A polygon's reach is kReachOfWidth of its
// width, and at most kRayReach. Up to the share kReachOfWidth of its rays starts within reach of an edge. Such a ray
// may meet or miss the neighbour at this edge by mistake.
constexpr float kRayReach = 3e-7f;
constexpr double kReachOfWidth = 0x1p-12;
// Places far from a ray's start err by less than this share of their distance. A ray meets a polygon up to its reach
// beyond its edges, and near the ray's start up to the reach of the ray's polygon.
constexpr float kReachOfDistance = 0x1p-20f;

// Returns the reach of a polygon, in unit-ball units.
float reachOf(const Scene& scene, const Polygon& polygon);

// Rays are sixteen rays from one polygon, and what they meet.
template <class Floats>
struct Rays {
  glm::dvec3 origin;                    // a corner of their polygon
  const LaneVector<float>* corners;     // float3[3], the other corners, relative to the origin
  LaneVector<Floats> start, direction;  // start: relative to the origin; direction: unit length
  float reach;                          // of their polygon
  uint32_t plane;                       // of the polygon on which they start; its polygons are not met
  Floats distance;                      // to the polygon met; before the search, the largest distance wanted
  Floats facet;                         // 1 + index of the facet met; 0: none
  Floats rank{};                        // of the facet among coincident ones, in the order in which the ray meets them
};

class RayTree {
 public:
  // A Facet is a polygon as rays see it.
  struct Facet {
    // The normal of the plane, and the outward normals of the edges within it. A triangle has its first edge twice.
    float normal[3], edges[4][3];
    double planes[4][5];  // normals of plane and edges by axis, and minus their offsets
    float reach;          // of the polygon
    float side;           // 1 if the front looks along the plane's normal, else -1
    float level;          // position among the coincident polygons of its plane, along the plane's normal
    uint32_t polygon, plane;

    // Sets offsets: float[5], minus the offsets of plane and edges from this origin.
    VIEWPEEL_INLINE void setOffsets(const glm::dvec3& origin, float* offsets) const {
      for (int k = 0; k < 5; ++k)
        offsets[k] = static_cast<float>(planes[0][k] * origin.x + planes[1][k] * origin.y + planes[2][k] * origin.z +
                                        planes[3][k]);
    }
    // Returns how far beyond the edges places are, relative to the origin of the offsets.
    template <class Lanes>
    VIEWPEEL_INLINE Lanes beyondEdges(const float* offsets, const LaneVector<Lanes>& at) const {
      Lanes most = dot(edges[0], at) + offsets[1];
      for (int e = 1; e < 4; ++e) most = greatest(most, dot(edges[e], at) + offsets[1 + e]);
      return most;
    }
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
  void meetAll(Rays<Floats>& rays, bool with_heights) const;
  template <class Floats>
  void meetFacet(Rays<Floats>& rays, uint32_t index, bool with_heights) const;
  template <class Floats>
  static Floats heightOfPolygon(const Rays<Floats>& rays, const Facet& facet, float offset, const Floats& slope);

  static constexpr int kMostDepth = 256;
  // How far on the wrong side a ray may start that meets a back, in reaches of its polygon; -1: on the right side only,
  // and at least a reach from the plane.
  float reach_of_backs_;
  std::vector<Node> nodes_;
  std::vector<Facet> facets_;
};

// Returns how high the rays' polygon reaches above the side of a facet on which each ray arrives.
//   In: offset: of the facet's plane from the rays' origin; slope: of rays against the facet's front
template <class Floats>
VIEWPEEL_INLINE Floats RayTree::heightOfPolygon(const Rays<Floats>& rays, const Facet& facet, float offset,
                                                const Floats& slope) {
  float lowest = offset, highest = offset;
  for (int k = 0; k < 3; ++k) {
    const float height = dot(facet.normal, rays.corners[k]) + offset;
    lowest = least(lowest, height), highest = greatest(highest, height);
  }
  const bool is_along = facet.side > 0;
  return ifBelow(slope, Floats{}, Floats(is_along ? highest : -lowest), Floats(is_along ? -lowest : highest));
}

//   In: with_heights: whether a ray that starts behind the plane meets only what its polygon reaches above
template <class Floats>
VIEWPEEL_INLINE void RayTree::meetFacet(Rays<Floats>& rays, uint32_t index, bool with_heights) const {
  const Facet& facet = facets_[index];
  if (facet.plane == rays.plane) return;
  float offsets[5];  // from the rays' origin
  facet.setOffsets(rays.origin, offsets);
  constexpr float kLeastSlope = 1e-12f, kRankStep = 1e-30f, kNumberStep = 3e-38f;
  const Floats none{},
      slope = dot(facet.normal, rays.direction) * facet.side + none;  // + 0: a slope of -0 counts as +0
  // Height of the start above the side on which the ray arrives.
  const Floats height = -withSign((dot(facet.normal, rays.start) + offsets[0]) * facet.side, slope);
  const Floats t = height / greatest(sizeOf(slope), Floats(kLeastSlope));
  const LaneVector<Floats> at{rays.start.x + t * rays.direction.x, rays.start.y + t * rays.direction.y,
                              rays.start.z + t * rays.direction.z};
  // A start within reach of the plane counts as on the side that receives the ray.
  const Floats ahead = height + ifBelow(slope, none, Floats(rays.reach), Floats(reach_of_backs_ * rays.reach));
  // Polygons of one plane are met at one distance. The ranks of coincident ones decide, and where two only touch, the
  // numbers of their facets: what a ray meets must not depend on its neighbours, which choose the way through the tree.
  // Distances that differ at all differ by far more than these steps.
  const Floats number(static_cast<float>(index + 1)),
      rank = withSign(Floats(facet.level * facet.side), slope),
      sooner = (rays.distance - t) + (rays.rank - rank) * kRankStep + (rays.facet - number) * kNumberStep;
  const Floats reach = least(rays.reach + t * kReachOfDistance, Floats(facet.reach)),
               most = least(least(ahead, sooner), reach - facet.beyondEdges(offsets, at));
  Floats margin = most;
  if (with_heights) [[unlikely]]
    margin = ifBelow(rays.reach, heightOfPolygon(rays, facet, offsets[0], slope), most, least(most, height));
  rays.distance = ifBelow(none, margin, t, rays.distance);
  rays.rank = ifBelow(none, margin, rank, rays.rank);
  rays.facet = ifBelow(none, margin, number, rays.facet);
}

template <class Floats>
VIEWPEEL_INLINE void RayTree::meet(Rays<Floats>& rays) const {
  const Rays<Floats> before = rays;
  meetAll(rays, false);
  // Few rays meet something at a distance below 0, which takes heights to decide.
  if (isAnyBelow(rays.distance, Floats{})) [[unlikely]] {
    rays = before;
    meetAll(rays, true);
  }
}

template <class Floats>
VIEWPEEL_INLINE void RayTree::meetAll(Rays<Floats>& rays, bool with_heights) const {
  constexpr float kLeastPart = 1e-20f;
  const Floats none{}, one(1.0f);
  const auto inverse = [&](const Floats& part) __attribute__((always_inline)) {
    return one / ifBelow(sizeOf(part), Floats(kLeastPart), Floats(kLeastPart), part);
  };
  const LaneVector<Floats> inverses{inverse(rays.direction.x), inverse(rays.direction.y), inverse(rays.direction.z)};
  const LaneVector<Floats> from{rays.start.x + static_cast<float>(rays.origin.x),
                                rays.start.y + static_cast<float>(rays.origin.y),
                                rays.start.z + static_cast<float>(rays.origin.z)};
  const bool runs_back[3] = {sumOf(rays.direction.x) < 0, sumOf(rays.direction.y) < 0, sumOf(rays.direction.z) < 0};
  uint32_t waiting[kMostDepth], count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const Node& node = nodes_[waiting[--count]];
    const Floats x0 = (node.low[0] - from.x) * inverses.x, x1 = (node.high[0] - from.x) * inverses.x,
                 y0 = (node.low[1] - from.y) * inverses.y, y1 = (node.high[1] - from.y) * inverses.y,
                 z0 = (node.low[2] - from.z) * inverses.z, z1 = (node.high[2] - from.z) * inverses.z;
    const Floats enter = greatest(greatest(least(x0, x1), least(y0, y1)), greatest(least(z0, z1), none)),
                 leave = least(least(greatest(x0, x1), greatest(y0, y1)), least(greatest(z0, z1), rays.distance));
    if (!isAnyAtMost(enter, leave)) continue;
    for (uint32_t k = node.first; k < node.first + node.facets; ++k) meetFacet(rays, k, with_heights);
    if (node.facets > 0) continue;
    const uint32_t nearer = runs_back[node.axis] ? 1 : 0;
    waiting[count++] = node.first + 1 - nearer;
    waiting[count++] = node.first + nearer;
  }
}

}  // namespace viewpeel
