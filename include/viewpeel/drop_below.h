// Small form factors can be left out of a matrix, and each row keeps what they add up to.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// DroppedSums has what was left out of each row.
struct DroppedSums {
  double least = 0;            // form factors below it were left out
  std::vector<Measured> sums;  // of each id, sum of the F_ij left out; the standard errors are taken for independent
  uint64_t pairs = 0;          // left out
};

struct DroppedBelow {
  FormFactors kept;
  DroppedSums dropped;
};

// Leaves out pairs i, j with F_ij and F_ji both below a bound. Environment, leak and row sums stay as they are, so that
// the entries kept, environment, leak and the sum left out add up to the row sum.
//   In: form_factors: n ids; least: in (0, 1)
//   Out: the pairs kept, in the same order, with their intervals. A pair that was left out has the interval from 0 to
//     the largest upper bound of all of them.
//   Error: rounding. Tests: tests/unit/drop_below_test.cpp.    Throws: nothing.    Cost: O(entries).
DroppedBelow dropBelow(const FormFactors& form_factors, double least);

}  // namespace viewpeel
