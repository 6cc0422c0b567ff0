// Here are the methods that error_time compares: viewpeel's and its rivals', each as ladders of runs of growing work.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/support/exchange_matrix.h"
#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel::bench {

// Of the part that counts: until the method has its result, before that becomes a matrix to compare.
struct RunTime {
  double seconds = 0;
  double cpu_seconds = 0;   // of all threads
  double host_seconds = 0;  // of the calling thread: the rest of `seconds` it waits
};

struct Outcome {
  ExchangeMatrix exchange;               // unit-ball units squared
  std::optional<double> standard_error;  // rms over all ordered pairs, where the method states one
  RunTime time;
  std::string chosen;  // parameters that the method chose itself: "directions=64 resolution=32"
};

struct Profile {
  uint64_t device_bytes = 0;
  std::string passes;  // shares of the time on the device: "project 0.12 peel 0.70"
};

// A method made ready for a scene; not to be used after its ladder.
struct Runner {
  std::function<Outcome(double amount, uint64_t seed)> run;
  double setup_seconds = 0;  // to build the parts that every run needs, kernels compiled
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
  bool full = false;   // every resolution, not two
  std::string view3d;  // its program; none where empty
  std::string work_directory = ".";
};

// Returns all ladders for a scene whose polygons are faces, both of which have to outlive them.
std::vector<Ladder> makeLadders(const Device& device, const Scene& scene, const MethodOptions& options);

// Returns the names of the methods that verifyRivals checks.
std::vector<std::string> rivalNames();

// A LongRun has the exchange areas and standard errors of all pairs by viewpeel with unoccluded form factors, as a
// reference: as many directions as a time allows; specks in windows.
struct LongRun {
  ExchangeMatrix exchange, standard_errors;
};
LongRun runLong(const Device& device, const Scene& scene, double seconds);

}  // namespace viewpeel::bench
