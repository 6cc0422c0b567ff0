#pragma once

// A State is a run (include/viewpeel/compute.h). plan_run.cpp makes the plan, for which choose_mixture.cpp and
// choose_directions.cpp decide what counts which pairs; step_run.cpp counts and makes the result.
// It counts in exactly one of four ways: EstimateRun, GuaranteeRun, LineRun or LineGuarantee.

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>

#include "estimator/estimate_run.h"
#include "estimator/find_prior.h"
#include "estimator/guarantee_run.h"
#include "estimator/line_guarantee.h"
#include "estimator/line_run.h"
#include "estimator/plan_rays.h"
#include "estimator/plan_rays_for_rms.h"
#include "estimator/survey_outside.h"
#include "io/checkpoint.h"
#include "rays/ray_engine.h"
#include "run/setup.h"
#include "run/summaries.h"
#include "stopwatch.h"

namespace viewpeel {

constexpr uint64_t kFewReplicates = 8;     // replicates of common directions that a guarantee by lines counts
constexpr uint32_t kPilotDirections = 64;  // common directions from which a run with pair lines learns first

struct FormFactorRun::State {
  Observer observer;
  Progress progress;
  Setup setup;
  PlanSummary summary;
  std::optional<Checkpoint> resumed;
  std::filesystem::path resumed_file;
  std::optional<Clock::time_point> start;  // when planning began
  std::optional<Plan> plan, plan_between_surfaces;
  std::optional<GuaranteePlan> guarantee;
  PairSampler pairs;
  FaceExchanges exchanges;
  FoundPrior found_prior;
  std::optional<PriorSummary> prior_summary;
  std::optional<EstimateRun> estimate_run;
  std::optional<GuaranteeRun> guarantee_run;
  std::optional<PairLines> pair_lines;
  std::optional<PairSample> pair_sample;
  std::optional<double> pairs_of_direction;  // of faces, which one pilot direction counts on average
  LineMixture line_mixture{};                // pairs with lines, and what counts the others
  RayEngine* rays = nullptr;                 // the plan's engine, where it counts along rays
  std::unique_ptr<RayEngine> ray_engine;     // until the plan has it
  std::optional<RayPlanner> ray_planner;     // of ray_engine
  std::optional<RmsRayPlanner> rms_planner;  // of ray_engine, where the goal is the root mean square of all errors
  std::vector<LinePair> line_pairs;          // as found, then with their planned lines
  double finding_seconds = 0;                // that it took to find them
  std::optional<LineRun> line_run;
  std::optional<LineGuarantee> line_guarantee;
  std::optional<RunSums> common_sums;                    // of common directions of a guarantee by lines
  std::optional<std::vector<PairCounts>> common_counts;  // of the same directions, where the plan has counted them
  double leaked_share = 0;                               // largest share of a row's lines or rays that leak, of a few
  std::vector<bool> surveyed_leaks;                      // by face: whether one of its few rays leaks
  bool may_leave = false;          // whether more of them leave the scene or leak than may graze edges
  std::string no_promise;          // why the tolerance is not promised but estimated; else empty
  std::string no_pair_lines;       // why there are no pair lines; else empty
  bool is_promise_broken = false;  // whether a promise was planned and could not be kept
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
  void reportProgress() const {
    if (observer.on_progress) observer.on_progress(progress);
  }
  void enter(Progress::Phase phase) {
    progress.phase = phase;
    reportProgress();
  }
  void onBatch(uint64_t directions) {
    stopIfRequested();
    if (setup.guarantee()) return;  // a guarantee's progress is in blocks
    progress.directions = directions;
    reportProgress();
  }

  // Runs the work. Where the observer stops it, the run ends.
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

  std::string takeDirectionsAlone();
  PairNumbers pairNumbers();
  Plan makeFixedPlan() const;
  Plan makePlanOfRequest();
  void makePlan();
  PairCounts countDirections(uint32_t count);
  double pairsOfDirection();
  double measureLeaks(const PairCounts& counts) const;
  void surveyOutside();
  bool maySurvey() const;
  uint32_t leakRays() const;
  LeakingFaces findLeakingFaces(uint32_t leak_rays);
  LeakingFaces exposedFaces() const;
  std::string makePairLines();
  std::string takeMixture();
  bool mayHaveRays() const;
  bool mayPromise() const;
  double pilotRays() const;
  RayEngine& rayEngine();
  PlannedRays planRays();
  double numberOfRays(const std::vector<uint32_t>& of_faces) const;
  bool takeRays(const PairNumbers& numbers);
  std::optional<std::vector<uint32_t>> planRaysAloneForRms();
  bool mayHaveRaysForRms() const;
  RmsRayPlanner& rmsPlanner();
  bool takeRaysForRms();
  void planRaysForRms();
  std::string takeTimedTolerance();
  void countAlongRays(LineMixture mixture);
  void useRays(std::unique_ptr<RayEngine> engine);
  bool fitMixture(LineMixture mixture, LineWork& work);
  void makeLineEngine();
  void makeOutsideEngine();
  void planPairLines();
  void planEstimateLines();
  void planEstimateOfDirections();
  void planWithoutPairLines(const std::string& why);
  void requireNoPairLines() const;
  bool findLinePairs();
  bool isAllExact() const;
  void planGuarantee();
  bool planLineGuarantee();
  void makeLineGuarantee();
  bool planPromise();
  bool countOutside();
  OutsideShares castSurvey(double least_rays, double further_rays);
  void surveyLeaks(const EpsilonDelta& goal);
  void refusePromise(const std::string& why);
  void refusePromiseOfLeak(double leak);
  void takeBackPromise();
  void breakPromise(const std::string& why);
  void summariseRun();
  std::vector<PairCounts> countCommonDirections() const;
  double commonCountArea() const;
  uint32_t commonDirections() const;
  void beginLineGuarantee();
  void findPrior();
  EstimateOptions estimateOptions();
  double measureLineSeconds();
  double measureDirectionSeconds();
  void begin();
  template <class Run>
  void beginEstimate(const Run& run);
  void step();
  Estimate estimateOfNothing() const;
  Result resultOf(Estimate estimate) const;
  bool isGoalReached() const;
};

}  // namespace viewpeel
