// objective() is the norm that balancing minimises: the sum over pairs of (x - c)^2 / w, with w = min(c, standard error
// of c).
#pragma once
#include <algorithm>
#include <vector>

#include <viewpeel/balance.h>

namespace viewpeel {

using Entry = FormFactors::Entry;

inline std::vector<double> valuesOf(const FormFactors& form_factors) {
  std::vector<double> values;
  for (const Entry& entry : form_factors.entries()) values.push_back(entry.exchange_area.value);
  return values;
}

inline double weightOf(const Measured& c) { return std::min(c.value, c.standard_error); }

inline double objective(const FormFactors& measured, const std::vector<double>& x) {
  double sum = 0;
  for (size_t k = 0; k < x.size(); ++k) {
    const Measured& c = measured.entries()[k].exchange_area;
    if (measured.entries()[k].j < kEnvironment) sum += (x[k] - c.value) * (x[k] - c.value) / weightOf(c);
  }
  return sum;
}

}  // namespace viewpeel
