#pragma once
#include "engines/graphics_engine.h"
#include "estimator/estimate.h"
#include "vulkan/device.h"

namespace viewpeel {

// The device all tests share, with validation and synchronisation validation on. Any error message fails the test in which it came.
const Device& testDevice();

struct TestRun {
  GraphicsOptions graphics{.resolution = 64};
  By by = By::polygon;
  EstimateOptions estimate{.directions = 400, .replicates = 16};
};

Estimate estimateScene(const InputScene& input, const TestRun& run = {});

// Counts of one set of directions.
PairCounts countPairs(const Scene& scene, const std::vector<Direction>& directions, const GraphicsOptions& options, By by = By::polygon);

}  // namespace viewpeel
