// For a question about one pair of surfaces, or one emitter, directions are drawn only where they matter for it.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// A DirectionRegion is a convex polygon on the sphere of directions u. It never holds both u and -u, except on its
// boundary. Opposite directions have the same lines. So a pair needs only a region that holds u or -u for the direction
// u of each of its lines.
class DirectionRegion {
 public:
  // Makes a region without directions.
  DirectionRegion() = default;
  // Returns the half sphere dot(pole, u) >= 0, which serves any pair.    In: pole: a unit vector
  static DirectionRegion hemisphere(const glm::dvec3& pole);

  // Removes the part with dot(inner_normal, u) < 0.    In: inner_normal: a unit vector
  void clip(const glm::dvec3& inner_normal);
  // Prepares solidAngle() and map(). It must be called after the last clip().
  void close();

  bool isEmpty() const { return arcs_.empty(); }
  // Returns the solid angle in sr, 2 pi for a half sphere.
  double solidAngle() const { return arcs_.empty() ? 0 : arcs_.back().solid_angle_to_here; }
  // Returns whether u is a direction of the region, or within 1e-14 rad of it, which allows for rounding.
  bool contains(const glm::dvec3& u) const;

  // Maps the unit square onto the region, so that solid angles are in proportion to areas.
  //   The coordinate `around` runs along the boundary, and `outwards` from the centre to it. So map(0, t) = map(1, t),
  //     map(s, 0) is the centre for all s, and map(s, 1) is the boundary.
  //   In: around, outwards: numbers in [0, 1]; the region must be closed and not empty    Out: a unit vector
  //   Error: 1e-15 rad of directions; shares of area to 1e-15 / solidAngle(). tests/unit/drawn_directions_test.cpp.
  //   Cost: O(log corners).
  //   Source: J. Arvo, Stratified sampling of spherical triangles, SIGGRAPH 1995, with every triangle cut by the
  //     perpendicular from the centre. A right triangle of legs p, q has area 2 atan(tan(p/2) tan(q/2)) (I. Todhunter,
  //     Spherical Trigonometry, 1886, 103), which keeps its digits however small the triangle.
  glm::dvec3 map(double around, double outwards) const;

 private:
  // An Arc goes from `from` to the next arc's `from`, at most a quarter of a great circle. The region is on its left,
  // where inner_normal points.
  struct Arc {
    glm::dvec3 from, inner_normal;
    // close() sets the members from here on. `foot` is the point of the great circle that is nearest to the region's
    // centre, and `along` is the direction in which the arc runs there. half_tangent is tan(p / 2), with p the angle
    // between centre and foot. first_area is the signed solid angle of the right triangle of centre, foot and `from`.
    // solid_angle_to_here is the solid angle of the triangles over all arcs up to this one.
    glm::dvec3 foot{0}, along{0};
    double half_tangent = 0, first_area = 0, solid_angle_to_here = 0;
  };
  std::vector<Arc> arcs_;
  glm::dvec3 centre_{0};
};

// Returns a region that holds all directions along which a line can leave a front of `a` and arrive at a front of `b`.
//   For two convex polygons, each clipped to the front of the other's plane, it is the cone of all q - p with p in a
//     and q in b. This is the paper's anti-convex hull. One great circle for each edge cuts it out of the wedge of the
//     two planes.
//   For several polygons, or two-sided ones, it is the convex hull of such cones, if they fit in a half sphere.
//     Otherwise it is the wedge of the planes of a and b if each is planar, or a half sphere.
//   It is empty where no front of one can see a front of the other, so that F = 0. Polygons of one plane that face each
//     other and overlap have F > 0 by the rules of facing.h; their region is a half sphere.
//   In: a, b: indices of Scene::polygons, any number; two_sided: as in Ids
//   Out: the region, closed. F_ab = solidAngle / (2 pi) x mean of 2 A'_ab(u) / A_a over u uniform in it.
//   Error: it lacks at most slivers of grazing lines, of an area of less than 1e-14 of the pair's extent squared. The
//     factor is 1e-7 where corners are off their plane by the tolerance of group_planes.h. For two convex polygons that
//     are at least as far apart as this, it is too large by at most 1e-13 rad for each unit of extent / distance.
//     tests/unit/drawn_directions_test.cpp.
//   Throws: nothing.
//   Cost: O(c_a c_b) for two convex polygons of c_a and c_b corners; otherwise O(c log c) with c = min(c_a c_b, 2^20),
//     for surfaces with more pairs of corners are replaced by their bounding boxes.
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, section 4.2.
DirectionRegion findPairRegion(const Scene& scene, std::span<const uint32_t> a, std::span<const uint32_t> b,
                               bool two_sided = false);

// DrawnDirections are directions with weights. The estimate of C_ab = E[A'_ab] is
//   weight_unit x sum over k of weights[k] A'_ab(directions[k]) / directions.size(),      F_ab = 2 C_ab / A_a.
struct DrawnDirections {
  std::vector<Direction> directions;
  std::vector<uint32_t> weights;  // uint32_t[directions]
  double weight_unit = 1;
};

// Draws the directions of one replicate in a region: a randomly shifted lattice of points.
//   Any part of the region has an expected share of the points that is its share of the solid angle. Each direction has
//     a lattice offset uniform in [0, 1)^2 and a lattice rotation uniform about u.
//   In: count: number of directions, above 0; seed, replicate: any
//   Out: count directions of weight 1, with weight_unit = solidAngle / (2 pi); no directions and weight_unit 0 where
//     the region is empty. The same arguments give the same bits.
//   Error: the mean over the set is unbiased for pairs all of whose directions the region holds, and for no others. The
//     term of a single direction is not unbiased. Tests: tests/unit/drawn_directions_test.cpp.
//   Throws: nothing.
//   Cost: O(count log corners).
//   Source: rank-1 lattice of the golden ratio, random shift: R. Cranley & T. N. L. Patterson, SIAM J. Numer. Anal. 13,
//     1976. It is folded in the coordinate in which the integrand is not periodic: F. J. Hickernell, Obtaining
//     O(N^(-2+eps)) convergence for lattice quadrature rules, MCQMC 2000.
DrawnDirections sampleRegion(const DirectionRegion& region, uint32_t count, uint64_t seed, uint64_t replicate);

// This is e of eq. (11), the share of an emitter's directions that is uniform over the half sphere. Weights are at most
// 1 / e. docs/method.md has the measurements behind the value.
constexpr double kUniformShare = 1.0 / 4;
constexpr double kEmitterWeightUnit = 0x1p-12;

// Draws the directions of one replicate for all pairs of an emitter, by eq. (11) of docs/method.md with e =
// kUniformShare. Weights are in units of kEmitterWeightUnit, rounded up or down at random by their fraction. An emitter
// whose polygons have several normals gets sampleDirections(Sampler::fibonacci), with weights and weight_unit 1.
//   In: emitter: indices of Scene::polygons, one or more; count: number of directions, above 0; seed, replicate: any
//   Out: count directions, with lattices as in sampleRegion; weights in [2^11, 2^14]. The same arguments give the same
//     bits.
//   Error: the mean over the set is unbiased for every pair of the scene, not only for the emitter's. With exact areas
//     the term of one direction in F_emitter,j is at most 2 / (2 - e), against 2 for uniform directions. Tests:
//     tests/unit/drawn_directions_test.cpp.
//   Throws: nothing.
//   Cost: O(count).
//   Source: defensive mixture: T. Hesterberg, Weighted average importance sampling and defensive mixture distributions,
//     Technometrics 37, 1995; lattice as in sampleRegion.
DrawnDirections sampleEmitter(const Scene& scene, std::span<const uint32_t> emitter, uint32_t count, uint64_t seed,
                              uint64_t replicate);

}  // namespace viewpeel
