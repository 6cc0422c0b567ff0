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

// A run with a Tolerance ends once the standard error of every form factor is at most this. Where that costs little
// more, it is promised in place of estimated: see Request::promise.
struct Tolerance {
  double standard_error = 1e-3;  // above 0
  // The run may have a second goal: standard errors of all form factors of at least Request::relative_floor, as shares
  // of their form factors.
  std::optional<double> relative;
};

// A run with a Relative goal ends once the standard error of every form factor of at least Request::relative_floor is
// at most this share of it.
struct Relative {
  double standard_error = 0.01;  // above 0
};

// A run with Seconds counts as many replicates as fit into this time, two at least.
struct Seconds {
  double seconds = 60;  // above 0
};

// A guarantee holds for one of two statistics.
enum class Statistic {
  mean,  // the mean of blocks of directions
  // The median is over Q runs of M^2 / epsilon^2 directions (Pellegrini 1997, section 5.3). Each errs by more than
  // epsilon with probability 1/4 at most, by Chebyshev.
  median,
};

// EpsilonDelta is a guarantee: with probability 1 - delta every form factor between polygons (or surfaces) is within
// epsilon of the true one, and in its interval (FormFactors::interval). With common directions (Request::pair_lines)
// environment and leak are within epsilon, too.
struct EpsilonDelta {
  double epsilon = 1e-2;  // in (0, 1)
  double delta = 1e-2;    // in [0, 1); with 0 only what geometry alone proves is in the intervals
  Statistic statistic = Statistic::mean;
  bool rows = false;  // the promise is for the environment of each row, too
  // Lattices are so fine that a direction adds at most about this to a form factor. The range is above 2; with 0 it is
  // planned.
  double range = 0;
  uint32_t block_directions = 0;  // 0: planned
};

// A FixedAmount is counted without a plan, and is the only goal.
struct FixedAmount {
  uint32_t directions = 400;  // of a replicate
  uint32_t replicates = 8;    // two at least
  int resolution = 0;         // lattice spacings across the scene's diameter; 0: 64
  // The number of lattice spacings across is for the polygon that needs most of them, in windows. With 0 none has more
  // than `resolution`.
  int finest = 0;
};

// A run has exactly one goal, which ends it.
using Goal = std::variant<Tolerance, Relative, Seconds, EpsilonDelta, FixedAmount>;

// An Amount fixes what it sets, and a plan chooses the rest. It is for goals other than FixedAmount.
struct Amount {
  uint32_t directions = 0;  // of a replicate; 0: planned
  uint32_t replicates = 8;  // at least
  int resolution = 0;       // 0: planned
  int finest = 0;           // with directions and resolution only
  bool is_exact = false;    // counts `replicates`, no more, even short of the goal: a part of a run
};

// Program and library give the same bits for the same request and plan.
struct Request {
  By by = By::polygon;
  Question question;  // empty: the whole matrix
  bool two_sided = false;

  Goal goal = Tolerance{};
  Amount amount;
  double relative_floor = 0.01;  // the least form factor whose relative error counts, in (0, 1]
  // The goal is given up when this time is over. A guarantee that takes longer is refused.
  std::optional<double> time_limit_s;

  std::optional<Sampling> sampling;  // unset: the quicker for engine and scene
  // The sampler draws directions over the sphere. Unset, it is fibonacci, better ones for a question, jittered for a
  // guarantee.
  std::optional<Sampler> sampler;
  // Only the visibility of each pair's unoccluded form factor is sampled. Unset, this is done where it pays.
  std::optional<bool> unoccluded;
  // Lines are drawn between the two polygons of each pair that something may block, as many as the pair's error needs.
  // They replace directions that all pairs have in common. Needs a Tolerance, Relative or
  // EpsilonDelta; unset: where it pays.
  std::optional<bool> pair_lines;
  // A Tolerance T is promised, as EpsilonDelta{T, 0.01} with rows is: every form factor is within T with probability
  // 0.99, and has an interval. Unset: where that costs at most twice an estimate of the same largest error, and nothing
  // else in the request is about estimates (PlanSummary::no_promise). FormFactorRun::request() has the goal then.
  std::optional<bool> promise;
  uint64_t seed = 1;             // the same seed and plan give the same bits
  uint64_t first_replicate = 0;  // of a part of a run, for merging

  EngineKind engine = EngineKind::automatic;
  EngineFactory exact_engine;  // of EngineKind::exact, which has no lattice: the library itself has none
  DeviceOptions device;
  uint32_t threads = 0;           // of the host engine; 0: one for each core
  uint32_t batch_directions = 0;  // peeled at once; 0: by memory. Never changes a result
  bool measure_work = false;      // fills Result::work

  bool balance = false;        // fills Result::balanced: the nearest form factors whose rows sum to 1
  SceneOptions scene_options;  // how the scene was made; checkpoints name it
};

// Refuses a request that contradicts itself, whatever the scene is. Every run does so first; a program may, before it
// reads a large scene.
//   In: request: any
//   Throws: Error bad_usage, naming the program's options and the remedy. Tests: tests/unit/front_door_test.cpp.
//   Cost: O(1).
void checkRequest(const Request& request);

}  // namespace viewpeel
