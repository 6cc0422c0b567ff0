#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <viewpeel/solve.h>

#include "program/command_line.h"
#include "program/commands.h"
#include "program/describe_heat.h"
#include "program/heat_outputs.h"
#include "program/options.h"
#include "program/outputs.h"
#include "program/progress_line.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/solve_command.h"
#include "program/summary.h"
#include "program/warnings.h"
#include <viewpeel/error.h>
#include <viewpeel/ranks.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

std::string describeTolerance(const HeatTolerance& tolerance, double reached) {
  using Of = HeatTolerance::Of;
  const char* unit = tolerance.of == Of::temperature ? " K" : tolerance.of == Of::heat_flux ? " W/m2" : " of all heat";
  return fmt::format("{:.2g}{}, {:.2g} asked for", reached, unit, tolerance.standard_error);
}

std::string describeMaterials(const MaterialTable& table, const HeatSolution& solution) {
  std::string text = fmt::format("materials  {}: {} for {}", table.file, counted(table.lines.size(), "line"),
                                 counted(solution.rows.size(), "row"));
  if (!table.laws.empty()) text += fmt::format(", {}", counted(table.laws.size(), "directional law"));
  if (table.environment_temperature) text += fmt::format(", environment {} K", *table.environment_temperature);
  if (const auto& parts = table.sky_and_ground)
    text += fmt::format(", environment {} K above and {} K below the horizon", parts->up, parts->down);
  return text + "\n";
}

void warnOfEnvironment(const MaterialTable& table, const HeatSolution& solution) {
  if ((table.environment_temperature || table.sky_and_ground) && !solution.is_open)
    warn(fmt::format("{}: no radiation leaves the scene, so that its environment has no effect", table.file));
}

void writeExchanges(const SolveCommand& command, const FormFactors& form_factors, const Enclosure& enclosure) {
  if (!command.exchange) return;
  const ExchangeFactors factors = findExchangeFactors(form_factors, enclosure, command.drop_below);
  for (const std::string& output : command.outputs)
    writeExchange(factors, *command.exchange, exchangeFileOf(output, *command.exchange));
  if (!command.talks()) return;
  fmt::print("exchange   {}", counted(factors.entries.size(), "conductor"));
  if (factors.dropped)
    fmt::print("; {} below {} were dropped, {:.2g} of a row at most, and the rest balanced",
               counted(factors.dropped, "pair"), command.drop_below, factors.largest_dropped_share);
  fmt::print("\n");
}

void conclude(const SolveCommand& command, const MaterialTable& table, const HeatSolution& solution,
              const OutputContent& content) {
  warnOfEnvironment(table, solution);
  writeHeatOutputs(content, command.request.by, command.outputs);
  if (!command.talks()) return;
  fmt::print("{}{}", describeMaterials(table, solution), describeHeat(solution, command.request.by));
}

void printJson(const SolveCommand& command, const HeatSolution& heat, const FormFactors& form_factors,
               const Estimate& estimate, const SceneHeat* found) {
  Json report = startReport();
  if (found) {
    addResult(report, found->form_factors);
    report["runs"] = found->runs;
    report["goal_reached"] = found->is_reached && found->form_factors.goal_reached;
  } else {
    addEstimate(report, estimate);
  }
  addHeat(report, heat, command.request.by);
  report["files"] = jsonOf(command.files);
  printReport(std::move(report), OutputContent{form_factors});
}

namespace {

// Warns of temperatures that look like degrees Celsius: the highest of all is above 0 and below 100 K.
void warnOfCelsius(const MaterialTable& table) {
  constexpr double kBoiling = 100;  // degrees Celsius; rooms, cities and spacecraft are warmer in kelvins
  double highest = table.environment_temperature.value_or(0);
  if (const auto& parts = table.sky_and_ground) highest = std::max(parts->up, parts->down);
  for (const MaterialTable::Line& line : table.lines)
    highest = std::max(highest, line.material.temperature.value_or(0));
  if (highest > 0 && highest < kBoiling)
    warn(fmt::format(
        "{}: no temperature is above {} K; temperatures are in kelvins, and 20 degrees Celsius are 293.15 K",
        table.file, highest));
}

}  // namespace

MaterialTable readTable(const SolveCommand& command) {
  MaterialTable table = readMaterials(command.materials);
  warnOfCelsius(table);
  if (command.up && !table.sky_and_ground)
    throw Error(ErrorCode::bad_usage,
                fmt::format("--up: {} has neither environment:up nor environment:down; leave out --up, or give them "
                            "temperatures",
                            command.materials));
  if (command.up) table.up = *command.up;
  return table;
}

namespace {

// Reads "0.1K", "2W/m2", "1%" or "0.01".    Throws: CLI::ValidationError.
HeatTolerance toleranceOf(const std::string& text) {
  using Of = HeatTolerance::Of;
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string unit(end, text.data() + text.size());
  const bool is_number = failure == std::errc() && std::isfinite(value) && value > 0;
  if (is_number && unit == "K") return {value, Of::temperature};
  if (is_number && unit == "W/m2") return {value, Of::heat_flux};
  if (is_number && unit == "%") return {value / 100, Of::relative};
  if (is_number && unit.empty()) return {value, Of::relative};
  throw CLI::ValidationError("--tolerance",
                             fmt::format("'{}' is not a number above 0 with a unit: 0.1K, 2W/m2, 1% or 0.01", text));
}

const std::map<std::string, ExchangeKind> kExchangeKinds = {{"gebhart", ExchangeKind::gebhart},
                                                            {"script-f", ExchangeKind::script_f},
                                                            {"esatan", ExchangeKind::esatan},
                                                            {"sinda", ExchangeKind::sinda}};

int solveFile(const SolveCommand& command) {
  const MaterialTable table = readTable(command);
  checkMatrixFree(command, table);
  if (command.epsilon && !table.band_limits_um.empty())
    throw Error(ErrorCode::bad_usage,
                fmt::format("--epsilon: there are no bounds with bands of wavelengths, which {} has; leave it out",
                            command.materials));
  if (command.exchange && !table.band_limits_um.empty())
    throw Error(ErrorCode::bad_usage,
                fmt::format("--exchange: exchange factors are of grey surfaces, and {} has bands; leave it out",
                            command.materials));
  if (command.epsilon && table.sky_and_ground)
    throw Error(ErrorCode::bad_usage,
                fmt::format("--epsilon: there are no bounds with sky and ground apart; leave it out, or give one "
                            "temperature to 'environment' in {}",
                            command.materials));
  Request request = command.request;
  request.goal = Tolerance{command.form_factor_tolerance.value_or(Tolerance{}.standard_error)};
  if (command.epsilon) {
    request.goal = EpsilonDelta{.epsilon = *command.epsilon, .delta = command.delta};
    request.pair_lines = true;  // pair lines give an interval for each pair
  }
  checkRequest(request);
  const Scene scene = loadSceneOf(command.scene, request.scene_options, command.groups);
  if (command.talks()) fmt::print("{}", describeScene(scene));
  std::fflush(stdout);
  if (isMatrixFree(command, table, scene)) return solveWithoutMatrix(command, table, scene);
  ProgressLine progress(request, !command.quiet);
  const SceneHeat found = solveScene(scene, table, request, command.tolerance, {.on_progress = progress.listener()});
  progress.clear();
  for (const std::string& warning : found.form_factors.warnings) warn(warning);
  const OutputContent content{.form_factors = found.form_factors.form_factors,
                              .scene = &scene,
                              .parameters = {{"version", VIEWPEEL_VERSION},
                                             {"by", request.by == By::surface ? "surface" : "polygon"},
                                             {"two-sided", request.two_sided ? "yes" : "no"},
                                             {"seed", std::to_string(request.seed)},
                                             {"materials", table.file},
                                             {"command", commandLine()}},
                              .heat = &found.heat};
  conclude(command, table, found.heat, content);
  if (const auto& guarantee = found.form_factors.guarantee; guarantee && command.talks())
    fmt::print("guarantee  every form factor within {:.3g}, and all answers within their bounds, with probability {}\n",
               guarantee->bound, 1 - guarantee->delta);
  const FormFactors& form_factors = found.form_factors.form_factors;
  writeExchanges(command, form_factors,
                 assignMaterials(table, form_factors.ids(), found.form_factors.between_surfaces.ids().names));
  if (command.tolerance) {
    const double reached = largestHeatError(found.heat, command.tolerance->of);
    const std::string text = describeTolerance(*command.tolerance, reached);
    if (!found.is_reached) warn(fmt::format("time was up before the tolerance: standard errors of {}", text));
    if (command.talks())
      fmt::print("tolerance  standard errors up to {}; form factors to {:.2g} in {}\n", text,
                 found.form_factor_tolerance, counted(found.runs, "run"));
  }
  if (command.json) printJson(command, found.heat, form_factors, found.form_factors, &found);
  if (command.talks())
    fmt::print("work       {}, {}{}, {}; {:.2f} s\n", counted(found.form_factors.replicates, "replicate"),
               counted(found.form_factors.directions, "direction"), describeDirected(found.form_factors),
               counted(found.heat.steps, "step") + " of conjugate gradients", found.form_factors.seconds);
  return 0;
}

int runSolve(SolveCommand command) {
  if (command.scene.empty() && command.stored.empty())
    throw Error(ErrorCode::bad_usage, "solve needs a scene, or form factors by --from-result");
  checkHeatOutputs(command.outputs, command.exchange, !command.scene.empty());
  command.files = planFiles(heatFilesOf(command.outputs, command.exchange));
  const int status = command.stored.empty() ? solveFile(command) : solveStored(command);
  if (command.talks()) fmt::print("{}", describeWritten(command.files));
  return status;
}

void addComputing(CLI::App* command, SolveCommand& options) {
  startGroup(command, kHowExact);
  std::vector<CLI::Option*> computing;
  computing.push_back(command
                          ->add_option_function<std::string>(
                              "--tolerance",
                              [&options](const std::string& text) { options.tolerance = toleranceOf(text); },
                              "Compute until the largest standard error of the answers is at most this: of "
                              "temperatures (0.1K), heat fluxes (2W/m2), or heat flows as a share of all heat (1%)")
                          ->type_name("T"));
  computing.push_back(
      command
          ->add_option_function<double>(
              "--form-factors", [&options](const double& value) { options.form_factor_tolerance = value; },
              "Largest standard error of form factors, as of compute --tolerance; 1e-3 unless --tolerance is given")
          ->type_name("T")
          ->check([](const std::string& text) { return isNumber(text, 1e-9, 1); })
          ->excludes(computing.front()));
  computing.push_back(command
                          ->add_option_function<double>(
                              "--epsilon", [&options](const double& value) { options.epsilon = value; },
                              "Guarantee: every form factor between rows within E with probability 1 - D, and bounds "
                              "of all answers that follow; see --delta")
                          ->type_name("E")
                          ->check([](const std::string& text) { return isNumber(text, 1e-9, 0.999); })
                          ->excludes(computing[0])
                          ->excludes(computing[1]));
  computing.push_back(command->add_option("--delta", options.delta, "Probability with which a guarantee may fail")
                          ->type_name("D")
                          ->check([](const std::string& text) { return isNumber(text, 0, 0.999); })
                          ->needs(computing.back())
                          ->capture_default_str());
  computing.push_back(command
                          ->add_option_function<double>(
                              "--seconds", [&options](const double& value) { options.request.time_limit_s = value; },
                              "Stop short of the tolerance when this time is up")
                          ->type_name("S")
                          ->check([](const std::string& text) { return isNumber(text, 1e-3, 1e9); }));
  computing.push_back(command->add_option("--seed", options.request.seed, "The same seed and plan give the same bits")
                          ->type_name("K")
                          ->check(isWholeNumber)
                          ->capture_default_str());
  addChoice(
      command, "--matrix-free", options.matrix_free,
      {{"auto", MatrixFree::automatic}, {"on", MatrixFree::on}, {"off", MatrixFree::off}},
      "Keep no form factors, and peel directions again in each step of the solution: slower, and for scenes of any "
      "size; auto: where form factors could take more than 4 GiB");
  computing.push_back(command->get_option("--matrix-free"));
  startGroup(command, kWhat);
  addSceneOptions(command, options.request.scene_options);
  addGroupsOption(command, options.groups);
  for (const char* name : {"--sheets", "--solids", "--flip", "--fix-normals", "--zone", "--outside", "--lod"})
    computing.push_back(command->get_option(name));
  computing.push_back(
      command->add_flag("--two-sided", options.request.two_sided, "Every polygon emits and receives on both sides"));
  startGroup(command, kMachine);
  computing.push_back(command
                          ->add_option("--device", options.request.device.selector,
                                       "Vulkan device: index, part of its name, cpu or gpu")
                          ->type_name("DEVICE"));
  for (CLI::Option* option : computing) command->get_option("--from-result")->excludes(option);
}

}  // namespace

void addSolve(CLI::App& app, Run& chosen, Job& job) {
  auto options = std::make_shared<SolveCommand>();
  options->request.by = By::surface;
  CLI::App* command = app.add_subcommand(
      "solve", "Compute radiative heat flows and temperatures of a scene from the materials of its surfaces");
  command->add_option("SCENE", options->scene, std::string(kSceneText) + "; in metres unless --units says so");
  startGroup(command, kWhat);
  command
      ->add_option("--materials", options->materials,
                   "File .csv with the header surface,emissivity,temperature,heat_flux: K, or W/m2 or adiabatic; names "
                   "with wildcards, default, environment, environment:up, environment:down")
      ->type_name("FILE")
      ->required();
  startGroup(command, kOutput);
  command
      ->add_option("-o,--output", options->outputs,
                   "Write the answers: .csv; with the form factors, if they are kept: .vtp; always with them: .h5, or "
                   "a page: .html")
      ->type_name("FILE")
      ->allow_extra_args(false);
  CLI::Option* exchange =
      command
          ->add_option_function<std::string>(
              "--exchange", [options](const std::string& word) { options->exchange = kExchangeKinds.at(word); },
              "Also write exchange factors, reflections and all, and conductors in m2, into NAME.exchange.csv beside "
              "NAME.csv; or conductors alone, as a network of ESATAN (NAME.exchange.d) or SINDA (NAME.exchange.inp)")
          ->type_name("gebhart|script-f|esatan|sinda")
          ->check(isOneOf("gebhart|script-f|esatan|sinda"));
  command
      ->add_option(
          "--drop-below", options->drop_below,
          "Leave out pairs whose Gebhart factors are below this both ways; the rest is balanced so that energy "
          "is kept")
      ->type_name("X")
      ->check([](const std::string& text) { return isNumber(text, 0, 0.999); })
      ->needs(exchange);
  startGroup(command, kWhat);
  addUpOption(
      command, [options](const glm::dvec3& up) { options->up = up; },
      "Above the horizon is where this points, for environment:up and environment:down; 0,0,1 otherwise");
  addChoice(command, "--by", options->request.by, {{"surface", By::surface}, {"polygon", By::polygon}},
            "One radiosity for each named surface, or for each polygon");
  command
      ->add_option("--from-result", options->stored,
                   "Take form factors from this result (.h5) or checkpoint in place of computing them; SCENE is needed "
                   "only for sky and ground, and as of merge --scene")
      ->type_name("FILE")
      ->allow_extra_args(false);
  startGroup(command, kMachine);
  addThreadsOption(command);
  addComputing(command, *options);
  startGroup(command, kOutput);
  CLI::Option* quiet = command->add_flag("-q,--quiet", options->quiet, "Print nothing but errors and warnings");
  command->add_flag("--json", options->json, kJsonHelp)->excludes(quiet);
  command->callback([options, &chosen, &job] {
    options->request.ranks = job.ranks;
    chosen = [options] { return runSolve(*options); };
    if (!options->stored.empty()) return;
    job.serve = [options](Ranks& ranks) {
      const Request& request = options->request;
      serveRanks(ranks, loadSceneOf(options->scene, request.scene_options, options->groups), request);
    };
  });
}

}  // namespace viewpeel::program
