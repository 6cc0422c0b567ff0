// A result in HDF5 becomes form factors again: write_hdf5.cpp says where everything is.
#include <viewpeel/read.h>

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>

#include "io/hdf5_file.h"
#include "scene/face_names.h"

namespace viewpeel {
namespace {

constexpr const char* kResultFormat = "1";  // as write_hdf5.cpp has it

template <class T>
std::vector<T> readRows(Hdf5Input& in, const std::string& name, size_t count) {
  std::vector<T> values = in.read<T>(name);
  if (values.size() != count) in.refuse(fmt::format("its '{}' has {} values for {}", name, values.size(), count));
  return values;
}

// Returns the id of each row of the file; rows that are empty have none.
constexpr uint32_t kNone = UINT32_MAX;
std::vector<uint32_t> idsOfRows(const Ids& ids) {
  std::vector<uint32_t> id_of_row(ids.rowCount(), kNone);
  const std::vector<uint32_t> rows = ids.rows();
  for (uint32_t id = 0; id < ids.count(); ++id) id_of_row[rows[id]] = id;
  return id_of_row;
}

Ids readIds(Hdf5Input& in) {
  Ids ids;
  const std::vector<std::string> names = in.readTexts("name");
  const std::vector<double> areas = readRows<double>(in, "area", names.size());
  const std::vector<uint8_t> is_requested = readRows<uint8_t>(in, "is_requested", names.size());
  for (uint32_t row = 0; row < names.size(); ++row) {
    if (areas[row] == 0) {
      ids.empty_rows.push_back({row, names[row]});
      continue;
    }
    ids.names.push_back(names[row]);
    ids.areas.push_back(areas[row]);
    ids.requested.push_back(is_requested[row] != 0);
  }
  if (!std::ranges::count(ids.requested, false)) ids.requested.clear();
  return ids;
}

// Surfaces are those of the geometry, or where there is none those that the names of rows tell.
std::vector<std::string> readSurfaces(Hdf5Input& in, Ids& ids) {
  ids.surface.assign(ids.count(), 0);
  std::vector<std::string> names;
  if (in.has("geometry")) {
    names = in.readTexts("geometry/surface_name");
    const std::vector<int32_t> rows = in.read<int32_t>("geometry/row_of_polygon");
    const std::vector<int32_t> surfaces = readRows<int32_t>(in, "geometry/surface_of_polygon", rows.size());
    const std::vector<uint32_t> id_of_row = idsOfRows(ids);
    for (size_t k = 0; k < rows.size(); ++k) {
      const auto row = static_cast<size_t>(rows[k]), surface = static_cast<size_t>(surfaces[k]);
      if (row >= id_of_row.size() || id_of_row[row] == kNone || surface >= names.size())
        in.refuse("its geometry names absent rows or surfaces");
      ids.surface[id_of_row[row]] = static_cast<uint32_t>(surface);
    }
    return names;
  }
  std::unordered_map<std::string, uint32_t> surface_of_name;
  for (uint32_t id = 0; id < ids.count(); ++id) {
    const std::string name = surfaceOfName(ids.names[id]);
    const auto [at, is_new] = surface_of_name.try_emplace(name, static_cast<uint32_t>(names.size()));
    if (is_new) names.push_back(name);
    ids.surface[id] = at->second;
  }
  return names;
}

// StoredRows are the compressed rows of the file.
struct StoredRows {
  std::vector<int64_t> starts;
  std::vector<int32_t> columns;
};

StoredRows readPlaces(Hdf5Input& in, size_t row_count) {
  StoredRows rows{readRows<int64_t>(in, "form_factors/indptr", row_count + 1),
                  in.read<int32_t>("form_factors/indices")};
  bool fits = rows.starts.front() == 0 && rows.starts.back() == static_cast<int64_t>(rows.columns.size()) &&
              std::ranges::is_sorted(rows.starts);
  for (const int32_t column : rows.columns) fits = fits && column >= 0 && static_cast<size_t>(column) < row_count;
  for (size_t row = 0; fits && row < row_count; ++row)
    for (int64_t k = rows.starts[row] + 1; k < rows.starts[row + 1]; ++k)
      fits = fits && rows.columns[static_cast<size_t>(k - 1)] < rows.columns[static_cast<size_t>(k)];
  if (!fits) in.refuse("its rows are not in order");
  return rows;
}

// A column of form factors, with those to environment and leak behind: [row] of each.
struct Column {
  std::vector<double> pairs, environment, leak;
};

Column readColumn(Hdf5Input& in, const std::string& group, const std::string& suffix, const StoredRows& rows) {
  const size_t count = rows.starts.size() - 1;
  return {readRows<double>(in, group + "/data", rows.columns.size()),
          readRows<double>(in, "environment" + suffix, count), readRows<double>(in, "leak" + suffix, count)};
}

// PlacedEntries have the places of entries in a Column: k in `pairs`, or a row.
struct PlacedEntry {
  uint32_t i, j, id_of_value;  // the row whose value it is
  size_t place;
};

// An exchange area stands twice in the file where both rows were requested; it is taken once.
std::vector<PlacedEntry> placeEntries(Hdf5Input& in, const Ids& ids, const StoredRows& rows) {
  const std::vector<uint32_t> id_of_row = idsOfRows(ids);
  std::vector<PlacedEntry> entries;
  for (uint32_t row = 0; row < ids.rowCount(); ++row) {
    if (rows.starts[row] == rows.starts[row + 1]) continue;
    const uint32_t i = id_of_row[row];
    if (i == kNone || !ids.isRequested(i)) in.refuse("an empty row has form factors");
    for (auto k = static_cast<size_t>(rows.starts[row]); k < static_cast<size_t>(rows.starts[row + 1]); ++k) {
      const uint32_t j = id_of_row[static_cast<size_t>(rows.columns[k])];
      if (j == kNone) in.refuse("an empty column has form factors");
      if (j >= i || !ids.isRequested(j)) entries.push_back({std::min(i, j), std::max(i, j), i, k});
    }
  }
  for (uint32_t row = 0; row < ids.rowCount(); ++row)
    for (const uint32_t j : {kEnvironment, kLeak})
      if (const uint32_t i = id_of_row[row]; i != kNone && ids.isRequested(i)) entries.push_back({i, j, i, row});
  std::ranges::sort(entries, {}, [](const PlacedEntry& entry) { return std::pair(entry.i, entry.j); });
  return entries;
}

double valueAt(const Column& column, const PlacedEntry& entry) {
  return (entry.j == kEnvironment ? column.environment : entry.j == kLeak ? column.leak : column.pairs)[entry.place];
}

std::vector<Measured> readRowSums(Hdf5Input& in, const Ids& ids) {
  const std::vector<double> values = readRows<double>(in, "row_sum", ids.rowCount());
  const std::vector<double> errors = readRows<double>(in, "row_sum_standard_error", ids.rowCount());
  std::vector<Measured> sums;
  for (const uint32_t row : ids.rows()) sums.push_back({values[row], errors[row]});
  return sums;
}

double readUnlistedBound(Hdf5Input& in, const std::vector<std::pair<std::string, std::string>>& attributes) {
  for (const auto& [name, value] : attributes)
    if (name == "unlisted_bound") return std::stod(value);
  in.refuse("it has intervals without a bound for the other pairs");
}

}  // namespace

StoredResult readResult(const std::filesystem::path& file) {
  Hdf5Input in(file, "result", "take a .h5 that viewpeel wrote, or write it anew");
  StoredResult stored{FormFactors({}, {}, {}), {}, {}, in.attributes()};
  const auto find = [&](const std::string& name) {
    const auto at = std::ranges::find(stored.parameters, name, &std::pair<std::string, std::string>::first);
    return at == stored.parameters.end() ? std::string() : at->second;
  };
  if (find("viewpeel_result_format").empty()) in.refuse("it is another file, perhaps a checkpoint");
  if (find("viewpeel_result_format") != kResultFormat) in.refuse("it is of another format");
  Ids ids = readIds(in);
  ids.two_sided = find("two-sided") == "yes";
  ids.rows_sum_to_one = !find("closure_largest").empty();
  stored.surface_names = readSurfaces(in, ids);
  const StoredRows rows = readPlaces(in, ids.rowCount());
  const std::vector<PlacedEntry> places = placeEntries(in, ids, rows);
  const Column values = readColumn(in, "form_factors", "", rows);
  const Column errors = readColumn(in, "standard_errors", "_standard_error", rows);
  const bool has_intervals = in.has("lower_bounds");
  const Column lower = has_intervals ? readColumn(in, "lower_bounds", "_lower", rows) : Column{};
  const Column upper = has_intervals ? readColumn(in, "upper_bounds", "_upper", rows) : Column{};
  const Column balanced{in.has("balanced_form_factors")
                            ? readRows<double>(in, "balanced_form_factors/data", rows.columns.size())
                            : std::vector<double>(),
                        {},
                        {}};
  std::vector<FormFactors::Entry> entries, balanced_entries;
  std::vector<Interval> intervals;
  for (const PlacedEntry& place : places) {
    const double area = ids.areas[place.id_of_value];
    const Measured exchange{area * valueAt(values, place), area * valueAt(errors, place)};
    const Interval interval =
        has_intervals ? Interval{area * valueAt(lower, place), area * valueAt(upper, place)} : Interval{};
    const bool is_listed =
        place.j < kEnvironment || exchange.value != 0 || exchange.standard_error != 0 || interval.upper != 0;
    if (!is_listed) continue;
    entries.push_back({place.i, place.j, exchange});
    if (has_intervals) intervals.push_back(interval);
    if (balanced.pairs.empty()) continue;
    const double of_pair = place.j < kEnvironment ? area * valueAt(balanced, place) : 0;
    balanced_entries.push_back({place.i, place.j, {of_pair, exchange.standard_error}});
  }
  const std::vector<Measured> sums = readRowSums(in, ids);
  if (!balanced_entries.empty())
    stored.balanced.emplace(ids, std::move(balanced_entries), std::vector<Measured>(ids.count(), Measured{1, 0}));
  stored.form_factors = FormFactors(std::move(ids), std::move(entries), sums, std::move(intervals),
                                    has_intervals ? readUnlistedBound(in, stored.parameters) : 0);
  return stored;
}

}  // namespace viewpeel
