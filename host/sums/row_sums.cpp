#include "sums/row_sums.h"

#include <cmath>

namespace viewpeel {

std::vector<Measured> sumRows(const std::vector<FormFactors::Entry>& entries, const std::vector<double>& areas) {
  return rowSumsOf(sumByRow(entries.size(), areas.size(),
                            [&](size_t k, RowTotals& totals) {
                              const FormFactors::Entry& entry = entries[k];
                              addToRows(totals[0], entry, entry.exchange_area.value);
                              addToRows(totals[1], entry, entry.errorInSums() * entry.errorInSums());
                            }),
                   areas);
}

std::vector<Measured> rowSumsOf(const RowTotals& totals, const std::vector<double>& areas) {
  std::vector<Measured> rows(areas.size());
  for (size_t i = 0; i < areas.size(); ++i) rows[i] = {totals[0][i] / areas[i], std::sqrt(totals[1][i]) / areas[i]};
  return rows;
}

}  // namespace viewpeel
