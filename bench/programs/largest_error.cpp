// This bench tests `--tolerance T`: it counts the seeds with an error above T in any form factor, environment and leak
// included. It prints CSV on stdout.
//   largest_error [--scene office|room|street|city1000|two_sided|touching]... [--tolerance T]... [--seeds K]
//
// The truth is one run of each scene at T / 20 with another seed, and reference_error is its largest standard error.
// Seconds are processor time of all threads, and include the start but not the loading of the scene.
#include <algorithm>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <viewpeel/compute.h>
#include "bench/support/measure.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kReferenceSeed = 1'000'000;
constexpr double kFiner = 20;  // the tolerance of the reference is T / kFiner

struct Options {
  std::vector<std::string> scenes{"office", "room", "street", "city1000", "two_sided", "touching"};
  std::vector<double> tolerances{1e-2};
  uint32_t seeds = 100;
};

Scene makeScene(const std::string& name) {
  if (name == "office" || name == "street") return loadScene(VIEWPEEL_SOURCE "/scenes/" + name + ".obj");
  if (name == "room") return buildScene(roomWithBoxes(1));
  if (name == "city1000") return buildScene(triangulatedCity(1000).scene);
  if (name == "two_sided") return buildScene(randomTriangles(200));
  return buildScene(test_scenes::roomWithTouchingBoxes());
}

FormFactors compute(const Scene& scene, const std::string& name, double tolerance, uint64_t seed) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.seed = seed;
  request.two_sided = name == "two_sided";
  return computeFormFactors(scene, request).form_factors;
}

// Returns the largest difference of two sets of form factors, taken from the smaller id of each pair.
double largestError(const FormFactors& found, const FormFactors& truth) {
  std::map<std::pair<uint32_t, uint32_t>, double> differences;
  for (const FormFactors::Entry& entry : truth.entries()) differences[{entry.i, entry.j}] -= entry.exchange_area.value;
  for (const FormFactors::Entry& entry : found.entries()) differences[{entry.i, entry.j}] += entry.exchange_area.value;
  double largest = 0;
  for (const auto& [pair, difference] : differences)
    largest = std::max(largest, std::abs(difference) / truth.ids().smallerArea(pair.first, pair.second));
  return largest;
}

void measure(const std::string& name, double tolerance, uint32_t seeds) {
  const Scene scene = makeScene(name);
  const FormFactors truth = compute(scene, name, tolerance / kFiner, kReferenceSeed);
  double reference_error = 0;
  for (const FormFactors::Entry& entry : truth.entries())
    reference_error =
        std::max(reference_error, entry.exchange_area.standard_error / truth.ids().smallerArea(entry.i, entry.j));
  std::vector<double> errors, seconds;
  for (uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::clock_t start = std::clock();
    const FormFactors found = compute(scene, name, tolerance, seed);
    seconds.push_back(double(std::clock() - start) / CLOCKS_PER_SEC);
    errors.push_back(largestError(found, truth));
  }
  const auto above = std::ranges::count_if(errors, [&](double error) { return error > tolerance; });
  fmt::print("{},{},{},{},{},{:.3g},{:.3g},{:.3g},{:.3g}\n", name, scene.faces.size(), tolerance, seeds, above,
             median(errors), *std::ranges::max_element(errors), reference_error, median(seconds));
  std::fflush(stdout);
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  viewpeel::bench::Options options;
  CLI::App app("Counts the seeds whose largest true error is above the tolerance.");
  app.add_option("--scene", options.scenes)->check(CLI::IsMember(viewpeel::bench::Options{}.scenes));
  app.add_option("--tolerance", options.tolerances)->check(CLI::PositiveNumber);
  app.add_option("--seeds", options.seeds)->check(CLI::PositiveNumber)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  fmt::print("# commit {}\n", viewpeel::bench::commitOf(VIEWPEEL_SOURCE));
  fmt::print(
      "scene,polygons,tolerance,seeds,above,median_largest_error,worst_largest_error,reference_error,cpu_seconds\n");
  for (const std::string& scene : options.scenes)
    for (const double tolerance : options.tolerances) viewpeel::bench::measure(scene, tolerance, options.seeds);
  return 0;
}
