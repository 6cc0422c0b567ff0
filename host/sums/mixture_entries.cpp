#include "sums/mixture_entries.h"

#include <algorithm>

#include "sums/line_form_factors.h"

namespace viewpeel {

FormFactors::Entry countedEntry(const ReplicateSums& counted, const ReplicateSums::PairSum& pair, double measure_area,
                                double count_area, double least_form_factor) {
  Measured exchange = counted.exchangeArea(pair, measure_area, count_area);
  if (least_form_factor > 0 && pair.j < kEnvironment) {
    const double largest = least_form_factor * counted.ids().smallerArea(pair.i, pair.j);
    exchange.value = std::min(exchange.value, kMostOfCounted * largest);
    exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, largest));
  }
  return {pair.i, pair.j, exchange};
}

}  // namespace viewpeel
