// makeLadders() makes the methods that error_time compares, viewpeel's and its rivals'. A ladder is a row of runs of
// growing work.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/support/exchange_matrix.h"
#include "bench/support/run_time.h"
#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel::bench {

struct Outcome {
  ExchangeMatrix exchange;               // unit-ball units squared
  std::optional<double> standard_error;  // rms over all ordered pairs, where the method states one
  RunTime time;
  std::string chosen;  // parameters that the method chose itself: "directions=64 resolution=32"
  // Each polygon has here the exchange area to environment and leak; empty where a method says nothing of the two,
  // so that users take one less the row's form factors.
  std::vector<double> rest{};
};

struct Profile {
  uint64_t device_bytes = 0;
  std::string passes;  // shares of the time on the device: "project 0.12 peel 0.70"
};

// A Runner is a method made ready for a scene. It is not to be used after its ladder.
struct Runner {
  std::function<Outcome(double amount, uint64_t seed)> run;
  double setup_seconds = 0;  // to build what every run needs, kernels compiled
  Profile profile;
  std::string chosen;  // parameters chosen when it was made ready
};

struct Ladder {
  struct Rung {
    double amount = 0, cost = 0;  // time grows about as the cost does
  };
  std::string method, parameters, amount_name;
  bool on_device = true;    // of Vulkan
  std::vector<Rung> rungs;  // by cost
  std::function<Runner()> set_up;
};

struct MethodOptions {
  bool full = false;                   // every resolution, not two
  std::string view3d;                  // its program; none where empty
  size_t view3d_most_polygons = 5000;  // in larger scenes it takes minutes even once
  std::string work_directory = ".";
};

// Makes all ladders for a scene whose polygons are faces. Both have to outlive the ladders.
std::vector<Ladder> makeLadders(const Device& device, const Scene& scene, const MethodOptions& options);

// Returns the methods that verifyRivals is about.
std::vector<std::string> rivalNames();

// Amounts, and costs, from `first` to `last`, each `factor` times the one before.
std::vector<Ladder::Rung> climbBy(double first, double factor, double last);

// The exchange areas and standard errors of all pairs by viewpeel with unoccluded form factors, as a reference: as many
// directions as a time allows; specks in windows.
struct LongRun {
  ExchangeMatrix exchange, standard_errors;
  std::vector<double> rest;       // as in Outcome
  double largest_rest_error = 0;  // standard error, of form factors
};
LongRun runLong(const Device& device, const Scene& scene, double seconds);

}  // namespace viewpeel::bench
