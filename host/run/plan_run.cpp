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
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr double kSecondsOfLine = 4e-8;  // of one thread, where a line is tested against some 10 blockers
constexpr double kLeastLeft = 0.1;       // lines get this share of a time limit, even if all of it has been spent
// Lines that graze edges may end on backs by rounding where nothing leaks. They are at most this share of a row's
// lines: in cities of 1,000 to 6,600 triangles 4e-5 were measured.
constexpr double kGrazedShare = 1e-3;
// A survey casts so many rays of each polygon at a tolerance of 1, and more at finer ones.
constexpr double kSurveyedAtOne = 0.25, kLeastSurvey = 64, kMostSurvey = 1024;
// So many rays of each face decide from which faces lines may end on backs, at a tolerance of 1. A face that leaks the
// tolerance is then missed with a probability of exp(-6), and one ray's share is below an error that the goal allows.
constexpr double kLeakRaysAtOne = 6;
// Where a ray of the survey ended on a back, further rays of its row decide whether the row leaks more than the
// tolerance. They are as many as above, within these bounds.
constexpr double kLeastOfLeak = 1024, kMostOfLeak = 1 << 16;
// Lines for all pairs with backs cost less than more rays than this, and less than rays where the faces are fewer than
// this share of the rays of a face.
constexpr double kMostLeakRays = 8192, kFacesOfLeakRay = 0.125;
// Lines are planned by standard errors of single pairs, which are larger than errors in sums.
constexpr double kPlannedRms = 1.4;
constexpr uint32_t kMostSurveyed = 200'000;  // faces: rays of more take long, and much memory

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

// Returns whether rays may survey what leaves the scene and what leaks.
bool FormFactorRun::State::maySurvey() const {
  const Ids& ids = setup.faceIds();
  return ids.counts_environment && ids.count() <= kMostSurveyed && suitsRays(setup.scene());
}

// Finds out from a few rays or directions whether anything leaves the scene, and the largest share of a row that leaks.
// Rays see small polygons as well as large ones.
void FormFactorRun::State::surveyOutside() {
  if (resumed) return;
  const bool may_survey = maySurvey();
  if (!may_survey || setup.guarantee()) {
    makeLineEngine();
    const PairCounts counts = countDirections(kPilotDirections);
    if (!may_survey) leaked_share = measureLeaks(counts);
    may_leave = shareOutside(counts) > kGrazedOfScene;
  }
  if (setup.guarantee() && !(setup.leastFormFactor() > 0)) {
    countOutside();
    surveyLeaks(*setup.guarantee());
    return;
  }
  if (!may_survey) return;
  const double tolerance = setup.estimate().tolerance.value_or(1),
               at_least = setup.isLarge() ? 0 : kSurveyedAtOne / tolerance;
  const OutsideShares shares = castSurvey(std::clamp(at_least, kLeastSurvey, kMostSurvey), kLeakRaysAtOne / tolerance);
  surveyed_leaks = shares.has_leak;
  refusePromiseOfLeak(shares.largest_leak);
}

// Surveys all rows by rays.
//   In: least_rays, further_rays: of each polygon, rounded up to what surveyOutside() takes
//   Out: what they see; sets may_leave where anything leaves the scene or leaks, and leaked_share where more leaks
OutsideShares FormFactorRun::State::castSurvey(double least_rays, double further_rays) {
  OutsideShares shares = viewpeel::surveyOutside(
      rayEngine(), setup.scene(), setup.faceIds(), RayEngine::usualRays(least_rays),
      RayEngine::usualRays(std::clamp(further_rays, kLeastOfLeak, kMostOfLeak)), setup.request().seed);
  leaked_share = std::max(leaked_share, shares.largest_leak);
  may_leave |= shares.has_outside || shares.largest_environment > 0 || shares.largest_leak > 0;
  return shares;
}

// Surveys what leaks for a guarantee. It takes more rays where the guarantee covers each row's environment, for the
// environment's interval includes leaks that were missed.
//   Out: as castSurvey()
void FormFactorRun::State::surveyLeaks(const EpsilonDelta& goal) {
  if (!maySurvey()) return;
  const double of_each = goal.rows ? std::min(kLeakRaysAtOne / goal.epsilon, kMostOfLeak)
                                   : std::min(kSurveyedAtOne / goal.epsilon, kMostSurvey);
  castSurvey(std::max(of_each, kLeastSurvey), kLeakRaysAtOne / (kGrazedPart * goal.epsilon));
}

// Returns the number of rays of each face that decide whether the face gets lines to backs; 0: every face gets some.
// Only an estimate at a tolerance has such rays. They save time: there are as many pairs with backs as other pairs, and
// nearly all of them are hidden.
uint32_t FormFactorRun::State::leakRays() const {
  if (mayPromise() || setup.guarantee() || setup.estimate().is_timed || !setup.estimate().tolerance || !maySurvey())
    return 0;
  const double least_rays = kLeakRaysAtOne / *setup.estimate().tolerance;
  if (least_rays > kMostLeakRays || setup.faceIds().count() < kFacesOfLeakRay * least_rays) return 0;
  return RayEngine::usualRays(least_rays);
}

// Returns the faces whose pairs with backs get lines.    In: leak_rays: from leakRays(), above 0
LeakingFaces FormFactorRun::State::findLeakingFaces(uint32_t leak_rays) {
  const Ids& ids = setup.faceIds();
  std::vector<bool> leaking = findLeakingRows(rayEngine(), setup.scene(), ids, leak_rays, setup.request().seed);
  if (setup.request().by == By::surface) {
    // What a surface leaks is a sum over its faces, so either all of them have lines to backs, or none has.
    const std::vector<bool> of_surface = leakingSurfaces(leaking, ids.surface, setup.ids().count());
    for (uint32_t id = 0; id < ids.count(); ++id) leaking[id] = of_surface[ids.surface[id]];
  }
  return {std::move(leaking), leak_rays};
}

// Makes pair_lines and finds blockers, and decides what counts.    Out: why pair lines are not possible, else empty
std::string FormFactorRun::State::makePairLines() {
  plan.emplace();
  line_mixture = {setup.leastFormFactor(), commonDirections(), 0};
  surveyOutside();
  // Pairs with backs get lines only where a row leaks a share that matters at the goal.
  const double least_share = setup.guarantee() ? kGrazedPart * setup.guarantee()->epsilon
                                               : std::min(kGrazedShare, setup.estimate().tolerance.value_or(1));
  const bool with_leak = leaked_share > least_share && !(setup.leastFormFactor() > 0);
  const auto make = [&](LeakingFaces leaking) {
    pair_lines.emplace(
        setup.scene(), setup.faceIds(), std::move(leaking), setup.request().seed, setup.request().threads,
        [this] { stopIfRequested(); }, setup.lineDevice(), setup.crew());
  };
  // Few rays say about how many faces leak, until all pairs are sure to have lines.
  const uint32_t leak_rays = with_leak && !resumed ? leakRays() : 0;
  make(resumed         ? resumed->sums.lines->leakingFaces()
       : leak_rays > 0 ? LeakingFaces{surveyed_leaks}
       : with_leak     ? LeakingFaces{std::vector<bool>(setup.faceIds().count(), true)}
                       : LeakingFaces());
  const bool insists = setup.request().pair_lines.value_or(false) || resumed;
  if (pair_lines->hasUnordered() && insists)
    throw Error(
        ErrorCode::bad_usage,
        "polygons coincide, and nothing says which of them lies in front, as pair lines need to know; name them by "
        "--sheets or --solids, or leave out --pair-lines");
  if (pair_lines->hasUnordered()) return "coincident polygons have no order";
  // By lines a row's environment is 1 less its pairs, of which the ones with blockers would be missing.
  const Ids& ids = setup.faceIds();
  const std::string why = may_leave && ids.counts_environment && mayEndOnBlockers(setup.scene(), ids)
                              ? "rows see a --blocker, and lines do not tell it from what leaves the scene"
                              : takeMixture();
  // Rays or common directions that count small pairs count what leaks, too.
  if (line_mixture.least_form_factor > 0 && !pair_lines->leakingFaces().of_face.empty()) make({});
  else if (why.empty() && leak_rays > 0) make(findLeakingFaces(leak_rays));
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
    if (options.rms && rms_planner) {
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
