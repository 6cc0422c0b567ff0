#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/compute.h>

#include "directions/replicates.h"
#include <viewpeel/error.h>
#include "estimator/estimate_run.h"
#include "estimator/guarantee_run.h"
#include "estimator/line_guarantee.h"
#include "estimator/line_run.h"
#include "estimator/find_prior.h"
#include "io/checkpoint.h"
#include "result/leak_warnings.h"
#include "run/observed_engine.h"
#include "run/settings.h"
#include "run/setup.h"
#include "run/summaries.h"
#include "stopwatch.h"
#include "sums/add_pairs.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr double kTrialSeconds = 0.5;    // of measureSeconds
constexpr double kSecondsOfLine = 4e-8;  // on one thread, against some 10 blockers
constexpr uint64_t kFewReplicates = 8;   // of common directions of a guarantee

void requireSamePairs(const std::vector<LinePair>& found, const std::vector<LinePair>& stored) {
  if (!std::ranges::equal(found, stored, {}, keyOf<LinePair>, keyOf<LinePair>))
    throw Error(
        ErrorCode::bad_usage,
        "the checkpoint has lines of other pairs than this scene, though the settings are the same; was it made "
        "by another build of viewpeel?");
}

}  // namespace

struct FormFactorRun::State {
  Observer observer;
  Progress progress;
  Setup setup;
  PlanSummary summary;
  std::optional<Checkpoint> resumed;
  std::filesystem::path resumed_file;
  std::optional<Clock::time_point> start;  // of the plan
  std::optional<Plan> plan;
  std::optional<GuaranteePlan> guarantee;
  PairSampler pairs;
  FaceExchanges exchanges;
  FoundPrior found_prior;
  std::optional<PriorSummary> prior_summary;
  std::optional<EstimateRun> estimate_run;
  std::optional<GuaranteeRun> guarantee_run;
  std::optional<PairLines> pair_lines;
  std::vector<LinePair> line_pairs;  // as planned
  std::optional<LineRun> line_run;
  std::optional<LineGuarantee> line_guarantee;
  std::optional<RunSums> common_sums;  // of a guarantee by lines: environment and leak
  bool is_interrupted = false, is_done = false;

  State(const Scene& scene, Request request, Observer watching)
      : observer(std::move(watching)),
        setup(
            scene, std::move(request), [this](uint64_t directions) { onBatch(directions); },
            [this] { stopIfRequested(); }),
        summary(summarise(setup)),
        pairs(setup.pairSampler()),
        exchanges(setup.device(), scene, setup.faceIds(), [this] { stopIfRequested(); }) {}

  void stopIfRequested() const {
    if (observer.should_stop && observer.should_stop()) throw Interrupted{};
  }
  void tellProgress() const {
    if (observer.on_progress) observer.on_progress(progress);
  }
  void onBatch(uint64_t directions) {
    stopIfRequested();
    if (setup.guarantee()) return;  // it counts blocks
    progress.directions = directions;
    tellProgress();
  }

  // Runs the work; if the observer stops it, the run has come to its end.
  template <class Work>
  void doUnlessStopped(const Work& work) {
    if (is_interrupted) return;
    try {
      work();
    } catch (const Interrupted&) {
      is_interrupted = is_done = true;
    }
  }

  Engine& engine() const { return guarantee ? *guarantee->engine : *plan->engine; }
  const RunSums& sums() const {
    return guarantee_run ? guarantee_run->sums()
           : line_run    ? line_run->sums()
           : common_sums ? *common_sums
                         : estimate_run->sums();
  }
  bool isBegun() const { return estimate_run || guarantee_run || line_run || common_sums; }
  uint64_t replicateCount() const { return line_guarantee ? line_guarantee->lookCount() : sums().replicateCount(); }

  Plan makeFixedPlan() const;
  Plan makePlanOfRequest();
  void makePlan();
  bool leaks();
  bool makePairLines();
  void planPairLines();
  void planWithoutPairLines();
  void requireNoPairLines() const;
  void planGuarantee();
  bool planLineGuarantee();
  void countCommonDirections();
  void findPrior();
  EstimateOptions estimateOptions();
  void begin();
  void step();
  Estimate estimateOfNothing() const;
  Result resultOf(Estimate estimate) const;
};

// As the request has it.
Plan FormFactorRun::State::makeFixedPlan() const {
  Plan fixed;
  fixed.directions = setup.estimate().directions;
  fixed.finest = setup.finest();
  const Lattices lattices = setup.lattices();
  const int resolution = setup.resolution() ? setup.resolution() : lattices.lattice.resolution;
  fixed.groups = fixed.finest ? planGroups(setup.scene(), setup.ids(), setup.sampling(), resolution, fixed.finest,
                                           fixed.directions)
                              : groupAsOne(setup.scene(), resolution);
  fixed.engine = makeEngine(lattices, setup.scene(), setup.ids(), fixed.groups);
  return fixed;
}

// Makes the plan. It goes without unoccluded form factors where counts would be too large for them and the request does
// not insist on them.
Plan FormFactorRun::State::makePlanOfRequest() {
  if (setup.isExact() || !setup.plans()) return makeFixedPlan();
  const auto planned = [&] { return planEstimate(setup.scene(), setup.ids(), setup.estimate(), setup.lattices()); };
  Plan found = planned();
  if (!found.counts_too_large) return found;
  if (!setup.unoccludedByDefault())
    throw Error(
        ErrorCode::bad_usage,
        "polygons differ too much in size for unoccluded form factors at this goal: counts would be too large; say "
        "--unoccluded off, or ask for less");
  found.engine.reset();
  setup.leaveOutUnoccluded();
  return planned();
}

// Whether any line of a few directions ends on a back.
bool FormFactorRun::State::leaks() {
  const std::vector<Direction> directions =
      sampleDirections(setup.estimate().sampler, 2 * kLineRunDirections, setup.request().seed, kLineReplicates.first);
  return std::ranges::any_of(plan->engine->count(directions), [](const PairCount& count) { return count.j == kLeak; });
}

// Finds what lies between polygons, with an engine for a few common directions.    Out: false where it is not defined
// what lies between two polygons
bool FormFactorRun::State::makePairLines() {
  plan.emplace();
  plan->directions = setup.faceIds().counts_environment ? kLineRunDirections : 0;
  const Lattices lattices = setup.lattices();
  plan->groups = groupAsOne(setup.scene(), lattices.lattice.resolution);
  plan->engine = makeEngine(lattices, setup.scene(), setup.faceIds(), plan->groups);
  const bool with_leak = resumed ? resumed->sums.lines->hasBacks() : plan->directions > 0 && leaks();
  pair_lines.emplace(setup.scene(), setup.faceIds(), with_leak, setup.request().seed, setup.request().threads,
                     [this] { stopIfRequested(); });
  if (pair_lines->hasUnordered() && (setup.request().pair_lines || resumed))
    throw Error(
        ErrorCode::bad_usage,
        "polygons coincide of which nothing says which lies in front, and pair lines need to know; name them by "
        "--sheets or --solids, or leave out --pair-lines");
  return !pair_lines->hasUnordered();
}

// Few common directions, and lines for each pair.
void FormFactorRun::State::planPairLines() {
  const auto begun = Clock::now();
  if (!makePairLines()) return planWithoutPairLines();
  const EstimateOptions& options = setup.estimate();
  // Half of the time is for finding pairs, and for further lines of those that need them.
  const double threads = setup.request().threads ? setup.request().threads : double(threadCount()),
               most_lines = options.seconds ? *options.seconds / 2 * threads / kSecondsOfLine : INFINITY;
  line_pairs = resumed ? resumed->sums.lines->pairs()
                       : planLines(*pair_lines, setup.faceIds(), setup.ids(), options, most_lines);
  if (resumed) requireSamePairs(pair_lines->find(), line_pairs);
  if (pair_lines->hasTooMany()) {
    requireNoPairLines();
    return planWithoutPairLines();
  }
  const PairLinesFigures figures = pair_lines->figures();
  plan->pair_lines = {figures.clear, figures.partial, 0, figures.blockers, secondsSince(begun)};
  for (const LinePair& pair : line_pairs)
    plan->pair_lines->lines += static_cast<uint64_t>(pair.linesIn(options.replicates));
}

// Refuses a request that insists on pair lines where there are too many pairs.
void FormFactorRun::State::requireNoPairLines() const {
  if (setup.request().pair_lines || resumed)
    throw Error(ErrorCode::limit, fmt::format("more than {} pairs of polygons see each other, too many for pair lines; "
                                              "leave out --pair-lines",
                                              kMostPatchPairs));
}

void FormFactorRun::State::planWithoutPairLines() {
  pair_lines.reset();
  line_pairs.clear();
  setup.leaveOutPairLines();
  plan = makePlanOfRequest();
}

void FormFactorRun::State::planGuarantee() {
  if (setup.usesPairLines()) {
    if (planLineGuarantee()) return;
    line_guarantee.reset(), pair_lines.reset(), plan.reset();
    setup.leaveOutPairLines();
  }
  guarantee =
      viewpeel::planGuarantee(setup.scene(), setup.ids(), setup.guaranteeOptions(), setup.lattices(), setup.isExact());
  if (const auto& limit = setup.request().time_limit_s; limit && guarantee->least_seconds > *limit)
    refuseGuarantee(*guarantee, *limit);
  guarantee->engine = observed(std::move(guarantee->engine), observer.on_count);
  summary = summarise(setup, *guarantee);
}

// Returns false where pair lines cannot do it.
bool FormFactorRun::State::planLineGuarantee() {
  if (!makePairLines()) return false;
  const EpsilonDelta& goal = *setup.guarantee();
  line_guarantee.emplace(setup.scene(), setup.faceIds(), setup.ids(), *pair_lines,
                         LineGuaranteeOptions{goal.epsilon, goal.delta, goal.rows, setup.request().by});
  if (pair_lines->hasTooMany()) {
    requireNoPairLines();
    return false;
  }
  const LineGuaranteeFigures& figures = line_guarantee->figures();
  if (const auto& limit = setup.request().time_limit_s; limit && figures.expected_seconds > *limit)
    refuseGuarantee(figures, *limit);
  plan->engine = observed(std::move(plan->engine), observer.on_count);
  summary = summarise(setup, *plan);
  summary.line_guarantee = figures;
  return true;
}

void FormFactorRun::State::makePlan() {
  start = Clock::now();
  if (setup.guarantee()) {
    planGuarantee();
  } else {
    if (setup.usesPairLines()) planPairLines();
    else plan = makePlanOfRequest();
    plan->engine = observed(std::move(plan->engine), observer.on_count);
    summary = summarise(setup, *plan);
  }
  if (resumed) requireSameSettings(settingsOf(setup, summary), resumed->settings, resumed_file);
}

void FormFactorRun::State::findPrior() {
  if (!setup.usesUnoccluded() || setup.guarantee() || resumed || prior_summary) return;
  EstimateOptions pilot = setup.estimate();
  pilot.directions = plan->directions;
  pilot.pairs = &pairs;
  found_prior = viewpeel::findPrior(engine(), exchanges, setup.scene(), setup.faceIds(), plan->groups, pilot,
                                    choosePriorPilot(pilot));
  prior_summary = summarise(found_prior);
}

EstimateOptions FormFactorRun::State::estimateOptions() {
  EstimateOptions options = setup.estimate();
  options.directions = plan->directions;
  options.resumed = resumed ? &resumed->sums : nullptr;
  options.pairs = &pairs;
  if (setup.usesUnoccluded()) {
    options.prior = &found_prior.prior;
    options.exchanges = &exchanges;
  }
  if (options.seconds) options.seconds = std::max(*options.seconds - secondsSince(*start), 1e-3);
  return options;
}

// Common directions tell which rows see the environment, and where lines leak.
void FormFactorRun::State::countCommonDirections() {
  common_sums.emplace(makeRunSums(setup.scene(), setup.faceIds()));
  if (plan->directions == 0) return;
  common_sums->measure_area =
      plan->engine->unitArea() * setup.scene().scale * setup.scene().scale / double(plan->directions);
  for (uint64_t replicate = 0; replicate < kFewReplicates; ++replicate) {
    PairCounts counts = plan->engine->count(
        sampleDirections(setup.estimate().sampler, plan->directions, setup.request().seed, replicate));
    std::erase_if(counts, [](const PairCount& count) { return count.j < kEnvironment; });
    common_sums->add(replicate, counts, plan->directions);
  }
}

void FormFactorRun::State::begin() {
  if (line_guarantee) {
    progress.expected_blocks = progress.most_blocks = line_guarantee->mostLooks();
    return countCommonDirections();
  }
  if (guarantee) {
    GuaranteeOptions options = setup.guaranteeOptions();
    options.resumed = resumed ? &resumed->sums : nullptr;
    guarantee_run.emplace(setup.scene(), setup.ids(), options, *guarantee);
    progress.expected_blocks = guarantee_run->expectedBlocks();
    progress.most_blocks = guarantee_run->mostBlocks();
    is_done = guarantee_run->isDone();
    return;
  }
  progress.directions_of_replicate = plan->directions;
  if (pair_lines) {
    line_run.emplace(*plan->engine, setup.scene(), setup.faceIds(), *pair_lines, std::move(line_pairs),
                     estimateOptions());
    is_done = line_run->isDone();
    return;
  }
  estimate_run.emplace(*plan->engine, setup.scene(), setup.countedIds(), estimateOptions());
  is_done = estimate_run->isDone();
}

void FormFactorRun::State::step() {
  const auto tell = [&] {
    progress.replicates = replicateCount();
    progress.directions = 0;
    tellProgress();
    stopIfRequested();
  };
  if (line_guarantee) {
    line_guarantee->step();
    is_done = line_guarantee->isDone();
    tell();
    return;
  }
  if (guarantee_run) {
    guarantee_run->step(tell);
    is_done = guarantee_run->isDone();
    return;
  }
  const auto stepOf = [&](auto& run) {
    run.step();
    is_done = run.isDone();
    progress.largest_standard_error = run.largestStandardError();
    tell();
  };
  if (line_run) stepOf(*line_run);
  else stepOf(*estimate_run);
}

// Of a run that was stopped before it counted anything.
Estimate FormFactorRun::State::estimateOfNothing() const {
  return {FormFactors(setup.ids(), {}, std::vector<Measured>(setup.ids().count())),
          FormFactors({}, {}, {}),
          0,
          0,
          INFINITY,
          INFINITY};
}

Result FormFactorRun::State::resultOf(Estimate estimate) const {
  Result result{std::move(estimate)};
  result.interrupted = is_interrupted;
  result.environment_share = shareOf(result.form_factors, kEnvironment);
  result.leak_share = shareOf(result.form_factors, kLeak);
  result.plan = summary;
  result.seconds = start ? secondsSince(*start) : 0;
  if (!setup.request().balance) return result;
  try {
    result.balanced = balanceRows(result.form_factors);
  } catch (const Error& error) {
    result.balance_refusal = error;
  }
  return result;
}

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
  const uint64_t first = request().first_replicate;
  if (found.sums.replicates != std::vector{ReplicateRange{first, first + found.sums.replicateCount()}})
    throw Error(
        ErrorCode::bad_usage,
        fmt::format(
            "{}: holds replicates {}, not all from --first-replicate {} on; merge it with those that are missing",
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

double FormFactorRun::measureSeconds() {
  makePlan();
  const EstimateOptions& estimate = state_->setup.estimate();
  const auto directionsOf = [&](uint32_t count) {
    return estimate.drawn_directions ? estimate.drawn_directions(count, kPlanReplicates.first).directions
                                     : sampleDirections(estimate.sampler, count, estimate.seed, kPlanReplicates.first);
  };
  const uint32_t all = state_->plan->directions;
  if (state_->pair_lines) {
    const auto trial = Clock::now();
    state_->pair_lines->count(state_->line_pairs, kTrialReplicates.first);
    return secondsSince(trial) * estimate.replicates;
  }
  double each = 0;
  uint32_t count = std::min(4u, all);
  for (uint32_t turn = 0; turn < 2; ++turn, count = std::clamp(static_cast<uint32_t>(kTrialSeconds / each), 1u, all)) {
    if (turn == 0) state_->engine().count(directionsOf(count));  // kernels are compiled and tuned
    const auto trial = Clock::now();
    state_->engine().count(directionsOf(count));
    each = std::max(secondsSince(trial), 1e-9) / count;
  }
  return each * all * estimate.replicates;
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
  if (!result.interrupted) result.warnings = warnOfLeaks(state_->setup.scene(), result.form_factors);
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
