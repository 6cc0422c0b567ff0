// Plans a run: engine, samples and directions, the pairs that get lines of their own, or what a guarantee takes.

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "directions/replicates.h"
#include "run/observed_engine.h"
#include "run/rules.h"
#include "run/run_state.h"
#include "run/settings.h"
#include "sums/add_pairs.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr double kSecondsOfLine = 4e-8;  // on one thread, against some 10 blockers
// A part of a row's lines up to this share may graze edges within rounding and end on backs where nothing leaks. In
// cities of 1,000 to 6,600 triangles it was 4e-5 at most.
constexpr double kGrazedShare = 1e-3;

void requireSamePairs(const std::vector<LinePair>& found, const std::vector<LinePair>& stored) {
  if (!std::ranges::equal(found, stored, {}, keyOf<LinePair>, keyOf<LinePair>))
    throw Error(
        ErrorCode::bad_usage,
        "the checkpoint has lines of other pairs than this scene, though the settings are the same; was it made "
        "by another build of viewpeel?");
}

}  // namespace

// Makes the plan that the request spells out.
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

// Returns the largest share of a row's lines that end on backs, over a few directions.
double FormFactorRun::State::measureLeaks() {
  const PairCounts counts = plan->engine->count(
      sampleDirections(setup.estimate().sampler, 2 * kLineRunDirections, setup.request().seed, kLineReplicates.first));
  std::vector<double> all(setup.faceIds().count()), leaked(all.size());
  for (const PairCount& count : counts) {
    for (const uint32_t id : {count.i, count.j})
      if (id < kEnvironment) all[id] += double(count.count);
    if (count.j == kLeak) leaked[count.i] += double(count.count);
  }
  double largest = 0;
  for (size_t k = 0; k < all.size(); ++k)
    if (leaked[k] > 0) largest = std::max(largest, leaked[k] / all[k]);
  return largest;
}

// Returns how many common directions a replicate has beside lines. Where they count pairs, five of all of them that a
// pair meets whole make up epsilon, by eq. (1), so that hardly a count is cut off there.
uint32_t FormFactorRun::State::commonDirections() const {
  if (!(setup.leastFormFactor() > 0)) return kLineRunDirections;
  constexpr double kMet = 5, kMostDirections = 512;
  const double all = 2 * kMet / setup.guarantee()->epsilon;
  return static_cast<uint32_t>(
      std::clamp(std::ceil(all / kFewReplicates), double(kLineRunDirections), kMostDirections));
}

// Finds the blockers of pairs, with an engine for a few common directions.    Out: false where coincident polygons have
// no order
bool FormFactorRun::State::makePairLines() {
  plan.emplace();
  plan->directions = setup.faceIds().counts_environment ? commonDirections() : 0;
  const Lattices lattices = setup.lattices();
  plan->groups = groupAsOne(setup.scene(), lattices.lattice.resolution);
  plan->engine = makeEngine(lattices, setup.scene(), setup.faceIds(), plan->groups);
  leaked_share = plan->directions > 0 && !resumed ? measureLeaks() : 0;
  // For an estimate a row has to lose a share that it would miss.
  const double least_share = setup.guarantee() ? 0 : std::min(kGrazedShare, setup.estimate().tolerance.value_or(1));
  const bool with_leak =
      resumed ? resumed->sums.lines->hasBacks() : leaked_share > least_share && !(setup.leastFormFactor() > 0);
  pair_lines.emplace(
      setup.scene(), setup.faceIds(), with_leak, setup.request().seed, setup.request().threads,
      [this] { stopIfRequested(); }, setup.lineDevice());
  if (pair_lines->hasUnordered() && (setup.request().pair_lines || resumed))
    throw Error(
        ErrorCode::bad_usage,
        "polygons coincide of which nothing says which lies in front, and pair lines need to know; name them by "
        "--sheets or --solids, or leave out --pair-lines");
  return !pair_lines->hasUnordered();
}

// Finds the pairs.    Out: false where there are too many of them
bool FormFactorRun::State::findLinePairs() {
  line_pairs = pair_lines->find(setup.leastFormFactor());
  if (pair_lines->hasTooMany()) requireNoPairLines();
  return !pair_lines->hasTooMany();
}

// Plans few common directions, and lines for each pair: a promise of the tolerance where it may have one.
void FormFactorRun::State::planPairLines() {
  if (!makePairLines()) return planWithoutPairLines("coincident polygons have no order");
  if (!findLinePairs()) return planWithoutPairLines("too many pairs of polygons see each other");
  if (resumed || !no_promise.empty() || !planPromise()) planEstimateLines();
}

// Gives pairs the lines of an estimate.    In: line_pairs: as found
void FormFactorRun::State::planEstimateLines() {
  const EstimateOptions& options = setup.estimate();
  if (resumed) {
    requireSamePairs(line_pairs, resumed->sums.lines->pairs());
    line_pairs = resumed->sums.lines->pairs();
  } else {
    // Half of the time is left for finding pairs, and for further lines of pairs that need them.
    const double threads = setup.request().threads ? setup.request().threads : double(threadCount()),
                 most_lines = options.seconds ? *options.seconds / 2 * threads / kSecondsOfLine : INFINITY;
    line_pairs = planLines(*pair_lines, std::move(line_pairs), setup.faceIds(), setup.ids(), options, most_lines);
  }
  const PairLinesFigures figures = pair_lines->figures();
  plan->pair_lines = {figures.clear, figures.partial, 0, figures.blockers, secondsSince(*start)};
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

void FormFactorRun::State::planWithoutPairLines(const std::string& why) {
  if (no_promise.empty()) refusePromise(why);
  pair_lines.reset();
  line_pairs.clear();
  setup.leaveOutPairLines();
  plan = makePlanOfRequest();
}

void FormFactorRun::State::planEstimateOfDirections() {
  if (no_promise.empty())
    refusePromise(setup.scene().faces.size() > kMostPairLineFaces
                      ? fmt::format("there are more than {} polygons", kMostPairLineFaces)
                      : fmt::format("the tolerance is above {}", kPairLineTolerance));
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
}

// Returns false where pair lines cannot do it.
bool FormFactorRun::State::planLineGuarantee() {
  if (!makePairLines() || !findLinePairs()) return false;
  makeLineGuarantee();
  line_guarantee->measureSeconds();
  const LineGuaranteeFigures& figures = line_guarantee->figures();
  if (const auto& limit = setup.request().time_limit_s; limit && figures.expected_seconds > *limit)
    refuseGuarantee(figures, *limit);
  return true;
}

void FormFactorRun::State::makeLineGuarantee() {
  const EpsilonDelta& goal = *setup.guarantee();
  line_guarantee.emplace(
      setup.scene(), setup.faceIds(), setup.ids(), *pair_lines, line_pairs,
      LineGuaranteeOptions{goal.epsilon, goal.delta, goal.rows, setup.request().by, setup.leastFormFactor()});
}

void FormFactorRun::State::makePlan() {
  start = Clock::now();
  enter(Progress::Phase::planning);
  if (const std::string option = optionAgainstPromise(setup.request()); !option.empty())
    no_promise = fmt::format("{} asks for an estimate", option);
  if (setup.guarantee()) planGuarantee();
  else if (setup.usesPairLines()) planPairLines();
  else planEstimateOfDirections();
  summariseRun();
  if (resumed) requireSameSettings(settingsOf(setup, summary), resumed->settings, resumed_file);
}

// Says what is planned, and lets the observer watch the engine.
void FormFactorRun::State::summariseRun() {
  std::unique_ptr<Engine>& engine = guarantee ? guarantee->engine : plan->engine;
  engine = observed(std::move(engine), observer.on_count);
  summary = guarantee ? summarise(setup, *guarantee) : summarise(setup, *plan);
  if (line_guarantee) summary.line_guarantee = line_guarantee->figures();
  if (!setup.guarantee()) summary.no_promise = no_promise;
}

}  // namespace viewpeel
