// This file runs `viewpeel solve --from-result`, with form factors from a result or from checkpoints.
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "io/hdf5_input.h"
#include "program/command_line.h"
#include "program/request_options.h"
#include "program/solve_command.h"
#include "program/stored_run.h"
#include "program/summary.h"
#include "run/settings.h"
#include "sums/line_sums.h"
#include <viewpeel/error.h>
#include <viewpeel/read.h>

namespace viewpeel::program {
namespace {

using Parameters = std::vector<std::pair<std::string, std::string>>;

std::string findParameter(const Parameters& parameters, const std::string& name) {
  const auto found = std::ranges::find(parameters, name, &std::pair<std::string, std::string>::first);
  return found == parameters.end() ? "" : found->second;
}

// A Stored is what files say about form factors.
struct Stored {
  const FormFactors& form_factors;
  const std::vector<std::string>& surface_names;  // that Ids::surface is an index of
  const Scene* scene = nullptr;                   // where it is available
  Parameters parameters;
  const Estimate& figures;  // how much was counted, and the largest error
};

// Measures form factors to sky and ground, to the standard error of the other form factors.
EnvironmentParts measureParts(const SolveCommand& command, const Stored& stored, const MaterialTable& table) {
  if (!stored.scene)
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: form factors do not tell sky from ground, as {} does; give the SCENE, too",
                            command.stored.front(), command.materials));
  EnvironmentRequest request{
      .by = command.request.by, .two_sided = stored.form_factors.ids().two_sided, .up = table.up};
  const double error = stored.figures.largest_standard_error;
  request.tolerance = error > 0 ? error : Tolerance{}.standard_error;
  request.seed = command.request.seed;
  return measureEnvironment(*stored.scene, request);
}

int solveWith(const SolveCommand& command, const MaterialTable& table, const Stored& stored) {
  Enclosure enclosure = assignMaterials(table, stored.form_factors.ids(), stored.surface_names);
  if (enclosure.sky_and_ground) enclosure.environment_parts = measureParts(command, stored, table);
  const HeatSolution solution = solveHeat(stored.form_factors, enclosure);
  Parameters parameters = stored.parameters;
  std::erase_if(parameters, [](const auto& parameter) { return parameter.first == "command"; });
  parameters.emplace_back("command", commandLine());
  conclude(command, table, solution,
           {.form_factors = stored.form_factors, .scene = stored.scene, .parameters = parameters, .heat = &solution});
  writeExchanges(command, stored.form_factors, enclosure);
  if (command.json) printJson(command, solution, stored.form_factors, stored.figures, nullptr);
  if (command.talks())
    fmt::print("work       form factors of {}, {}, {}{}\n", command.stored.front(),
               counted(stored.figures.replicates, "replicate"), counted(stored.figures.directions, "direction"),
               describeDirected(stored.figures));
  return 0;
}

[[noreturn]] void refusePolygons(const SolveCommand& command) {
  throw Error(ErrorCode::bad_usage,
              fmt::format("{}: its rows are surfaces; leave out --by polygon", command.stored.front()));
}

int solveCheckpoints(const SolveCommand& command, const MaterialTable& table) {
  StoredRun run(command.stored, command.scene, command.groups);
  run.requireErrors();
  const Estimate estimate = run.estimate();
  const bool is_by_surface = command.request.by == By::surface;
  if (!is_by_surface && findSetting(run.merged().settings, "--by") == "surface") refusePolygons(command);
  return solveWith(command, table,
                   {.form_factors = is_by_surface ? estimate.between_surfaces : estimate.form_factors,
                    .surface_names = estimate.between_surfaces.ids().names,
                    .scene = run.scene(),
                    .parameters = parametersOf(run.merged().settings, estimate),
                    .figures = estimate});
}

// Adds rows by polygon up to rows by surface.    Error: standard errors are those of independent entries.
FormFactors addBySurface(const FormFactors& of_polygons, const std::vector<std::string>& surface_names) {
  const Ids& ids = of_polygons.ids();
  const std::vector<Measured>& sums = of_polygons.rowSums();
  std::vector<double> areas(surface_names.size());
  for (uint32_t id = 0; id < ids.count(); ++id) areas[ids.surface[id]] += ids.areas[id];
  Ids surfaces;
  surfaces.two_sided = ids.two_sided, surfaces.rows_sum_to_one = ids.rows_sum_to_one;
  std::vector<uint32_t> row_of_surface(surface_names.size());
  for (uint32_t surface = 0; surface < surface_names.size(); ++surface) {
    if (!(areas[surface] > 0)) continue;
    row_of_surface[surface] = surfaces.count();
    surfaces.names.push_back(surface_names[surface]);
    surfaces.areas.push_back(areas[surface]);
    surfaces.surface.push_back(surface);
  }
  std::vector<uint32_t> rows;
  std::vector<Measured> row_sums(surfaces.count());
  for (uint32_t id = 0; id < ids.count(); ++id) {
    rows.push_back(row_of_surface[ids.surface[id]]);
    const double share = ids.areas[id] / surfaces.areas[rows.back()];
    Measured& sum = row_sums[rows.back()];
    sum = {sum.value + share * sums[id].value, std::hypot(sum.standard_error, share * sums[id].standard_error)};
  }
  return {std::move(surfaces), mergeBySurface(of_polygons.entries(), rows), std::move(row_sums)};
}

int solveResult(const SolveCommand& command, const MaterialTable& table) {
  const std::string& file = command.stored.front();
  if (command.stored.size() > 1)
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("{}: is a result, and results cannot be added up; give it alone, or give checkpoints", file));
  StoredResult result = readResult(file);
  const Parameters& parameters = result.parameters;
  const bool has_surfaces = findParameter(parameters, "by") == "surface";
  if (command.request.by == By::polygon && has_surfaces) refusePolygons(command);
  const Ids& ids = result.form_factors.ids();
  if (!ids.requested.empty())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: has some rows only, and heat needs all; compute it without --from and --pair", file));
  Estimate figures{FormFactors({}, {}, {}), FormFactors({}, {}, {})};
  const auto figure = [&](const char* name) { return std::strtod(findParameter(parameters, name).c_str(), nullptr); };
  figures.replicates = static_cast<uint64_t>(figure("replicates"));
  figures.directions = static_cast<uint64_t>(figure("all_directions"));
  figures.largest_standard_error = figure("largest_standard_error");
  if (std::isinf(figures.largest_standard_error))
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: has no standard errors, for it is of 1 replicate; compute more of them", file));
  std::optional<Scene> scene;
  if (!command.scene.empty()) scene = loadSceneOf(command.scene, command.request.scene_options, command.groups);
  const bool adds = command.request.by == By::surface && !has_surfaces;
  // There are no bounds with bands of wavelengths, or with sky and ground apart: estimates do then.
  const bool has_no_bounds = !table.band_limits_um.empty() || table.sky_and_ground.has_value();
  FormFactors form_factors = adds ? addBySurface(result.form_factors, result.surface_names)
                             : has_no_bounds
                                 ? FormFactors(ids, result.form_factors.entries(), result.form_factors.rowSums())
                                 : std::move(result.form_factors);
  if (scene && makeIds(*scene, command.request.by, form_factors.ids().two_sided).count() != form_factors.ids().count())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: another scene than that of {}: it has another number of rows; give the scene that was "
                            "computed",
                            scene->file, file));
  figures.form_factors = form_factors;
  return solveWith(command, table,
                   {.form_factors = form_factors,
                    .surface_names = result.surface_names,
                    .scene = scene ? &*scene : nullptr,
                    .parameters = parameters,
                    .figures = figures});
}

// Returns whether a file is a result; else it is to be read as a checkpoint, which has its format as a column.
bool isResult(const std::string& file) {
  return !Hdf5Input(file, "result or checkpoint", "take a .h5 that viewpeel wrote, or write it anew").has("format");
}

}  // namespace

int solveStored(const SolveCommand& command) {
  const MaterialTable table = readTable(command);
  checkMatrixFree(command, table);
  return isResult(command.stored.front()) ? solveResult(command, table) : solveCheckpoints(command, table);
}

}  // namespace viewpeel::program
