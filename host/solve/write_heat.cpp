#include <viewpeel/solve.h>

#include <fmt/ostream.h>

#include "io/csv.h"
#include "io/write_file.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

void requireCsv(const std::filesystem::path& file) {
  if (file.extension() != ".csv")
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: unknown output format of heat; use a name that ends in .csv", file.string()));
}

}  // namespace

void writeHeat(const HeatSolution& solution, By by, std::ostream& out) {
  const std::vector<HeatRow>& rows = by == By::surface ? solution.surfaces : solution.rows;
  const bool has_bounds = !rows.empty() && rows.front().bounds;
  out << (by == By::surface ? "surface" : "polygon") << ",area,emissivity";
  for (const char* name : {"temperature", "radiosity", "irradiation", "heat_flux", "heat_flow"}) {
    fmt::print(out, ",{},{}_standard_error", name, name);
    if (has_bounds) fmt::print(out, ",{}_bound", name);
  }
  out << '\n';
  for (const HeatRow& row : rows) {
    fmt::print(out, "{},{},{}", quoteName(row.name), row.area, row.emissivity);
    const auto print = [&](const Measured& value, double HeatBounds::*bound) {
      fmt::print(out, ",{},{}", value.value, value.standard_error);
      if (has_bounds) fmt::print(out, ",{}", (*row.bounds).*bound);
    };
    print(row.temperature, &HeatBounds::temperature);
    print(row.radiosity, &HeatBounds::radiosity);
    print(row.irradiation, &HeatBounds::irradiation);
    print(row.heat_flux, &HeatBounds::heat_flux);
    print(row.heat_flow, &HeatBounds::heat_flow);
    out << '\n';
  }
  // The surroundings absorb the heat that leaves the scene, so their heat flow has the opposite sign.
  const auto printOutside = [&](const char* name, const Measured& flow) {
    fmt::print(out, "{},,1,{}{},{}{}\n", name, has_bounds ? ",,,,,,,,,,,," : ",,,,,,,,", -flow.value,
               flow.standard_error, has_bounds ? "," : "");
  };
  if (solution.to_up && solution.to_down) {
    printOutside("environment:up", *solution.to_up);
    printOutside("environment:down", *solution.to_down);
  } else if (solution.is_open) {
    printOutside("environment", solution.to_environment);
  }
}

void writeHeat(const HeatSolution& solution, By by, const std::filesystem::path& file) {
  requireCsv(file);
  writeFile(file, [&](std::ostream& out) { writeHeat(solution, by, out); });
}

void checkHeatOutput(const std::filesystem::path& file) {
  requireCsv(file);
  checkWritable(file);
}

}  // namespace viewpeel
