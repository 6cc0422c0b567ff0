#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

#include "program/checkpoint_keeper.h"
#include "program/commands.h"
#include "program/interrupts.h"
#include "program/outputs.h"
#include "program/session.h"
#include "program/summary.h"
#include "estimator/visible_share.h"
#include "error.h"
#include "io/write_form_factors.h"
#include "result/closure.h"
#include "result/leak_warnings.h"

namespace viewpeel::program {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// One line on the terminal, rewritten after every batch of directions and every replicate.
class ProgressLine {
 public:
  explicit ProgressLine(const EstimateOptions& options) : options_(options) {}
  void onBatch(uint64_t directions) {
    directions_ = directions;
    show();
  }
  void onBlock(const GuaranteeProgress& progress) {
    if (secondsSince(shown_) < 0.1) return;
    shown_ = Clock::now();
    fmt::print(stderr, "\r\033[Kblock {} of {} expected, {} at most, {:.1f} s", progress.blocks, progress.expected_blocks, progress.most_blocks, secondsSince(start_));
    std::fflush(stderr);
  }
  void onReplicate(const EstimateProgress& progress) {
    progress_ = progress;
    directions_ = 0;
    show();
  }

 private:
  void show() {
    if (secondsSince(shown_) < 0.1) return;
    shown_ = Clock::now();
    std::string goal = fmt::format("of {}", options_.replicates);
    if (options_.seconds) goal = fmt::format("until {:.0f} s", *options_.seconds);
    else if (options_.relative) goal = fmt::format("goal {:.1e} of a form factor", *options_.relative);
    else if (options_.tolerance) goal = fmt::format("goal {:.1e}", *options_.tolerance);
    if (options_.tolerance && std::isfinite(progress_.largest_standard_error)) goal = fmt::format("largest standard error {:.1e}, {}", progress_.largest_standard_error, goal);
    fmt::print(stderr, "\r\033[Kreplicate {} {}, direction {} of {}, {:.1f} s", progress_.replicates + 1, goal, directions_, options_.directions, secondsSince(start_));
    std::fflush(stderr);
  }

  const EstimateOptions& options_;
  EstimateProgress progress_;
  uint64_t directions_ = 0;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
};

// One line on stderr: what is left of a run that was stopped.
void tellInterruption(const ProgramOptions& options, uint64_t replicates) {
  std::string left;
  if (!options.checkpoint.file.empty() && replicates > 0) left = fmt::format("; {} has what was counted, go on with --resume", options.checkpoint.file);
  if (!options.outputs.empty()) left += replicates < 2 ? "; too few to write results" : "; results are written";
  fmt::print(stderr, "viewpeel: stopped by {}, {} replicate{} done{}\n", interruption() == SIGINT ? "SIGINT" : "SIGTERM", replicates, replicates == 1 ? "" : "s", left);
}

// A run that is gone on with keeps its plan: what a plan chose is among the settings of its checkpoint. What is said beside has to be the same there.
void adoptPlan(const Settings& stored, ProgramOptions& options) {
  if (options.closed_forms_by_default && options.closed_forms_possible && !stored.empty()) {
    options.closed_forms = findSetting(stored, "--closed-forms") == "on";
    options.closed_forms_by_default = false;
  }
  const auto figureOf = [&](const char* name) {
    const std::optional<std::string> figure = findSetting(stored, name);
    return figure ? std::strtod(figure->c_str(), nullptr) : 0;
  };
  if (options.epsilon) {
    if (!options.range) options.range = figureOf("--range");
    if (!options.block) options.block = static_cast<uint32_t>(figureOf("--block"));
  } else if (options.plans && options.engine != EngineKind::exact && figureOf("--directions") >= 1) {
    options.plans = false;
    options.estimate.directions = static_cast<uint32_t>(figureOf("--directions"));
    if (!options.resolution) options.resolution = static_cast<int>(figureOf("--resolution"));
    options.finest = static_cast<int>(figureOf("--finest"));
  }
}

// Where closure is refused the form factors are written as measured.
ClosedFormFactors closeOrKeep(const FormFactors& measured, const std::vector<std::string>& outputs) {
  try {
    return closeRows(measured);
  } catch (const Error& error) {
    writeOutputs(measured, outputs);
    throw Error(error.code(), fmt::format("{}{}", error.what(), outputs.empty() ? "" : "; form factors were written as measured"));
  }
}

int runCompute(ProgramOptions options) {
  if (options.closure && !options.question.isEverything()) throw Error(ErrorCode::bad_usage, kClosureNeedsEveryRow);
  checkOutputs(options.outputs, options.checkpoint.file, options.closure);
  const bool keeps = !options.checkpoint.file.empty(), show_progress = !options.quiet && ::isatty(STDERR_FILENO);
  if (keeps && !options.checkpoint.resume) requireNewCheckpoint(options.checkpoint.file);
  ProgressLine progress(options.estimate);
  if (keeps || !options.outputs.empty())
    holdInterrupts([&] {
      tellInterruption(options, 0);
      return 128 + interruption();
    });
  options.estimate.on_replicate = [&](const EstimateProgress& p) {
    stopIfInterrupted();
    if (show_progress) progress.onReplicate(p);
  };
  options.lattice.on_batch = [&](uint64_t directions) {
    stopIfInterrupted();
    if (show_progress && !options.epsilon) progress.onBatch(directions);
  };
  options.lattice.measure_work = options.json;
  const Session session(options);
  if (session.talks()) session.describe();
  std::optional<CheckpointKeeper> keeper;
  if (keeps) {
    keeper.emplace(options.checkpoint, session.settings(), options.estimate.first_replicate);
    adoptPlan(keeper->found(), options);
  }

  const auto start = Clock::now();
  Plan plan;
  GuaranteePlan guarantee;
  try {
    if (options.epsilon) guarantee = session.planGuarantee();
    else plan = session.plan();
  } catch (const Interrupted&) {
    endByItself();
    tellInterruption(options, 0);
    return 128 + interruption();
  }
  std::unique_ptr<Engine>& planned = options.epsilon ? guarantee.engine : plan.engine;
  const std::unique_ptr<Engine> found = std::move(planned);
  planned = interruptible(*found);
  Engine& engine = *planned;
  if (show_progress) fmt::print(stderr, "\r\033[K");
  if (session.talks()) fmt::print("{}", options.epsilon ? session.describe(guarantee) : session.describe(plan));
  if (keeper) {
    keeper->setSettings(options.epsilon ? session.settings(guarantee) : session.settings(plan));
    if (session.talks()) fmt::print("{}", keeper->describe());
  }
  const RunSums* last_sums = nullptr;
  const auto keep = [&](const RunSums& sums, bool last) {
    last_sums = &sums;
    if (keeper) keeper->keep(sums, last);
  };
  const std::string division = engine.describePlan();
  if (options.verbose && session.talks()) fmt::print("{}", division);
  std::fflush(stdout);
  VisibleShares shares;
  PairSampler pairs(session.scene, session.face_ids, options.estimate.seed, session.pairEngines(), maxWindowResolution(options.lattice.sampling));
  FaceExchanges exchanges(session.deviceOrNone(), session.scene, session.face_ids, stopIfInterrupted);
  if (session.usesClosedForms() && !options.epsilon && !(keeper && keeper->resumed())) {
    EstimateOptions pilot = options.estimate;
    pilot.directions = plan.directions;
    pilot.pairs = &pairs;
    try {
      shares = findVisibleShares(engine, exchanges, session.scene, session.face_ids, plan.groups, pilot, sharePilot(pilot));
    } catch (const Interrupted&) {
      endByItself();
      tellInterruption(options, 0);
      return 128 + interruption();
    }
    if (session.talks()) fmt::print("{}", session.describe(shares));
    std::fflush(stdout);
  }
  const auto conclude = [&](const Estimate& estimate, bool is_at_rest) {
    if (show_progress) fmt::print(stderr, "\r\033[K");
    const double seconds = secondsSince(start);
    if (options.estimate.relative && !(estimate.largest_relative_error > 0))
      fmt::print(stderr, "viewpeel: warning: no form factor reaches --floor {}, so that --relative {} asked for nothing; lower --floor, or ask by --tolerance\n",
                 options.estimate.relative_floor, *options.estimate.relative);
    if (estimate.interrupted) tellInterruption(options, estimate.replicates);
    const int status = estimate.interrupted ? 128 + interruption() : keeper && !keeper->isKept() ? 1 : 0;
    if (estimate.interrupted && estimate.replicates < 2) return status;
    if (!estimate.interrupted)
      for (const std::string& warning : warnOfLeaks(session.scene, estimate.form_factors)) fmt::print(stderr, "viewpeel: warning: {}\n", warning);
    std::optional<ClosedFormFactors> closed;
    if (options.closure) closed = closeOrKeep(estimate.form_factors, options.outputs);
    writeOutputs(estimate.form_factors, options.outputs, closed ? &closed->form_factors : nullptr);
    if (options.json)
      fmt::print("{}", asJson(options.scene, session.deviceName(), estimate, seconds, is_at_rest ? engine.work() : nullptr,
                              closed ? &*closed : nullptr));
    if (!session.talks()) return status;
    if (options.verbose && is_at_rest && engine.describePlan() != division) fmt::print("after a trial\n{}", engine.describePlan());
    fmt::print("{}{}", describeResult(estimate), closed ? describeClosed(*closed) : "");
    fmt::print("work       {}, {}{}, {:.2f} s\n", counted(estimate.replicates, !options.epsilon ? "replicate" : options.statistic == Statistic::median ? "run" : "block"),
               counted(estimate.directions, "direction"), describeDirected(estimate), seconds);
    for (const std::string& output : options.outputs)
      for (const std::filesystem::path& file : filesOf(output, options.closure)) fmt::print("written    {}\n", file.string());
    return status;
  };
  const auto offer = [&](const std::function<Estimate()>& so_far) {
    offerResults([&, so_far] {
      if (keeper && last_sums) keeper->keep(*last_sums, true);
      Estimate estimate = so_far();
      estimate.interrupted = true;
      return conclude(estimate, false);
    });
  };
  const auto estimateAsAsked = [&] {
    if (options.epsilon) {
      GuaranteeOptions asked = session.guaranteeOptions();
      asked.resumed = keeper ? keeper->resumed() : nullptr;
      asked.on_sums = keep;
      asked.on_so_far = offer;
      asked.on_block = [&](const GuaranteeProgress& p) {
        stopIfInterrupted();
        if (show_progress) progress.onBlock(p);
      };
      return guaranteeFormFactors(session.scene, session.ids, asked, guarantee);
    }
    EstimateOptions asked = options.estimate;
    asked.directions = plan.directions;
    asked.on_so_far = offer;
    asked.resumed = keeper ? keeper->resumed() : nullptr;
    asked.on_sums = keep;
    asked.pairs = &pairs;
    asked.known = session.usesClosedForms() ? &shares.known : nullptr;
    asked.exchanges = session.usesClosedForms() ? &exchanges : nullptr;
    if (asked.seconds) asked.seconds = std::max(*asked.seconds - secondsSince(start), 1e-3);
    return estimateFormFactors(engine, session.scene, session.usesClosedForms() ? session.face_ids : session.ids, asked);
  };
  const Estimate estimate = estimateAsAsked();
  endByItself();
  if (session.device) checkValidation(*session.device);
  return conclude(estimate, true);
}

}  // namespace

void addCompute(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("compute", "Compute the form factors of a scene");
  const auto options = addOptions(command);
  command->add_option("-o,--output", options->outputs, "Write the matrix: .csv or .mtx; may be given several times")
      ->type_name("FILE")->allow_extra_args(false);
  command->add_flag("--closure", options->closure, "Closed scenes: also the nearest form factors whose rows sum to 1, beside those measured");
  addCheckpointOptions(command, options->checkpoint);
  CLI::Option* quiet = command->add_flag("--quiet", options->quiet, "Print nothing but errors and warnings");
  CLI::Option* verbose = command->add_flag("--verbose", options->verbose, "Print how work and memory are divided, too")->excludes(quiet);
  command->add_flag("--json", options->json, "Print the outcome and the work done as JSON")->excludes(quiet)->excludes(verbose);
  command->callback([=, &chosen] {
    settle(command, *options);
    chosen = [options] { return runCompute(*options); };
  });
}

}  // namespace viewpeel::program
