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

void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, std::ostream& out) {
  fmt::print(out, "from,to,{},conductor\n", kind == ExchangeKind::gebhart ? "gebhart" : "script_f");
  std::vector<std::vector<std::pair<uint32_t, double>>> rows(factors.names.size());
  for (const ExchangeFactors::Entry& entry : factors.entries)
    if (entry.j < kEnvironment && entry.j != entry.i) rows[entry.j].emplace_back(entry.i, entry.conductor);
  for (const ExchangeFactors::Entry& entry : factors.entries) rows[entry.i].emplace_back(entry.j, entry.conductor);
  for (size_t i = 0; i < rows.size(); ++i) {
    const double all = factors.areas[i] * (kind == ExchangeKind::gebhart ? factors.emissivities[i] : 1);
    for (const auto& [j, conductor] : rows[i])
      fmt::print(out, "{},{},{},{}\n", quoteName(factors.names[i]),
                 j == kEnvironment ? "environment" : quoteName(factors.names[j]), conductor / all, conductor);
  }
}

void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, const std::filesystem::path& file) {
  requireCsv(file);
  writeFile(file, [&](std::ostream& out) { writeExchange(factors, kind, out); });
}

void checkHeatOutput(const std::filesystem::path& file) {
  requireCsv(file);
  checkWritable(file);
}

}  // namespace viewpeel
