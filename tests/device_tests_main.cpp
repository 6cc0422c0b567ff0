#include <gtest/gtest.h>

#include "test_device.h"

namespace viewpeel {
namespace {

// Fails a test in which the validation layer reported an error.
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

Estimate estimateScene(const InputScene& input, const TestRun& run) {
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, run.by, run.graphics.two_sided);
  const auto engine = makeGraphicsEngine(testDevice(), scene, ids, run.graphics);
  return estimateFormFactors(*engine, scene, ids, run.estimate);
}

PairCounts countPairs(const Scene& scene, const std::vector<Direction>& directions, const GraphicsOptions& options, By by) {
  return makeGraphicsEngine(testDevice(), scene, makeIds(scene, by, options.two_sided), options)->count(directions);
}

}  // namespace viewpeel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new viewpeel::ValidationListener);
  return RUN_ALL_TESTS();
}
