// readResult() makes form factors of a .h5 of results; write_hdf5.cpp describes its columns.
#include <viewpeel/read.h>

#include <algorithm>
#include <charconv>
#include <unordered_map>

#include "io/stored_rows.h"
#include "scene/face_names.h"

namespace viewpeel {
namespace {

// Returns the id of each row of the file; empty rows have kNone.
constexpr uint32_t kNone = UINT32_MAX;
std::vector<uint32_t> idsOfRows(const Ids& ids) {
  std::vector<uint32_t> id_of_row(ids.rowCount(), kNone);
  const std::vector<uint32_t> rows = ids.rows();
  for (uint32_t id = 0; id < ids.count(); ++id) id_of_row[rows[id]] = id;
  return id_of_row;
}

Ids readIds(Hdf5Input& in, const StoredRows& rows) {
  Ids ids;
  const std::vector<uint8_t> is_requested = in.read<uint8_t>("is_requested", rows.count());
  for (uint32_t row = 0; row < rows.count(); ++row) {
    if (rows.areas[row] == 0) {
      ids.empty_rows.push_back({row, rows.names[row]});
      continue;
    }
    ids.names.push_back(rows.names[row]);
    ids.areas.push_back(rows.areas[row]);
    ids.requested.push_back(is_requested[row] != 0);
  }
  if (!std::ranges::count(ids.requested, false)) ids.requested.clear();
  return ids;
}

// Returns the names of surfaces, by the geometry if there is one, and otherwise by the names of rows.
std::vector<std::string> readSurfaces(Hdf5Input& in, Ids& ids) {
  ids.surface.assign(ids.count(), 0);
  if (in.has("geometry")) {
    ReportGeometry geometry = readGeometry(in, ids.rowCount());
    const std::vector<uint32_t> id_of_row = idsOfRows(ids);
    for (size_t k = 0; k < geometry.row_of_polygon.size(); ++k) {
      const uint32_t id = id_of_row[static_cast<size_t>(geometry.row_of_polygon[k])];
      if (id == kNone) in.refuse("an empty row has polygons");
      ids.surface[id] = static_cast<uint32_t>(geometry.surface_of_polygon[k]);
    }
    return std::move(geometry.surface_names);
  }
  std::vector<std::string> names;
  std::unordered_map<std::string, uint32_t> surface_of_name;
  for (uint32_t id = 0; id < ids.count(); ++id) {
    const std::string name = surfaceOfName(ids.names[id]);
    const auto [at, is_new] = surface_of_name.try_emplace(name, static_cast<uint32_t>(names.size()));
    if (is_new) names.push_back(name);
    ids.surface[id] = at->second;
  }
  return names;
}

// A Column holds one quantity for all entries: of pairs, and by row of environment and leak.
struct Column {
  std::vector<double> pairs, environment, leak;
};

Column readColumn(Hdf5Input& in, const std::string& group, const std::string& suffix, const StoredRows& rows) {
  return {readNumbers(in, group + "/data", rows.entryCount()), readNumbers(in, "environment" + suffix, rows.count()),
          readNumbers(in, "leak" + suffix, rows.count())};
}

// A PlacedEntry says where a Column holds an entry: at pairs[place], environment[place] or leak[place].
struct PlacedEntry {
  uint32_t i, j, id_of_value;  // id_of_value: the row whose form factor is stored there
  size_t place;
};

// Finds the place of each entry. The file has an exchange area twice where both rows were requested; one is taken.
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
  const std::vector<double> values = readNumbers(in, "row_sum", ids.rowCount());
  const std::vector<double> errors = readNumbers(in, "row_sum_standard_error", ids.rowCount());
  std::vector<Measured> sums;
  for (const uint32_t row : ids.rows()) sums.push_back({values[row], errors[row]});
  return sums;
}

double unlistedBound(Hdf5Input& in, const StoredRows& rows) {
  const std::string text = rows.attribute("unlisted_bound");
  double bound = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), bound);
  if (failure != std::errc() || end != text.data() + text.size() || !(bound >= 0))
    in.refuse("it has intervals, and no number 'unlisted_bound' for the other pairs");
  return bound;
}

// Returns whether write_hdf5.cpp adds this attribute to every file: then it is no parameter of the run.
bool describesTheFile(const std::string& name) {
  return name == "viewpeel_result_format" || name == "row_order" || name == "unlisted_bound" ||
         name.starts_with("closure_");
}

}  // namespace

StoredResult readResult(const std::filesystem::path& file) {
  Hdf5Input in = openResult(file);
  StoredRows rows = readStoredRows(in);
  StoredResult stored{FormFactors({}, {}, {}), {}, {}, {}};
  Ids ids = readIds(in, rows);
  ids.two_sided = rows.attribute("two-sided") == "yes";
  ids.rows_sum_to_one = !rows.attribute("closure_largest").empty();
  stored.surface_names = readSurfaces(in, ids);
  const std::vector<PlacedEntry> places = placeEntries(in, ids, rows);
  const Column values = readColumn(in, "form_factors", "", rows);
  const Column errors = readColumn(in, "standard_errors", "_standard_error", rows);
  const bool has_intervals = rows.has_intervals;
  const Column lower = has_intervals ? readColumn(in, "lower_bounds", "_lower", rows) : Column{};
  const Column upper = has_intervals ? readColumn(in, "upper_bounds", "_upper", rows) : Column{};
  const Column balanced{in.has("balanced_form_factors")
                            ? readNumbers(in, "balanced_form_factors/data", rows.entryCount())
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
                                    has_intervals ? unlistedBound(in, rows) : 0);
  std::erase_if(rows.attributes, [](const auto& attribute) { return describesTheFile(attribute.first); });
  stored.parameters = std::move(rows.attributes);
  return stored;
}

}  // namespace viewpeel
