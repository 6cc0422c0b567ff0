// This file decides what counts in a run with pair lines: which pairs have lines of their own, and whether common
// directions or rays of each polygon's own count the others.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/plan_rays.h"
#include "run/rules.h"
#include "run/run_state.h"
#include "sums/line_form_factors.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr uint32_t kTriedDirections = 16;  // of each lattice

}  // namespace

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

// Makes the engine of the mixture's rays, or of its common directions. Where common directions count pairs, small
// polygons have windows of their own.
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

// Makes the engine that sees what leaves the scene or ends on backs, where all pairs have lines: rays if they suit the
// scene, else common directions. Rays cost less, and see small polygons as well as large ones.
void FormFactorRun::State::makeOutsideEngine() {
  if (!maySurvey()) {
    if (!plan->engine) makeLineEngine();
    return;
  }
  line_mixture.resolution = LatticeOptions{}.resolution;
  // A leak as large as the tolerance T takes 24 / T rays to a standard error of T / 4.9, the one that several thousand
  // rows are allowed. A run has at most 512 replicates of rays, so each has 1 / 512 of them.
  if (std::ranges::count(surveyed_leaks, true) > 0 && line_mixture.directions) {
    constexpr double kOfLeakAtOne = 24.0 / 512, kMost = 1024;
    line_mixture.directions = RayEngine::usualRays(
        std::clamp(kOfLeakAtOne / setup.estimate().tolerance.value_or(1), double(line_mixture.directions), kMost));
  }
  if (line_mixture.directions) line_mixture.rays.assign(setup.faceIds().count(), line_mixture.directions);
  rayEngine().setRays(line_mixture.rays);
  useRays(std::move(ray_engine));
}

// Decides whether all pairs have lines, or only the pairs that are not small against the goal. Then it also decides
// what counts the small pairs, and makes its engine.
//   Out: the reason if neither is possible, else empty
std::string FormFactorRun::State::takeMixture() {
  if (resumed) {
    const double least = resumed->sums.lines->leastFormFactor(), most = least * kMostOfCounted;
    constexpr double kRounding = 1e-9;
    if (setup.estimate().is_timed)
      setup.setTimedTolerance(least > 0 && least < kAllCounted ? std::min(most, kCoarsestTimed) : kFinestTimed);
    if (least > 0 && least < kAllCounted && !setup.estimate().rms &&
        setup.mixture().least_form_factor < (1 - kRounding) * least)
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("{}: pairs with form factors below {:.2g} have no lines there, so that errors may be {:.2g}; "
                      "ask for that --tolerance or a larger one, or take another file",
                      resumed_file.string(), least, most));
    const bool has_lattice = least > 0 || !resumed->sums.rays.empty();
    line_mixture = {least, setup.estimate().directions, has_lattice ? setup.resolution() : 0, resumed->sums.rays};
    makeLineEngine();
    return "";
  }
  if (setup.estimate().is_timed)
    if (std::string why = takeTimedTolerance(); !why.empty()) return why;
  if (setup.estimate().rms)
    return takeRaysForRms() || !setup.isLarge() || mayFindAll(pairNumbers())
               ? ""
               : "too many pairs of polygons see each other";
  if (std::string why = takeDirectionsAlone(); !why.empty()) return why;
  if (line_mixture.countsAll() || !setup.plansWhichPairs()) return "";
  const bool may_have_rays = mayHaveRays(), may_count = setup.isLarge() || !(may_leave || no_promise.empty());
  if (!may_have_rays && !may_count) return "";
  const uint32_t replicates = setup.estimate().replicates;
  const LineMixture mixture = setup.mixture();
  LineWork work{pairNumbers()};
  if ((may_have_rays && takeRays(work.pairs)) || !may_count) return "";
  const bool may_be_exact = !setup.isLarge() && work.pairs.blocked == 0;
  if (may_be_exact || areLinesQuick(work.pairs)) return "";
  work.pairs_of_direction = pairsOfDirection();
  if (paysLinesForAll(work, mixture, replicates)) return "";
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
  plan->engine.reset();
  return !setup.isLarge() || mayFindAll(work.pairs) ? "" : why;
}

// Chooses the tolerance of a run whose goal is a time: the finest one for which the costs of line_mixture.h take half
// of the time that is left. The other half is for what these costs do not contain, and for their error.
//   Out: the reason where pairs get no lines, else empty
std::string FormFactorRun::State::takeTimedTolerance() {
  const EstimateOptions& options = setup.estimate();
  const double threads = setup.request().threads ? setup.request().threads : double(threadCount()),
               most = 0.5 * threads * std::max(0.0, *options.seconds - secondsSince(*start));
  // Of sums over many polygons of an open scene common directions say more.
  const bool suits_all = (options.by == By::polygon || !may_leave) && mayFindAll(pairNumbers()) &&
                         secondsOfLines(pairNumbers(), may_leave) <= most;
  if (suits_all || !mayPayMixture(setup.faceIds().count()) || setup.request().pair_lines.value_or(false)) {
    setup.setTimedTolerance(kFinestTimed);
    return "";
  }
  const bool may_have_rays = mayHaveRays();
  if (options.by == By::surface || !setup.plansWhichPairs() || !setup.request().question.isEverything() ||
      (may_leave && !may_have_rays))
    return "lines for all pairs would take longer than --seconds";
  const auto fits = [&](double tolerance) {
    setup.setTimedTolerance(tolerance);
    return (may_have_rays ? secondsWithRays(pairNumbers(), numberOfRays(planRays().outside))
                          : secondsWithDirections({pairNumbers(), pairsOfDirection()}, setup.mixture(),
                                                  options.replicates)) <= most;
  };
  double tolerance = kCoarsestTimed;
  while (tolerance > kFinestTimed && fits(tolerance / 2)) tolerance /= 2;
  setup.setTimedTolerance(tolerance);
  return "";
}

// Returns how many pairs of faces one common direction counts on average, on the lattice of a run in which all pairs
// have lines.
double FormFactorRun::State::pairsOfDirection() {
  if (!pairs_of_direction) {
    if (!plan->engine) makeLineEngine();
    pairs_of_direction = double(countDirections(kTriedDirections).size()) / kTriedDirections;
  }
  return *pairs_of_direction;
}

// Returns estimates of how many pairs of polygons there are, whose lines may have to be found.
PairNumbers FormFactorRun::State::pairNumbers() {
  if (!pair_sample) pair_sample = pair_lines->samplePairs();
  const EstimateOptions& options = setup.estimate();
  return pair_sample->numbersFor(options.rms ? leastFormFactorBesideRays(options, setup.faceIds().count())
                                             : setup.mixture().least_form_factor);
}

// Returns whether each polygon may have rays of its own: where the scene and the request suit rays, and lines for the
// most pairs that there can be would take longer.
bool FormFactorRun::State::mayHaveRays() const {
  const Request& request = setup.request();
  const EstimateOptions& options = setup.estimate();
  const auto most = double(pairCount(setup.faceIds().count()));
  return may_leave && (options.tolerance || options.relative) && request.question.isEverything() &&
         !request.pair_lines.value_or(false) && suitsRays(setup.scene()) &&
         paysRays({.facing = most, .decided = most, .found = most, .blocked = most}, pilotRays(), mayPromise());
}

// Returns whether the tolerance may become a promise, where all pairs have lines.
bool FormFactorRun::State::mayPromise() const { return no_promise.empty() && !setup.isLarge(); }

// Returns the number of rays of a pilot, of all polygons.
double FormFactorRun::State::pilotRays() const {
  return double(setup.scene().polygons.size()) * kPilotRays * kRayPilotReplicates;
}

// Returns ray_engine, and makes it if there is none yet.
RayEngine& FormFactorRun::State::rayEngine() {
  if (!ray_engine) ray_engine = makeRayEngine(setup.scene(), setup.faceIds(), setup.lattices().lattice);
  return *ray_engine;
}

// Returns the numbers of rays that polygons need. Their pilot is cast once, with ray_engine.
PlannedRays FormFactorRun::State::planRays() {
  const EstimateOptions& options = setup.estimate();
  if (!ray_planner) {
    const Ids& face_ids = setup.faceIds();
    std::vector<uint32_t> rows = face_ids.surface;
    if (options.by == By::polygon) std::iota(rows.begin(), rows.end(), 0);
    ray_planner.emplace(rayEngine(), setup.scene(), face_ids, std::move(rows), options.seed, mayHaveRaysAlone(options));
  }
  return ray_planner->plan(options);
}

// Returns the number of rays of all polygons, in all replicates, where a ray counts as many times as costOfRay() says.
double FormFactorRun::State::numberOfRays(const std::vector<uint32_t>& of_faces) const {
  double all = 0;
  const Scene& scene = setup.scene();
  for (size_t k = 0; k < scene.polygons.size(); ++k)
    all += of_faces[setup.faceIds().of_polygon[k]] * costOfRay(scene, scene.polygons[k]);
  return all * setup.estimate().replicates;
}

// Decides whether rays see what leaves the scene, and count the small pairs or all of them.
//   Out: whether they do; then line_mixture and its engine are set
bool FormFactorRun::State::takeRays(const PairNumbers& numbers) {
  const bool may_be_alone = mayHaveRaysAlone(setup.estimate());
  PairNumbers none_large = numbers;  // as if rays counted all pairs
  if (may_be_alone) none_large.large = none_large.small_of_parts = 0;
  if (!paysRays(none_large, pilotRays(), mayPromise())) return false;
  const PlannedRays planned = planRays();
  const double beside = numberOfRays(planned.outside);
  const bool pays_mixture = paysRays(numbers, beside, mayPromise());
  if (may_be_alone) {
    const double alone = numberOfRays(planned.alone);
    if (paysRays(none_large, alone, mayPromise()) &&
        (!pays_mixture || paysRaysAlone(numbers, setup.faceIds().count(), alone, beside))) {
      countAlongRays(raysAlone(planned.alone));
      return true;
    }
  }
  if (pays_mixture) countAlongRays(rayMixtureFor(setup.estimate(), planned.outside));
  return pays_mixture;
}

// Returns how many rays each face has where rays alone count all pairs, and the goal is the root mean square of all
// errors; nothing where pairs get lines.
std::optional<std::vector<uint32_t>> FormFactorRun::State::planRaysAloneForRms() {
  const size_t face_count = setup.faceIds().count();
  if (resumed || !mayHaveRaysForRms()) return std::nullopt;
  std::vector<uint32_t> alone = rmsPlanner().plan({}, setup.estimate());
  if (!paysRaysAloneForRms(face_count, numberOfRays(alone))) return std::nullopt;
  return alone;
}

// Returns whether rays may count pairs where the goal is the root mean square of all errors.
bool FormFactorRun::State::mayHaveRaysForRms() const {
  return setup.estimate().rms && !setup.request().pair_lines.value_or(false) && suitsRays(setup.scene()) &&
         mayPayMixture(setup.faceIds().count());
}

// Returns rms_planner, whose pilot is cast once, with ray_engine.
RmsRayPlanner& FormFactorRun::State::rmsPlanner() {
  if (!rms_planner) rms_planner.emplace(rayEngine(), setup.scene(), setup.faceIds(), setup.request().seed);
  return *rms_planner;
}

// Decides whether rays count pairs, where the goal is the root mean square of all errors.
//   Out: whether they do; then line_mixture and its engine are set, but planRaysForRms() chooses the rays
bool FormFactorRun::State::takeRaysForRms() {
  if (!mayHaveRaysForRms()) return false;
  const size_t face_count = setup.faceIds().count();
  const EstimateOptions& options = setup.estimate();
  const PairNumbers numbers = pairNumbers();
  const double small = pair_sample->sumOfSmall(leastFormFactorBesideRays(options, face_count)),
               least_rays = double(RayEngine::kLeastRays) * options.replicates,
               polygons = numberOfRays(std::vector<uint32_t>(face_count, 1)) / options.replicates;  // by costOfRay()
  const auto pays = [&](double form_factors) {
    const double all_rays = raysForRms(form_factors, face_count, *options.rms) / (1 - kLinesOfSquares),
                 of_each = std::max(least_rays, all_rays / double(face_count));
    return paysRays(numbers, (kPilotRays + of_each) * polygons, false, may_leave) &&
           std::min(of_each * polygons, numbers.facing) <= enoughCounts(face_count);
  };
  if (!pays(small)) return false;
  if (!pays(small + rmsPlanner().environments())) return false;
  line_mixture = rayMixtureFor(options, std::vector<uint32_t>(face_count, kPilotRays));
  useRays(std::move(ray_engine));
  return true;
}

// Chooses how many rays each face has.    In: line_pairs: of the mixture
void FormFactorRun::State::planRaysForRms() {
  line_mixture.rays = rmsPlanner().plan(line_pairs, setup.estimate());
  line_mixture.directions = std::ranges::max(line_mixture.rays);
  rays->setRays(line_mixture.rays);
  plan->directions = line_mixture.directions;
}

// Plans to count along rays of planRays().
void FormFactorRun::State::countAlongRays(LineMixture mixture) {
  if (no_promise.empty())
    refusePromise("a promise needs lines of all pairs, which take more than twice the time of rays");
  line_mixture = std::move(mixture);
  ray_engine->setRays(line_mixture.rays);
  useRays(std::move(ray_engine));
}

// Plans to count along rays.    In: engine: with the rays of line_mixture, which may have none
void FormFactorRun::State::useRays(std::unique_ptr<RayEngine> engine) {
  plan->directions = line_mixture.directions;
  plan->groups = groupAsOne(setup.scene(), line_mixture.resolution);
  rays = line_mixture.hasRays() ? engine.get() : nullptr;
  plan->engine = std::move(engine);
}

// Takes the finest lattice at which the sums of counted pairs fit into memory.
//   Out: false where no lattice fits; sets line_mixture, its engine, and work.pairs_of_direction for this lattice
bool FormFactorRun::State::fitMixture(LineMixture mixture, LineWork& work) {
  constexpr int kLeastResolution = 64;
  const double enough = enoughCounts(setup.faceIds().count());
  for (;; mixture.resolution = std::max(mixture.resolution / 2, kLeastResolution)) {
    line_mixture = mixture;
    makeLineEngine();
    work.pairs_of_direction = double(countDirections(kTriedDirections).size()) / kTriedDirections;
    const double counted = countedPairs(work, mixture, setup.estimate().replicates);
    if (counted <= enough) return true;
    if (mixture.resolution <= kLeastResolution) return counted <= kMostCountedPairs;
  }
}

}  // namespace viewpeel
