// computeFormFactors goes the whole way from a Request to a Result in one call; FormFactorRun goes it step by step.
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

// Settings decide about the counts of a run, by name, in words. Two runs with the same settings count the same in the
// same replicate.
using Settings = std::vector<std::pair<std::string, std::string>>;

// Progress says how far a run is.
struct Progress {
  uint64_t replicates = 0;                   // complete ones; blocks of a guarantee
  double largest_standard_error = INFINITY;  // over all form factors; infinite before it is measured
  // The counts are of directions of the replicate in progress that are done, and of all its directions. The latter is 0
  // for a pilot.
  uint64_t directions = 0, directions_of_replicate = 0;
  uint64_t expected_blocks = 0, most_blocks = 0;  // of a guarantee
};

// An Observer watches a run. Each function may be empty.
struct Observer {
  // The run calls it often, from any thread. If it returns true the run ends, and the replicate in progress is dropped.
  std::function<bool()> should_stop;
  std::function<void(const Progress&)> on_progress;
  // The run's own thread calls it before (true) and after (false) each call of the engine, once there is a plan. In
  // between the run's results stay as they are: another thread may look at them. It must not throw.
  std::function<void(bool begins)> on_count;
};

// A FormFactorRun is a run in steps. It refers to the scene, which has to outlive it.
//   FormFactorRun run(scene, request);
//   while (!run.isDone()) run.step();
//   Result result = run.result();
class FormFactorRun {
 public:
  // Chooses engine and sampling, and opens the device.
  //   Throws: Error bad_usage where the request contradicts itself or the scene; Error device.
  explicit FormFactorRun(const Scene& scene, Request request = {}, Observer observer = {});
  ~FormFactorRun();
  FormFactorRun(FormFactorRun&&) noexcept;
  FormFactorRun& operator=(FormFactorRun&&) noexcept;

  // Returns the request, with every open choice settled.
  const Request& request() const;
  // Returns the plan. Before makePlan() it has engine, sampling and sampler alone.
  const PlanSummary& plan() const;
  // Returns the device of an engine that needs one; else nullptr.
  const DeviceDescription* device() const;

  // Returns the settings that a checkpoint keeps: some before the plan, all of them afterwards.
  //   Throws: Error bad_usage for runs that checkpoints cannot keep: medians.
  Settings settings() const;
  // Goes on with the plan of an earlier run of the same scene and request, and after its replicates. Call it before
  // makePlan().
  //   In: a file of writeCheckpoint of the earlier run, or of `viewpeel merge`    Out: the replicates in it, in words:
  //     "0 to 7"
  //   Throws: Error bad_input where the file is no checkpoint, or damaged; Error bad_usage where it is of another run.
  std::string resumeFrom(const std::filesystem::path& checkpoint);
  // Writes the sums to a file. Call it after the first step.
  //   Throws: Error output; the file is then as it was before.
  //   Cost: about 40 bytes of disk a nonzero pair (formats.md).
  void writeCheckpoint(const std::filesystem::path& file) const;

  // Plans lattices, directions and blocks, once; later calls return the same plan.
  //   Throws: Error bad_usage where the goal is out of reach; Error device, Error limit.
  //   Cost: pilots of about a tenth of the run.
  const PlanSummary& makePlan();
  // Finds visibilities and unoccluded form factors before the first replicate; nullptr where the run has no prior.
  // Plans first.
  const PriorSummary* findPrior();
  // Returns the time of all replicates of the request, in seconds, from a few directions. Plans first.
  double measureSeconds();

  // Returns a few lines about how the engine divides its work and how much memory it takes. Call it after makePlan().
  std::string division() const;
  // Returns true where the goal is reached, or the run was stopped.
  bool isDone() const;
  // Counts one replicate, or some blocks of a guarantee. Plans and finds the prior first.    Throws: as makePlan().
  void step();
  // Returns true where the observer stopped the run.
  bool isInterrupted() const;
  // Returns the number of complete replicates or blocks, those resumed included.
  uint64_t replicateCount() const;
  // Returns all counts, for the library's own use. Call it after the first step.
  const RunSums& sums() const;

  // Returns the result of the replicates up to now, without the work. Call it after the first step; from any thread
  // where Observer::on_count allows it.
  Result resultSoFar() const;
  // Returns the result with the engine's work, and with the guarantee where the run reached it. There are no form
  // factors before the first step, as after an early stop.
  //   Throws: Error device where the validation layer found fault: there is never a result beside it.
  Result result();
  // Refuses a device with whose use the validation layer found fault.    Throws: Error device.
  void checkDevice() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Returns what a file of results says of a run beside its form factors: settings, and the amount that was counted.
//   In: settings: of a run or checkpoint, names with dashes; estimate: of the same run
//   Out: OutputContent::parameters: names without dashes; an option that was given several times has all its values
//   Error, Throws: none.    Cost: O(settings).
std::vector<std::pair<std::string, std::string>> parametersOf(const Settings& settings, const Estimate& estimate);
// The same of a run that began; one that no checkpoint can keep has fewer settings.
std::vector<std::pair<std::string, std::string>> parametersOf(const FormFactorRun& run, const Estimate& estimate);

// Computes F_ij = (2 / A_i) E[A'_ij(u)] of all pairs of the request (Pellegrini 1997, sections 4.3 and 5.1), as
// `viewpeel compute` does.
//   It plans, and uses unoccluded form factors times visibilities where this pays. Pairs that common directions hardly
//     hit get directions of their own.
//   In: scene as from loadScene or buildScene    Out: see Result
//   Error: as the goal demands; unbiased at any spacing and number of directions, but for the small bias of
//     visibilities (docs/method.md, section 6). Tests: tests/unit/front_door_test.cpp; tests/consumer compares it with
//     the program's files.
//   Throws: as FormFactorRun.
//   Cost: replicates x directions projections of the scene; memory O(nonzero pairs) beside the engine's.
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, Discrete &
//     Computational Geometry 17, 1997.
Result computeFormFactors(const Scene& scene, const Request& request = {}, const Observer& observer = {});

}  // namespace viewpeel
