// The environment has two parts, above and below a horizon: sky and ground. Each row has a form factor to both.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/compute.h>
#include <viewpeel/form_factors.h>
#include <viewpeel/ids.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// An EnvironmentRequest says which rows to measure, which way is up, and how exact their form factors must be.
struct EnvironmentRequest {
  By by = By::polygon;
  bool two_sided = false;
  glm::dvec3 up{0, 0, 1};   // of any length above 0
  double tolerance = 1e-3;  // largest standard error that up, down and all may have, above 0
  uint64_t seed = 1;        // the same seed gives the same bits
  uint32_t threads = 0;     // 0: one for each core
  // The run ends when this time is over, even within a replicate; four small replicates are counted in any case.
  std::optional<double> time_limit_s;
  // The run ends short of the tolerance where its rows need more rays of their own than this, by a rough estimate.
  std::optional<double> most_rays;
  // Form factors to the whole environment, one for each row, where they are known; else empty. The tolerance then holds
  // for them times the standard error of up_share.
  std::vector<double> whole_environment;
};

// EnvironmentParts have the form factors from each row to the parts of the environment above and below the horizon.
// Radiation that leaves the scene along d ends in the part above where dot(d, up) > 0.
struct EnvironmentParts {
  Ids ids;                         // of the rows
  std::vector<Measured> up, down;  // form factors, one for each row
  std::vector<Measured> all;       // up + down
  // Intervals of up and down, from splitEnvironment() with form factors that have intervals; else empty. They hold
  // where the intervals of the form factors do.
  std::vector<Interval> up_intervals, down_intervals;
  // An Extent is what a row's intervals need to know of it.
  struct Extent {
    double up = 0;                   // form factor to the part above with nothing in the way
    double lowest = 0, highest = 0;  // of the row's points along the direction up, unit-ball units
  };
  std::vector<Extent> extents;  // one for each row
  // The share of `up` in a row's environment, up / all; 1/2 +- 1/2 where no line left the row.
  std::vector<Measured> up_share;
  // Errors of different rows are correlated, for all rows have their directions in common. Entry [r][i] is the
  // contribution of replicate r to the error of up_share[i]: the sum of its squares over r is the square of the
  // standard error.
  std::vector<std::vector<double>> up_share_errors;
  uint64_t replicates = 0, directions = 0;  // directions of all replicates together
  uint64_t rows_with_rays = 0, rays = 0;    // rows that have rays of their own, and these rays together
  double largest_standard_error = 0;        // of up, down and all
  bool is_reached = true;                   // false where time or directions ran out before the tolerance was reached
};

// Measures the environment of all rows by common directions, which count nothing else. Rows that these directions
// hardly meet get rays of their own where that is less work.
//   F_i,up = (2 / A_i) E[A'_i,up(u)]. E is the mean over directions u, and A'_i,up(u) the area of the lines along u
//   that leave row i, and then the scene, upwards. Of rays, F_i,up is the share that does so.
//   In: scene; request
//   Out: see EnvironmentParts
//   Error: up and down are unbiased; up_share is a ratio of means, whose bias falls with the number of directions.
//     Standard errors come from 8 replicates, from 4 to 8 where time was up. They are no smaller than the weight of one
//     line; those of rays are also no smaller than what binomial errors and the spread of all such rows suggest.
//     Tests: tests/unit/environment_test.cpp.
//   Throws: Error bad_usage for a direction up of length 0 or a tolerance that is not above 0; Error limit where the
//     observer stops the run.
//   Cost: as many directions as the tolerance takes, up to 2^19 in all; each is a sweep of the scene. A row has up to
//     2^19 rays of 2 us, or of some 0.15 us until its error is 2^-10.
EnvironmentParts measureEnvironment(const Scene& scene, const EnvironmentRequest& request,
                                    const Observer& observer = {});

// Splits each row's form factor to the environment, which another method has computed, by the measured shares. Then up
// + down = all is that form factor.
//   up_i = F_i,environment up_share_i, moved into its interval where there is one (docs/method.md, section 14)
//   In: form_factors: of the rows of `parts`; parts: of the same scene
//   Out: parts with other up, down, all, largest_standard_error and intervals
//   Error: that of the form factor and that of the share, as independent ones. Tests: tests/unit/environment_test.cpp.
//   Throws: Error bad_usage where rows differ in number.    Cost: O(rows log nonzeros).
EnvironmentParts splitEnvironment(const FormFactors& form_factors, EnvironmentParts parts);

// Returns form factors to the environment alone, without any between rows, for writers: OutputContent::parts has sky
// and ground.
//   In: parts: of n rows    Out: n ids, whose row sums are the environment's    Cost: O(rows).
FormFactors environmentAlone(const EnvironmentParts& parts);

}  // namespace viewpeel
