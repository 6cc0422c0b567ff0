#include "io/entry_rows.h"

#include <limits>

#include "threads.h"
#include <viewpeel/error.h>

namespace viewpeel {

EntryRows::EntryRows(const FormFactors& form_factors)
    : form_factors_(form_factors), starts_(count() + 1, 0), mirrored_starts_(count() + 1, 0) {
  const std::vector<FormFactors::Entry>& entries = form_factors.entries();
  const auto isMirrored = [](const FormFactors::Entry& entry) { return entry.j < kEnvironment && entry.j != entry.i; };
  for (const FormFactors::Entry& entry : entries) {
    ++starts_[entry.i + 1];
    if (isMirrored(entry)) ++mirrored_starts_[entry.j + 1];
  }
  for (uint32_t i = 0; i < count(); ++i) {
    starts_[i + 1] += starts_[i];
    mirrored_starts_[i + 1] += mirrored_starts_[i];
  }
  mirrored_.resize(mirrored_starts_.back());
  std::vector<size_t> next(mirrored_starts_.begin(), mirrored_starts_.end() - 1);
  for (size_t pair = 0; pair < entries.size(); ++pair)
    if (isMirrored(entries[pair])) mirrored_[next[entries[pair].j]++] = pair;
}

std::vector<int64_t> EntryRows::startsOfRows() const {
  const Ids& ids = form_factors_.ids();
  if (ids.rowCount() > static_cast<uint32_t>(std::numeric_limits<int32_t>::max()))
    throw Error(ErrorCode::limit, "sparse rows hold 2147483647 rows at most; use --by surface");
  const std::vector<uint32_t> rows = ids.rows();
  std::vector<int64_t> starts(ids.rowCount() + 1, 0);
  forEach([&](const RowEntry& entry) { starts[rows[entry.i] + 1] += entry.j < kEnvironment; });
  for (size_t row = 1; row < starts.size(); ++row) starts[row] += starts[row - 1];
  return starts;
}

void makeRows(const EntryRows& rows, const std::function<void(uint32_t, uint32_t, fmt::memory_buffer&)>& make,
              const std::function<void(std::span<const char>)>& use) {
  constexpr size_t kEntriesTogether = 10'000;  // of texts some ms of work and half a MB
  const size_t threads = threadCount();
  std::vector<fmt::memory_buffer> parts(4 * threads);
  std::vector<uint32_t> ends;  // [parts] one past the last row of each part
  for (uint32_t first = 0; first < rows.count(); first = ends.back()) {
    ends.clear();
    for (uint32_t row = first; row < rows.count() && ends.size() < parts.size(); ends.push_back(row))
      for (size_t entries = 0; row < rows.count() && entries < kEntriesTogether; ++row) entries += rows.countOf(row);
    shareOut(threads, ends.size(), 1, [&](size_t, size_t k) {
      parts[k].clear();
      make(k ? ends[k - 1] : first, ends[k], parts[k]);
    });
    for (size_t k = 0; k < ends.size(); ++k) use({parts[k].data(), parts[k].size()});
  }
}

}  // namespace viewpeel
