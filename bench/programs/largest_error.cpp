// This bench tests `--tolerance T`: it counts the seeds with an error above T in any form factor, environment and leak
// included. It prints CSV on stdout.
//   largest_error [--scene NAME]... [--tolerance T]... [--seeds K] [--finer K]
//
// Scenes and their truths are those of support/truth.h. The truth is a run at T / 20, or as --finer says, and
// reference_error is its largest standard error.
// beyond_5 is the share of entries off by more than 5 stated errors, of all runs.
// Seconds are processor time of all threads, and include the start but not the loading of the scene.
#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "bench/support/measure.h"
#include "bench/support/truth.h"

namespace viewpeel::bench {
namespace {

struct Options {
  std::vector<std::string> scenes{"office", "room", "street", "city1000", "two_sided", "touching"};
  std::vector<double> tolerances{1e-2};
  uint32_t seeds = 100;
  double finer = 20;  // the tolerance over the truth's tolerance
};

void measure(const std::string& name, double tolerance, const Options& options) {
  const Scene scene = makeJudgedScene(name);
  const FormFactors truth = computeTruth(scene, name, tolerance / options.finer);
  std::vector<double> errors, seconds;
  Comparison all;
  for (uint64_t seed = 1; seed <= options.seeds; ++seed) {
    const std::clock_t start = std::clock();
    const FormFactors found = computeFormFactors(scene, requestFor(name, tolerance, seed)).form_factors;
    seconds.push_back(double(std::clock() - start) / CLOCKS_PER_SEC);
    const Comparison here = compare(found, truth);
    errors.push_back(here.largest);
    all.entries += here.entries, all.beyond += here.beyond;
  }
  const auto above = std::ranges::count_if(errors, [&](double error) { return error > tolerance; });
  fmt::print("{},{},{},{},{},{:.3g},{:.3g},{:.3g},{:.3g},{:.2g}\n", name, scene.faces.size(), tolerance, options.seeds,
             above, median(errors), *std::ranges::max_element(errors), largestErrorOf(truth), median(seconds),
             double(all.beyond) / double(all.entries));
  std::fflush(stdout);
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  viewpeel::bench::Options options;
  CLI::App app("Counts the seeds whose largest true error is above the tolerance.");
  app.add_option("--scene", options.scenes)->check(CLI::IsMember(viewpeel::bench::judgedScenes()));
  app.add_option("--tolerance", options.tolerances)->check(CLI::PositiveNumber);
  app.add_option("--seeds", options.seeds)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--finer", options.finer, "goals of the truth, in parts of the tolerance")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  fmt::print("# commit {}\n", viewpeel::bench::commitOf(VIEWPEEL_SOURCE));
  fmt::print(
      "scene,polygons,tolerance,seeds,above,median_largest_error,worst_largest_error,reference_error,cpu_seconds,"
      "beyond_5\n");
  for (const std::string& scene : options.scenes)
    for (const double tolerance : options.tolerances) viewpeel::bench::measure(scene, tolerance, options);
  return 0;
}
