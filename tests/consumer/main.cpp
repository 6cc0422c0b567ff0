#include <cstdio>

#include <engines/compute_engine.h>
#include <estimator/estimate.h>
#include <io/checkpoint.h>

int main() {
  using namespace viewpeel;
  const Scene scene = buildScene({"plates", {"lower", "upper"}, {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0, 0},
                                                                 {{{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}}, 1, 0}}});
  const Device device;
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeComputeEngine(device, scene, ids, {});
  EstimateOptions options;
  options.on_sums = [](const RunSums& sums, bool last) {
    if (last) writeCheckpoint({{"--seed", "1"}}, sums, "consumer.h5");
  };
  const auto f = estimateFormFactors(*engine, scene, ids, options).form_factors.formFactor(0, 1);
  std::printf("F = %.4f +- %.4f\n", f.value, f.standard_error);
  return f.value > 0.19 && f.value < 0.21 && readCheckpoint("consumer.h5").sums.replicateCount() == 8 && device.validationErrors().empty() ? 0 : 1;
}
