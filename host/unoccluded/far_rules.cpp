#include "unoccluded/far_rules.h"

#include "unoccluded/gauss.h"

namespace viewpeel {
namespace {

// Returns binomial(n, 3).
double binomialOf3(int n) { return double(n) * (n - 1) * (n - 2) / 6; }

}  // namespace

unoccluded_data::FarBound farBound(int n) {
  const double error = largestMonomialError(n);
  // From one even power k to the next, the binomials in each of the three sums grow by at most the last factor
  // (`tail`).
  return {float(error * binomialOf3(2 * n + 3)), float(error * binomialOf3(2 * n + 2)),
          float(error * binomialOf3(2 * n + 1)), float(binomialOf3(2 * n + 3) / binomialOf3(2 * n + 1))};
}

}  // namespace viewpeel
