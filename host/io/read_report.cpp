#include "io/read_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "io/hdf5_file.h"

namespace viewpeel {
namespace {

constexpr const char* kRemedy = "take a .h5 that viewpeel wrote, or write it anew";

struct NamedColumn {
  const char *name, *unit;
};
// Rows have these columns, where the file has them.
constexpr NamedColumn kColumns[] = {{"environment", "1"},
                                    {"environment_standard_error", "1"},
                                    {"environment_lower", "1"},
                                    {"environment_upper", "1"},
                                    {"leak", "1"},
                                    {"leak_standard_error", "1"},
                                    {"leak_lower", "1"},
                                    {"leak_upper", "1"},
                                    {"row_sum", "1"},
                                    {"row_sum_standard_error", "1"},
                                    {"emissivity", "1"},
                                    {"temperature", "K"},
                                    {"temperature_standard_error", "K"},
                                    {"temperature_bound", "K"},
                                    {"radiosity", "W/m2"},
                                    {"radiosity_standard_error", "W/m2"},
                                    {"radiosity_bound", "W/m2"},
                                    {"irradiation", "W/m2"},
                                    {"irradiation_standard_error", "W/m2"},
                                    {"irradiation_bound", "W/m2"},
                                    {"heat_flux", "W/m2"},
                                    {"heat_flux_standard_error", "W/m2"},
                                    {"heat_flux_bound", "W/m2"},
                                    {"heat_flow", "W"},
                                    {"heat_flow_standard_error", "W"},
                                    {"heat_flow_bound", "W"}};

// A Reader refuses columns that do not fit each other: a page would show nonsense.
class Reader {
 public:
  explicit Reader(Hdf5Input& input) : input_(input) {}

  ReportContent read() {
    if (!input_.has("form_factors") || !input_.has("name") || !input_.has("area"))
      input_.refuse("it holds no form factors");
    ReportContent content;
    content.names = input_.readTexts("name");
    content.areas = column("area", content.names.size());
    for (const NamedColumn& named : kColumns)
      if (input_.has(named.name))
        content.columns.push_back({named.name, named.unit, column(named.name, content.names.size())});
    if (input_.has("is_requested")) {
      const auto flags = input_.read<uint8_t>("is_requested");
      if (flags.size() != content.names.size()) refuseLength("is_requested");
      content.columns.push_back({"is_requested", "1", {flags.begin(), flags.end()}});
    }
    readMatrix(content);
    if (input_.has("geometry")) readGeometry(content);
    content.parameters = input_.attributes();
    return content;
  }

 private:
  [[noreturn]] void refuseLength(const std::string& name) const {
    input_.refuse(fmt::format("its '{}' does not go with its other columns", name));
  }

  std::vector<double> column(const std::string& name, size_t length) {
    std::vector<double> values = input_.read<double>(name);
    if (values.size() != length) refuseLength(name);
    return values;
  }

  std::vector<int32_t> indices(const std::string& name, size_t length, size_t end) {
    std::vector<int32_t> values = input_.read<int32_t>(name);
    const bool is_within =
        std::ranges::all_of(values, [&](int32_t value) { return value >= 0 && static_cast<size_t>(value) < end; });
    if (values.size() != length || !is_within) refuseLength(name);
    return values;
  }

  void readMatrix(ReportContent& content) {
    content.starts = input_.read<int64_t>("form_factors/indptr");
    content.form_factors = input_.read<double>("form_factors/data");
    const size_t count = content.form_factors.size();
    if (content.starts.size() != content.names.size() + 1 || content.starts.front() != 0 ||
        content.starts.back() != static_cast<int64_t>(count) || !std::ranges::is_sorted(content.starts) ||
        count > static_cast<size_t>(std::numeric_limits<int32_t>::max()))
      refuseLength("form_factors/indptr");
    content.to = indices("form_factors/indices", count, content.names.size());
    for (int64_t row = 0; row < content.rowCount(); ++row)
      if (!std::is_sorted(content.to.begin() + content.starts[row], content.to.begin() + content.starts[row + 1]))
        refuseLength("form_factors/indices");
    content.standard_errors = column("standard_errors/data", count);
    if (!input_.has("lower_bounds")) return;
    content.lower = column("lower_bounds/data", count);
    content.upper = column("upper_bounds/data", count);
  }

  void readGeometry(ReportContent& content) {
    ReportGeometry& geometry = content.geometry;
    geometry.surface_names = input_.readTexts("geometry/surface_name");
    geometry.x = input_.read<double>("geometry/x");
    const size_t corners = geometry.x.size();
    geometry.y = column("geometry/y", corners);
    geometry.z = column("geometry/z", corners);
    geometry.polygon_area = input_.read<double>("geometry/polygon_area");
    const size_t count = geometry.polygon_area.size();
    geometry.first_corner = indices("geometry/first_corner", count, corners);
    geometry.corner_count = indices("geometry/corner_count", count, 5);
    geometry.row_of_polygon = indices("geometry/row_of_polygon", count, content.names.size());
    geometry.surface_of_polygon = indices("geometry/surface_of_polygon", count, geometry.surface_names.size());
    for (size_t k = 0; k < count; ++k)
      if (geometry.corner_count[k] < 3 ||
          static_cast<size_t>(geometry.first_corner[k]) + geometry.corner_count[k] > corners)
        refuseLength("geometry/corner_count");
  }

  Hdf5Input& input_;
};

}  // namespace

ReportContent readReport(const std::filesystem::path& file) {
  Hdf5Input input(file, "result", kRemedy);
  return Reader(input).read();
}

ReportContent readReport(const std::vector<char>& bytes, const std::string& name) {
  Hdf5Input input(bytes, name, "result", kRemedy);
  return Reader(input).read();
}

}  // namespace viewpeel
