// countWith() counts pairs once, with a compute engine of the given options.
#pragma once
#include "engines/compute_engine.h"
#include "tests/support/test_device.h"

namespace viewpeel {

inline PairCounts countWith(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions,
                            const LatticeOptions& lattice, Work* work = nullptr) {
  LatticeOptions options = lattice;
  options.measure_work = work != nullptr;
  const auto engine = makeComputeEngine(testDevice(), scene, ids, options);
  PairCounts counts = engine->count(directions);
  if (work) *work = *engine->work();
  return counts;
}

}  // namespace viewpeel
