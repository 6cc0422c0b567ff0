// All device tests share this device, and these functions that run the estimator on it.
#pragma once
#include <ostream>

#include "engines/compute_engine.h"
#include "engines/engine_factory.h"
#include "engines/graphics_engine.h"
#include "engines/host_engine.h"
#include "estimator/estimate.h"
#include "vulkan/device.h"

namespace viewpeel {

// Comparisons and failure messages need these operators.
inline bool operator==(const PairCount& a, const PairCount& b) {
  return a.i == b.i && a.j == b.j && a.count == b.count && a.blocked == b.blocked;
}
inline void PrintTo(const PairCount& c, std::ostream* out) {
  *out << "(" << c.i << ", " << c.j << "): " << c.count << ", blocked " << c.blocked;
}

// Returns the device that all tests share. Validation and synchronisation validation are on, and a test fails if it
// causes an error message.
const Device& testDevice();

// Returns a factory for engines of this kind, which use the shared device if they need one.
EngineFactory enginesOf(EngineKind kind);

struct TestRun {
  LatticeOptions lattice;
  bool two_sided = false;
  By by = By::polygon;
  EngineKind engine = EngineKind::compute;
  EstimateOptions estimate{.directions = 400, .replicates = 16};
  const char* name = "compute";
};

// Returns three variants of the run: lattice points of the compute engine and of the host engine, whose counts are
// equal, and scanlines of the host engine.
std::vector<TestRun> withEngines(const TestRun& run = {});

Estimate estimateScene(const InputScene& input, const TestRun& run = {});

// CountRun has the settings for counting one set of directions.
struct CountRun {
  LatticeOptions lattice;
  bool two_sided = false;
  By by = By::polygon;
};

// Returns the counts of the compute engine. Expects the same bits from the graphics and host engines.
PairCounts countPairs(const Scene& scene, const std::vector<Direction>& directions, const CountRun& run);

}  // namespace viewpeel
