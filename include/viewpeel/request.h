// A request says what to compute: the rows, one goal, and how to get there. Everything has a default. Request{} wants
// all form factors of all polygons to 1e-3.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <viewpeel/device.h>
#include <viewpeel/engine.h>
#include <viewpeel/ids.h>
#include <viewpeel/sampling.h>
#include <viewpeel/scene.h>

namespace viewpeel {

class Ranks;

// A run with a Tolerance ends once the standard error of every form factor is at most the tolerance. If a guarantee
// costs little more, the tolerance becomes a guarantee: see Request::promise.
struct Tolerance {
  double standard_error = 1e-3;  // above 0
  // A second goal may stand beside the first: every form factor of at least Request::relative_floor has a standard
  // error of at most this share of it.
  std::optional<double> relative;
};

// A run with a Relative goal ends once the standard error of every form factor of at least Request::relative_floor is
// at most this share of it.
struct Relative {
  double standard_error = 0.01;  // above 0
};

// A run with a RootMeanSquare goal ends once the root mean square of the errors of all n^2 form factors between n
// polygons is at most this. Form factors that are 0 count, too. Errors are errors in sums (FormFactors::Entry).
// Standard errors are larger: they leave a margin for what the few lines of a single form factor may have missed. The
// goal is for sums of many form factors, where the largest single error matters less. It needs By::polygon and the
// whole matrix.
struct RootMeanSquare {
  double standard_error = 1e-5;  // above 0
};

// A run with Seconds has the lines, rays or directions that fit into this time, and two replicates at least.
struct Seconds {
  double seconds = 60;  // above 0
};

// A guarantee bounds the error of one of two statistics of the counted directions.
enum class Statistic {
  mean,  // the mean of blocks of directions
  // The median of Q independent runs of M^2 / epsilon^2 directions each (Pellegrini 1997, section 5.3), where a
  // direction adds at most M to a form factor. By Chebyshev's inequality one run errs by more than epsilon with
  // probability 1/4 at most.
  median,
};

// EpsilonDelta is a guarantee: with probability 1 - delta every form factor between polygons (or surfaces) is within
// epsilon of the true one, and in its interval (FormFactors::interval). With common directions (Request::pair_lines)
// environment and leak are within epsilon, too.
struct EpsilonDelta {
  double epsilon = 1e-2;  // in (0, 1)
  double delta = 1e-2;    // in [0, 1); with 0 only what geometry alone proves is in the intervals
  Statistic statistic = Statistic::mean;
  bool rows = false;  // the guarantee also holds for each row's environment
  // Lattices are made so fine that one direction adds about this much to a form factor at most. It is above 2; with 0
  // the plan chooses it.
  double range = 0;
  uint32_t block_directions = 0;  // 0: the plan chooses it
};

// A FixedAmount is counted without a plan, and replaces any other goal.
struct FixedAmount {
  uint32_t directions = 400;  // of a replicate
  uint32_t replicates = 8;    // two at least
  int resolution = 0;         // lattice spacings across the scene's diameter; 0: 64
  // Windows give the polygon that needs the finest lattice a resolution of at least this. With 0 there are no windows.
  int finest = 0;
};

// A run has exactly one goal, which ends it.
using Goal = std::variant<Tolerance, Relative, RootMeanSquare, Seconds, EpsilonDelta, FixedAmount>;

// An Amount fixes some numbers, and a plan chooses the others. It is for goals other than FixedAmount.
struct Amount {
  uint32_t directions = 0;  // of a replicate; 0: the plan chooses
  uint32_t replicates = 8;  // least number
  int resolution = 0;       // 0: the plan chooses
  int finest = 0;           // as FixedAmount::finest; needs directions and resolution
  bool is_exact = false;    // counts exactly `replicates`, even short of the goal, for a part of a run
};

// Program and library give the same bits for the same request and plan.
struct Request {
  By by = By::polygon;
  Question question;  // empty: the whole matrix
  bool two_sided = false;

  Goal goal = Tolerance{};
  Amount amount;
  double relative_floor = 0.01;  // smallest form factor whose relative error counts, in (0, 1]
  // The run ends after this time even without its goal. A guarantee that takes longer is refused.
  std::optional<double> time_limit_s;

  std::optional<Sampling> sampling;  // unset: the quicker one
  // The sampler draws directions over the sphere. Unset: fibonacci, or jittered for a guarantee. A question about one
  // pair or a few rows has directions of its own.
  std::optional<Sampler> sampler;
  // Only the visibility of each pair is sampled, and multiplied by its unoccluded form factor. Unset: the run decides,
  // by the predicted time.
  std::optional<bool> unoccluded;
  // Lines are drawn between the two polygons of each pair that something may block, as many as the pair's error needs.
  // They replace common directions. The goal must be a Tolerance, Relative, RootMeanSquare, Seconds or EpsilonDelta.
  // Unset: the run decides, by the predicted time.
  std::optional<bool> pair_lines;
  // A Tolerance T is promised: it becomes the guarantee EpsilonDelta{T, 0.01} with rows, so every form factor is within
  // T with probability 0.99, and has an interval. Unset: where the run costs at most twice an estimate, or half
  // a second of CPU time, and no option needs an estimate (PlanSummary::no_promise). request() has the goal then.
  std::optional<bool> promise;
  // An estimate of up to 8,000 polygons has lines for all pairs, and does not leave small ones to common directions
  // (docs/method.md, mixtures). Small form factors matter where they are added up, as heat flows are, or where a
  // checkpoint is to go on to a smaller tolerance.
  bool lines_for_all = false;
  uint64_t seed = 1;             // the same seed and plan give the same bits
  uint64_t first_replicate = 0;  // of a part of a run, whose checkpoints can be merged

  EngineKind engine = EngineKind::automatic;
  EngineFactory exact_engine;  // for EngineKind::exact; the library has no exact engine
  DeviceOptions device;
  uint32_t threads = 0;           // of the host engine; 0: one for each core
  uint32_t batch_directions = 0;  // directions that are peeled at once; 0: by memory. Never changes a result
  bool measure_work = false;      // fills Result::work

  // Processes that share the counting, this one being rank 0 (<viewpeel/ranks.h>); the caller keeps them. nullptr: the
  // run is alone.
  Ranks* ranks = nullptr;

  bool balance = false;        // fills Result::balanced: the nearest form factors whose rows sum to 1
  SceneOptions scene_options;  // how the scene was made; checkpoints name it
};

// Refuses a request that contradicts itself, whatever the scene. Every run calls it first; a program may call it before
// it reads a large scene.
//   In: request: any
//   Throws: Error bad_usage, naming the program's options and the remedy. Tests: tests/unit/front_door_test.cpp.
//   Cost: O(1).
void checkRequest(const Request& request);

}  // namespace viewpeel
