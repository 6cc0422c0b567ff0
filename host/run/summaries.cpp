#include "run/summaries.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

std::vector<LatticeSummary> summariseGroups(const std::vector<SizeGroup>& groups) {
  std::vector<LatticeSummary> lattices{{groups[0].resolution, 1, groups[0].polygons.size()}};
  for (size_t g = 1; g < groups.size(); ++g) {
    if (g == 1 || groups[g].resolution != lattices.back().resolution) lattices.push_back({groups[g].resolution, 0, 0});
    ++lattices.back().windows;
    lattices.back().polygons += groups[g].polygons.size();
  }
  return lattices;
}

// Returns the goal as a standard error, or as a relative one for a relative goal; infinite where there is none.
double goalOf(const Request& request) {
  if (const auto* tolerance = std::get_if<Tolerance>(&request.goal)) return tolerance->standard_error;
  if (const auto* rms = std::get_if<RootMeanSquare>(&request.goal)) return rms->standard_error;
  const auto* relative = std::get_if<Relative>(&request.goal);
  return relative ? relative->standard_error : INFINITY;
}

std::optional<PlanSummary::GoalCost> costBeyond(const Request& request, const Plan& plan) {
  const double goal = goalOf(request);
  if (!(plan.pilot_seconds > 0) || !(plan.standard_error > goal)) return std::nullopt;
  const double more = std::pow(plan.standard_error / goal, 2);
  return PlanSummary::GoalCost{goal, std::ceil(more * request.amount.replicates), more * plan.seconds};
}

}  // namespace

PlanSummary summarise(const Setup& setup) {
  PlanSummary summary;
  summary.engine = setup.engine();
  summary.device = setup.deviceName();
  summary.sampling = setup.sampling();
  summary.sampler = setup.sampler();
  summary.unoccluded = setup.usesUnoccluded();
  return summary;
}

PlanSummary summarise(const Setup& setup, const Plan& plan) {
  PlanSummary summary = summarise(setup);
  summary.directions = plan.directions;
  summary.lattices = summariseGroups(plan.groups);
  summary.finest = plan.finest;
  summary.seconds = plan.seconds;
  summary.standard_error = plan.standard_error;
  summary.pilot_seconds = plan.pilot_seconds;
  summary.goal_beyond_request = costBeyond(setup.request(), plan);
  summary.pair_lines = plan.pair_lines;
  summary.aims_at_largest_error = plan.pair_lines || setup.countsSurfaces();
  for (uint32_t id : plan.barely_covered) summary.barely_covered.push_back(setup.ids().names[id]);
  return summary;
}

PlanSummary summarise(const Setup& setup, const GuaranteePlan& plan) {
  PlanSummary summary = summarise(setup);
  summary.directions = plan.block_directions;
  summary.lattices = summariseGroups(plan.groups);
  summary.guarantee = plan;
  if (!plan.visibility_bounds) return summary;
  summary.unoccluded_pairs = plan.prior.pairs.size();
  summary.pairs_with_visibility = std::count_if(plan.prior.pairs.begin(), plan.prior.pairs.end(),
                                                [](const PairPrior& pair) { return pair.visibility > 0; });
  return summary;
}

PriorSummary summarise(const FoundPrior& found) {
  PriorSummary summary;
  for (const PairPrior& pair : found.prior.pairs) {
    summary.pairs += pair.j < kEnvironment;
    summary.never_blocked += pair.j < kEnvironment && pair.visibility == kVisibilityOne;
  }
  summary.unreached = found.unreached;
  summary.directed_pairs = found.prior.directed.size();
  for (const DirectedPair& pair : found.prior.directed) summary.directed_directions += pair.directions;
  summary.pilot_seconds = found.pilot_seconds;
  summary.unoccluded_seconds = found.unoccluded_seconds;
  summary.directed_seconds = found.directed_seconds;
  return summary;
}

std::string optionsOf(const PlanSummary& plan) {
  if (plan.line_guarantee) return "--promise on";
  if (plan.pair_lines) return plan.pair_lines->least_form_factor > 0 ? "--promise off" : "--pair-lines on";
  return fmt::format("--directions {} --resolution {}{}{}{}", plan.directions, plan.lattices[0].resolution,
                     plan.lattices.size() > 1 ? fmt::format(" --finest {}", plan.finest) : "",
                     plan.sampling == Sampling::scanline ? " --sampling scanline" : "",
                     plan.unoccluded ? " --unoccluded on" : "");
}

std::string inWords(double seconds) {
  if (seconds < 0.01) return "less than 0.01 s";
  if (seconds < 99.5) return fmt::format("{:.2g} s", seconds);
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} minutes", seconds / 60);
  if (seconds < 48 * 3600) return fmt::format("{:.0f} hours", seconds / 3600);
  return fmt::format("{:.3g} days", seconds / 86400);
}

void refuseGuarantee(const GuaranteeFigures& plan, double time_limit_s) {
  throw Error(ErrorCode::bad_usage,
              fmt::format("a guarantee of {} takes {} at least, {} at most, more than --seconds {}; ask for a larger "
                          "--epsilon, or an estimate by --tolerance",
                          plan.epsilon, inWords(plan.least_seconds), inWords(plan.most_seconds), time_limit_s));
}

void refuseGuarantee(const LineGuaranteeFigures& plan, double time_limit_s) {
  throw Error(ErrorCode::bad_usage,
              fmt::format("a guarantee of {} takes about {}, {} at most, more than --seconds {}; ask for a larger "
                          "--epsilon, or an estimate by --tolerance",
                          plan.epsilon, inWords(plan.expected_seconds), inWords(plan.most_seconds), time_limit_s));
}

double shareOf(const FormFactors& form_factors, uint32_t column) {
  double exchange = 0, area = 0;
  for (const auto& entry : form_factors.entries())
    if (entry.j == column) exchange += entry.exchange_area.value;
  for (uint32_t k = 0; k < form_factors.ids().count(); ++k)
    if (form_factors.ids().isRequested(k)) area += form_factors.ids().areas[k];
  return exchange / area;
}

}  // namespace viewpeel
