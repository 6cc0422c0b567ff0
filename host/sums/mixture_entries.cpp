#include "sums/mixture_entries.h"

#include <algorithm>
#include <cmath>

#include "sums/line_form_factors.h"

namespace viewpeel {

// Returns the entry of a pair that common directions counted. Between polygons it is cut to kMostOfCounted times the
// least form factor with lines, from the smaller polygon. A replicate's directions meet such a pair less than once on
// average (mixtureFor). Of thousands of rows some have replicates that agree by chance. So an environment by rays errs
// by no less than the efficiency of all rows makes of its binomial variance.
FormFactors::Entry MixtureEntries::countedEntry(const ReplicateSums::PairSum& pair) const {
  Measured exchange = counted_.exchangeArea(pair, measure_area_, count_area_, pair.j < kEnvironment);
  if (pair.j < kEnvironment) {
    const double largest = lines_.leastFormFactor() * counted_.ids().smallerArea(pair.i, pair.j);
    exchange.value = std::min(exchange.value, kMostOfCounted * largest);
    exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, largest));
  } else if (ray_efficiency_ > 0) {
    const double binomial = counted_.binomialVariance(pair.i, exchange.value, measure_area_, count_area_);
    exchange.standard_error = std::max(exchange.standard_error, std::sqrt(ray_efficiency_ * binomial));
  }
  // Rays of different polygons are independent, so that sums over many pairs err by the spread of each.
  const double in_sums = counted_.countsRays() && pair.j < kEnvironment ? counted_.spreadOf(pair, measure_area_) : 0;
  return {pair.i, pair.j, exchange, std::min(in_sums, exchange.standard_error)};
}

}  // namespace viewpeel
