// This file plans a run: engine, sampling and directions, and the lines of pairs or the cost of a guarantee.

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>
#include "directions/replicates.h"
#include "estimator/plan_lines.h"
#include "memory.h"
#include "run/observed_engine.h"
#include "run/rules.h"
#include "run/run_state.h"
#include "run/settings.h"
#include "scene/exposed_backs.h"
#include "sums/add_pairs.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr double kSecondsOfLine = 4e-8;  // of one thread, where a line is tested against some 10 blockers
constexpr double kLeastLeft = 0.1;       // lines get this share of a time limit, even if all of it has been spent
// Lines that graze edges may end on backs by rounding where nothing leaks. They are at most this share of a row's
// lines: in cities of 1,000 to 6,600 triangles 4e-5 were measured.
constexpr double kGrazedShare = 1e-3;
// Pairs with exposed backs get lines where they are few, or at most this share of the pairs.
constexpr double kFewPairs = 2e5, kExposedShare = 0.125;
// Lines are planned by standard errors of single pairs, which are larger than errors in sums.
constexpr double kPlannedRms = 1.4;

// Returns the tolerance that a run with this number of lines is expected to reach. It is proportional to the number to
// the power of -5/8. At 1e-3 a pair that something may block has 175 lines on average in the office, and 240 in a city
// of 1,016 triangles.
double toleranceOfLines(const std::vector<LinePair>& pairs, double lines) {
  constexpr double kTolerance = 1e-3, kLinesOfPair = 200;
  const auto blocked = std::ranges::count_if(pairs, [](const LinePair& pair) { return pair.clear < pair.exchange; });
  return kTolerance * std::pow(kLinesOfPair * double(blocked) / lines, 5.0 / 8);
}

// Returns whether lines from a polygon that emits may end on one without a role: whether some points of each are in
// front of the other.
bool mayEndOnBlockers(const Scene& scene, const Ids& ids) {
  constexpr double kHeight = 1e-7;  // in radii: points that are less in front of a plane exchange next to nothing
  if (ids.rows_sum_to_one) return false;
  const auto isInFront = [&](const Polygon& polygon, const Polygon& of) {
    const Plane& plane = scene.planes[of.plane];
    const double side = of.front_along_plane_normal ? 1 : -1;
    const auto corners = std::span(scene.corners).subspan(polygon.first_corner, polygon.corner_count);
    return std::ranges::any_of(corners, [&](const glm::dvec3& corner) {
      const double height = side * (glm::dot(plane.normal, corner) - plane.offset);
      return (ids.two_sided ? std::abs(height) : height) > kHeight;
    });
  };
  for (uint32_t b = 0; b < scene.polygons.size(); ++b) {
    if (ids.rolesOf(b) != 0) continue;
    for (uint32_t e = 0; e < scene.polygons.size(); ++e)
      if ((ids.rolesOf(e) & kEmits) && isInFront(scene.polygons[e], scene.polygons[b]) &&
          isInFront(scene.polygons[b], scene.polygons[e]))
        return true;
  }
  return false;
}

// Returns whether some of the pairs are of faces that only block.
bool haveBlockers(const std::vector<LinePair>& pairs, const Ids& ids) {
  return std::ranges::any_of(pairs,
                             [&](const LinePair& pair) { return ids.onlyBlocks(pair.i) || ids.onlyBlocks(pair.j); });
}

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

// Returns the faces whose backs get lines although no ray of the survey ended on one: as few as are exposed, so that
// their lines cost little beside the others.
LeakingFaces FormFactorRun::State::exposedFaces() const {
  const Ids& ids = setup.faceIds();
  if (!ids.counts_environment || ids.two_sided || setup.leastFormFactor() > 0) return {};
  std::vector<bool> is_exposed = findExposedBacks(setup.scene());
  const auto exposed = double(std::ranges::count(is_exposed, true)), all = double(ids.count());
  if (exposed == 0 || exposed * all > std::max(kFewPairs, kExposedShare * all * all)) return {};
  return {std::vector<bool>(ids.count(), true), 0, std::move(is_exposed)};
}

// Makes pair_lines and finds blockers, and decides what counts.    Out: why pair lines are not possible, else empty
std::string FormFactorRun::State::makePairLines() {
  plan.emplace();
  line_mixture = {setup.leastFormFactor(), commonDirections(), 0};
  const std::optional<std::vector<uint32_t>> rays_alone = planRaysAloneForRms();
  if (!rays_alone) surveyOutside();
  // Pairs with backs get lines only where a row leaks a share that matters at the goal.
  const double least_share = setup.guarantee() ? kGrazedPart * setup.guarantee()->epsilon
                                               : std::min(kGrazedShare, setup.estimate().tolerance.value_or(1));
  const bool with_leak = leaked_share > least_share && !(setup.leastFormFactor() > 0);
  // By lines a row's environment is 1 less its pairs, the ones with blockers included.
  const Ids& ids = setup.faceIds();
  const bool ends_on_blockers = resumed ? haveBlockers(resumed->sums.lines->pairs(), ids)
                                        : ids.counts_environment && mayEndOnBlockers(setup.scene(), ids);
  const auto make = [&](LeakingFaces leaking, bool with_blockers) {
    pair_lines.emplace(
        setup.scene(), ids, std::move(leaking), setup.request().seed, setup.request().threads,
        [this] { stopIfRequested(); }, setup.lineDevice(), setup.crew(), with_blockers);
  };
  // Few rays say about how many faces leak, until all pairs are sure to have lines.
  const uint32_t leak_rays = with_leak && !resumed ? leakRays() : 0;
  make(resumed         ? resumed->sums.lines->leakingFaces()
       : leak_rays > 0 ? LeakingFaces{surveyed_leaks}
       : with_leak     ? LeakingFaces{std::vector<bool>(ids.count(), true)}
       : rays_alone    ? LeakingFaces()
                       : exposedFaces(),
       ends_on_blockers);
  const bool insists = setup.request().pair_lines.value_or(false) || resumed;
  if (pair_lines->hasUnordered() && insists)
    throw Error(
        ErrorCode::bad_usage,
        "polygons coincide, and nothing says which of them lies in front, as pair lines need to know; name them by "
        "--sheets or --solids, or leave out --pair-lines");
  if (pair_lines->hasUnordered()) return "coincident polygons have no order";
  if (rays_alone) {
    countAlongRays(raysAlone(*rays_alone));
    return "";
  }
  const std::string why = takeMixture();
  // Rays or common directions that count small pairs count what leaves the scene or leaks, too.
  const bool ends_beside_rows = ends_on_blockers || !pair_lines->leakingFaces().of_face.empty();
  if (line_mixture.least_form_factor > 0 && ends_beside_rows) make({}, false);
  else if (why.empty() && leak_rays > 0) make(findLeakingFaces(leak_rays), ends_on_blockers);
  if (!why.empty() && insists) throw Error(ErrorCode::limit, fmt::format("{}; leave out --pair-lines", why));
  return why;
}

// Finds the pairs that get lines.    Out: false where there are too many of them
bool FormFactorRun::State::findLinePairs() {
  const auto begun = Clock::now();
  line_pairs = line_mixture.countsAll() ? std::vector<LinePair>() : pair_lines->find(line_mixture.least_form_factor);
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

// Plans the lines of each pair, and a few rays or common directions: a promise where possible, else an estimate.
void FormFactorRun::State::planPairLines() {
  if (const std::string why = makePairLines(); !why.empty()) return planWithoutPairLines(why);
  if (!findLinePairs()) return planWithoutPairLines("too many pairs of polygons see each other");
  if (!resumed && isAllExact()) line_mixture.directions = plan->directions = 0;
  if (setup.isLarge() && setup.plansWhichPairs() && no_promise.empty())
    no_promise = fmt::format("there are more than {} polygons", kMostPairLineFaces);
  if (resumed || !no_promise.empty() || !planPromise()) planEstimateLines();
}

// Plans the lines of each pair for an estimate.    In: line_pairs: from findLinePairs()
void FormFactorRun::State::planEstimateLines() {
  if (!resumed && !(line_mixture.least_form_factor > 0)) makeOutsideEngine();
  EstimateOptions options = setup.estimate();
  if (resumed) {
    requireSamePairs(line_pairs, resumed->sums.lines->pairs());
    line_pairs = resumed->sums.lines->pairs();
    pair_lines->cut(line_pairs);
  } else {
    // Half of the time that is left is kept for further lines, where errors are still too large.
    const double threads = setup.request().threads ? setup.request().threads : double(threadCount()),
                 left = options.seconds
                            ? std::max(*options.seconds - secondsSince(*start), kLeastLeft * *options.seconds)
                            : INFINITY,
                 most_lines = left / 2 * threads / kSecondsOfLine;
    if (options.is_timed) options.tolerance = std::max(*options.tolerance, toleranceOfLines(line_pairs, most_lines));
    // Where all pairs have lines, a row's environment is what they leave of it. Beside rays, row sums would differ from
    // 1 by as much as all lines of a row err together.
    const bool with_rows = may_leave && (line_mixture.hasRays() || !(line_mixture.least_form_factor > 0));
    if (options.rms && line_mixture.hasRays() && line_mixture.least_form_factor > 0) {
      planRaysForRms();
      *options.rms *= std::sqrt(kLinesOfSquares);
    }
    if (options.rms) *options.rms *= kPlannedRms;
    line_pairs =
        planLines(*pair_lines, std::move(line_pairs), setup.faceIds(), setup.ids(), options, with_rows, most_lines);
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
  if (plan_between_surfaces) plan = std::move(plan_between_surfaces);
  else plan = makePlanOfRequest();
}

void FormFactorRun::State::planEstimateOfDirections() {
  no_pair_lines = resumed ? "the checkpoint has none" : setup.noPairLines();
  if (no_promise.empty()) refusePromise(no_pair_lines);
  plan = makePlanOfRequest();
}

void FormFactorRun::State::planGuarantee() {
  if (setup.usesPairLines()) {
    if (planLineGuarantee()) return;
    line_guarantee.reset(), pair_lines.reset(), plan.reset(), common_counts.reset();
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
  if (isAllExact()) plan->directions = 0, common_counts.reset();
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
      LineGuaranteeOptions{goal.epsilon, goal.delta, goal.rows, setup.request().by, setup.leastFormFactor(),
                           double(kFewReplicates) * line_mixture.directions});
}

void FormFactorRun::State::makePlan() {
  start = Clock::now();
  enter(Progress::Phase::planning);
  if (const std::string option = optionAgainstPromise(setup.request()); !option.empty())
    no_promise = fmt::format("{} asks for an estimate", option);
  if (setup.guarantee()) planGuarantee();
  else if (setup.usesPairLines()) planPairLines();
  else planEstimateOfDirections();
  ray_engine.reset();  // where only its pilot was cast
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
  if (setup.estimate().hasErrorGoal()) summary.no_pair_lines = no_pair_lines;
}

}  // namespace viewpeel
