#include <viewpeel/sparse_rows.h>

#include "io/entry_rows.h"

namespace viewpeel {

SparseRows compressRows(const FormFactors& form_factors) {
  const std::vector<uint32_t> rows = form_factors.ids().rows();
  const EntryRows entries(form_factors);
  SparseRows sparse;
  sparse.starts = entries.startsOfRows();
  const auto count = static_cast<size_t>(sparse.starts.back());
  sparse.columns.reserve(count), sparse.form_factors.reserve(count), sparse.standard_errors.reserve(count);
  if (form_factors.hasIntervals()) sparse.lower.reserve(count), sparse.upper.reserve(count);
  entries.forEach([&](const RowEntry& entry) {
    if (entry.j >= kEnvironment) return;
    sparse.columns.push_back(static_cast<int32_t>(rows[entry.j]));
    sparse.form_factors.push_back(entry.form_factor.value);
    sparse.standard_errors.push_back(entry.form_factor.standard_error);
    if (!form_factors.hasIntervals()) return;
    const Interval interval = entries.intervalOf(entry);
    sparse.lower.push_back(interval.lower), sparse.upper.push_back(interval.upper);
  });
  return sparse;
}

std::vector<double> spreadOverRows(const Ids& ids, const std::vector<double>& of_ids) {
  std::vector<double> of_rows(ids.rowCount(), 0.0);
  const std::vector<uint32_t> rows = ids.rows();
  for (uint32_t id = 0; id < ids.count(); ++id) of_rows[rows[id]] = of_ids[id];
  return of_rows;
}

std::vector<std::string> rowNames(const Ids& ids) {
  std::vector<std::string> names(ids.rowCount());
  const std::vector<uint32_t> rows = ids.rows();
  for (uint32_t id = 0; id < ids.count(); ++id) names[rows[id]] = ids.names[id];
  for (const EmptyRow& empty : ids.empty_rows) names[empty.row] = empty.name;
  return names;
}

}  // namespace viewpeel
