// The bench measures errors against a ReferenceMatrix.
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
  MatrixError error;              // its own: bounds of closed forms, or standard errors
  std::vector<double> rest;       // as in Outcome
  double largest_rest_error = 0;  // standard error, of form factors
  double seconds = 0;             // of the long run that it comes from; 0 for closed forms
  std::string source;
};

// Returns closed forms by contour integrals, for scenes in which nothing is in the way.
ReferenceMatrix referenceByClosedForms(const Scene& scene);

// viewpeel's longest run (runLong in methods.h), from another seed than every method. Kept in `directory` by the
// scene's fingerprint, and taken from there where that run had as long.
//   Throws: Error output.
ReferenceMatrix referenceByLongRun(const Device& device, const Scene& scene, const std::string& name, double seconds,
                                   const std::string& directory);

// The mean of eight long runs of another method than the one judged, from seeds of their own; its error is the spread
// of their mean. Kept as above, by method.
//   Throws: Error output.
struct ReferenceEffort {
  double seconds = 0;            // of all eight
  std::optional<double> amount;  // of each, as the ladder's; in place of seconds
};
ReferenceMatrix referenceByMethod(const Ladder& ladder, const Scene& scene, const std::string& name,
                                  const ReferenceEffort& effort, const std::string& directory);

}  // namespace viewpeel::bench
