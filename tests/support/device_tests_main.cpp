#include <algorithm>

#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

// ValidationListener fails every test in which the validation layer reports an error.
class ValidationListener : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo&) override { seen_ = testDevice().validationErrors().size(); }
  void OnTestEnd(const testing::TestInfo&) override {
    const auto& errors = testDevice().validationErrors();
    for (size_t k = seen_; k < errors.size(); ++k) ADD_FAILURE() << "Vulkan validation: " << errors[k];
  }
  size_t seen_ = 0;
};

}  // namespace

const Device& testDevice() {
  static const Device device({.selector = "", .validation = true});
  return device;
}

EngineFactory enginesOf(EngineKind kind) { return latticeEngines(kind, &testDevice()); }

std::vector<TestRun> withEngines(const TestRun& run) {
  std::vector<TestRun> runs(3, run);
  for (size_t k : {1, 2}) runs[k].engine = EngineKind::host, runs[k].name = "host";
  runs[2].lattice.sampling = Sampling::scanline;
  runs[2].name = "host, scanlines";
  return runs;
}

Estimate estimateScene(const InputScene& input, const TestRun& run) {
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, run.by, run.two_sided);
  const auto engine = enginesOf(run.engine)(scene, ids, run.lattice);
  return estimateFormFactors(*engine, scene, ids, run.estimate);
}

PairCounts countPairs(const Scene& scene, const std::vector<Direction>& directions, const CountRun& run) {
  const Ids ids = makeIds(scene, run.by, run.two_sided);
  PairCounts counts = makeComputeEngine(testDevice(), scene, ids, run.lattice)->count(directions);
  const auto isStacked = [](const Polygon& polygon) {
    return polygon.tie_rank != kContactRank && polygon.tie_rank != kSheetRank;
  };
  if (std::any_of(scene.polygons.begin(), scene.polygons.end(), isStacked)) {
    EXPECT_THROW(makeGraphicsEngine(testDevice(), scene, ids, run.lattice),
                 Error);  // it can order two coincident polygons only
  } else {
    EXPECT_EQ(counts, makeGraphicsEngine(testDevice(), scene, ids, run.lattice)->count(directions))
        << scene.file << ": compute and graphics differ";
  }
  EXPECT_EQ(counts, makeHostEngine(scene, ids, run.lattice)->count(directions))
      << scene.file << ": compute and host differ";
  return counts;
}

}  // namespace viewpeel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new viewpeel::ValidationListener);
  return RUN_ALL_TESTS();
}
