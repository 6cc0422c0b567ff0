// The form factor of two convex polygons with nothing between them is estimated from random projections.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel::reference {

// A ProjectedPair computes one direction's term of F from polygon a to polygon b, fronts only:
//   zeta(u) = 2/A area(projections of a and b along u, intersected), where u or -u leaves a's front and arrives at b's
//   front, else 0.
// The area counts only lines that meet a first. F is the mean of zeta over directions uniform on the sphere.
class ProjectedPair {
 public:
  //   In: convex planar polygons of 3 or more corners, counter-clockwise seen from the front, any unit.
  //   Throws: Error bad_input (a degenerate polygon).
  //   Cost: O(corners squared), for the check of convexity.
  ProjectedPair(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b);

  // Returns zeta(u).
  //   In: u of unit length    Out: 0 to 2
  //   Error: 2e-14 / A, A the area of a where the pair fits in the unit ball. tests/unit/projected_estimate_test.cpp.
  //   Cost: O(corners_a corners_b).
  //   Source: Pellegrini as below.
  double zeta(const glm::dvec3& u) const;

 private:
  struct FlatPolygon {
    std::vector<glm::dvec3> corners;
    glm::dvec3 normal{0};
  };
  FlatPolygon a_, b_;
  double area_ = 0;  // of a
};

struct ProjectedEstimate {
  double value = 0;
  double standard_error = 0;  // from the sample's spread
};

// Estimates F from polygon a to polygon b, fronts only, from N independent uniform directions u:
//   F ~ 1/N sum_u zeta(u).
//   In: convex planar polygons of 3 or more corners, counter-clockwise seen from the front, any unit; direction_count
//     of 2 or more.
//   Out: the mean, and its standard error.
//   Error: unbiased; the standard deviation of one term is at most sqrt(v(F)) with v(F) = 4/3 (1 - (1-F)^(3/2)) - F^2.
//     This deviation is at most 0.798, so the standard error's expectation is at most 0.798 / sqrt(N).
//     tests/unit/projected_estimate_test.cpp.
//   Throws: Error bad_input (a degenerate polygon, fewer than 2 directions).
//   Cost: O(N corners_a corners_b).
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, Discrete &
//     Computational Geometry 17, 1997, section 4.1, procedure ff(A, B).
ProjectedEstimate estimateFormFactor(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b,
                                     uint64_t direction_count, uint64_t seed);

}  // namespace viewpeel::reference
