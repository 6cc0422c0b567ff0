#include <viewpeel/sparse_rows.h>

#include <limits>

#include <viewpeel/error.h>
#include "io/entry_rows.h"

namespace viewpeel {

SparseRows compressRows(const FormFactors& form_factors) {
  const Ids& ids = form_factors.ids();
  if (ids.rowCount() > static_cast<uint32_t>(std::numeric_limits<int32_t>::max()))
    throw Error(ErrorCode::limit, "sparse rows hold 2147483647 rows at most; use --by surface");
  const std::vector<uint32_t> rows = ids.rows();
  SparseRows sparse;
  sparse.starts.assign(ids.rowCount() + 1, 0);
  const EntryRows entries(form_factors);
  entries.forEach([&](const RowEntry& entry) {
    if (entry.j >= kEnvironment) return;
    ++sparse.starts[rows[entry.i] + 1];
    sparse.columns.push_back(static_cast<int32_t>(rows[entry.j]));
    sparse.form_factors.push_back(entry.form_factor.value);
    sparse.standard_errors.push_back(entry.form_factor.standard_error);
    if (!form_factors.hasIntervals()) return;
    const Interval interval = entries.intervalOf(entry);
    sparse.lower.push_back(interval.lower), sparse.upper.push_back(interval.upper);
  });
  for (size_t row = 1; row < sparse.starts.size(); ++row) sparse.starts[row] += sparse.starts[row - 1];
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
