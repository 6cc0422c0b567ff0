#include <algorithm>
#include <cmath>

#include <viewpeel/result.h>

namespace viewpeel {

Closure measureClosure(const FormFactors& form_factors) {
  Closure closure;
  double squares = 0;
  const auto& sums = form_factors.rowSums();
  size_t row_count = 0;
  for (uint32_t k = 0; k < sums.size(); ++k) {
    if (!form_factors.ids().isRequested(k)) continue;
    ++row_count;
    const double error = std::abs(sums[k].value - 1);
    squares += error * error;
    if (error >= closure.largest_error) {
      closure.largest_error = error;
      closure.row = form_factors.ids().names[k];
      closure.standard_error = sums[k].standard_error;
    }
  }
  closure.rms_error = std::sqrt(squares / double(row_count));
  return closure;
}

StandardErrors measureStandardErrors(const FormFactors& form_factors, size_t worst) {
  StandardErrors errors;
  std::vector<std::pair<double, std::pair<uint32_t, uint32_t>>> largest;  // sorted, at most `worst` entries
  double squares = 0, between_rows = 0;
  const auto add = [&](uint32_t from, uint32_t to, const FormFactors::Entry& entry) {
    if (!form_factors.ids().isRequested(from)) return;
    const double area = form_factors.ids().areas[from], error = entry.exchange_area.standard_error / area;
    ++errors.count;
    squares += error * error;
    if (to < kEnvironment) between_rows += std::pow(entry.errorInSums() / area, 2);
    if (worst == 0 || (largest.size() == worst && error <= largest.back().first)) return;
    const auto at =
        std::find_if(largest.begin(), largest.end(), [&](const auto& other) { return other.first < error; });
    largest.insert(at, {error, {from, to}});
    if (largest.size() > worst) largest.pop_back();
  };
  for (const auto& entry : form_factors.entries()) {
    add(entry.i, entry.j, entry);
    if (entry.j < kEnvironment && entry.j != entry.i) add(entry.j, entry.i, entry);
  }
  for (const auto& [error, pair] : largest) errors.worst.push_back(pair);
  errors.rms = errors.count ? std::sqrt(squares / double(errors.count)) : 0;
  size_t rows = 0;
  for (uint32_t id = 0; id < form_factors.ids().count(); ++id) rows += form_factors.ids().isRequested(id);
  if (rows > 0) errors.rms_with_zeros = std::sqrt(between_rows / (double(rows) * double(form_factors.ids().count())));
  return errors;
}

}  // namespace viewpeel
