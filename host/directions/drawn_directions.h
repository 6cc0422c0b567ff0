// Questions narrower than all pairs draw their own directions: for one pair of surfaces, or for one emitter.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// A DirectionRegion is a convex spherical polygon: directions u, of which it never holds both u and -u but on its
// boundary. Opposite directions carry the same lines, so a region that holds u or -u of every line of a pair is all
// that the pair needs.
class DirectionRegion {
 public:
  // The default region has no direction at all.
  DirectionRegion() = default;
  // Returns the half sphere dot(pole, u) >= 0, whose lines may meet any pair.    In: pole of unit length
  static DirectionRegion hemisphere(const glm::dvec3& pole);

  // Keeps the part with dot(inner_normal, u) >= 0.    In: inner_normal of unit length
  void clip(const glm::dvec3& inner_normal);
  // Prepares solidAngle() and map(). To be called after the last clip().
  void close();

  bool isEmpty() const { return arcs_.empty(); }
  double solidAngle() const { return arcs_.empty() ? 0 : arcs_.back().solid_angle_to_here; }  // 2 pi for a hemisphere
  // Returns true for directions of the region or within rounding of it, 1e-14 rad.
  bool contains(const glm::dvec3& u) const;

  // Maps the unit square onto the region, areas in proportion.
  //   The coordinate `around` runs along the boundary, and `outwards` from the centre to it. So map(0, t) = map(1, t),
  //     map(s, 0) is one point, and map(s, 1) the boundary.
  //   In: around, outwards in [0, 1]; a region closed and not empty    Out: a unit vector
  //   Error: 1e-15 rad of directions; shares of area to 1e-15 / solidAngle(). tests/unit/drawn_directions_test.cpp.
  //   Cost: O(log corners).
  //   Source: J. Arvo, Stratified sampling of spherical triangles, SIGGRAPH 1995, with every triangle cut by the
  //     perpendicular from the centre. A right triangle of legs p, q has area 2 atan(tan(p/2) tan(q/2)) (I. Todhunter,
  //     Spherical Trigonometry, 1886, 103), which keeps its digits however small the triangle.
  glm::dvec3 map(double around, double outwards) const;

 private:
  // An Arc goes from `from` to the next arc's `from`, at most a quarter of a great circle, the region on its left,
  // where inner_normal points.
  struct Arc {
    glm::dvec3 from, inner_normal;
    // The method close() sets these vectors. They are the circle's point nearest to the centre, and the way the arc
    // runs there. Then follow tan(p/2) of the distance p between, and the signed area of the right triangle that ends
    // at the arc's start. Last come the areas of all arcs to this one's end.
    glm::dvec3 foot{0}, along{0};
    double half_tangent = 0, first_area = 0, solid_angle_to_here = 0;
  };
  std::vector<Arc> arcs_;
  glm::dvec3 centre_{0};
};

// Returns the directions along which a line can leave a front of `a` and arrive at a front of `b`, or a region that
// holds them.
//   For two convex polygons, each clipped to the front of the other's plane, it is the cone of all q - p with p in a
//     and q in b: the paper's anti-convex hull. One great circle for each edge cuts it out of the wedge of the two
//     planes.
//   For anything else, or two-sided, it is the convex hull of such cones where they fit in a half sphere. Else it is
//     the wedge of the planes of a and b where each is planar, else a half sphere.
//   It is empty where no front of one sees a front of the other: F = 0. Polygons of one plane that face and overlap
//     have zero distance and F > 0 by the rules of facing.h: a half sphere.
//   In: a, b indices of Scene::polygons, any number; two_sided as in Ids
//   Out: the region, closed. F_ab = solidAngle / (2 pi) x mean of 2 A'_ab(u) / A_a over u uniform in it.
//   Error: never smaller than the exact region but for slivers of grazing lines. Their pair area is less than 1e-14 of
//     the pair's extent squared (1e-7 where corners are off their plane by the tolerance of group_planes.h). For two
//     convex polygons that far apart or further it is larger by at most 1e-13 rad for each unit of extent / distance.
//     tests/unit/drawn_directions_test.cpp.
//   Throws: nothing.
//   Cost: O(c_a c_b) for c_a, c_b corners for two convex polygons; O(c log c), c = min(c_a c_b, 2^20), else: larger
//     surfaces enter by their bounding boxes.
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, section 4.2.
DirectionRegion findPairRegion(const Scene& scene, std::span<const uint32_t> a, std::span<const uint32_t> b,
                               bool two_sided = false);

// DrawnDirections do not count alike: C_ab = E[A'_ab] ~ weight_unit x sum over k of weights[k] A'_ab(directions[k]) /
// directions.size(), F_ab = 2 C_ab / A_a.
struct DrawnDirections {
  std::vector<Direction> directions;
  std::vector<uint32_t> weights;  // as many
  double weight_unit = 1;
};

// Draws the directions of one replicate: a randomly shifted lattice of points in the region.
//   The expected share of points in any part of the region is the part's share of solid angle. Each direction has a
//     lattice offset uniform in [0, 1)^2 and a lattice rotation uniform about u.
//   In: count > 0; seed, replicate: any
//   Out: count directions, weights 1, weight_unit = solidAngle / (2 pi); no directions and weight_unit 0 where the
//     region is empty. A function of the arguments only.
//   Error: the mean over the set is unbiased for pairs whose directions the region holds, and for no others; a single
//     direction's term is not. Tests: tests/unit/drawn_directions_test.cpp.
//   Throws: nothing.
//   Cost: O(count log corners).
//   Source: rank-1 lattice of the golden ratio, random shift: R. Cranley & T. N. L. Patterson, SIAM J. Numer. Anal. 13,
//     1976. It is folded in the coordinate in which the integrand is not periodic: F. J. Hickernell, Obtaining
//     O(N^(-2+eps)) convergence for lattice quadrature rules, MCQMC 2000.
DrawnDirections sampleRegion(const DirectionRegion& region, uint32_t count, uint64_t seed, uint64_t replicate);

// This share e of an emitter's density is uniform; weights are at most its inverse. The value was measured:
// docs/method.md, after eq. (11).
constexpr double kUniformShare = 1.0 / 4;
constexpr double kEmitterWeightUnit = 0x1p-12;

// Draws the directions of one replicate for all pairs of an emitter of one normal n, by eq. (11) of docs/method.md with
// e = kUniformShare. Weights are in units of kEmitterWeightUnit, rounded up or down at random by their fraction. An
// emitter whose polygons have several normals gets sampleDirections(Sampler::fibonacci), weights and weight_unit 1.
//   In: emitter: indices of Scene::polygons, one or more; count > 0; seed, replicate: any
//   Out: count directions with offset and rotation as above; weights in [2^11, 2^14]. A function of the arguments only.
//   Error: the mean over the set is unbiased for every pair of the scene, the emitter's or not. With exact areas one
//     direction's term of F_emitter,j is at most 2 / (2 - e), against 2 for uniform directions. Tests:
//     tests/unit/drawn_directions_test.cpp.
//   Throws: nothing.
//   Cost: O(count).
//   Source: defensive mixture: T. Hesterberg, Weighted average importance sampling and defensive mixture distributions,
//     Technometrics 37, 1995; lattice as in sampleRegion.
DrawnDirections sampleEmitter(const Scene& scene, std::span<const uint32_t> emitter, uint32_t count, uint64_t seed,
                              uint64_t replicate);

}  // namespace viewpeel
