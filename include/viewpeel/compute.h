// Form factors of a scene: the whole way from a Request to a Result, in one call or step by step.
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

// What decides about the counts of a run, by name, in words: two runs with the same settings count the same in the same
// replicate.
using Settings = std::vector<std::pair<std::string, std::string>>;

// How far a run is.
struct Progress {
  uint64_t replicates = 0;                   // done; blocks of a guarantee
  double largest_standard_error = INFINITY;  // over all form factors so far; infinite before it is measured
  uint64_t directions = 0, directions_of_replicate =
                               0;  // counted of the replicate in progress, of so many; of a pilot where these are 0
  uint64_t expected_blocks = 0, most_blocks = 0;  // of a guarantee
};

// Whoever watches a run. Each may be empty.
struct Observer {
  // Asked often, from any thread: true ends the run, and the replicate in progress is dropped.
  std::function<bool()> should_stop;
  std::function<void(const Progress&)> on_progress;
  // Called before (true) and after (false) each call of the engine, from the run's thread, once there is a plan. In
  // between the run's results stay as they are: another thread may look at them. Must not throw.
  std::function<void(bool begins)> on_count;
};

// A run in steps. What it refers to, the scene, has to outlive it.
//   FormFactorRun run(scene, request);
//   while (!run.isDone()) run.step();
//   Result result = run.result();
class FormFactorRun {
 public:
  // Chooses engine and sampling, and opens the device.
  //   Throws: Error bad_usage for what the request cannot have; Error device.
  explicit FormFactorRun(const Scene& scene, Request request = {}, Observer observer = {});
  ~FormFactorRun();
  FormFactorRun(FormFactorRun&&) noexcept;
  FormFactorRun& operator=(FormFactorRun&&) noexcept;

  // The request with what was left open settled.
  const Request& request() const;
  // The engine, sampling and sampler that were chosen; the rest once there is a plan.
  const PlanSummary& plan() const;
  // Of an engine that needs a device; else nullptr.
  const DeviceDescription* device() const;

  // What a checkpoint is to be kept with: what is known before the plan, and all of it afterwards.
  //   Throws: Error bad_usage for runs that checkpoints cannot keep: medians.
  Settings settings() const;
  // Goes on with the plan of an earlier run of the same scene and request, and after its replicates. Before makePlan().
  //   In: a file that writeCheckpoint of that run, or `viewpeel merge`, has written    Out: the replicates in it, in
  //   words: "0 to 7"
  //   Throws: Error bad_input where the file is none, or damaged; Error bad_usage where it is of another run.
  std::string resumeFrom(const std::filesystem::path& checkpoint);
  // Not before the first step.    Throws: Error output; the file is then what it was.    Cost: about 40 bytes of disk a
  // nonzero pair (formats.md).
  void writeCheckpoint(const std::filesystem::path& file) const;

  // Plans, where that was not done: lattices, directions, blocks.
  //   Throws: Error bad_usage where a goal cannot be reached as asked; Error device, Error limit.    Cost: pilots of
  //   about a tenth of the run.
  const PlanSummary& makePlan();
  // Finds visibilities and unoccluded form factors before the first replicate; nullptr where the run has none of its
  // own. Plans first.
  const PriorSummary* findPrior();
  // How long the replicates asked for take, in seconds, from a few directions. Plans first.
  double measureSeconds();

  // How the engine divides its work and what memory that takes, a few lines. Not before makePlan().
  std::string division() const;
  // Whether the goal is reached, or the run was stopped.
  bool isDone() const;
  // Counts one replicate, or some blocks of a guarantee. Plans and finds shares first.    Throws: as makePlan().
  void step();
  // The observer asked for the end.
  bool isInterrupted() const;
  // How many replicates or blocks are done, those resumed included.
  uint64_t replicateCount() const;
  // What was counted, for the library's own use. Not before the first step.
  const RunSums& sums() const;

  // What the replicates so far come to, without the work. Not before the first step; from any thread where
  // Observer::on_count allows it.
  Result resultSoFar() const;
  // The same with what the engine says of its work; the guarantee where the run reached it. Before the first step, as
  // after an early stop: no form factors.
  //   Throws: Error device where the validation layer found fault: there is never a result beside that.
  Result result();
  //   Throws: Error device where the validation layer has found fault.
  void checkDevice() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Computes F_ij = (2 / A_i) E[A'_ij(u)] of all pairs asked for (Pellegrini 1997, sections 4.3 and 5.1), as `viewpeel
// compute` finds them: with a plan, unoccluded form factors times visibilities where that pays, and directions of their
// own for pairs that others hardly meet.
//   In: scene as from loadScene or buildScene    Out: see Result
//   Error: as asked for by the goal; unbiased at any spacing and number of directions, but for the small bias of shares
//   (docs/method.md).
//     Tests: tests/unit/front_door_test.cpp; tests/consumer compares it with the program's files.
//   Throws: as FormFactorRun.
//   Cost: replicates x directions projections of the scene; memory O(nonzero pairs) beside the engine's.
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, Discrete &
//   Computational Geometry 17, 1997.
Result computeFormFactors(const Scene& scene, const Request& request = {}, const Observer& observer = {});

}  // namespace viewpeel
