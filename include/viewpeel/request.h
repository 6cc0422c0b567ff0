// What to compute: the rows, one goal, and how to get there. Everything has a default; Request{} asks for all form
// factors of all polygons to 1e-3.
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

// Ends once the standard error of every form factor is at most this.
struct Tolerance {
  double standard_error = 1e-3;  // above 0
  // With it: the standard errors of all form factors of at least Request::relative_floor, too, as shares of their form
  // factors.
  std::optional<double> relative;
};

// Ends once the standard error of every form factor of at least Request::relative_floor is at most this share of it.
struct Relative {
  double standard_error = 0.01;  // above 0
};

// As many replicates as fit into a time, two at least.
struct Seconds {
  double seconds = 60;  // above 0
};

// What a guarantee is of.
enum class Statistic {
  mean,    // the mean of blocks of directions
  median,  // the median of Q runs of M^2 / epsilon^2 directions (Pellegrini 1997, section 5.3): each errs by more than
           // epsilon with probability 1/4 at most, by Chebyshev
};

// A guarantee: with probability 1 - delta every form factor is within epsilon of the true one.
struct EpsilonDelta {
  double epsilon = 1e-2;  // in (0, 1)
  double delta = 1e-2;    // in (0, 1)
  Statistic statistic = Statistic::mean;
  double range =
      0;  // lattices are so fine that a direction adds at most about this to a form factor, above 2; 0: planned
  uint32_t block_directions = 0;  // 0: planned
};

// No goal but this amount, and no plan.
struct FixedAmount {
  uint32_t directions = 400;  // of a replicate
  uint32_t replicates = 8;    // two at least
  int resolution = 0;         // lattice spacings across the scene's diameter; 0: 64
  int finest = 0;  // spacings for the polygon that needs most of them, in windows; 0: none has more than `resolution`
};

// When a run ends. Exactly one.
using Goal = std::variant<Tolerance, Relative, Seconds, EpsilonDelta, FixedAmount>;

// What a plan is not to choose, with a goal that is no FixedAmount.
struct Amount {
  uint32_t directions = 0;  // of a replicate; 0: planned
  uint32_t replicates = 8;  // at least
  int resolution = 0;       // 0: planned
  int finest = 0;           // with directions and resolution only
};

// A request. Program and library give the same bits for the same request and plan.
struct Request {
  By by = By::polygon;
  Question question;  // empty: the whole matrix
  bool two_sided = false;

  Goal goal = Tolerance{};
  Amount amount;
  double relative_floor = 0.01;  // the least form factor whose relative error counts, in (0, 1]
  std::optional<double>
      time_limit_s;  // the goal is given up when this time is over; a guarantee that takes longer is refused

  std::optional<Sampling> sampling;  // unset: the quicker for engine and scene
  std::optional<Sampler>
      sampler;  // of directions over the sphere; unset: fibonacci, better ones for a question, jittered for a guarantee
  std::optional<bool>
      unoccluded;  // sample only the visibility of each pair's unoccluded form factor; unset: where that pays
  // Draws lines between the two polygons of each pair that something may block, as many as the pair's error asks for,
  // in place of directions that all pairs have in common. Needs a Tolerance or Relative; unset: where that pays.
  std::optional<bool> pair_lines;
  uint64_t seed = 1;             // the same seed and plan give the same bits
  uint64_t first_replicate = 0;  // of a part of a run, for merging

  EngineKind engine = EngineKind::automatic;
  EngineFactory exact_engine;  // of EngineKind::exact, which has no lattice: the library itself has none
  DeviceOptions device;
  uint32_t threads = 0;           // of the host engine; 0: one for each core
  uint32_t batch_directions = 0;  // peeled at once; 0: by memory. Never changes a result
  bool measure_work = false;      // fills Result::work

  bool balance = false;        // fills Result::balanced: the nearest form factors whose rows sum to 1
  SceneOptions scene_options;  // that the scene was made with: checkpoints name them
};

// Refuses what contradicts itself, whatever the scene is. Every run does so first; a program may, before it reads a
// large scene.
//   Tests: tests/unit/front_door_test.cpp.
//   Throws: Error bad_usage, naming the program's options and the remedy.    Cost: O(1).
void checkRequest(const Request& request);

}  // namespace viewpeel
