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

// An EdgeSum adds up integrals over pairs of edges. It gathers points of their outer integrals, and evaluates many at
// once, in vectors.
struct EdgeSum {
  static constexpr size_t kMostPoints = 256;  // at least the points of any rule

  double value = 0;
  double error = 0;     // of rules and closed forms, and of as much rounding as the kernels allow for
  double rounding = 0;  // the rest of a bound on rounding

  // Each point of an edge p is this far along the edge q from its start, and back from its end, and this far from the
  // line of q. The weight is that of the inner integral in the value.
  std::array<double, kMostPoints> along, rest, distance, weight;
  size_t count = 0;  // of points whose integrals are still to be added

  // Adds the integrals at the points to value, error and rounding, and forgets the points.
  void evaluate();
};

// EdgeRules integrates over edges in any position.
class EdgeRules {
 public:
  EdgeRules();

  // Adds int_p int_q (1 + ln r) ds . dt to a sum that is to be evaluated afterwards. The outer integral, over the
  // shorter edge, is by a Gauss rule.
  //   In: round: of kLineRounds; later rounds have more points
  //   Out: sum: its value and errors are raised
  void add(Edge p, Edge q, size_t round, EdgeSum& sum) const;

 private:
  struct Rule {
    std::vector<double> at, weight;
  };
  std::array<std::array<Rule, unoccluded_data::kLineRules>, kLineRounds.size()> rules_;
};

}  // namespace viewpeel
