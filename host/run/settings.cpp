#include "run/settings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <viewpeel/error.h>

namespace viewpeel {

std::string identityOf(const Scene& scene) {
  return fmt::format("{} polygons, fingerprint {:016x}", scene.faces.size(), fingerprint(scene));
}

void addSettings(const SceneOptions& options, Settings& settings) {
  for (const std::string& name : options.sheets) settings.emplace_back("--sheets", name);
  for (const std::string& name : options.solids) settings.emplace_back("--solids", name);
  for (const std::string& name : options.flip) settings.emplace_back("--flip", name);
  if (options.fix_normals) settings.emplace_back("--fix-normals", "yes");
  if (options.unit_m != 1) settings.emplace_back("--units", fmt::format("{}", options.unit_m));
  for (const std::string& name : options.zones) settings.emplace_back("--zone", name);
  if (options.outside) settings.emplace_back("--outside", "yes");
  if (options.lod < INFINITY) settings.emplace_back("--lod", fmt::format("{}", options.lod));
}

SceneOptions sceneOptionsOf(const Settings& settings) {
  SceneOptions options;
  for (const auto& [name, value] : settings) {
    if (name == "--sheets") options.sheets.push_back(value);
    if (name == "--solids") options.solids.push_back(value);
    if (name == "--flip") options.flip.push_back(value);
    if (name == "--fix-normals") options.fix_normals = value == "yes";
    if (name == "--units") std::from_chars(value.data(), value.data() + value.size(), options.unit_m);
    if (name == "--zone") options.zones.push_back(value);
    if (name == "--outside") options.outside = value == "yes";
    if (name == "--lod") std::from_chars(value.data(), value.data() + value.size(), options.lod);
  }
  return options;
}

// Each option that changes counts has a line here, or in the other settingsOf().
Settings settingsOf(const Setup& setup) {
  const Request& request = setup.request();
  const Question& question = request.question;
  Settings all = {
      {"version", VIEWPEEL_VERSION},
      {"scene", identityOf(setup.scene())},
      {"--by", request.by == By::polygon ? "polygon" : "surface"},
      {"--two-sided", request.two_sided ? "yes" : "no"},
      {"--from", fmt::format("{}", fmt::join(question.from, ", "))},
      {"--pair", fmt::format("{}", fmt::join(question.pair, ", "))},
      {"--blocker", fmt::format("{}", fmt::join(question.blockers, ", "))},
      {"--seed", std::to_string(request.seed)},
      {"--sampling", setup.isExact()                          ? "exact areas"
                     : setup.sampling() == Sampling::scanline ? "scanline"
                                                              : "lattice"},
      {"--sampler", setup.sampler()},
  };
  addSettings(request.scene_options, all);
  const EpsilonDelta* guarantee = setup.guarantee();
  if (!guarantee) return all;
  if (guarantee->statistic == Statistic::median)
    throw Error(ErrorCode::bad_usage, "--checkpoint keeps means only; leave out --statistic median");
  if (setup.usesPairLines())
    throw Error(ErrorCode::bad_usage,
                "--checkpoint keeps a guarantee by common directions only; add --pair-lines off, or leave out "
                "--checkpoint");
  all.insert(all.end(),
             {{"--epsilon", fmt::format("{}", guarantee->epsilon)}, {"--delta", fmt::format("{}", guarantee->delta)}});
  return all;
}

bool mayBePlanned(const std::string& name) {
  constexpr std::array kPlanned = {"--unoccluded", "--pair-lines", "--directions", "--resolution",     "--finest",
                                   "--range",      "--block",      "--rays",       kAimsAtLargestError};
  return std::ranges::find(kPlanned, name) != kPlanned.end();
}

Settings settingsOf(const Setup& setup, const PlanSummary& plan) {
  Settings all = settingsOf(setup);
  all.emplace_back("--unoccluded", setup.usesUnoccluded() ? "on" : "off");
  if (setup.usesPairLines()) all.emplace_back("--pair-lines", "on");
  if (setup.countsSurfaces()) all.emplace_back(kAimsAtLargestError, "yes");
  if (plan.pair_lines && plan.pair_lines->has_rays) all.emplace_back("--rays", "on");
  if (plan.guarantee) {
    all.insert(all.end(), {{"--resolution", std::to_string(setup.resolution())},
                           {"--range", fmt::format("{}", plan.guarantee->range)},
                           {"--block", std::to_string(plan.guarantee->block_directions)}});
    return all;
  }
  all.insert(all.end(), {{"--directions", std::to_string(plan.directions)},
                         {"--resolution", setup.isExact() ? "any" : std::to_string(plan.lattices[0].resolution)},
                         {"--finest", plan.lattices.size() > 1 ? std::to_string(plan.finest) : "0"}});
  return all;
}

std::vector<std::pair<std::string, std::string>> parametersOf(const Settings& settings, const Estimate& estimate) {
  std::vector<std::pair<std::string, std::string>> parameters;
  const auto add = [&](const std::string& name, const std::string& value) {
    const std::string plain = name.substr(std::min(name.find_first_not_of('-'), name.size()));
    const auto same = std::ranges::find(parameters, plain, &std::pair<std::string, std::string>::first);
    if (same == parameters.end()) parameters.emplace_back(plain, value);
    else same->second += ", " + value;  // an option that was given several times
  };
  for (const auto& [name, value] : settings) add(name, value);
  add("replicates", std::to_string(estimate.replicates));
  // The settings have `directions` and `lines` of a replicate; all_directions and all_lines are of the whole run.
  add("all_directions", std::to_string(estimate.directions));
  add("all_lines", std::to_string(estimate.lines));
  add("largest_standard_error", fmt::format("{}", estimate.largest_standard_error));
  return parameters;
}

std::vector<std::pair<std::string, std::string>> parametersOf(const FormFactorRun& run, const Estimate& estimate) {
  const Request& request = run.request();
  const auto* guarantee = std::get_if<EpsilonDelta>(&request.goal);
  const bool has_checkpoint = !guarantee || (guarantee->statistic != Statistic::median && !run.plan().line_guarantee);
  if (has_checkpoint) return parametersOf(run.settings(), estimate);
  return parametersOf({{"version", VIEWPEEL_VERSION},
                       {"--by", request.by == By::polygon ? "polygon" : "surface"},
                       {"--two-sided", request.two_sided ? "yes" : "no"},
                       {"--seed", std::to_string(request.seed)},
                       {"--epsilon", fmt::format("{}", guarantee->epsilon)},
                       {"--delta", fmt::format("{}", guarantee->delta)},
                       {"--statistic", guarantee->statistic == Statistic::median ? "median" : "mean"}},
                      estimate);
}

}  // namespace viewpeel
