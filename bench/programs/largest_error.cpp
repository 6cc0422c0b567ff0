// This bench tests `--tolerance T`: it counts the seeds with an error above T in any form factor, environment and leak
// included. It prints CSV on stdout.
//   largest_error [--scene office|room|street|city1000|two_sided|touching|office9280|city10000|city19572|room39936]...
//     [--tolerance T]... [--seeds K] [--finer K]
//
// The truth is one run of each scene at T / 20, or as --finer says, with another seed, and reference_error is its
// largest standard error. Of scenes beyond 8,000 polygons the truth has 48 rows, and only their entries are looked at.
// beyond_5 is the share of entries off by more than 5 stated errors, of all runs.
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
constexpr size_t kMostFaces = 8'000, kRows = 48;  // scenes of more faces have a truth of kRows rows, others of all

struct Options {
  std::vector<std::string> scenes{"office", "room", "street", "city1000", "two_sided", "touching"};
  std::vector<double> tolerances{1e-2};
  uint32_t seeds = 100;
  double finer = 20;  // the tolerance over the truth's tolerance
};

Scene makeScene(const std::string& name) {
  if (name == "office" || name == "street") return loadScene(VIEWPEEL_SOURCE "/scenes/" + name + ".obj");
  if (name == "room") return buildScene(roomWithBoxes(1));
  if (name == "room39936") return buildScene(roomWithBoxes(8));
  if (name == "office9280") return buildScene(refined(loadScene(VIEWPEEL_SOURCE "/scenes/office.obj"), 4));
  if (name == "city19572") return buildScene(city(19'760));
  if (name == "city10000") return buildScene(triangulatedCity(10'000).scene);
  if (name == "city1000") return buildScene(triangulatedCity(1000).scene);
  if (name == "two_sided") return buildScene(randomTriangles(200));
  return buildScene(test_scenes::roomWithTouchingBoxes());
}

FormFactors compute(const Scene& scene, const std::string& name, double tolerance, uint64_t seed,
                    const std::vector<std::string>& rows = {}) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.seed = seed;
  request.two_sided = name == "two_sided";
  request.question.from = rows;
  return computeFormFactors(scene, request).form_factors;
}

// Returns the names of the rows that the truth has. The list is empty if it has all rows.
std::vector<std::string> rowsOf(const Scene& scene) {
  std::vector<std::string> rows;
  if (scene.faces.size() <= kMostFaces) return rows;
  const Ids ids = makeIds(scene, By::polygon, false);
  for (size_t k = 0; k < kRows; ++k) rows.push_back(ids.names[(2 * k + 1) * ids.count() / (2 * kRows)]);
  return rows;
}

struct Comparison {
  double largest = 0;                // largest error of a form factor, from the row with the smaller area
  uint64_t entries = 0, beyond = 0;  // entries with a standard error; and the entries off by more than 5 of both errors
};

// Compares the entries of all rows that the truth has.
Comparison compare(const FormFactors& found, const FormFactors& truth) {
  const Ids& ids = truth.ids();
  std::map<std::pair<uint32_t, uint32_t>, std::pair<Measured, Measured>> both;
  for (const FormFactors::Entry& entry : truth.entries()) both[{entry.i, entry.j}].second = entry.exchange_area;
  for (const FormFactors::Entry& entry : found.entries())
    if (ids.isRequested(entry.i) || (entry.j < kEnvironment && ids.isRequested(entry.j)))
      both[{entry.i, entry.j}].first = entry.exchange_area;
  Comparison all;
  for (const auto& [pair, measured] : both) {
    const auto& [here, there] = measured;
    const double difference = std::abs(here.value - there.value);
    all.largest = std::max(all.largest, difference / ids.smallerArea(pair.first, pair.second));
    if (!(here.standard_error > 0)) continue;  // exact, or missing in the run that is judged
    ++all.entries;
    all.beyond += difference > 5 * std::hypot(here.standard_error, there.standard_error);
  }
  return all;
}

void measure(const std::string& name, double tolerance, const Options& options) {
  const Scene scene = makeScene(name);
  const FormFactors truth = compute(scene, name, tolerance / options.finer, kReferenceSeed, rowsOf(scene));
  double reference_error = 0;
  for (const FormFactors::Entry& entry : truth.entries())
    reference_error =
        std::max(reference_error, entry.exchange_area.standard_error / truth.ids().smallerArea(entry.i, entry.j));
  std::vector<double> errors, seconds;
  Comparison all;
  for (uint64_t seed = 1; seed <= options.seeds; ++seed) {
    const std::clock_t start = std::clock();
    const FormFactors found = compute(scene, name, tolerance, seed);
    seconds.push_back(double(std::clock() - start) / CLOCKS_PER_SEC);
    const Comparison here = compare(found, truth);
    errors.push_back(here.largest);
    all.entries += here.entries, all.beyond += here.beyond;
  }
  const auto above = std::ranges::count_if(errors, [&](double error) { return error > tolerance; });
  fmt::print("{},{},{},{},{},{:.3g},{:.3g},{:.3g},{:.3g},{:.2g}\n", name, scene.faces.size(), tolerance, options.seeds,
             above, median(errors), *std::ranges::max_element(errors), reference_error, median(seconds),
             double(all.beyond) / double(all.entries));
  std::fflush(stdout);
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  viewpeel::bench::Options options;
  CLI::App app("Counts the seeds whose largest true error is above the tolerance.");
  app.add_option("--scene", options.scenes)
      ->check(CLI::IsMember({"office", "room", "street", "city1000", "two_sided", "touching", "office9280", "city10000",
                             "city19572", "room39936"}));
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
