// computeFormFactors() turns a Request into a Result in one call; FormFactorRun does the same step by step.
#pragma once
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/request.h>
#include <viewpeel/result.h>

namespace viewpeel {

struct RunSums;

// Settings are name and value, as text, of everything that affects the counts of a run. Two runs with the same settings
// have the same counts in the same replicate.
using Settings = std::vector<std::pair<std::string, std::string>>;

// Progress says how far a run has come.
struct Progress {
  // The run makes its plan, computes unoccluded form factors and a pilot of them, or counts.
  enum class Phase { planning, unoccluded, counting };
  Phase phase = Phase::planning;
  uint64_t replicates = 0;                   // complete replicates; for a guarantee complete blocks
  uint64_t resumed = 0;                      // the first of them, which an earlier run counted
  double largest_standard_error = INFINITY;  // over all form factors; infinite before it is measured
  // `directions` are counted in the current replicate, which has directions_of_replicate in all. The second number is 0
  // during a pilot.
  uint64_t directions = 0, directions_of_replicate = 0;
  uint64_t expected_blocks = 0, most_blocks = 0;  // of a guarantee
};

// An Observer watches a run. Each function may be empty.
struct Observer {
  // The run calls this often, from any thread. If it returns true the run ends, and the current replicate is dropped.
  std::function<bool()> should_stop;
  std::function<void(const Progress&)> on_progress;
  // Once there is a plan, the run's own thread calls this before (true) and after (false) each call of the engine.
  // Between the two calls the run's results do not change, so another thread may read them. The function must not
  // throw.
  std::function<void(bool begins)> on_count;
};

// A FormFactorRun computes form factors step by step. The scene must outlive it.
//   FormFactorRun run(scene, request);
//   while (!run.isDone()) run.step();
//   Result result = run.result();
class FormFactorRun {
 public:
  // Chooses engine and sampling, and opens the device.
  //   Throws: Error bad_usage where the request contradicts itself or does not suit the scene; Error device.
  explicit FormFactorRun(const Scene& scene, Request request = {}, Observer observer = {});
  ~FormFactorRun();
  FormFactorRun(FormFactorRun&&) noexcept;
  FormFactorRun& operator=(FormFactorRun&&) noexcept;

  // Returns the request, with every open choice settled.
  const Request& request() const;
  // Returns the plan. Before makePlan() only its engine, sampling and sampler are set.
  const PlanSummary& plan() const;
  // Returns the device that the engine uses; nullptr where the engine uses none.
  const DeviceDescription* device() const;

  // Returns the settings that a checkpoint keeps. Before makePlan() the settings that the plan chooses are missing.
  //   Throws: Error bad_usage for a median, which checkpoints cannot keep.
  Settings settings() const;
  // Continues an earlier run of the same scene and request: with its plan, and after its replicates. Call it before
  // makePlan().
  //   In: checkpoint: a file that writeCheckpoint() or `viewpeel merge` has written
  //   Out: the replicates in the file, as text: "0 to 7"
  //   Throws: Error bad_input where the file is no checkpoint, or is damaged; Error bad_usage where it is of another
  //     run.
  std::string resumeFrom(const std::filesystem::path& checkpoint);
  // Writes the sums to a file. Call it after the first step.
  //   Throws: Error output; the file then stays as it was.
  //   Cost: about 40 bytes of disk a nonzero pair (formats.md).
  void writeCheckpoint(const std::filesystem::path& file) const;

  // Plans lattices, directions and blocks. Later calls return the same plan.
  //   Throws: Error bad_usage where the goal is out of reach; Error device, Error limit.
  //   Cost: pilots of about a tenth of the run.
  const PlanSummary& makePlan();
  // Finds visibilities and unoccluded form factors before the first replicate. It calls makePlan() first.
  //   Out: their summary; nullptr where the run uses none
  const PriorSummary* findPrior();
  // Returns the predicted time of all replicates of the request, s. It calls makePlan() first, and times a few
  // directions.
  double measureSeconds();

  // Returns a few lines about how the engine divides its work and how much memory it takes. Call it after makePlan().
  std::string division() const;
  // Returns true where the goal is reached, or the run was stopped.
  bool isDone() const;
  // Counts one replicate, or some blocks of a guarantee. The first call plans and finds the prior.    Throws: as
  // makePlan().
  void step();
  // Returns true where the observer stopped the run.
  bool isInterrupted() const;
  // Returns the number of complete replicates or blocks, with the replicates of a resumed checkpoint.
  uint64_t replicateCount() const;
  // Returns all counts, for the library's own use. Call it after the first step.
  const RunSums& sums() const;

  // Returns the result of the replicates so far, without the engine's work. Call it after the first step. Another
  // thread may call it while Observer::on_count allows it.
  Result resultSoFar() const;
  // Returns the result with the engine's work, and with the guarantee where the run reached it. Where the run was
  // stopped before its first step, the result has no form factors.
  //   Throws: Error device where the validation layer reported a fault.
  Result result();
  // Throws Error device where the validation layer has reported a fault in the use of the device.
  void checkDevice() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Returns what a file of results says about a run beside its form factors: its settings, and how much it counted.
//   In: settings: of a run or a checkpoint, with names as options ("--seed"); estimate: of the same run
//   Out: OutputContent::parameters, with names without dashes. An option that was given several times has all its
//     values.
//   Error, Throws: none.    Cost: O(settings).
std::vector<std::pair<std::string, std::string>> parametersOf(const Settings& settings, const Estimate& estimate);
// Returns the same for a run that has begun. A guarantee by medians, which no checkpoint can keep, has fewer settings.
std::vector<std::pair<std::string, std::string>> parametersOf(const FormFactorRun& run, const Estimate& estimate);

// Computes F_ij = (2 / A_i) E[A'_ij(u)] of all pairs of the request (Pellegrini 1997, sections 4.3 and 5.1), as
// `viewpeel compute` does. E is the mean over directions u, and A'_ij(u) the area of the lines along u on which i and j
// are a facing pair.
//   It plans the run first. Where it takes less time, form factors are products of unoccluded form factors and
//     visibilities, and pairs get lines or directions of their own.
//   In: scene: from loadScene() or buildScene()    Out: see Result
//   Error: as the goal demands. The estimate is unbiased at any spacing and number of directions, except for the small
//     bias of visibilities (docs/method.md, section 6). Tests: tests/unit/front_door_test.cpp; tests/consumer compares
//     the result with the program's files.
//   Throws: as FormFactorRun.
//   Cost: replicates x directions projections of the scene; memory O(nonzero pairs) beside the engine's.
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, Discrete &
//     Computational Geometry 17, 1997.
Result computeFormFactors(const Scene& scene, const Request& request = {}, const Observer& observer = {});

}  // namespace viewpeel
