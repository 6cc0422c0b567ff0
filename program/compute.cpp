#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

#include <viewpeel/compute.h>

#include "program/commands.h"
#include "program/compute_options.h"
#include "program/describe_run.h"
#include "program/interrupts.h"
#include "program/json_error.h"
#include "program/only_environment.h"
#include "program/outputs.h"
#include "program/progress_line.h"
#include "program/request_options.h"
#include "program/result_json.h"
#include "program/row_blocks.h"
#include "program/summary.h"
#include "program/warnings.h"
#include "estimator/find_guesses.h"
#include <viewpeel/drop_below.h>
#include <viewpeel/error.h>
#include <viewpeel/ranks.h>
#include <viewpeel/write.h>

namespace viewpeel::program {
namespace {

// Prints on stderr, in one line, how much of a stopped run is kept. Returns the exit status.
int reportInterruption(const ComputeOptions& options, uint64_t replicates) {
  std::string left;
  if (options.keepsCheckpoint() && replicates > 0)
    left = fmt::format("; {} has what was counted, go on with --resume", options.checkpoint.file);
  if (options.keepsResults()) left += replicates < 2 ? "; too few to write results" : "; results are written";
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
        fmt::format("no form factor reaches --floor {}, so that --relative {} has none to look at; give a lower "
                    "--floor, or a --tolerance",
                    request.relative_floor, *relative));
}

// Prints on stderr that the run ended before its goal: its time was up, or more replicates would not help. Returns the
// exit status.
int reportMissedGoal(const Request& request, const Result& result) {
  const bool has_limit = request.time_limit_s.has_value();
  complain(fmt::format("the goal was not reached{}: largest standard error {:.1e}; give {}a coarser goal",
                       has_limit ? " in time" : fmt::format(" in {} replicates", result.replicates),
                       result.largest_standard_error, has_limit ? "more --seconds, or " : ""));
  return kGoalMissed;
}

// A Delivery is what files and --json get beside the result itself: the form factors that --drop-below keeps, sky and
// ground, and which pairs (i, j) are guesses because no line met them (eq. (20) of docs/method.md).
struct Delivery {
  std::optional<DroppedBelow> below;
  std::optional<EnvironmentParts> parts;  // sky and ground, for --up; measured only at the end of a run
  std::vector<std::pair<uint32_t, uint32_t>> guesses;

  Delivery(const ComputeOptions& options, const Result& result, const FormFactorRun& run)
      : guesses(findGuesses(run.sums(), result.form_factors)) {
    if (options.output.drop_below > 0) below = dropBelow(result.form_factors, options.output.drop_below);
  }
};

// Returns what files are made of. It refers to the arguments, which have to outlive it.
OutputContent contentOf(const ComputeOptions& options, const Result& result, const FormFactorRun& run,
                        const Scene& scene, const Delivery& delivery) {
  auto parameters = parametersOf(run, result);
  addOrigin(options.request, parameters);
  return {.form_factors = delivery.below ? delivery.below->kept : result.form_factors,
          .balanced = result.balanced ? &result.balanced->form_factors : nullptr,
          .scene = &scene,
          .parameters = std::move(parameters),
          .shown = options.output.shown,
          .ccx_version = options.output.ccx_version,
          .balanced_column = options.older_names ? kOlderBalancedColumn : kBalancedColumn,
          .guesses = &delivery.guesses,
          .dropped = delivery.below ? &delivery.below->dropped : nullptr,
          .parts = delivery.parts ? &*delivery.parts : nullptr};
}

// Writes the outputs. Where balancing is refused, form factors are written as measured.
//   In: may_ask: whether to ask on the terminal for another place where a file cannot be written
void write(const ComputeOptions& options, const Result& result, const OutputContent& content, bool may_ask) {
  const std::string remedy =
      options.keepsCheckpoint()
          ? fmt::format("; {0} has what was counted: viewpeel merge {0} -o FILE", options.checkpoint.file)
          : "; a run with --checkpoint keeps what was counted";
  writeOutputs(content, options.output, may_ask, remedy);
  if (content.balanced)
    for (const std::string& file : options.older_files) writeFormFactors(OutputContent{*content.balanced}, file);
  if (!result.balance_refusal) return;
  const Error& refusal = *result.balance_refusal;
  throw Error(refusal.code(), fmt::format("{}{}", refusal.what(),
                                          options.keepsResults() ? "; form factors were written as measured" : ""));
}

void printJson(const ComputeOptions& options, const Result& result, const FormFactorRun& run,
               const OutputContent& content, int status) {
  Json report = startReport();
  addScene(report, *content.scene);
  addResult(report, result);
  report["settings"] = jsonOf(parametersOf(run, result));
  report["files"] = jsonOf(options.files);
  report["status"] = status;
  if (content.dropped) report["dropped"] = {{"least", content.dropped->least}, {"pairs", content.dropped->pairs}};
  printReport(std::move(report), content);
}

void printResult(const ComputeOptions& options, const Result& result, const OutputContent& content,
                 const std::string& first_division) {
  if (!options.talks()) return;
  if (options.verbose && !result.division.empty() && result.division != first_division)
    fmt::print("after a trial\n{}", result.division);
  fmt::print("{}{}", describeResult(result), result.balanced ? describeBalance(*result.balanced) : "");
  if (std::holds_alternative<RootMeanSquare>(options.request.goal))
    fmt::print("all errors root mean square {:.1e}, over all form factors between rows, zeros included\n",
               measureStandardErrors(result.form_factors, 0).rms_with_zeros);
  if (content.parts) fmt::print("{}", describeParts(*content.parts));
  if (content.dropped) fmt::print("{}", describeDropped(result.form_factors.ids(), *content.dropped));
  const auto* guarantee = std::get_if<EpsilonDelta>(&options.request.goal);
  const char* unit = result.plan.line_guarantee                  ? "look"
                     : !guarantee                                ? "replicate"
                     : guarantee->statistic == Statistic::median ? "run"
                                                                 : "block";
  fmt::print("work       {}, {}{}, {:.2f} s\n", counted(result.replicates, unit),
             describeDirections(result, result.plan.pair_lines && result.plan.pair_lines->has_rays),
             describeDirected(result), result.seconds);
  fmt::print("{}", describeWritten(options.files));
}

// Writes the outputs and prints a summary. Returns the exit status.
int conclude(const ComputeOptions& options, const Result& result, const FormFactorRun& run, const Scene& scene,
             bool is_kept, const std::string& first_division, ProgressLine& progress) {
  warnOfGoal(options.request, result);
  const int status = result.interrupted     ? reportInterruption(options, result.replicates)
                     : !is_kept             ? kFailed
                     : !result.goal_reached ? reportMissedGoal(options.request, result)
                                            : 0;
  if (result.interrupted && result.replicates < 2) return status;
  for (const std::string& warning : result.warnings) warn(warning);
  Delivery delivery(options, result, run);
  if (options.up && result.interrupted) warn("the run was stopped, so that sky and ground are not apart");
  else delivery.parts = splitEnvironmentOf(options, scene, result, {.on_progress = progress.listener()});
  const OutputContent content = contentOf(options, result, run, scene, delivery);
  if (options.keepsResults()) progress.begin("writing");
  write(options, result, content, !options.quiet && !options.json);
  progress.clear();
  if (options.json) printJson(options, result, run, content, status);
  printResult(options, result, content, first_division);
  return status;
}

// Writes the result so far, after SIGUSR1, and reports it on stderr. If that fails, the run continues.
void writeSoFar(const ComputeOptions& options, const FormFactorRun& run, const Scene& scene) {
  const std::string counted_so_far = counted(run.replicateCount(), "replicate");
  if (run.replicateCount() < 2) {
    fmt::print(stderr, "viewpeel: SIGUSR1: {} so far, too few to write results\n", counted_so_far);
    return;
  }
  try {
    const Result result = run.resultSoFar();
    const Delivery delivery(options, result, run);
    write(options, result, contentOf(options, result, run, scene, delivery), false);
    fmt::print(stderr, "viewpeel: SIGUSR1: the results of {} so far are written; the run goes on\n", counted_so_far);
  } catch (const Error& error) {
    warn(fmt::format("SIGUSR1: {}", error.what()));
  }
}

// Plans the run and prints the plan. Returns false where the run was stopped meanwhile.
bool prepare(const ComputeOptions& options, FormFactorRun& run, const CheckpointKeeper* keeper,
             const ProgressLine& progress) {
  run.makePlan();
  progress.clear();
  if (run.isInterrupted()) return false;
  if (options.talks()) fmt::print("{}", describePlan(run));
  if (keeper && options.talks()) fmt::print("{}", keeper->describe());
  if (options.verbose && options.talks()) fmt::print("{}", run.division());
  std::fflush(stdout);
  const PriorSummary* prior = run.findPrior();
  progress.clear();
  if (prior && options.talks()) fmt::print("{}", describePrior(*prior));
  std::fflush(stdout);
  return !run.isInterrupted();
}

// Counts until the run ends, and keeps the checkpoint up to date.
//   In: on_step: called after each step; conclude_early: called for a run that was stopped; show: called to write the
//     result so far
void count(FormFactorRun& run, CheckpointKeeper* keeper, const std::function<void()>& on_step,
           const std::function<int()>& conclude_early, const std::function<void()>& show) {
  const auto keep = [&](bool last) {
    if (keeper) keeper->keep(run, last);
  };
  try {
    do {
      run.step();
      on_step();
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
  checkFiles(options);
  const bool is_held = options.keepsCheckpoint() || options.keepsResults();
  if (is_held) holdInterrupts([&] { return reportInterruption(options, 0); });
  ProgressLine progress(options.request, !options.quiet);
  progress.begin(fmt::format("reading {}", fmt::join(options.scene, ", ")));
  const Scene scene = loadSceneOf(options.scene, options.request.scene_options, options.groups);
  progress.clear();
  checkScene(options, scene);
  FormFactorRun run(scene, options.request,
                    {.should_stop = [] { return interruption() != 0; },
                     .on_progress = progress.listener(),
                     .on_count = letOthersEnd});
  if (options.talks()) {
    fmt::print("{}", describePlace(run, scene));
    if (options.request.ranks) fmt::print("ranks      {} share the counting\n", options.request.ranks->size());
    if (!is_held) fmt::print("kept       nothing but this summary; name a file by -o to keep the form factors\n");
  }
  std::fflush(stdout);
  std::optional<CheckpointKeeper> keeper;
  if (options.keepsCheckpoint()) keeper.emplace(options.checkpoint, run);
  const auto endEarly = [&] {
    endByItself();
    return reportInterruption(options, 0);
  };
  if (!prepare(options, run, keeper ? &*keeper : nullptr, progress)) return endEarly();
  progress.clear();
  const std::string division = run.division();
  const auto concludeEarly = [&] {
    if (keeper) keeper->keep(run, true);
    Result result = run.resultSoFar();
    result.interrupted = true;
    progress.clear();
    return conclude(options, result, run, scene, true, division, progress);
  };
  const PlanSummary& plan = run.plan();
  bool has_prediction = plan.pilot_seconds > 0 || plan.guarantee || plan.line_guarantee;  // then the plan says it
  const auto predict = [&] {
    const auto prediction = has_prediction || !options.talks() ? std::nullopt : progress.predict();
    if (!prediction) return;
    has_prediction = true;
    progress.clear();
    fmt::print("{}", *prediction);
    std::fflush(stdout);
  };
  count(run, keeper ? &*keeper : nullptr, predict, concludeEarly, [&] {
    progress.clear();
    writeSoFar(options, run, scene);
  });
  endByItself();
  progress.clear();
  return conclude(options, run.result(), run, scene, !keeper || keeper->isKept(), division, progress);
}

}  // namespace

void addCompute(CLI::App& app, Run& chosen, Job& job) {
  CLI::App* command = app.add_subcommand("compute", "Compute the form factors of a scene");
  const auto settle = addComputeOptions(command);
  command->callback([=, &chosen, &job] {
    const std::shared_ptr<ComputeOptions> options = settle();
    options->request.ranks = job.ranks;
    chosen = [options] {
      return options->only_environment ? computeOnlyEnvironment(*options)
             : options->row_blocks     ? runRowBlocks(*options)
                                       : runCompute(*options);
    };
    job.serve = [options](Ranks& ranks) {
      const Request& request = options->request;
      serveRanks(ranks, loadSceneOf(options->scene, request.scene_options, options->groups), request);
    };
  });
}

}  // namespace viewpeel::program
