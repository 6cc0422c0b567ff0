#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

#include <viewpeel/compute.h>

#include "program/checkpoint_keeper.h"
#include "program/commands.h"
#include "program/describe_run.h"
#include "program/interrupts.h"
#include "program/json_error.h"
#include "program/outputs.h"
#include "program/progress_line.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/summary.h"
#include "program/warnings.h"
#include <viewpeel/error.h>
#include <viewpeel/write.h>

namespace viewpeel::program {
namespace {

struct ComputeOptions {
  std::string scene;
  Request request;
  std::vector<std::string> outputs, shown;
  std::vector<PlannedFile> files;  // of the outputs, as they are before the run
  std::string ccx_version = "2.20";
  CheckpointOptions checkpoint;
  bool quiet = false, verbose = false, json = false;
  bool older_names = false;  // of what --balance writes

  bool talks() const { return !quiet && !json; }
  bool keepsCheckpoint() const { return !checkpoint.file.empty(); }
};

// Checkpoints keep estimates.
void leaveOutPromise(Request& request) {
  if (request.promise.value_or(false))
    throw Error(ErrorCode::bad_usage, "--checkpoint keeps no promise; leave out one of --checkpoint and --promise on");
  if (!std::holds_alternative<EpsilonDelta>(request.goal)) request.promise = false;
}

std::vector<PlannedFile> planOutputs(const std::vector<std::string>& outputs, bool with_balance) {
  std::vector<std::string> names;
  for (const std::string& output : outputs)
    for (const std::filesystem::path& file : filesOf(output, with_balance)) names.push_back(file.string());
  return planFiles(names);
}

// Says on stderr, in one line, how much of a stopped run is kept. Returns the exit status.
int reportInterruption(const ComputeOptions& options, uint64_t replicates) {
  std::string left;
  if (options.keepsCheckpoint() && replicates > 0)
    left = fmt::format("; {} has what was counted, go on with --resume", options.checkpoint.file);
  if (!options.outputs.empty()) left += replicates < 2 ? "; too few to write results" : "; results are written";
  const std::string message =
      fmt::format("stopped by {}, {} done{}", interruptionName(), counted(replicates, "replicate"), left);
  const int status = 128 + interruption();
  complain(message);
  if (options.json && replicates < 2) fmt::print("{}", errorAsJson(message, status));
  return status;
}

void warnOfGoal(const Request& request, const Result& result) {
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  const auto* only = std::get_if<Relative>(&request.goal);
  const std::optional<double> relative = tolerance ? tolerance->relative
                                         : only    ? std::optional(only->standard_error)
                                                   : std::nullopt;
  if (relative && !(result.largest_relative_error > 0))
    warn(
        fmt::format("no form factor reaches --floor {}, so that --relative {} asked for nothing; lower "
                    "--floor, or ask by --tolerance",
                    request.relative_floor, *relative));
}

// Says on stderr that time was up before the goal was reached. Returns the exit status.
int reportMissedGoal(const Result& result) {
  complain(fmt::format(
      "the goal was not reached in time: largest standard error {:.1e}; give more --seconds, or a coarser goal",
      result.largest_standard_error));
  return kGoalMissed;
}

// Where balancing is refused, form factors are written as measured.
void write(const ComputeOptions& options, const Result& result, const FormFactorRun& run, const Scene& scene) {
  auto parameters = parametersOf(run, result);
  addOrigin(options.request, parameters);
  writeOutputs(
      {result.form_factors, result.balanced ? &result.balanced->form_factors : nullptr, &scene, parameters,
       options.shown, nullptr, options.ccx_version, options.older_names ? kOlderBalancedColumn : kBalancedColumn},
      options.outputs);
  if (!result.balance_refusal) return;
  const Error& refusal = *result.balance_refusal;
  throw Error(refusal.code(), fmt::format("{}{}", refusal.what(),
                                          options.outputs.empty() ? "" : "; form factors were written as measured"));
}

void printJson(const ComputeOptions& options, const Result& result, const FormFactorRun& run, const Scene& scene,
               int status) {
  Json report = startReport();
  addScene(report, scene);
  addResult(report, result);
  report["settings"] = jsonOf(parametersOf(run, result));
  report["files"] = jsonOf(options.files);
  report["status"] = status;
  printReport(std::move(report), result.form_factors, result.balanced ? &result.balanced->form_factors : nullptr);
}

void printResult(const ComputeOptions& options, const Result& result, const std::string& first_division) {
  if (!options.talks()) return;
  if (options.verbose && !result.division.empty() && result.division != first_division)
    fmt::print("after a trial\n{}", result.division);
  fmt::print("{}{}", describeResult(result), result.balanced ? describeBalance(*result.balanced) : "");
  const auto* guarantee = std::get_if<EpsilonDelta>(&options.request.goal);
  const char* unit = result.plan.line_guarantee                  ? "look"
                     : !guarantee                                ? "replicate"
                     : guarantee->statistic == Statistic::median ? "run"
                                                                 : "block";
  fmt::print("work       {}, {}{}, {:.2f} s\n", counted(result.replicates, unit),
             counted(result.directions, "direction"), describeDirected(result), result.seconds);
  fmt::print("{}", describeWritten(options.files));
}

// Writes and prints the results. Returns the exit status.
int conclude(const ComputeOptions& options, const Result& result, const FormFactorRun& run, const Scene& scene,
             bool is_kept, const std::string& first_division) {
  warnOfGoal(options.request, result);
  const int status = result.interrupted     ? reportInterruption(options, result.replicates)
                     : !is_kept             ? kFailed
                     : !result.goal_reached ? reportMissedGoal(result)
                                            : 0;
  if (result.interrupted && result.replicates < 2) return status;
  for (const std::string& warning : result.warnings) warn(warning);
  write(options, result, run, scene);
  if (options.json) printJson(options, result, run, scene, status);
  printResult(options, result, first_division);
  return status;
}

// Writes what there is, after SIGUSR1, and says so on stderr. The run goes on where that fails.
void writeSoFar(const ComputeOptions& options, const FormFactorRun& run, const Scene& scene) {
  const std::string counted_so_far = counted(run.replicateCount(), "replicate");
  if (run.replicateCount() < 2) {
    fmt::print(stderr, "viewpeel: SIGUSR1: {} so far, too few to write results\n", counted_so_far);
    return;
  }
  try {
    write(options, run.resultSoFar(), run, scene);
    fmt::print(stderr, "viewpeel: SIGUSR1: the results of {} so far are written; the run goes on\n", counted_so_far);
  } catch (const Error& error) {
    warn(fmt::format("SIGUSR1: {}", error.what()));
  }
}

// Plans, and says so. False where the run was stopped meanwhile.
bool prepare(const ComputeOptions& options, FormFactorRun& run, const CheckpointKeeper* keeper) {
  run.makePlan();
  if (run.isInterrupted()) return false;
  if (options.talks()) fmt::print("{}", describePlan(run));
  if (keeper && options.talks()) fmt::print("{}", keeper->describe());
  if (options.verbose && options.talks()) fmt::print("{}", run.division());
  std::fflush(stdout);
  const PriorSummary* prior = run.findPrior();
  if (prior && options.talks()) fmt::print("{}", describePrior(*prior));
  std::fflush(stdout);
  return !run.isInterrupted();
}

// Counts to the end, and keeps the counts.
//   In: conclude_early: ends a run that was stopped; show: writes the results so far
void count(FormFactorRun& run, CheckpointKeeper* keeper, const std::function<int()>& conclude_early,
           const std::function<void()>& show) {
  const auto keep = [&](bool last) {
    if (keeper) keeper->keep(run, last);
  };
  try {
    do {
      run.step();
      if (run.replicateCount() == 0) continue;
      const bool is_wanted = wantsResults();
      keep(is_wanted);
      if (is_wanted) show();
      offerResults(conclude_early);
    } while (!run.isDone());
  } catch (...) {
    keep(true);
    throw;
  }
  keep(true);
}

int runCompute(const ComputeOptions& options) {
  checkOutputs(options.outputs, options.checkpoint.file, options.request.balance);
  if (options.keepsCheckpoint() && !options.checkpoint.resume) requireNewCheckpoint(options.checkpoint.file);
  const bool is_held = options.keepsCheckpoint() || !options.outputs.empty();
  if (is_held) holdInterrupts([&] { return reportInterruption(options, 0); });
  const Scene scene = loadSceneOf(options.scene, options.request.scene_options);
  const Ids ids = makeIds(scene, options.request.by, options.request.two_sided);
  checkShown(scene, ids, options.shown);
  for (const std::string& output : options.outputs) checkRows(output, scene, ids);
  ProgressLine progress(options.request, !options.quiet);
  FormFactorRun run(scene, options.request,
                    {.should_stop = [] { return interruption() != 0; },
                     .on_progress = progress.listener(),
                     .on_count = letOthersEnd});
  if (options.talks()) {
    fmt::print("{}", describePlace(run, scene));
    if (!is_held) fmt::print("kept       nothing but this summary; name a file by -o to keep the form factors\n");
  }
  std::fflush(stdout);
  std::optional<CheckpointKeeper> keeper;
  if (options.keepsCheckpoint()) keeper.emplace(options.checkpoint, run);
  const auto endEarly = [&] {
    endByItself();
    return reportInterruption(options, 0);
  };
  if (!prepare(options, run, keeper ? &*keeper : nullptr)) return endEarly();
  progress.clear();
  const std::string division = run.division();
  const auto concludeEarly = [&] {
    if (keeper) keeper->keep(run, true);
    Result result = run.resultSoFar();
    result.interrupted = true;
    progress.clear();
    return conclude(options, result, run, scene, true, division);
  };
  count(run, keeper ? &*keeper : nullptr, concludeEarly, [&] {
    progress.clear();
    writeSoFar(options, run, scene);
  });
  endByItself();
  progress.clear();
  return conclude(options, run.result(), run, scene, !keeper || keeper->isKept(), division);
}

}  // namespace

void addCompute(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("compute", "Compute the form factors of a scene");
  const auto request_options = addRequestOptions(command);
  const auto options = std::make_shared<ComputeOptions>();
  startGroup(command, kOutput);
  addOutputOptions(command, options->outputs, options->shown, options->ccx_version);
  command->add_flag("--balance", request_options->request.balance,
                    "Closed scenes: also the nearest form factors whose rows sum to 1, beside those measured");
  command->add_flag("--closure", options->older_names,
                    "The older name of --balance, until 0.3: its .csv column has its older name, closed_form_factor");
  startGroup(command, kLongRuns);
  addCheckpointOptions(command, options->checkpoint);
  startGroup(command, kOutput);
  CLI::Option* quiet = command->add_flag("--quiet", options->quiet, "Print nothing but errors and warnings");
  CLI::Option* verbose =
      command->add_flag("--verbose", options->verbose, "Print how work and memory are divided, too")->excludes(quiet);
  command->add_flag("--json", options->json, kJsonHelp)->excludes(quiet)->excludes(verbose);
  command->callback([=, &chosen] {
    options->scene = request_options->scene;
    options->request = requestOf(command, *request_options);
    if (options->keepsCheckpoint()) leaveOutPromise(options->request);
    options->request.balance |= options->older_names;
    options->request.measure_work = options->json;
    chosen = [options] {
      options->files = planOutputs(options->outputs, options->request.balance);
      return runCompute(*options);
    };
  });
}

}  // namespace viewpeel::program
