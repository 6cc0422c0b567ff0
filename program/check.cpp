#include <map>

#include <fmt/format.h>

#include "program/commands.h"
#include "program/options.h"
#include "program/result_json.h"
#include "program/summary.h"
#include "program/warnings.h"
#include "engines/engine_factory.h"
#include "engines/lattice.h"
#include <viewpeel/error.h>
#include "scene/leaks.h"
#include "scene/interpenetration.h"
#include "scene/read_groups.h"
#include "reference/exact/lattice_check.h"

namespace viewpeel::program {
namespace {

using reference::CheckReport;
using reference::CheckRow;

struct CheckCommand {
  std::vector<std::string> scene;  // its files
  std::string groups;
  SceneOptions scene_options;
  reference::CheckOptions check;
  EngineKind engine = EngineKind::compute;
  Sampling sampling = Sampling::lattice;
  DeviceOptions device;
  bool two_sided = false;
  bool json = false;
};

std::string tabulate(const CheckReport& report) {
  std::string text = fmt::format("  {:>10}  {:>15}  {:>22}  {:>16}  {:>15}  {:>21}\n", "resolution", "regions (pooled)",
                                 "deviation (allowed)", "spread/predicted", "counted/exact-1", "leak counted (exact)");
  for (const CheckRow& row : report.rows)
    text += fmt::format("  {:>10}  {:>16}  {:>22}  {:>16}  {:>15.1e}  {:>21}  {}\n", row.resolution,
                        fmt::format("{} ({})", row.regions_tested, row.regions_pooled),
                        fmt::format("{:.2f} ({:.2f})", row.largest_deviation, row.allowed_deviation),
                        row.spread_regions ? fmt::format("{:.2f}", row.spread_ratio) : "-",
                        row.total_counted / row.total_exact - 1,
                        fmt::format("{:.1e} ({:.1e})", row.leak_counted, row.leak_exact),
                        !row.unbiased              ? "BIASED"
                        : !row.spread_as_predicted ? "SPREAD IS OFF"
                                                   : "ok");
  for (const CheckRow& row : report.rows)
    text += fmt::format("  worst at {}: {}: mean difference {:.2e}, standard error {:.1e}\n", row.resolution,
                        row.worst_pair, row.worst_difference, row.worst_standard_error);
  return text;
}

int runCheck(const CheckCommand& command) {
  const Scene scene =
      loadGroupedScene({command.scene.begin(), command.scene.end()}, command.groups, command.scene_options);
  fmt::print("{}", command.json ? "" : describeCoincidences(scene));
  for (const std::string& warning : scene.warnings) warn(warning);
  if (!command.two_sided)
    for (const std::string& warning : warnOfBacks(scene)) warn(warning);
  // Polygons that pass through each other have no order along a line, so there is nothing to check.
  const auto interpenetrations = findInterpenetrations(scene);
  constexpr size_t kMostNamed = 10;
  for (size_t k = 0; k < std::min(interpenetrations.size(), kMostNamed); ++k)
    warn(fmt::format("{}; split them where they meet", describe(scene, interpenetrations[k])));
  if (interpenetrations.size() > kMostNamed)
    warn(fmt::format("{} more such places", interpenetrations.size() - kMostNamed));
  if (!interpenetrations.empty())
    throw Error(ErrorCode::check,
                fmt::format("{}: {} pairs of polygons pass through each other; mend them and check again", scene.file,
                            interpenetrations.size()));

  const Ids ids = makeIds(scene, By::polygon, command.two_sided);
  std::optional<Device> device;
  try {
    if (command.engine != EngineKind::host) device.emplace(command.device);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::device) throw;
    throw Error(error.code(), fmt::format("{}; --engine host checks the processor's counts without one", error.what()));
  }
  const EngineFactory make_engine = latticeEngines(command.engine, device ? &*device : nullptr);
  std::map<int, std::unique_ptr<Engine>> engines;
  for (int resolution : command.check.resolutions)
    engines[resolution] = make_engine(scene, ids,
                                      {.resolution = resolution,
                                       .sampling = command.sampling,
                                       .count_blocked = command.check.blocked,
                                       .batch_directions = 1});
  reference::CheckOptions options = command.check;
  if (command.sampling == Sampling::scanline) {
    if (command.engine == EngineKind::graphics)
      throw Error(ErrorCode::bad_usage, "--sampling scanline needs --engine compute or host");
    options.variance = reference::kScanlineVariance;
    options.counts_per_point =
        pointArea(options.resolutions.front()) / engines.at(options.resolutions.front())->unitArea();
  }
  const auto count = [&](const Direction& direction, int resolution) {
    return engines.at(resolution)->count({&direction, 1});
  };
  const CheckReport report = reference::checkLattice(scene, ids, count, options);
  if (device) checkValidation(*device);
  if (command.json) {
    Json json = startReport();
    addScene(json, scene);
    json.update(jsonOf(report));
    printReport(std::move(json));
  } else {
    fmt::print("{}{}{}", device ? describeDevice(device->description()) : describeProcessor(), describeScene(scene),
               fmt::format("check      {} directions, {} random lattices each: h^2 x counts against exact areas, "
                           "chance of a false alarm {:.0e}\n\n",
                           command.check.directions, command.check.lattices, command.check.false_alarm_rate));
    fmt::print(
        "{}\nexact {:.1f} s, counting {:.1f} s\n{}\n", tabulate(report), report.exact_seconds, report.counting_seconds,
        report.passes() ? "The lattice counts behave as claimed." : "The lattice counts do NOT behave as claimed.");
  }
  return report.passes() ? 0 : 1;
}

}  // namespace

void addCheck(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<CheckCommand>();
  CLI::App* command =
      app.add_subcommand("check", "Check lattice counts against exact areas; exit status 1 where they do not agree");
  command->add_option("SCENE", options->scene, kSceneText)->required();
  startGroup(command, kHowExact);
  command->add_option("--directions", options->check.directions, "Random directions")
      ->type_name("N")
      ->transform(isWholeNumberFrom(1, 1u << 20))
      ->capture_default_str();
  command->add_option("--lattices", options->check.lattices, "Random lattices per direction")
      ->type_name("M")
      ->transform(isWholeNumberFrom(8, 1u << 20))
      ->capture_default_str();
  command->add_option("--resolution", options->check.resolutions, "Lattice spacings across the scene's diameter")
      ->type_name("PX")
      ->transform(isWholeNumberFrom(1, kMaxResolution))
      ->allow_extra_args(false)
      ->capture_default_str();
  startGroup(command, kMachine);
  addChoice(command, "--engine", options->engine,
            {{"compute", EngineKind::compute}, {"host", EngineKind::host}, {"graphics", EngineKind::graphics}},
            "The engine to check");
  startGroup(command, kMethod);
  addChoice(command, "--sampling", options->sampling,
            {{"lattice", Sampling::lattice}, {"scanline", Sampling::scanline}}, "The samples to check");
  command->add_option("--seed", options->check.seed, "Seed of directions and lattices")
      ->type_name("K")
      ->check(isWholeNumber)
      ->capture_default_str();
  startGroup(command, kWhat);
  command->add_flag("--blocked", options->check.blocked, "Pairs whose fronts look at each other past something, too");
  addSceneOptions(command, options->scene_options);
  addGroupsOption(command, options->groups);
  command->add_flag("--two-sided", options->two_sided, "Every polygon emits and receives on both sides");
  startGroup(command, kMachine);
  addThreadsOption(command);
  command->add_option("--device", options->device.selector, "Vulkan device: index, part of its name, cpu or gpu")
      ->type_name("DEVICE");
  startGroup(command, kOutput);
  command->add_flag("--json", options->json, kJsonHelp);
  command->callback([options, &chosen] { chosen = [options] { return runCheck(*options); }; });
}

}  // namespace viewpeel::program
