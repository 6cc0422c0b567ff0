// dropBelow() leaves small form factors out of a matrix. Each row keeps the sum of the form factors it lost.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// DroppedSums says how much was left out of each row.
struct DroppedSums {
  double least = 0;            // smaller form factors were left out
  std::vector<Measured> sums;  // by id: sum of the F_ij left out; their standard errors are taken as independent
  uint64_t pairs = 0;          // number of pairs left out
};

struct DroppedBelow {
  FormFactors kept;
  DroppedSums dropped;
};

// Leaves out pairs whose F_ij and F_ji are both below a bound. Environment, leak and row sums stay the same: a row's
// sum is what it keeps, with environment and leak, plus the sum left out.
//   In: form_factors: n ids; least: in (0, 1)
//   Out: the pairs kept, in the same order, with their intervals. A pair that was left out has the interval from 0 to
//     the largest upper bound of all of them.
//   Error: rounding. Tests: tests/unit/drop_below_test.cpp.    Throws: nothing.    Cost: O(entries).
DroppedBelow dropBelow(const FormFactors& form_factors, double least);

}  // namespace viewpeel
