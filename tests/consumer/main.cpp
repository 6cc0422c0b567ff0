#include <cstdio>

#include <engines/compute_engine.h>
#include <estimator/estimate.h>

int main() {
  using namespace viewpeel;
  const Scene scene = buildScene({"plates", {"lower", "upper"}, {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0, 0},
                                                                 {{{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}}, 1, 0}}});
  const Device device;
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeComputeEngine(device, scene, ids, {});
  const auto f = estimateFormFactors(*engine, scene, ids, {}).form_factors.formFactor(0, 1);
  std::printf("F = %.4f +- %.4f\n", f.value, f.standard_error);
  return f.value > 0.19 && f.value < 0.21 && device.validationErrors().empty() ? 0 : 1;
}
