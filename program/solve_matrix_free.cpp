// This file runs `viewpeel solve` without form factors in memory, for scenes where they would not fit.
#include <cmath>

#include <fmt/format.h>

#include "program/command_line.h"
#include "program/describe_heat.h"
#include "program/heat_outputs.h"
#include "program/interrupts.h"
#include "program/progress_line.h"
#include "program/result_json.h"
#include "program/solve_command.h"
#include "program/summary.h"
#include "program/warnings.h"
#include <viewpeel/error.h>
#include <viewpeel/ranks.h>
#include <viewpeel/write.h>

namespace viewpeel::program {
namespace {

// Returns the option that needs form factors in memory; empty where there is none.
std::string findNeedOfMatrix(const SolveCommand& command) {
  if (command.form_factor_tolerance) return "--form-factors";
  if (command.epsilon) return "--epsilon";
  if (command.exchange) return "--exchange";
  for (const std::string& output : command.outputs)
    if (!output.ends_with(".csv") && !output.ends_with(".vtp")) return "-o " + output;
  return {};
}

MatrixFreeRequest requestOf(const SolveCommand& command) {
  MatrixFreeRequest request{.by = command.request.by, .two_sided = command.request.two_sided};
  request.tolerance = command.tolerance;
  request.seed = command.request.seed;
  request.threads = command.request.threads;
  request.time_limit_s = command.request.time_limit_s;
  request.ranks = command.request.ranks;
  return request;
}

int reportStop(const std::string& left) {
  complain(fmt::format("stopped by {}{}", interruptionName(), left));
  return 128 + interruption();
}

void printAnswers(const SolveCommand& command, const MaterialTable& table, const MatrixFreeRequest& request,
                  const MatrixFreeHeat& found, const std::string& tolerance) {
  if (request.ranks) fmt::print("ranks      {} share the sweeps\n", request.ranks->size());
  fmt::print("sampling   {} directions in {} replicates, lattice {} across; seed {}; no form factors are kept\n",
             found.directions, found.replicates, found.resolution, request.seed);
  fmt::print("{}{}", describeMaterials(table, found.heat), describeHeat(found.heat, command.request.by));
  fmt::print("tolerance  standard errors up to {}, in {}\n", tolerance, counted(found.rounds, "round"));
  fmt::print("work       {}, {}; {:.0f} MiB beside the scene; {:.2f} s\n", counted(found.sweeps, "sweep"),
             counted(found.heat.steps, "step") + " of conjugate gradients", double(found.memory_bytes) / 1048576.0,
             found.seconds);
}

void printJson(const SolveCommand& command, const MatrixFreeHeat& found) {
  Json report = startReport();
  report["matrix_free"] = {{"replicates", found.replicates}, {"directions", found.directions},
                           {"rounds", found.rounds},         {"sweeps", found.sweeps},
                           {"resolution", found.resolution}, {"memory_bytes", found.memory_bytes},
                           {"seconds", found.seconds}};
  report["goal_reached"] = found.is_reached;
  addHeat(report, found.heat, command.request.by);
  report["files"] = jsonOf(command.files);
  printReport(std::move(report));
}

// Warns of a row that directions hardly met. Its stated errors are those of the few lines that met it.
void warnOfLack(const HeatSolution& found) {
  constexpr double kMostLack = 0.5;
  if (std::abs(found.largest_lack) <= kMostLack) return;
  warn(fmt::format(
      "directions hardly met {}: its row sum differs from 1 by {:.2g}, and its answers may err by more than "
      "they state; give a finer --tolerance, or take --matrix-free off",
      found.lacking_row, std::abs(found.largest_lack)));
}

}  // namespace

void checkMatrixFree(const SolveCommand& command, const MaterialTable& table) {
  const std::string need = command.matrix_free == MatrixFree::off ? "--matrix-free off"
                           : !command.stored.empty()              ? "--from-result"
                                                                  : findNeedOfMatrix(command);
  if (!table.laws.empty() && !need.empty())
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("{} takes form factors, which are of diffuse surfaces, but {} has directional emissivities; "
                    "leave one of the two out",
                    need, table.file));
  if (command.matrix_free == MatrixFree::on && !need.empty())
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("--matrix-free on keeps no form factors, but {} takes them; leave one of the two out", need));
}

bool isMatrixFree(const SolveCommand& command, const MaterialTable& table, const Scene& scene) {
  if (!table.laws.empty()) return true;
  if (command.matrix_free != MatrixFree::automatic) return command.matrix_free == MatrixFree::on;
  const uint64_t rows = command.request.by == By::surface ? scene.surfaces.size() : scene.faces.size();
  return findNeedOfMatrix(command).empty() && matrixBytes(rows) > kMostMatrixBytes;
}

int solveWithoutMatrix(const SolveCommand& command, const MaterialTable& table, const Scene& scene) {
  const MatrixFreeRequest request = requestOf(command);
  holdInterrupts([] { return reportStop(" before the first answers; nothing is written"); });
  ProgressLine progress(command.request, !command.quiet);
  MatrixFreeHeat found;
  try {
    const auto show = [&](uint64_t product, uint64_t directions, uint64_t of_product, double error) {
      progress.begin(fmt::format("product {}, direction {} of {}{}", product, directions, of_product,
                                 std::isfinite(error) ? fmt::format("; last round's error {:.1e}", error) : ""));
    };
    MatrixFreeObserver observer{.should_stop = [] { return interruption() != 0; }};
    if (!command.quiet) observer.on_progress = show;
    found = solveMatrixFree(scene, table, request, observer);
  } catch (const Error&) {
    progress.clear();
    endByItself();
    if (interruption()) return reportStop(" before the first answers; nothing is written");
    throw;
  }
  endByItself();
  progress.clear();
  warnOfEnvironment(table, found.heat);
  warnOfLack(found.heat);
  const FormFactors rows(makeIds(scene, request.by, request.two_sided), {}, {});
  writeHeatOutputs({.form_factors = rows, .scene = &scene, .heat = &found.heat, .has_heat_alone = true},
                   command.request.by, command.outputs);
  const double reached = largestHeatError(found.heat, found.tolerance.of);
  const std::string tolerance = describeTolerance(found.tolerance, reached);
  if (!found.is_reached) warn(fmt::format("the run ended before the tolerance: standard errors of {}", tolerance));
  if (command.json) printJson(command, found);
  if (command.talks()) printAnswers(command, table, request, found, tolerance);
  return found.is_interrupted ? reportStop("; the answers so far are written") : 0;
}

}  // namespace viewpeel::program
