#include "program/result_json.h"

#include <numeric>

#include "program/summary.h"
#include "run/summaries.h"
#include "scene/leaks.h"

namespace viewpeel::program {
namespace {

const char* nameOf(EngineKind kind) {
  switch (kind) {
    case EngineKind::automatic:
      return "auto";
    case EngineKind::compute:
      return "compute";
    case EngineKind::host:
      return "host";
    case EngineKind::graphics:
      return "graphics";
    case EngineKind::exact:
      return "exact";
  }
  return "";
}

Json balancedJson(const BalancedFormFactors& balanced) {
  const std::vector<std::string>& names = balanced.form_factors.ids().names;
  return {{"largest", measureClosure(balanced.form_factors).largest_error},
          {"steps", balanced.steps},
          {"rms_change", balanced.rms_change},
          {"largest_change", balanced.largest_change},
          {"largest_form_factor_change", balanced.largest_form_factor_change},
          {"from", names[balanced.from]},
          {"to", names[balanced.to]}};
}

Json workJson(const Work& work) {
  Json seconds = Json::object();
  for (const auto& [pass, time_s] : work.pass_seconds) seconds[pass] = time_s;
  return {{"directions", work.directions},
          {"lattice_points", work.lattice_points},
          {"tiles", work.tiles},
          {"active_tiles", work.active_tiles},
          {"list_entries", work.list_entries},
          {"rows", work.rows},
          {"spans", work.spans},
          {"samples", work.samples},
          {"rounds", work.rounds},
          {"tests", work.tests},
          {"layers", work.fragments},
          {"gaps", work.gaps},
          {"repeats", work.repeats},
          {"resumed", work.resumed},
          {"bytes", work.memory_bytes},
          {"pass_seconds", std::move(seconds)}};
}

Json guaranteeJson(const GuaranteeFigures& g) {
  return {{"epsilon", g.epsilon},
          {"delta", g.delta},
          {"bounds", g.bounds},
          {"range", g.range},
          {"block_directions", g.block_directions},
          {"least_blocks", g.least_blocks},
          {"expected_blocks", g.expected_blocks},
          {"most_blocks", g.most_blocks},
          {"least_seconds", g.least_seconds},
          {"expected_seconds", g.expected_seconds},
          {"most_seconds", g.most_seconds}};
}

Json guaranteeJson(const LineGuaranteeFigures& g) {
  return {{"epsilon", g.epsilon},
          {"delta", g.delta},
          {"exact", g.exact},
          {"bounded", g.bounded},
          {"drawn", g.drawn},
          {"expected_lines", g.expected_lines},
          {"most_lines", g.most_lines},
          {"plan_seconds", g.plan_seconds},
          {"expected_seconds", g.expected_seconds},
          {"most_seconds", g.most_seconds}};
}

}  // namespace

Json jsonOf(const PlanSummary& plan) {
  Json json = {{"engine", nameOf(plan.engine)},
               {"device", plan.device},
               {"sampling", plan.engine == EngineKind::exact      ? "exact areas"
                            : plan.sampling == Sampling::scanline ? "scanline"
                                                                  : "lattice"},
               {"sampler", plan.sampler},
               {"unoccluded", plan.unoccluded},
               {"directions", plan.directions},
               {"plan_seconds", plan.plan_seconds}};
  Json lattices = Json::array();
  for (const LatticeSummary& lattice : plan.lattices)
    lattices.push_back(
        {{"resolution", lattice.resolution}, {"windows", lattice.windows}, {"polygons", lattice.polygons}});
  if (plan.engine != EngineKind::exact) json["lattices"] = std::move(lattices);
  if (plan.pilot_seconds > 0) {
    json["expected_seconds"] = plan.seconds;
    json["expected_standard_error"] = plan.standard_error;
    json["pilot_seconds"] = plan.pilot_seconds;
    json["same_again"] = optionsOf(plan);
  }
  if (const auto& goal = plan.goal_beyond_request)
    json["goal"] = {{"standard_error", goal->standard_error},
                    {"replicates", goal->replicates},
                    {"expected_seconds", goal->seconds}};
  if (!plan.barely_covered.empty()) json["barely_covered"] = plan.barely_covered;
  if (const auto& lines = plan.pair_lines)
    json["pair_lines"] = {{"clear", lines->clear},       {"partial", lines->partial}, {"lines", lines->lines},
                          {"blockers", lines->blockers}, {"rays", lines->has_rays},   {"plan_seconds", lines->seconds}};
  if (plan.guarantee) json["guarantee"] = guaranteeJson(*plan.guarantee);
  if (plan.line_guarantee) json["guarantee"] = guaranteeJson(*plan.line_guarantee);
  return json;
}

Json jsonOf(const DeviceDescription& device) {
  Json json = {{"index", device.index},   {"name", device.name},  {"kind", device.kind},
               {"driver", device.driver}, {"vulkan", device.api}, {"usable", device.refusal.empty()}};
  if (!device.refusal.empty()) json["refusal"] = device.refusal;
  return json;
}

Json jsonOf(const reference::CheckReport& report) {
  Json rows = Json::array();
  for (const reference::CheckRow& row : report.rows)
    rows.push_back({{"resolution", row.resolution},
                    {"regions_tested", row.regions_tested},
                    {"regions_pooled", row.regions_pooled},
                    {"largest_deviation", row.largest_deviation},
                    {"allowed_deviation", row.allowed_deviation},
                    {"worst_pair", row.worst_pair},
                    {"worst_difference", row.worst_difference},
                    {"worst_standard_error", row.worst_standard_error},
                    {"spread_regions", row.spread_regions},
                    {"spread_ratio", row.spread_ratio},
                    {"total_counted", row.total_counted},
                    {"total_exact", row.total_exact},
                    {"leak_counted", row.leak_counted},
                    {"leak_exact", row.leak_exact},
                    {"unbiased", row.unbiased},
                    {"spread_as_predicted", row.spread_as_predicted}});
  return {{"passes", report.passes()},
          {"exact_seconds", report.exact_seconds},
          {"counting_seconds", report.counting_seconds},
          {"resolutions", std::move(rows)}};
}

void addScene(Json& report, const Scene& scene) {
  const Ids ids = makeIds(scene, By::polygon, false);
  report["scene"] = scene.file;
  report["polygons"] = scene.faces.size();
  report["surfaces"] = scene.surfaces.size();
  report["area"] = std::accumulate(ids.areas.begin(), ids.areas.end(), 0.0);
  report["radius"] = scene.scale;
  report["closedness"] = describeClosedness(scene);
}

void addEstimate(Json& report, const Estimate& estimate) {
  const FormFactors& f = estimate.form_factors;
  const StandardErrors errors = measureStandardErrors(f, 0);
  report["ids"] = f.ids().count();
  report["replicates"] = estimate.replicates;
  report["directions"] = estimate.directions;
  report["interrupted"] = estimate.interrupted;
  report["largest_standard_error"] = estimate.largest_standard_error;
  report["rms_standard_error"] = errors.rms;
  report["nonzero_form_factors"] = errors.count;
  report["rms_with_zeros"] = errors.rms_with_zeros;
  if (estimate.unmet_pairs)
    report["unmet"] = {{"pairs", estimate.unmet_pairs}, {"largest_standard_error", estimate.largest_unmet_error}};
  if (estimate.unseen_pairs)
    report["unseen"] = {{"pairs", estimate.unseen_pairs}, {"largest_standard_error", estimate.largest_unseen_error}};
  if (estimate.lines) report["pair_lines"] = {{"pairs", estimate.line_pairs}, {"lines", estimate.lines}};
  if (estimate.directed_pairs)
    report["directed"] = {{"pairs", estimate.directed_pairs}, {"directions", estimate.directed_directions}};
  if (const auto& g = estimate.guarantee)
    report["guarantee"] = {
        {"epsilon", g->epsilon}, {"delta", g->delta}, {"bound", g->bound}, {"row_bound", g->row_bound}};
  if (!f.ids().rows_sum_to_one) return;
  const Closure closure = measureClosure(f);
  report["closure"] = {{"largest", closure.largest_error},
                       {"standard_error", closure.standard_error},
                       {"rms", closure.rms_error},
                       {"row", closure.row}};
  report["environment_share"] = shareOf(f, kEnvironment);
  report["leak_share"] = shareOf(f, kLeak);
}

void addResult(Json& report, const Result& result) {
  report["device"] = result.plan.device;
  report["plan"] = jsonOf(result.plan);
  addEstimate(report, result);
  report["seconds"] = result.seconds;
  if (!result.plan.no_promise.empty()) report["no_promise"] = result.plan.no_promise;
  if (!result.plan.no_pair_lines.empty()) report["no_pair_lines"] = result.plan.no_pair_lines;
  report["goal_reached"] = result.goal_reached;
  // Version 0.1 used the name `closed`.
  if (result.balanced) report["balanced"] = report["closed"] = balancedJson(*result.balanced);
  if (result.work) report["work"] = workJson(*result.work);
}

void addHeat(Json& report, const HeatSolution& solution, By by) {
  Json rows = Json::array();
  for (const HeatRow& row : by == By::surface ? solution.surfaces : solution.rows) {
    Json json = {{"name", row.name}, {"area", row.area}, {"emissivity", row.emissivity}};
    const auto add = [&](const char* name, const Measured& value, double HeatBounds::*bound) {
      json[name] = value.value;
      json[std::string(name) + "_standard_error"] = value.standard_error;
      if (row.bounds) json[std::string(name) + "_bound"] = (*row.bounds).*bound;
    };
    add("temperature", row.temperature, &HeatBounds::temperature);
    add("radiosity", row.radiosity, &HeatBounds::radiosity);
    add("irradiation", row.irradiation, &HeatBounds::irradiation);
    add("heat_flux", row.heat_flux, &HeatBounds::heat_flux);
    add("heat_flow", row.heat_flow, &HeatBounds::heat_flow);
    rows.push_back(std::move(json));
  }
  report["heat"] = {{"rows", std::move(rows)},
                    {"is_open", solution.is_open},
                    {"to_environment", solution.to_environment.value},
                    {"to_environment_standard_error", solution.to_environment.standard_error},
                    {"balance_residual", solution.balance_residual},
                    {"heat_flow_total", solution.heat_flow_total}};
  for (const auto& [name, part] : {std::pair("to_up", solution.to_up), std::pair("to_down", solution.to_down)}) {
    if (!part) continue;
    report["heat"][name] = part->value;
    report["heat"][std::string(name) + "_standard_error"] = part->standard_error;
  }
}

}  // namespace viewpeel::program
