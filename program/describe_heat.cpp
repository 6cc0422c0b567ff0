#include "program/describe_heat.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "program/summary.h"

namespace viewpeel::program {
namespace {

constexpr size_t kMostRows = 30;
constexpr double kRounding = 1e-8;  // relative; smaller standard errors are rounding and are not printed

// Returns a value to the second digit of its standard error: "351.02 +- 1.4e-01".
std::string inDigits(const Measured& value) {
  if (!(value.standard_error > kRounding * std::abs(value.value))) return fmt::format("{:.6g}", value.value);
  const double last = std::floor(std::log10(value.standard_error)) - 1;
  const int decimals = std::clamp(static_cast<int>(-last), 0, 9);
  return fmt::format("{:.{}f} +- {:.1e}", value.value, decimals, value.standard_error);
}

std::string tabulate(const std::vector<HeatRow>& rows) {
  std::vector<const HeatRow*> largest;
  for (const HeatRow& row : rows) largest.push_back(&row);
  std::ranges::stable_sort(largest, [](const HeatRow* a, const HeatRow* b) {
    return std::abs(a->heat_flow.value) > std::abs(b->heat_flow.value);
  });
  largest.resize(std::min(largest.size(), kMostRows));
  size_t width = 7;
  for (const HeatRow* row : largest) width = std::max(width, row->name.size());
  std::string text =
      fmt::format("\nheat flows and temperatures\n  {:<{}}  {:>9}  {:>10}  {:<22}  {:<22}  {}\n", "surface", width,
                  "area", "emissivity", "temperature, K", "heat flux, W/m2", "heat flow, W");
  for (const HeatRow* row : largest)
    text +=
        fmt::format("  {:<{}}  {:9.4g}  {:10.4g}  {:<22}  {:<22}  {}\n", row->name, width, row->area, row->emissivity,
                    inDigits(row->temperature), inDigits(row->heat_flux), inDigits(row->heat_flow));
  if (rows.size() > largest.size()) text += fmt::format("  and {} more\n", rows.size() - largest.size());
  return text + "\n";
}

std::string describeLargest(const std::vector<HeatRow>& rows, double HeatBounds::*of, const char* name,
                            const char* unit) {
  const auto boundOf = [&](const HeatRow& row) { return row.bounds ? (*row.bounds).*of : 0; };
  const auto largest = std::ranges::max_element(rows, {}, boundOf);
  if (largest == rows.end() || !(boundOf(*largest) > 0)) return "";
  return fmt::format("{} {:.2g} {} ({})", name, boundOf(*largest), unit, largest->name);
}

std::string describeLargest(const std::vector<HeatRow>& rows, Measured HeatRow::*of, const char* name,
                            const char* unit) {
  const auto largest = std::ranges::max_element(
      rows, [&](const HeatRow& a, const HeatRow& b) { return (a.*of).standard_error < (b.*of).standard_error; });
  if (largest == rows.end() || !(((*largest).*of).standard_error > 0)) return "";
  return fmt::format("{} {:.1e} {} ({})", name, ((*largest).*of).standard_error, unit, largest->name);
}

}  // namespace

std::string describeHeat(const HeatSolution& solution, By by) {
  const std::vector<HeatRow>& rows = by == By::surface ? solution.surfaces : solution.rows;
  std::string text = tabulate(solution.surfaces);
  if (solution.is_open)
    text += fmt::format(
        "outside    {} W leave the scene{}\n", inDigits(solution.to_environment),
        solution.to_up && solution.to_down
            ? fmt::format(": {} above the horizon, {} below", inDigits(*solution.to_up), inDigits(*solution.to_down))
            : "");
  text +=
      fmt::format("balance    all heat flows{} add up to {:.1e} W, of {:.6g} W exchanged\n",
                  solution.is_open ? " and those outside" : "", solution.balance_residual, solution.heat_flow_total);
  const std::string temperature = describeLargest(rows, &HeatRow::temperature, "temperature", "K"),
                    flux = describeLargest(rows, &HeatRow::heat_flux, "heat flux", "W/m2");
  if (!temperature.empty() || !flux.empty())
    text += fmt::format("errors     largest standard errors: {}{}{}\n", temperature,
                        temperature.empty() || flux.empty() ? "" : ", ", flux);
  const std::string temperature_bound = describeLargest(rows, &HeatBounds::temperature, "temperature", "K"),
                    flux_bound = describeLargest(rows, &HeatBounds::heat_flux, "heat flux", "W/m2");
  if (!rows.empty() && rows.front().bounds)
    text += fmt::format("bounds     largest: {}{}{}\n", temperature_bound,
                        temperature_bound.empty() || flux_bound.empty() ? "" : ", ", flux_bound);
  return text + fmt::format(
                    "closure    row sums differ from 1 by at most {:.1e} ({}); such radiation returns to its "
                    "row\n",
                    std::abs(solution.largest_lack), solution.lacking_row);
}

}  // namespace viewpeel::program
