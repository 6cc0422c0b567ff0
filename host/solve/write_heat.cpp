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
  fmt::print(out,
             "{},area,emissivity,temperature,temperature_standard_error,radiosity,radiosity_standard_error,irradiation,"
             "irradiation_standard_error,heat_flux,heat_flux_standard_error,heat_flow,heat_flow_standard_error\n",
             by == By::surface ? "surface" : "polygon");
  for (const HeatRow& row : by == By::surface ? solution.surfaces : solution.rows) {
    fmt::print(out, "{},{},{}", quoteName(row.name), row.area, row.emissivity);
    for (const Measured& value : {row.temperature, row.radiosity, row.irradiation, row.heat_flux, row.heat_flow})
      fmt::print(out, ",{},{}", value.value, value.standard_error);
    out << '\n';
  }
  // What leaves the scene is what its surroundings absorb: their heat flow is below 0.
  if (solution.is_open)
    fmt::print(out, "environment,,1,,,,,,,,,{},{}\n", -solution.to_environment.value,
               solution.to_environment.standard_error);
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
