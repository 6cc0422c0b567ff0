// Here are the device that all device tests share, and runs of the estimator on it.
#pragma once
#include <ostream>

#include "engines/compute_engine.h"
#include "engines/engine_factory.h"
#include "engines/graphics_engine.h"
#include "engines/host_engine.h"
#include "estimator/estimate.h"
#include "vulkan/device.h"

namespace viewpeel {

// Failure messages and == need these operators.
inline bool operator==(const PairCount& a, const PairCount& b) {
  return a.i == b.i && a.j == b.j && a.count == b.count && a.blocked == b.blocked;
}
inline void PrintTo(const PairCount& c, std::ostream* out) {
  *out << "(" << c.i << ", " << c.j << "): " << c.count << ", blocked " << c.blocked;
}

// Returns the device all tests share, with validation and synchronisation validation on. Any error message fails the
// test in which it came.
const Device& testDevice();

// Returns engines of a kind, on that device where they need one.
EngineFactory enginesOf(EngineKind kind);

struct TestRun {
  LatticeOptions lattice;
  bool two_sided = false;
  By by = By::polygon;
  EngineKind engine = EngineKind::compute;
  EstimateOptions estimate{.directions = 400, .replicates = 16};
  const char* name = "compute";
};

// The same run with lattice points of the compute and the host engine, whose counts are the same, and with the host
// engine's scanlines.
std::vector<TestRun> withEngines(const TestRun& run = {});

Estimate estimateScene(const InputScene& input, const TestRun& run = {});

// A CountRun says how counts of one set of directions are made.
struct CountRun {
  LatticeOptions lattice;
  bool two_sided = false;
  By by = By::polygon;
};

// The counts of the compute engine; graphics and host engine have to agree to the last bit.
PairCounts countPairs(const Scene& scene, const std::vector<Direction>& directions, const CountRun& run);

}  // namespace viewpeel
