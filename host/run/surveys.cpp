// This file surveys what leaves the scene and what leaks, by few rays or directions, before a run with pair lines is
// planned.

#include <algorithm>
#include <utility>

#include "estimator/line_mixture.h"
#include "estimator/survey_outside.h"
#include "run/rules.h"
#include "run/run_state.h"
#include "sums/line_form_factors.h"

namespace viewpeel {
namespace {

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
constexpr uint32_t kMostSurveyed = 200'000;  // faces: rays of more take long, and much memory

}  // namespace

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

}  // namespace viewpeel
