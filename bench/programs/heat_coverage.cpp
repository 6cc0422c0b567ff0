// This bench tests standard errors of heat flows and temperatures. Over many seeds it counts how often the 95 %
// interval, value +- t_0.975 standard errors, holds the true value. Student's t has R - 1 degrees of freedom, or R + 4
// with pair lines. It prints CSV on stdout, with a row for each scene, way to count, and kind of value.
//   heat_coverage [--scene sheet|office]... [--seeds K]
//
// The scene `sheet` has parts of two squares past a sheet, with form factors in closed form. The truth of the office,
// by surface, is a run by pair lines to 5e-5. There are three ways to count: pair lines, visibilities along common
// directions, and common directions alone. A column has the rms error in standard errors, 1 where standard errors are
// right. Values of one run are correlated, so the standard error of a coverage comes from the spread between seeds.
#include <cmath>
#include <map>

#include <CLI/CLI.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>

#include <viewpeel/solve.h>

#include "bench/support/measure.h"
#include "scenes/heat_scenes.h"

namespace viewpeel::bench {
namespace {

struct HeatCase {
  Scene scene;
  MaterialTable materials;
  By by;
  HeatSolution truth;
};

Material hot(double emissivity, double temperature) { return {emissivity, temperature, {}}; }
Material flux(double emissivity, double heat_flux) { return {emissivity, {}, heat_flux}; }

std::vector<std::string> surfaceNames(const Scene& scene) {
  std::vector<std::string> names;
  for (const Surface& surface : scene.surfaces) names.push_back(surface.name);
  return names;
}

HeatCase pastASheet() {
  const InputScene input = test_scenes::squaresPastASheet(2);
  HeatCase found{buildScene(input), {"sheet", {}, 300}, By::polygon, {}};
  found.materials.lines = {{"low", hot(0.8, 400), 0}, {"high", flux(0.6, 50), 0}, {"sheet_*", flux(0.3, 0), 0}};
  const FormFactors exact = test_scenes::exactPastASheet(input, makeIds(found.scene, By::polygon, false));
  found.truth = solveHeat(exact, assignMaterials(found.materials, exact.ids(), surfaceNames(found.scene)));
  return found;
}

HeatCase office() {
  HeatCase found{loadScene(std::string(VIEWPEEL_SOURCE) + "/scenes/office.obj"), {"office", {}, {}}, By::surface, {}};
  found.materials.lines = {{"default", flux(0.9, 0), 0},    {"radiator", hot(0.95, 333.15), 0},
                           {"wall_*", hot(0.92, 292), 0},   {"floor", hot(0.9, 293), 0},
                           {"window_?", hot(0.84, 281), 0}, {"person", flux(0.97, 45), 0}};
  const Request request{.by = By::surface, .goal = Tolerance{5e-5}, .seed = 1'000'000, .engine = EngineKind::host};
  found.truth = solveScene(found.scene, found.materials, request).heat;
  return found;
}

struct Tally {
  double squares = 0, compared = 0, covered = 0;
  std::vector<double> of_seeds;
};

Request requestOf(const std::string& way, By by, uint64_t seed) {
  Request request{.by = by, .seed = seed, .engine = EngineKind::host};
  request.goal = Tolerance{1e-2};
  request.pair_lines = way == "pair lines";
  if (way == "visibilities") request.unoccluded = true;
  if (way == "directions") {
    request.unoccluded = false;
    request.goal = FixedAmount{.directions = 400, .resolution = 64};
  }
  return request;
}

void run(const std::string& name, const HeatCase& of, uint32_t seeds) {
  for (const std::string way : {"pair lines", "visibilities", "directions"}) {
    std::map<std::string, Tally> tallies;
    double replicates = 0;
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
      const SceneHeat found = solveScene(of.scene, of.materials, requestOf(way, of.by, seed));
      replicates += double(found.form_factors.replicates) / seeds;
      // A pair's variance has 5 more degrees of freedom with pair lines, eq. (61); sums have at least as many.
      const double degrees = double(found.form_factors.replicates - 1) + (way == "pair lines" ? 5 : 0);
      const double quantile = boost::math::quantile(boost::math::students_t(degrees), 0.975);
      std::map<std::string, std::pair<double, double>> of_seed;
      const auto compare = [&](const std::string& kind, const Measured& answer, const Measured& truth) {
        if (!(answer.standard_error > 0)) return;
        const double off = std::abs(answer.value - truth.value) / answer.standard_error;
        Tally& tally = tallies[kind];
        tally.squares += off * off, tally.compared += 1, tally.covered += off <= quantile;
        of_seed[kind].first += off <= quantile, of_seed[kind].second += 1;
      };
      for (size_t k = 0; k < found.heat.rows.size(); ++k) {
        compare("temperature", found.heat.rows[k].temperature, of.truth.rows[k].temperature);
        compare("heat flux", found.heat.rows[k].heat_flux, of.truth.rows[k].heat_flux);
      }
      for (const auto& [kind, share] : of_seed) tallies[kind].of_seeds.push_back(share.first / share.second);
    }
    for (const auto& [kind, tally] : tallies) {
      const double mean = tally.covered / tally.compared;
      double spread = 0;
      for (const double share : tally.of_seeds) spread += (share - mean) * (share - mean);
      const auto n = double(tally.of_seeds.size());
      fmt::print("{},{},{},{},{:.1f},{},{:.3f},{:.3f},{:.2f}\n", name, way, kind, seeds, replicates,
                 uint64_t(tally.compared), mean, std::sqrt(spread / (n * (n - 1))),
                 std::sqrt(tally.squares / tally.compared));
    }
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel::bench;
  CLI::App app("Coverage of intervals of heat flows and temperatures");
  std::vector<std::string> scenes{"sheet", "office"};
  uint32_t seeds = 200;
  app.add_option("--scene", scenes, "sheet or office");
  app.add_option("--seeds", seeds, "Runs of each way to count")->check(CLI::Range(2u, 100'000u));
  CLI11_PARSE(app, argc, argv);
  fmt::print("# device processor\n# commit {}\n", commitOf(VIEWPEEL_SOURCE));
  fmt::print(
      "scene,way,answer,seeds,replicates,answers,coverage,coverage_standard_error,rms_error_in_standard_errors\n");
  for (const std::string& scene : scenes) run(scene, scene == "office" ? office() : pastASheet(), seeds);
}
