// This file defines the public functions of a run (include/viewpeel/compute.h).

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/compute.h>

#include <viewpeel/error.h>
#include "directions/replicates.h"
#include "io/checkpoint.h"
#include "result/leak_warnings.h"
#include "run/rules.h"
#include "run/run_state.h"
#include "run/settings.h"

namespace viewpeel {
namespace {

// Returns the largest error that a request allows a form factor; 1 where it names none.
double requestedError(const Request& request) {
  if (const auto* tolerance = std::get_if<Tolerance>(&request.goal)) return tolerance->standard_error;
  if (const auto* guarantee = std::get_if<EpsilonDelta>(&request.goal)) return guarantee->epsilon;
  return 1;
}

}  // namespace

FormFactorRun::FormFactorRun(const Scene& scene, Request request, Observer observer)
    : state_(std::make_unique<State>(scene, std::move(request), std::move(observer))) {}
FormFactorRun::~FormFactorRun() = default;
FormFactorRun::FormFactorRun(FormFactorRun&&) noexcept = default;
FormFactorRun& FormFactorRun::operator=(FormFactorRun&&) noexcept = default;

const Request& FormFactorRun::request() const { return state_->setup.request(); }
const PlanSummary& FormFactorRun::plan() const { return state_->summary; }
const DeviceDescription* FormFactorRun::device() const {
  return state_->setup.device() ? &state_->setup.device()->description() : nullptr;
}

Settings FormFactorRun::settings() const {
  const bool is_planned = state_->plan || state_->guarantee;
  return is_planned ? settingsOf(state_->setup, state_->summary) : settingsOf(state_->setup);
}

std::string FormFactorRun::resumeFrom(const std::filesystem::path& checkpoint) {
  Checkpoint found = readCheckpoint(checkpoint);
  Settings unplanned = found.settings;
  std::erase_if(unplanned, [](const auto& setting) { return mayBePlanned(setting.first); });
  requireSameSettings(settings(), unplanned, checkpoint);
  const std::string option = optionAgainstPairLines(request());
  const bool has_lines = findSetting(found.settings, "--pair-lines") == "on";
  if (has_lines && !request().pair_lines.value_or(false) && !option.empty() && option != "--engine")
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: has pair lines, and {} asks for common directions; leave it out, or take another file",
                            checkpoint.string(), option));
  const uint64_t first = request().first_replicate;
  if (found.sums.replicates != std::vector{ReplicateRange{first, first + found.sums.replicateCount()}})
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: holds replicates {}, not all from --first-replicate {} on; merge it with the files of "
                            "the missing ones",
                            checkpoint.string(), describeReplicates(found.sums.replicates), first));
  state_->setup.adoptPlan(found.settings);
  state_->resumed = std::move(found);
  state_->resumed_file = checkpoint;
  return describeReplicates(state_->resumed->sums.replicates);
}

void FormFactorRun::writeCheckpoint(const std::filesystem::path& file) const {
  viewpeel::writeCheckpoint(settings(), sums(), file);
}

const PlanSummary& FormFactorRun::makePlan() {
  if (!state_->start) state_->doUnlessStopped([&] { state_->makePlan(); });
  return state_->summary;
}

const PriorSummary* FormFactorRun::findPrior() {
  makePlan();
  state_->doUnlessStopped([&] { state_->findPrior(); });
  return state_->prior_summary ? &*state_->prior_summary : nullptr;
}

bool FormFactorRun::isDone() const { return state_->is_done; }

void FormFactorRun::step() {
  findPrior();
  state_->doUnlessStopped([&] {
    if (!state_->isBegun()) state_->begin();
    if (!state_->is_done) state_->step();
  });
}

bool FormFactorRun::isInterrupted() const { return state_->is_interrupted; }
uint64_t FormFactorRun::replicateCount() const { return state_->isBegun() ? state_->replicateCount() : 0; }
const RunSums& FormFactorRun::sums() const { return state_->sums(); }
std::string FormFactorRun::division() const { return state_->engine().describePlan(); }

Result FormFactorRun::resultSoFar() const {
  if (state_->line_guarantee)
    return state_->resultOf(state_->line_guarantee->estimate(state_->sums(), request().relative_floor));
  return state_->resultOf(state_->line_run        ? state_->line_run->estimate()
                          : state_->guarantee_run ? state_->guarantee_run->estimateSoFar()
                                                  : state_->estimate_run->estimateSoFar());
}

Result FormFactorRun::result() {
  checkDevice();
  if (!state_->isBegun()) return state_->resultOf(state_->estimateOfNothing());
  const auto estimate = [&] {
    if (state_->line_run) return state_->line_run->estimate();
    if (state_->line_guarantee) return state_->line_guarantee->estimate(sums(), request().relative_floor);
    if (!state_->guarantee_run) return state_->estimate_run->takeEstimate();
    return state_->is_done && !state_->is_interrupted ? state_->guarantee_run->estimate()
                                                      : state_->guarantee_run->estimateSoFar();
  };
  Result result = state_->resultOf(estimate());
  result.division = division();
  if (!result.interrupted)
    result.warnings = warnOfLeaks(state_->setup.scene(), result.form_factors, requestedError(request()));
  if (state_->is_promise_broken)
    result.warnings.push_back(fmt::format(
        "the promise of the plan could not be kept: {}; the form factors are estimates with standard errors",
        state_->no_promise));
  if (const Work* work = state_->engine().work()) result.work = *work;
  return result;
}

void FormFactorRun::checkDevice() const {
  const Device* device = state_->setup.device();
  if (device && !device->validationErrors().empty())
    throw Error(ErrorCode::device, "Vulkan validation: " + device->validationErrors().front());
}

Result computeFormFactors(const Scene& scene, const Request& request, const Observer& observer) {
  FormFactorRun run(scene, request, observer);
  while (!run.isDone()) run.step();
  return run.result();
}

}  // namespace viewpeel
