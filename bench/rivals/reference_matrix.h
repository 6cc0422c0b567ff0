// ReferenceMatrix is the truth against which error_time measures errors.
#pragma once
#include <optional>
#include <string>

#include "bench/rivals/methods.h"
#include "bench/support/exchange_matrix.h"
#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel::bench {

struct ReferenceMatrix {
  ExchangeMatrix exchange;        // unit-ball units squared
  MatrixError error;              // error of the reference: bounds of closed forms, or standard errors
  std::vector<double> rest;       // as in Outcome
  double largest_rest_error = 0;  // standard error, of form factors
  double seconds = 0;             // time of the long run; 0 for closed forms
  std::string source;
};

// Returns closed forms by contour integrals, for scenes in which nothing blocks a line.
ReferenceMatrix referenceByClosedForms(const Scene& scene);

// Returns viewpeel's longest run (runLong in methods.h), with a seed that no method has. The run is kept in `directory`
// by the scene's fingerprint, and used again if it had at least this time.
//   Throws: Error output.
ReferenceMatrix referenceByLongRun(const Device& device, const Scene& scene, const std::string& name, double seconds,
                                   const std::string& directory);

// ReferenceEffort says how long referenceByMethod() may run.
struct ReferenceEffort {
  double seconds = 0;            // time of all eight runs
  std::optional<double> amount;  // amount of each run, in the ladder's unit; replaces `seconds`
};
// Returns the mean of eight long runs of another method than the one judged, with seeds of their own. Its error is the
// standard error of this mean. It is kept as in referenceByLongRun, by method.
//   Throws: Error output.
ReferenceMatrix referenceByMethod(const Ladder& ladder, const Scene& scene, const std::string& name,
                                  const ReferenceEffort& effort, const std::string& directory);

}  // namespace viewpeel::bench
