// A Setup is a run before its plan: engine, sampling, ids and goals, all settled from the request and the scene.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include <viewpeel/compute.h>

#include "estimator/directed_pairs.h"
#include "estimator/guarantee.h"
#include "estimator/line_mixture.h"
#include "estimator/plan.h"
#include "ranks/crew.h"

namespace viewpeel {

// Name of the setting of a run of common directions whose tolerance is about the largest error.
constexpr const char* kAimsAtLargestError = "aims_at_largest_error";

class Setup {
 public:
  // Settles the request and opens the device.
  //   In: scene: kept by reference; on_batch: called by engines; stop: called between other work; both may throw
  //   Throws: Error bad_usage for a request that does not suit this scene; Error device.
  Setup(const Scene& scene, Request request, std::function<void(uint64_t directions)> on_batch,
        std::function<void()> stop);
  Setup(const Setup&) = delete;
  Setup& operator=(const Setup&) = delete;

  const Scene& scene() const { return scene_; }
  const Request& request() const { return request_; }
  const Ids& ids() const { return ids_; }
  const Ids& faceIds() const { return face_ids_; }
  // Returns the ids that engines count: faces where unoccluded form factors or pair lines are used, else rows.
  const Ids& countedIds() const { return unoccluded_ || pair_lines_ ? face_ids_ : ids_; }
  EngineKind engine() const { return engine_; }
  bool isExact() const { return engine_ == EngineKind::exact; }
  Sampling sampling() const { return lattice_.sampling; }
  // Returns a description of the sampler.
  const std::string& sampler() const { return sampler_; }
  std::string deviceName() const;
  const Device* device() const { return device_ ? &*device_ : nullptr; }
  // Returns the device that draws pair lines; nullptr where threads draw them, with the same bits.
  const Device* lineDevice() const;
  const std::function<void()>& stop() const { return stop_; }
  // Returns the ranks that share the counting; nullptr where this one is alone.
  Crew* crew() const { return crew_.get(); }

  const EpsilonDelta* guarantee() const { return std::get_if<EpsilonDelta>(&request_.goal); }
  // Returns goals, replicates and sampler, and the number of directions where no plan chooses it.
  const EstimateOptions& estimate() const { return estimate_; }
  GuaranteeOptions guaranteeOptions() const;
  // Returns whether the plan chooses directions, and also the resolution where resolution() is 0.
  bool plans() const { return plans_; }
  int finest() const { return finest_; }
  // Returns the resolution; 0 where the plan chooses it.
  int resolution() const { return resolution_; }
  bool usesUnoccluded() const { return unoccluded_ && !pair_lines_; }
  bool usesPairLines() const { return pair_lines_; }
  // Returns why pair lines are not used by default; empty where they are.
  const std::string& noPairLines() const { return no_pair_lines_; }
  // Returns the unoccluded form factor below which pairs get no lines in a guarantee; 0: all pairs get lines. Large
  // scenes have too many pairs below it, and a guarantee does not need their lines.
  double leastFormFactor() const;
  // Makes the tolerance a promise, that is, a guarantee.    In: rows: whether it also covers each row's environment
  void promise(bool rows);
  // Returns whether the request's goal is a tolerance, and is promised.
  bool hasPromise() const { return guarantee() && std::holds_alternative<Tolerance>(estimated_goal_); }
  // Makes the tolerance the goal of an estimate again.
  void takeBackPromise();
  // Continues without pair lines: coincident polygons have no order, or there are too many pairs.
  void leaveOutPairLines();
  // Sets the tolerance of a run whose goal is a time (EstimateOptions::is_timed).
  void setTimedTolerance(double tolerance) { estimate_.tolerance = tolerance; }
  // Returns whether the request left open whether to use unoccluded form factors, so that the run may do without.
  bool unoccludedByDefault() const { return unoccluded_by_default_; }
  void leaveOutUnoccluded() { unoccluded_ = false; }
  // Takes over the plan of an earlier run from its settings.
  void adoptPlan(const Settings& stored);

  // Returns whether there are so many polygons that lines for all pairs may take minutes.
  bool isLarge() const;
  // Returns whether the plan decides which pairs have lines: all pairs, the pairs that are not small against the goal
  // (line_mixture.h), or, in a large scene, none. In a small scene only an estimate leaves out lines.
  bool plansWhichPairs() const;
  LineMixture mixture() const;
  // Returns whether common directions alone may count the form factors between surfaces of an estimate.
  bool mayCountSurfaces() const;
  // Lets them do so. The tolerance is still about the largest error.
  void countSurfaces();
  bool countsSurfaces() const { return counts_surfaces_; }
  // Returns whether small polygons may have lattices of their own.
  bool mayHaveWindows() const;
  Lattices lattices() const;
  // Returns the sampler of directed pairs, which have directions of their own.
  PairSampler pairSampler() const;

 private:
  void settleUnoccluded();
  void settlePairLines();
  std::string reasonAgainstPairLines() const;
  void settleTimed(bool has_pair_lines);
  void chooseEngine();
  void requireWhatEnginesHave() const;
  void settleDirections();

  const Scene& scene_;
  Request request_;
  Goal estimated_goal_;  // the request's goal, whether promised or not
  std::function<void()> stop_;
  Ids ids_, face_ids_;
  EngineKind engine_ = EngineKind::host;
  LatticeOptions lattice_;
  std::string sampler_, no_pair_lines_;
  EstimateOptions estimate_;
  bool plans_ = true, unoccluded_ = false, unoccluded_by_default_ = false, unoccluded_possible_ = false,
       pair_lines_ = false, counts_surfaces_ = false;
  int resolution_ = 0, finest_ = 0;
  std::optional<Device> device_;
  std::unique_ptr<Crew> crew_;
  EngineFactory make_engine_;
};

}  // namespace viewpeel
