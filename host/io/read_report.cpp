#include "io/read_report.h"

#include <utility>

#include "io/stored_rows.h"

namespace viewpeel {
namespace {

struct NamedColumn {
  const char *name, *unit;
};
// These columns are read where the file has them; each has its unit.
constexpr NamedColumn kColumns[] = {{"environment", "1"},
                                    {"environment_standard_error", "1"},
                                    {"environment_lower", "1"},
                                    {"environment_upper", "1"},
                                    {"environment_up", "1"},
                                    {"environment_up_standard_error", "1"},
                                    {"environment_up_lower", "1"},
                                    {"environment_up_upper", "1"},
                                    {"environment_down", "1"},
                                    {"environment_down_standard_error", "1"},
                                    {"environment_down_lower", "1"},
                                    {"environment_down_upper", "1"},
                                    {"leak", "1"},
                                    {"leak_standard_error", "1"},
                                    {"leak_lower", "1"},
                                    {"leak_upper", "1"},
                                    {"row_sum", "1"},
                                    {"row_sum_standard_error", "1"},
                                    {"dropped", "1"},
                                    {"dropped_standard_error", "1"},
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

ReportContent read(Hdf5Input& in) {
  StoredRows rows = readStoredRows(in);
  ReportContent content;
  for (const NamedColumn& named : kColumns)
    if (in.has(named.name))
      content.columns.push_back({named.name, named.unit, readNumbers(in, named.name, rows.count())});
  const std::vector<uint8_t> flags = in.read<uint8_t>("is_requested", rows.count());
  content.columns.push_back({"is_requested", "1", {flags.begin(), flags.end()}});
  const size_t count = rows.entryCount();
  content.form_factors = readNumbers(in, "form_factors/data", count);
  content.standard_errors = readNumbers(in, "standard_errors/data", count);
  if (rows.has_intervals) {
    content.lower = readNumbers(in, "lower_bounds/data", count);
    content.upper = readNumbers(in, "upper_bounds/data", count);
  }
  content.geometry = readGeometry(in, rows.count());
  content.names = std::move(rows.names);
  content.areas = std::move(rows.areas);
  content.starts = std::move(rows.starts);
  content.to = std::move(rows.columns);
  content.parameters = std::move(rows.attributes);
  return content;
}

}  // namespace

ReportContent readReport(const std::filesystem::path& file) {
  Hdf5Input in = openResult(file);
  return read(in);
}

ReportContent readReport(const std::vector<char>& bytes, const std::string& name) {
  Hdf5Input in = openResult(bytes, name);
  return read(in);
}

}  // namespace viewpeel
