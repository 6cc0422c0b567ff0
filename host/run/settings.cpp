#include "run/settings.h"

#include <algorithm>
#include <array>

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
}

SceneOptions sceneOptionsOf(const Settings& settings) {
  SceneOptions options;
  for (const auto& [name, value] : settings) {
    if (name == "--sheets") options.sheets.push_back(value);
    if (name == "--solids") options.solids.push_back(value);
    if (name == "--flip") options.flip.push_back(value);
    if (name == "--fix-normals") options.fix_normals = value == "yes";
  }
  return options;
}

// An option that changes counts has its line here, or below.
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
  constexpr std::array kPlanned = {"--unoccluded", "--pair-lines", "--directions", "--resolution",
                                   "--finest",     "--range",      "--block"};
  return std::ranges::find(kPlanned, name) != kPlanned.end();
}

Settings settingsOf(const Setup& setup, const PlanSummary& plan) {
  Settings all = settingsOf(setup);
  all.emplace_back("--unoccluded", setup.usesUnoccluded() ? "on" : "off");
  if (setup.usesPairLines()) all.emplace_back("--pair-lines", "on");
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

}  // namespace viewpeel
