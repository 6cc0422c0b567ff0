#include <viewpeel/solve.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "solve/check_enclosure.h"
#include "solve/closed_exchange.h"
#include "solve/directional_law.h"
#include "stopwatch.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr double kFirstTolerance = 0.02, kLeastTolerance = 2e-6;
// The next tolerance aims below the goal for the answers' error, so that chance seldom makes another run necessary.
constexpr double kErrorMargin = 0.8, kMostReduction = 1e-2, kLeastReduction = 0.7;

const char* unitOf(HeatTolerance::Of of) {
  return of == HeatTolerance::Of::temperature ? " K" : of == HeatTolerance::Of::heat_flux ? " W/m2" : " of the heat";
}

// Measures form factors to sky and ground separately, at the tolerance of the other form factors.
void measureParts(const Scene& scene, const MaterialTable& materials, const Request& request, const Observer& observer,
                  Enclosure& enclosure) {
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  EnvironmentRequest parts{.by = request.by, .two_sided = request.two_sided, .up = materials.up};
  if (tolerance) parts.tolerance = tolerance->standard_error;
  parts.seed = request.seed;
  parts.threads = request.threads;
  parts.time_limit_s = request.time_limit_s;
  enclosure.environment_parts = measureEnvironment(scene, parts, observer);
}

SceneHeat solveOnce(const Scene& scene, const MaterialTable& materials, Enclosure& enclosure, const Request& request,
                    const Observer& observer) {
  Request estimated = request;
  estimated.lines_for_all = true;
  // Estimates have standard errors, from which errors of answers follow. A guarantee on request gives bounds.
  if (!std::holds_alternative<EpsilonDelta>(request.goal)) estimated.promise = request.promise.value_or(false);
  Result result = computeFormFactors(scene, estimated, observer);
  if (result.interrupted && result.replicates < 2)
    throw Error(ErrorCode::limit, "the run was stopped before its form factors had errors; let it run longer");
  // Intervals of common directions have no entry for pairs that no line met, so answers get no bounds from them.
  const bool has_all_intervals = result.guarantee && result.guarantee->by == GuaranteedBy::chernoff;
  const FormFactors& found = result.form_factors;
  requireNoLeak(found, &scene);
  if (enclosure.sky_and_ground && result.environment_share > 0)
    measureParts(scene, materials, request, observer, enclosure);
  HeatSolution heat = has_all_intervals || !found.hasIntervals()
                          ? solveHeat(found, enclosure)
                          : solveHeat(FormFactors(found.ids(), found.entries(), found.rowSums()), enclosure);
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  return {std::move(heat), std::move(result), 1, tolerance ? tolerance->standard_error : 0};
}

}  // namespace

double largestHeatError(const HeatSolution& solution, HeatTolerance::Of of) {
  double largest = 0;
  for (const HeatRow& row : solution.rows)
    largest = std::max(largest, of == HeatTolerance::Of::temperature ? row.temperature.standard_error
                                : of == HeatTolerance::Of::heat_flux ? row.heat_flux.standard_error
                                                                     : row.heat_flow.standard_error);
  if (of != HeatTolerance::Of::relative || largest == 0) return largest;
  return largest / solution.heat_flow_total;
}

SceneHeat solveScene(const Scene& scene, const MaterialTable& materials, Request request,
                     std::optional<HeatTolerance> tolerance, const Observer& observer) {
  std::vector<std::string> surface_names;
  for (const Surface& surface : scene.surfaces) surface_names.push_back(surface.name);
  Enclosure enclosure = assignMaterials(materials, makeIds(scene, request.by, request.two_sided), surface_names);
  requireDiffuse(enclosure);
  if (!tolerance) return solveOnce(scene, materials, enclosure, request, observer);

  requireTolerance(*tolerance, enclosure);
  const auto start = Clock::now();
  const std::optional<double> limit_s = request.time_limit_s;
  double of_form_factors = kFirstTolerance;
  for (uint32_t runs = 1;; ++runs) {
    request.goal = Tolerance{of_form_factors};
    if (limit_s) request.time_limit_s = std::max(*limit_s - secondsSince(start), 1e-3);
    SceneHeat found = solveOnce(scene, materials, enclosure, request, observer);
    found.runs = runs;
    const double error = largestHeatError(found.heat, tolerance->of);
    if (error <= tolerance->standard_error) return found;
    const bool is_time_up = limit_s && secondsSince(start) >= *limit_s;
    if (is_time_up || found.form_factors.interrupted) {
      found.is_reached = false;
      return found;
    }
    if (of_form_factors <= kLeastTolerance)
      throw Error(
          ErrorCode::limit,
          fmt::format("the tolerance is out of reach: form factors to {:.0e} leave a standard error of {:.2g}{}; "
                      "ask for more",
                      of_form_factors, error, unitOf(tolerance->of)));
    const double reduction =
        std::clamp(kErrorMargin * tolerance->standard_error / error, kMostReduction, kLeastReduction);
    of_form_factors = std::max(of_form_factors * reduction, kLeastTolerance);
  }
}

}  // namespace viewpeel
