// This bench measures the error of irradiations, W/m2 over all polygons, that each method reaches in a given time. It
// prints CSV on stdout.
//   heat_error_time [--scene office|city]... [--seconds S] [--seeds K]
//
// Methods: `paths` follows paths of radiation that polygons absorb with probability e (Monte Carlo path tracing by
// Embree). `rays` makes form factors by Embree's rays, N from each polygon, and solves them as viewpeel does. `pair
// lines` is `viewpeel solve --form-factors T`, `directions` is `viewpeel solve --matrix-free on`; both state standard
// errors, and their time is part of the method's. All methods have one radiosity for each polygon. The reference is a
// run by pair lines to a finer tolerance, from another seed; its own standard error is in a column. Each method climbs
// a ladder of growing work until its next run would take longer than --seconds.
#include <cmath>
#include <functional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bench/rivals/embree_rays.h"
#include "bench/support/measure.h"
#include "bench/support/run_time.h"
#include "scenes/generate.h"
#include <viewpeel/matrix_free.h>
#include <viewpeel/solve.h>

namespace viewpeel::bench {
namespace {

struct HeatCase {
  Scene scene;
  MaterialTable materials;
  double reference_tolerance;
};

Material hot(double emissivity, double temperature) { return {emissivity, temperature, {}}; }
Material flux(double emissivity, double heat_flux) { return {emissivity, {}, heat_flux}; }

// The office has the materials of docs/solve.md, the city 50 W/m2 from all surfaces.
HeatCase makeCase(const std::string& name) {
  if (name == "city") {
    HeatCase city_case{buildScene(city(1000)), {"city", {}, 265}, 3e-5};
    city_case.materials.lines = {{"default", flux(0.9, 50), 0}};
    return city_case;
  }
  HeatCase office{buildScene(refined(loadScene(VIEWPEEL_SOURCE "/scenes/office.obj"), 1)), {"office", {}, {}}, 1e-4};
  office.materials.lines = {{"default", flux(0.9, 0), 0},  {"radiator", hot(0.95, 333.15), 0},
                            {"wall_*", hot(0.92, 292), 0}, {"floor", hot(0.9, 293), 0},
                            {"ceiling", hot(0.9, 294), 0}, {"window_?", hot(0.84, 281), 0},
                            {"person", flux(0.97, 45), 0}, {"lamp", flux(0.9, 80), 0}};
  return office;
}

double power(double temperature) { return kStefanBoltzmann * std::pow(temperature, 4); }

// An Equation is the enclosure less one emissive power: B = source + reflectivity H, as docs/solve.md, eq. (1).
struct Equation {
  std::vector<double> source, reflectivity;
  double shift;
};

Equation equationOf(const HeatCase& of, const Ids& ids, const Enclosure& enclosure) {
  Equation found{{}, {}, power(of.materials.environment_temperature.value_or(293))};
  for (uint32_t i = 0; i < ids.count(); ++i) {
    const Material& material = enclosure.materials[i];
    found.source.push_back(material.temperature ? material.emissivity * (power(*material.temperature) - found.shift)
                                                : *material.heat_flux);
    found.reflectivity.push_back(material.temperature ? 1 - material.emissivity : 1);
  }
  return found;
}

std::vector<double> irradiationsOf(const HeatSolution& heat) {
  std::vector<double> irradiations;
  for (const HeatRow& row : heat.rows) irradiations.push_back(row.irradiation.value);
  return irradiations;
}

struct Method {
  std::string name;
  double first, factor;  // amounts of work
  std::function<std::vector<double>(double amount, uint64_t seed)> run;
};

// Returns form factors by polygon from rays, with the environment as what is left.
FormFactors fromRays(const EmbreeRays& rays, const Scene& scene, const Ids& ids, uint64_t count, uint64_t seed,
                     bool is_open) {
  const ExchangeMatrix exchange =
      estimateFromRays(rays.shoot(Trace::streams, Points::random, count, seed), scene).exchange;
  const double unit = scene.scale * scene.scale;
  std::vector<FormFactors::Entry> entries;
  std::vector<double> rest = ids.areas;
  std::vector<Measured> rows(ids.count());
  for (uint32_t i = 0; i < ids.count(); ++i) {
    for (uint32_t j = i + 1; j < ids.count(); ++j) {
      const double area = exchange.at(i, j) * unit;
      if (area == 0) continue;
      entries.push_back({i, j, {area, 0}});
      rest[i] -= area, rest[j] -= area;
    }
    if (is_open && rest[i] > 0) entries.push_back({i, kEnvironment, {rest[i], 0}});
    rows[i].value = 1;
  }
  return {ids, std::move(entries), std::move(rows)};
}

void measure(const std::string& name, double seconds, uint32_t seeds) {
  const HeatCase of = makeCase(name);
  const Ids ids = makeIds(of.scene, By::polygon, false);
  std::vector<std::string> surface_names;
  for (const Surface& surface : of.scene.surfaces) surface_names.push_back(surface.name);
  const Enclosure enclosure = assignMaterials(of.materials, ids, surface_names);
  const Equation equation = equationOf(of, ids, enclosure);
  Request request{.by = By::polygon, .engine = EngineKind::host};
  request.goal = Tolerance{of.reference_tolerance};
  request.seed = 1'000'000;
  const HeatSolution reference = solveScene(of.scene, of.materials, request).heat;
  double reference_squares = 0;
  for (const HeatRow& row : reference.rows) reference_squares += std::pow(row.irradiation.standard_error, 2);
  const double reference_error = std::sqrt(reference_squares / double(ids.count()));

  const EmbreeRays rays(of.scene);
  const auto tracePaths = [&](double amount, uint64_t seed) {
    std::vector<double> emitted, absorptivity, arriving;
    for (uint32_t i = 0; i < ids.count(); ++i) {
      emitted.push_back(equation.source[i] * ids.areas[i]);
      absorptivity.push_back(1 - equation.reflectivity[i]);
    }
    arriving = rays.tracePaths(Trace::streams, emitted, absorptivity, uint64_t(amount), seed);
    for (uint32_t i = 0; i < ids.count(); ++i) arriving[i] = arriving[i] / ids.areas[i] + equation.shift;
    return arriving;
  };
  const auto byRays = [&](double amount, uint64_t seed) {
    return irradiationsOf(
        solveHeat(fromRays(rays, of.scene, ids, uint64_t(amount), seed, reference.is_open), enclosure));
  };
  const auto byLines = [&](double amount, uint64_t seed) {
    Request lines{.by = By::polygon, .seed = seed, .engine = EngineKind::host};
    lines.goal = Tolerance{1 / amount};
    return irradiationsOf(solveScene(of.scene, of.materials, lines).heat);
  };
  const auto byDirections = [&](double amount, uint64_t seed) {
    MatrixFreeRequest directions{.tolerance = HeatTolerance{1e9, HeatTolerance::Of::heat_flux}, .seed = seed};
    directions.first_directions = uint32_t(amount);
    return irradiationsOf(solveMatrixFree(of.scene, of.materials, directions).heat);
  };
  for (const Method& method : {Method{"paths", 1e4, 8, tracePaths}, Method{"rays", 64, 8, byRays},
                               Method{"pair lines", 50, 2.5, byLines}, Method{"directions", 8, 4, byDirections}}) {
    double last_s = 0;
    for (double amount = method.first; last_s * method.factor <= seconds; amount *= method.factor) {
      double squares = 0, largest = 0, cpu_s = 0;
      last_s = 0;
      for (uint32_t seed = 1; seed <= seeds; ++seed) {
        std::vector<double> found;
        const RunTime time = timeOf([&] { found = method.run(amount, seed); });
        last_s += time.seconds / seeds, cpu_s += time.cpu_seconds / seeds;
        for (uint32_t i = 0; i < ids.count(); ++i) {
          const double error = found[i] - reference.rows[i].irradiation.value;
          squares += error * error / (double(ids.count()) * seeds);
          largest = std::max(largest, std::abs(error));
        }
      }
      fmt::print("{},{},{},{:.6g},{},{:.3g},{:.3g},{:.3g},{:.3g},{:.2g}\n", name, ids.count(), method.name, amount,
                 seeds, last_s, cpu_s, std::sqrt(squares), largest, reference_error);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel::bench;
  CLI::App app("Error of irradiations against time, for path tracing, form factors by rays, and viewpeel");
  std::vector<std::string> scenes{"office", "city"};
  double seconds = 5;
  uint32_t seeds = 3;
  app.add_option("--scene", scenes, "office or city")->check(CLI::IsMember({"office", "city"}));
  app.add_option("--seconds", seconds, "The longest run of a method")->check(CLI::PositiveNumber);
  app.add_option("--seeds", seeds, "Runs of each amount")->check(CLI::Range(1u, 1000u));
  CLI11_PARSE(app, argc, argv);
  fmt::print("# device processor, {} cores; {}\n# commit {}\n", std::thread::hardware_concurrency(), embreeVersion(),
             commitOf(VIEWPEEL_SOURCE));
  fmt::print("scene,polygons,method,amount,seeds,seconds,cpu_seconds,rms_error,largest_error,reference_error\n");
  for (const std::string& scene : scenes) measure(scene, seconds, seeds);
}
