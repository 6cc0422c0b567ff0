// Edge integrals add up to the exchange area of two polygons along their contours: docs/method.md, eq. (38).
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

#include "unoccluded/line_rules.h"
#include "unoccluded/shared.h"

namespace viewpeel {

constexpr double kUnitRounding = 2.2e-16;  // relative rounding of double precision

struct Edge {
  glm::dvec3 start{0}, along{0};
};

// Returns whether two edges are parallel, but for rounding of their corners.
bool areParallel(const glm::dvec3& p, const glm::dvec3& q);

// Returns int_p int_q (1 + ln r) ds . dt of parallel edges, in closed form. The 1 adds nothing along two closed
// contours.
//   Out: error: raised by a bound on rounding, of corners too
double integrateParallel(const Edge& p, const Edge& q, double& error);

// EdgeRules integrates over edges in any position.
class EdgeRules {
 public:
  EdgeRules();

  // Returns int_p int_q (1 + ln r) ds . dt. The outer integral, over the shorter edge, is by a Gauss rule.
  //   In: round: of kLineRounds; later rounds have more points
  //   Out: error: raised by a bound on the error of the rule, and by rounding
  double integrate(Edge p, Edge q, size_t round, double& error) const;

 private:
  struct Point {
    double at, weight;
  };
  std::array<std::array<std::vector<Point>, unoccluded_data::kLineRules>, kLineRounds.size()> points_;
};

}  // namespace viewpeel
