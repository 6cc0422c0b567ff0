// makeLadders() makes the methods that error_time compares, viewpeel's and its rivals'. A ladder is a list of runs of
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
  std::optional<double> standard_error;  // rms over all ordered pairs, if the method states one
  RunTime time;
  std::string chosen;  // parameters that the method chose itself: "directions=64 resolution=32"
  // Exchange area with environment and leak by polygon. Empty where a method states none, so that users take 1 less the
  // sum of a row.
  std::vector<double> rest{};
};

struct Profile {
  uint64_t device_bytes = 0;
  std::string passes;  // shares of device time, as "project 0.12 peel 0.70"
};

// Runner is a method that is ready for a scene. It must not outlive its ladder.
struct Runner {
  std::function<Outcome(double amount, uint64_t seed)> run;
  double setup_seconds = 0;  // time to make the method ready, kernels compiled
  Profile profile;
  std::string chosen;  // parameters that the method chose while it was made ready
};

struct Ladder {
  struct Rung {
    double amount = 0, cost = 0;  // time is about proportional to cost
  };
  std::string method, parameters, amount_name;
  bool on_device = true;    // uses the Vulkan device
  std::vector<Rung> rungs;  // in the order of cost
  std::function<Runner()> set_up;
};

struct MethodOptions {
  bool full = false;                   // try all resolutions, not two
  std::string view3d;                  // View3D's program; empty: leave it out
  size_t view3d_most_polygons = 5000;  // larger scenes take View3D minutes
  std::string work_directory = ".";
};

// Makes all ladders for a scene whose polygons are its faces. Device and scene have to outlive the ladders.
std::vector<Ladder> makeLadders(const Device& device, const Scene& scene, const MethodOptions& options);

// Returns the names of the rivals that verifyRivals() checks.
std::vector<std::string> rivalNames();

// Returns rungs whose amounts and costs go from `first` to `last` by factors of `factor`.
std::vector<Ladder::Rung> climbBy(double first, double factor, double last);

// LongRun is a reference: exchange areas and standard errors of all pairs by viewpeel with unoccluded form factors. It
// counts directions until the time is spent, with small polygons in windows.
struct LongRun {
  ExchangeMatrix exchange, standard_errors;
  std::vector<double> rest;       // as Outcome::rest
  double largest_rest_error = 0;  // largest standard error of `rest`, as form factors
};
LongRun runLong(const Device& device, const Scene& scene, double seconds);

}  // namespace viewpeel::bench
