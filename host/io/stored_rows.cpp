#include "io/stored_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace viewpeel {
namespace {

constexpr const char* kKind = "result";
constexpr const char* kRemedy = "take a .h5 that viewpeel wrote, or write it anew";

void requireMatrix(Hdf5Input& in, const StoredRows& rows) {
  const auto count = static_cast<int64_t>(rows.entryCount());
  bool fits = count <= std::numeric_limits<int32_t>::max() && rows.starts.front() == 0 && rows.starts.back() == count &&
              std::ranges::is_sorted(rows.starts);
  for (size_t row = 0; fits && row < rows.count(); ++row)
    for (int64_t k = rows.starts[row] + 1; k < rows.starts[row + 1]; ++k)
      fits = fits && rows.columns[static_cast<size_t>(k - 1)] < rows.columns[static_cast<size_t>(k)];
  if (!fits) in.refuse("its rows are not in order");
}

}  // namespace

std::string StoredRows::attribute(const std::string& name) const {
  const auto at = std::ranges::find(attributes, name, &std::pair<std::string, std::string>::first);
  return at == attributes.end() ? std::string() : at->second;
}

Hdf5Input openResult(const std::filesystem::path& file) { return Hdf5Input(file, kKind, kRemedy); }
Hdf5Input openResult(const std::vector<char>& bytes, const std::string& name) {
  return Hdf5Input(bytes, name, kKind, kRemedy);
}

std::vector<double> readNumbers(Hdf5Input& in, const std::string& name, std::optional<size_t> count) {
  std::vector<double> values = in.read<double>(name, count);
  if (std::ranges::any_of(values, [](double value) { return std::isnan(value); }))
    in.refuse(fmt::format("its '{}' has values that are no numbers", name));
  return values;
}

std::vector<int32_t> readIndices(Hdf5Input& in, const std::string& name, std::optional<size_t> count, size_t end) {
  std::vector<int32_t> values = in.read<int32_t>(name, count);
  for (const int32_t value : values)
    if (value < 0 || static_cast<size_t>(value) >= end)
      in.refuse(fmt::format("its '{}' has {}, which is not from 0 to {} exclusive", name, value, end));
  return values;
}

StoredRows readStoredRows(Hdf5Input& in) {
  StoredRows rows;
  rows.attributes = in.attributes();
  const std::string format = rows.attribute("viewpeel_result_format");
  if (format.empty()) in.refuse("it is another file, perhaps a checkpoint");
  if (format != std::to_string(kResultFormat)) in.refuse("it is of another format");
  if (rows.attribute("only") == "environment")
    in.refuse("it has the environment of each row alone, without form factors between rows");
  rows.names = in.readTexts("name");
  rows.areas = readNumbers(in, "area", rows.count());
  if (std::ranges::any_of(rows.areas, [](double area) { return area < 0 || std::isinf(area); }))
    in.refuse("its 'area' has values that are no areas");
  rows.starts = in.read<int64_t>("form_factors/indptr", rows.count() + 1);
  rows.columns = readIndices(in, "form_factors/indices", {}, rows.count());
  requireMatrix(in, rows);
  rows.has_intervals = in.has("lower_bounds");
  return rows;
}

ReportGeometry readGeometry(Hdf5Input& in, size_t row_count) {
  ReportGeometry geometry;
  if (!in.has("geometry")) return geometry;
  geometry.surface_names = in.readTexts("geometry/surface_name");
  geometry.x = readNumbers(in, "geometry/x");
  const size_t corners = geometry.x.size();
  geometry.y = readNumbers(in, "geometry/y", corners);
  geometry.z = readNumbers(in, "geometry/z", corners);
  geometry.polygon_area = readNumbers(in, "geometry/polygon_area");
  const size_t count = geometry.polygon_area.size();
  geometry.first_corner = readIndices(in, "geometry/first_corner", count, corners);
  geometry.corner_count = readIndices(in, "geometry/corner_count", count, 5);
  geometry.row_of_polygon = readIndices(in, "geometry/row_of_polygon", count, row_count);
  geometry.surface_of_polygon = readIndices(in, "geometry/surface_of_polygon", count, geometry.surface_names.size());
  for (size_t k = 0; k < count; ++k)
    if (geometry.corner_count[k] < 3 ||
        static_cast<size_t>(geometry.first_corner[k]) + static_cast<size_t>(geometry.corner_count[k]) > corners)
      in.refuse("its polygons do not agree with its list of corners");
  return geometry;
}

}  // namespace viewpeel
