// This file plans a run: engine, sampling and directions, and the lines of pairs or the cost of a guarantee.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "directions/replicates.h"
#include "estimator/plan_lines.h"
#include "estimator/plan_rays.h"
#include "memory.h"
#include "run/observed_engine.h"
#include "run/rules.h"
#include "run/run_state.h"
#include "run/settings.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr double kSecondsOfLine = 4e-8;  // of one thread, where a line is tested against some 10 blockers
// Lines that graze edges may end on backs by rounding where nothing leaks. They are at most this share of a row's
// lines: in cities of 1,000 to 6,600 triangles 4e-5 were measured.
constexpr double kGrazedShare = 1e-3;
constexpr uint32_t kPilotDirections = 64, kTriedDirections = 16;  // of the first pilot; of each lattice of a mixture

void requireSamePairs(const std::vector<LinePair>& found, const std::vector<LinePair>& stored) {
  if (!std::ranges::equal(found, stored, {}, keyOf<LinePair>, keyOf<LinePair>))
    throw Error(
        ErrorCode::bad_usage,
        "the checkpoint has lines of other pairs than this scene, though the settings are the same; was it made "
        "by another build of viewpeel?");
}

}  // namespace

// Makes the plan of a request that fixes directions and resolution.
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

// Makes the plan. It does without unoccluded form factors where they would make counts too large, unless the request
// asks for them.
Plan FormFactorRun::State::makePlanOfRequest() {
  if (setup.isExact() || !setup.plans()) return makeFixedPlan();
  const auto planned = [&] { return planEstimate(setup.scene(), setup.ids(), setup.estimate(), setup.lattices()); };
  Plan found = planned();
  if (!found.counts_too_large) return found;
  if (!setup.unoccludedByDefault())
    throw Error(
        ErrorCode::bad_usage,
        "polygons differ too much in size for unoccluded form factors at this goal: counts would be too large; add "
        "--unoccluded off, or ask for a larger error");
  found.engine.reset();
  setup.leaveOutUnoccluded();
  return planned();
}

// Counts pilot directions, which the run does not use again. The plan learns from them how many pairs a direction
// meets.
PairCounts FormFactorRun::State::countDirections(uint32_t count) {
  if (plan->directions == 0) return {};
  return plan->engine->count(
      sampleDirections(setup.estimate().sampler, count, setup.request().seed, kLineReplicates.first));
}

// Returns the largest share of a row's lines that end on backs, over a few directions.
double FormFactorRun::State::measureLeaks(const PairCounts& counts) const {
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

// Returns the number of common directions in a replicate of pair lines. Where these directions count pairs, there are
// so many that five of them, each meeting a whole pair, give it the form factor epsilon: docs/method.md, eq. (7). So
// counts are hardly ever cut off at epsilon.
uint32_t FormFactorRun::State::commonDirections() const {
  if (!(setup.leastFormFactor() > 0)) return kLineRunDirections;
  constexpr double kMeetings = 5, kMostDirections = 512;
  const double all = 2 * kMeetings / setup.guarantee()->epsilon;
  return static_cast<uint32_t>(
      std::clamp(std::ceil(all / kFewReplicates), double(kLineRunDirections), kMostDirections));
}

// Makes the engine of common directions. Where these count pairs, small polygons have windows of their own.
void FormFactorRun::State::makeLineEngine() {
  Lattices lattices = setup.lattices();
  int& resolution = lattices.lattice.resolution;
  rays = nullptr;
  if (line_mixture.hasRays()) {
    auto engine = makeRayEngine(setup.scene(), setup.faceIds(), lattices.lattice);
    engine->setRays(line_mixture.rays);
    useRays(std::move(engine));
    return;
  }
  const bool is_mixture = line_mixture.resolution > 0;
  if (is_mixture) resolution = line_mixture.resolution;
  plan->directions = setup.faceIds().counts_environment ? line_mixture.directions : 0;
  plan->groups = is_mixture && setup.mayHaveWindows() ? planGroups(setup.scene(), setup.faceIds(), setup.sampling(),
                                                                   resolution, resolution, plan->directions)
                                                      : groupAsOne(setup.scene(), resolution);
  plan->engine = makeEngine(lattices, setup.scene(), setup.faceIds(), plan->groups);
}

// Decides whether all pairs have lines, or only the pairs that are not small against the goal.
//   In: counts: along pilot directions    Out: the reason if neither is possible, else empty
std::string FormFactorRun::State::takeMixture(const PairCounts& counts) {
  if (resumed) {
    const double least = resumed->sums.lines->leastFormFactor(), most = least * kMostOfCounted;
    constexpr double kRounding = 1e-9;
    if (least > 0 && setup.mixture().least_form_factor < (1 - kRounding) * least)
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("{}: pairs with form factors below {:.2g} have no lines there, so that errors may be {:.2g}; "
                      "ask for that --tolerance or a larger one, or take another file",
                      resumed_file.string(), least, most));
    line_mixture = {least, setup.estimate().directions, least > 0 ? setup.resolution() : 0, resumed->sums.rays};
    makeLineEngine();
    return "";
  }
  if (!setup.plansWhichPairs()) return "";
  const bool may_have_rays = mayHaveRays(), may_count = setup.isLarge() || !(may_leave || no_promise.empty());
  if (!may_have_rays && !may_count) return "";
  const uint32_t replicates = setup.estimate().replicates;
  const LineMixture mixture = setup.mixture();
  LineWork work{pair_lines->estimatePairs(mixture.least_form_factor), double(counts.size()) / kPilotDirections};
  if ((may_have_rays && takeRays(work.pairs)) || !may_count) return "";
  const bool may_be_exact = !setup.isLarge() && work.pairs.blocked == 0;
  if (may_be_exact || paysLinesForAll(work, mixture, replicates)) return "";
  if (!setup.request().question.isEverything())
    return mayFindAll(work.pairs) ? "" : "too many pairs of polygons see each other";
  const bool insists = setup.request().pair_lines.value_or(false);
  if (may_leave && !insists && setup.estimate().tolerance.value_or(0) > kCoarseTolerance)
    return fmt::format("lines leave the scene or end on backs, and the tolerance is above {}", kCoarseTolerance);
  std::string why =
      "lines leave the scene or end on backs, and too many pairs of polygons see each other for pair lines";
  if (!may_leave) {
    why = "the scene has too many pairs of polygons";
    if (fitMixture(mixture, work) && !paysLinesForAll(work, mixture, replicates)) return "";
  }
  line_mixture = {};
  makeLineEngine();
  return !setup.isLarge() || mayFindAll(work.pairs) ? "" : why;
}

// Returns whether each polygon may have rays of its own: where the scene and the request suit rays, and lines for the
// most pairs that there can be would take longer.
bool FormFactorRun::State::mayHaveRays() const {
  const Request& request = setup.request();
  const EstimateOptions& options = setup.estimate();
  const auto most = double(pairCount(setup.faceIds().count()));
  return may_leave && options.tolerance && !options.relative && request.question.isEverything() &&
         !request.pair_lines.value_or(false) && suitsRays(setup.scene()) &&
         paysRays({.facing = most, .decided = most, .found = most, .blocked = most}, pilotRays(), mayPromise());
}

// Returns whether the tolerance may become a promise, where all pairs have lines.
bool FormFactorRun::State::mayPromise() const { return no_promise.empty() && !setup.isLarge(); }

// Returns the number of rays of a pilot, of all polygons.
double FormFactorRun::State::pilotRays() const {
  return double(setup.scene().polygons.size()) * kPilotRays * kPilotReplicates;
}

// Decides whether rays see what leaves the scene, and count the small pairs.
//   Out: whether they do; then line_mixture and its engine are set
bool FormFactorRun::State::takeRays(const PairNumbers& numbers) {
  if (!paysRays(numbers, pilotRays(), mayPromise())) return false;
  const Ids& face_ids = setup.faceIds();
  const EstimateOptions& options = setup.estimate();
  auto engine = makeRayEngine(setup.scene(), face_ids, setup.lattices().lattice);
  std::vector<uint32_t> rows = face_ids.surface;
  if (options.by == By::polygon) std::iota(rows.begin(), rows.end(), 0);
  std::vector<uint32_t> of_faces =
      planRays(*engine, setup.scene(), face_ids, rows, *options.tolerance, options.replicates, options.seed);
  double all = 0;
  for (const uint32_t face : face_ids.of_polygon) all += of_faces[face];
  if (!paysRays(numbers, all * options.replicates, mayPromise())) return false;
  if (no_promise.empty())
    refusePromise("a promise needs lines of all pairs, which take more than twice the time of rays");
  line_mixture = rayMixtureFor(*options.tolerance, std::move(of_faces));
  engine->setRays(line_mixture.rays);
  useRays(std::move(engine));
  return true;
}

// Plans to count along rays.    In: engine: with the rays of line_mixture
void FormFactorRun::State::useRays(std::unique_ptr<RayEngine> engine) {
  plan->directions = line_mixture.directions;
  plan->groups = groupAsOne(setup.scene(), line_mixture.resolution);
  rays = engine.get();
  plan->engine = std::move(engine);
}

// Takes the finest lattice at which the sums of counted pairs fit into memory.
//   Out: line_mixture and its engine; work: pairs of a direction on this lattice; false where none fits
bool FormFactorRun::State::fitMixture(LineMixture mixture, LineWork& work) {
  constexpr int kLeastResolution = 64;
  const double enough = std::clamp(kCountedOfFace * double(setup.faceIds().count()), kCountedPairs, kMostCountedPairs);
  for (;; mixture.resolution = std::max(mixture.resolution / 2, kLeastResolution)) {
    line_mixture = mixture;
    makeLineEngine();
    work.pairs_of_direction = double(countDirections(kTriedDirections).size()) / kTriedDirections;
    const double counted = countedPairs(work, mixture, setup.estimate().replicates);
    if (counted <= enough) return true;
    if (mixture.resolution <= kLeastResolution) return counted <= kMostCountedPairs;
  }
}

// Makes pair_lines and an engine for common directions, and finds blockers.    Out: why pair lines are not possible,
// else empty
std::string FormFactorRun::State::makePairLines() {
  plan.emplace();
  line_mixture = {setup.leastFormFactor(), commonDirections(), 0};
  makeLineEngine();
  const PairCounts counts = resumed ? PairCounts() : countDirections(kPilotDirections);
  leaked_share = measureLeaks(counts);
  may_leave = shareOutside(counts) > kGrazedOfScene;
  // In an estimate, backs are sampled only where a row loses a share that matters at its tolerance.
  const double least_share = setup.guarantee() ? 0 : std::min(kGrazedShare, setup.estimate().tolerance.value_or(1));
  const bool with_leak =
      resumed ? resumed->sums.lines->hasBacks() : leaked_share > least_share && !(setup.leastFormFactor() > 0);
  const auto make = [&](bool has_backs) {
    pair_lines.emplace(
        setup.scene(), setup.faceIds(), has_backs, setup.request().seed, setup.request().threads,
        [this] { stopIfRequested(); }, setup.lineDevice(), setup.crew());
  };
  make(with_leak);
  const bool insists = setup.request().pair_lines.value_or(false) || resumed;
  if (pair_lines->hasUnordered() && insists)
    throw Error(
        ErrorCode::bad_usage,
        "polygons coincide, and nothing says which of them lies in front, as pair lines need to know; name them by "
        "--sheets or --solids, or leave out --pair-lines");
  if (pair_lines->hasUnordered()) return "coincident polygons have no order";
  const std::string why = takeMixture(counts);
  if (!why.empty() && insists) throw Error(ErrorCode::limit, fmt::format("{}; leave out --pair-lines", why));
  if (line_mixture.least_form_factor > 0 && with_leak) make(false);  // common directions count the leak
  return why;
}

// Finds the pairs that get lines.    Out: false where there are too many of them
bool FormFactorRun::State::findLinePairs() {
  const auto begun = Clock::now();
  line_pairs = pair_lines->find(line_mixture.least_form_factor);
  if (line_pairs.size() > kLargeList) returnFreedMemory();  // threads had lists of their own
  finding_seconds = secondsSince(begun);
  if (pair_lines->hasTooMany()) requireNoPairLines();
  return !pair_lines->hasTooMany();
}

// Returns whether geometry alone gives all form factors of a closed scene: nothing can block a pair, and the exact form
// factors of each row add up to 1 within the bound on their errors. So nothing leaves the scene or ends on a back.
//   In: line_pairs: from findLinePairs()    Error: m terms are added with a rounding of (m + 1) 2^-53 of their sum
bool FormFactorRun::State::isAllExact() const {
  const Ids& ids = setup.faceIds();
  if (!ids.rows_sum_to_one || line_mixture.least_form_factor > 0) return false;
  std::vector<double> sums(ids.count()), errors(ids.count());
  for (const LinePair& pair : line_pairs) {
    if (pair.clear < pair.exchange || pair.j >= ids.count()) return false;  // something blocks it, or it leaks
    for (const uint32_t id : {pair.i, pair.j}) {
      sums[id] += pair.exchange;
      errors[id] += pair.error + 0x1p-53 * ids.areas[id];
    }
  }
  for (uint32_t id = 0; id < ids.count(); ++id)
    if (ids.isRequested(id) && !(std::abs(ids.areas[id] - sums[id]) <= errors[id] + 0x1p-53 * ids.areas[id]))
      return false;
  return true;
}

// Plans a few common directions and the lines of each pair: a promise where possible, else an estimate.
void FormFactorRun::State::planPairLines() {
  if (const std::string why = makePairLines(); !why.empty()) return planWithoutPairLines(why);
  if (!findLinePairs()) return planWithoutPairLines("too many pairs of polygons see each other");
  if (!resumed && isAllExact()) plan->directions = 0;
  if (setup.isLarge() && setup.plansWhichPairs() && no_promise.empty())
    no_promise = fmt::format("there are more than {} polygons", kMostPairLineFaces);
  if (resumed || !no_promise.empty() || !planPromise()) planEstimateLines();
}

// Plans the lines of each pair for an estimate.    In: line_pairs: from findLinePairs()
void FormFactorRun::State::planEstimateLines() {
  const EstimateOptions& options = setup.estimate();
  if (resumed) {
    requireSamePairs(line_pairs, resumed->sums.lines->pairs());
    line_pairs = resumed->sums.lines->pairs();
    pair_lines->cut(line_pairs);
  } else {
    // Half of the time is kept for finding pairs, and for further lines where errors are still too large.
    const double threads = setup.request().threads ? setup.request().threads : double(threadCount()),
                 most_lines = options.seconds ? *options.seconds / 2 * threads / kSecondsOfLine : INFINITY;
    // Where all pairs have lines, a row's environment is what they leave of it.
    const bool is_open = may_leave && !(line_mixture.least_form_factor > 0);
    line_pairs =
        planLines(*pair_lines, std::move(line_pairs), setup.faceIds(), setup.ids(), options, is_open, most_lines);
  }
  const PairLinesFigures figures = pair_lines->figures();
  plan->pair_lines = {figures.clear,         figures.partial,      0,
                      figures.blockers,      secondsSince(*start), line_mixture.least_form_factor,
                      line_mixture.hasRays()};
  for (const LinePair& pair : line_pairs)
    plan->pair_lines->lines += static_cast<uint64_t>(pair.linesIn(options.replicates));
}

// Continues without pair lines where there are too many pairs; throws where the request insists on them.
void FormFactorRun::State::requireNoPairLines() const {
  if (setup.request().pair_lines || resumed)
    throw Error(ErrorCode::limit, fmt::format("more than {} pairs of polygons see each other, too many for pair lines; "
                                              "leave out --pair-lines",
                                              kMostPatchPairs));
}

void FormFactorRun::State::planWithoutPairLines(const std::string& why) {
  if (no_promise.empty()) refusePromise(why);
  no_pair_lines = why;
  pair_lines.reset();
  line_pairs.clear();
  setup.leaveOutPairLines();
  plan = makePlanOfRequest();
}

void FormFactorRun::State::planEstimateOfDirections() {
  no_pair_lines = resumed ? "the checkpoint has none" : setup.noPairLines();
  if (no_promise.empty()) refusePromise(no_pair_lines);
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

// Plans a guarantee by pair lines. Returns false where pair lines cannot be used.
bool FormFactorRun::State::planLineGuarantee() {
  if (!makePairLines().empty() || !findLinePairs()) return false;
  if (isAllExact()) plan->directions = 0;
  makeLineGuarantee();
  line_guarantee->predictSeconds(finding_seconds);
  const LineGuaranteeFigures& figures = line_guarantee->figures();
  if (const auto& limit = setup.request().time_limit_s; limit && figures.expected_seconds > *limit)
    refuseGuarantee(figures, *limit);
  return true;
}

void FormFactorRun::State::makeLineGuarantee() {
  const EpsilonDelta& goal = *setup.guarantee();
  line_guarantee.emplace(
      setup.scene(), setup.faceIds(), setup.ids(), *pair_lines, line_pairs,
      LineGuaranteeOptions{
          goal.epsilon, goal.delta, goal.rows, setup.request().by, setup.leastFormFactor(),
          plan->directions ? double(kPilotDirections) + double(kFewReplicates) * plan->directions : 0});
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
  summary.plan_seconds = secondsSince(*start);
  if (resumed) requireSameSettings(settingsOf(setup, summary), resumed->settings, resumed_file);
}

// Describes the plan in `summary` and lets the observer watch the engine.
void FormFactorRun::State::summariseRun() {
  std::unique_ptr<Engine>& engine = guarantee ? guarantee->engine : plan->engine;
  engine = observed(std::move(engine), observer.on_count);
  summary = guarantee ? summarise(setup, *guarantee) : summarise(setup, *plan);
  if (line_guarantee) summary.line_guarantee = line_guarantee->figures();
  if (setup.guarantee()) return;
  summary.no_promise = no_promise;
  if (setup.estimate().tolerance || setup.estimate().relative) summary.no_pair_lines = no_pair_lines;
}

}  // namespace viewpeel
