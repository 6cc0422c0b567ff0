// Time to a given error, counts alone beside closed forms times visible shares. CSV on stdout: seconds of eight replicates with all that comes before them (pilots of shares, closed
// forms), rms and largest error over all ordered pairs of polygons; in comments the seconds to given rms and largest errors, of the quickest run that reaches them, or along the line through the best.
//   share_error [--scene cube|office|room4]... [--resolution PX]... [--directions N]... [--reference N] [--device D]
// References: closed forms for the inside of a cube of 96 patches; else a run with closed forms at 256 spacings and N directions, in two halves, whose difference says its own error.
#include <array>
#include <cmath>

#include <CLI/CLI.hpp>

#include "engines/compute_engine.h"
#include "error.h"
#include "estimator/visible_share.h"
#include "generate.h"
#include "measure.h"
#include "reference/contour_integral.h"

namespace viewpeel::bench {
namespace {

struct Options {
  std::vector<std::string> scenes{"cube", "office", "room4"};
  std::vector<int> resolutions{32, 64, 128, 256};
  std::vector<uint32_t> directions{64, 256, 1024};
  uint32_t reference = 32'768;
  DeviceOptions device;
};

constexpr std::array kRmsGoals = {1e-4, 1e-5}, kLargestGoals = {1e-3, 1e-4};

InputScene cubeOfPatches() {
  InputScene scene{"inside of a cube", {"cube"}, {}};
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int patch = 0; patch < 16; ++patch) {
        InputFace face;
        const int column = patch % 4, row = patch / 4;
        for (const auto& [dx, dy] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
          glm::dvec3 corner(0);
          corner[axis] = side;
          corner[(axis + 1) % 3] = (column + dx) / 4.0;
          corner[(axis + 2) % 3] = (row + dy) / 4.0;
          face.corners.push_back(corner);
        }
        if (side == 1) std::reverse(face.corners.begin(), face.corners.end());
        scene.faces.push_back(face);
      }
  return scene;
}

Scene makeScene(const std::string& name) {
  if (name == "cube") return buildScene(cubeOfPatches());
  if (name == "room4") return buildScene(roomWithBoxes(4));
  return loadScene(VIEWPEEL_SOURCE "/scenes/" + name + ".obj");
}

struct Difference {
  double rms = 0, largest = 0;
};

// Of form factors, over all ordered pairs of polygons.
Difference compare(const FormFactors& a, const FormFactors& b) {
  const std::vector<double>& areas = a.ids().areas;
  Difference difference;
  double squares = 0;
  auto at = a.entries().begin(), bt = b.entries().begin();
  while (at != a.entries().end() || bt != b.entries().end()) {
    const bool from_a = bt == b.entries().end() || (at != a.entries().end() && std::pair(at->i, at->j) <= std::pair(bt->i, bt->j));
    const bool from_b = at == a.entries().end() || (bt != b.entries().end() && std::pair(bt->i, bt->j) <= std::pair(at->i, at->j));
    const auto [i, j] = from_a ? std::pair(at->i, at->j) : std::pair(bt->i, bt->j);
    const double error = (from_a ? (at++)->exchange_area.value : 0) - (from_b ? (bt++)->exchange_area.value : 0);
    if (j >= kEnvironment || i == j) continue;
    for (double area : {areas[i], areas[j]}) {
      squares += error * error / (area * area);
      difference.largest = std::max(difference.largest, std::abs(error) / area);
    }
  }
  const auto n = double(areas.size());
  difference.rms = std::sqrt(squares / (n * (n - 1)));
  return difference;
}

struct Case {
  const Device& device;
  const Scene scene;
  const Ids ids;

  // Compiled and tuned; seconds are those of the run, with shares and closed forms.
  std::pair<FormFactors, double> run(int resolution, uint32_t directions, uint32_t replicates, uint64_t seed, bool closed_forms) const {
    const auto engine = makeComputeEngine(device, scene, ids, {.resolution = resolution, .count_blocked = closed_forms});
    engine->count(sampleDirections(Sampler::fibonacci, 64, 5, 0));
    EstimateOptions options{.directions = directions, .replicates = replicates, .seed = seed};
    const auto start = Clock::now();
    VisibleShares shares;
    FaceExchanges exchanges(&device, scene, ids);
    if (closed_forms) {
      shares = findVisibleShares(*engine, exchanges, scene, ids, groupAsOne(scene, resolution), options, pilotDirections(options));
      options.known = &shares.known;
      options.exchanges = &exchanges;
    }
    FormFactors result = estimateFormFactors(*engine, scene, ids, options).form_factors;
    return {std::move(result), secondsSince(start)};
  }
};

// Of what is exact but for closed forms, or the mean of two halves; and its error.
std::pair<FormFactors, double> makeReference(const std::string& name, const Case& scene_case, uint32_t directions) {
  if (name == "cube") {
    std::vector<FormFactors::Entry> exact;
    const auto cornersOf = [&](uint32_t k) {
      const auto first = scene_case.scene.corners.begin() + scene_case.scene.polygons[k].first_corner;
      return std::vector<glm::dvec3>(first, first + scene_case.scene.polygons[k].corner_count);
    };
    for (uint32_t i = 0; i < scene_case.ids.count(); ++i)
      for (uint32_t j = i + 1; j < scene_case.ids.count(); ++j) exact.push_back({i, j, {reference::formFactor(cornersOf(i), cornersOf(j)) * scene_case.ids.areas[i], 0}});
    return {FormFactors(scene_case.ids, std::move(exact), {}), 0};
  }
  const FormFactors a = scene_case.run(256, directions / 16, 8, 77, true).first, b = scene_case.run(256, directions / 16, 8, 78, true).first;
  std::vector<FormFactors::Entry> mean;
  for (const FormFactors* half : {&a, &b})
    for (FormFactors::Entry entry : half->entries()) {
      entry.exchange_area.value /= 2;
      mean.push_back(entry);
    }
  std::sort(mean.begin(), mean.end(), [](const auto& x, const auto& y) { return std::pair(x.i, x.j) < std::pair(y.i, y.j); });
  std::vector<FormFactors::Entry> merged;
  for (const FormFactors::Entry& entry : mean) {
    if (!merged.empty() && merged.back().i == entry.i && merged.back().j == entry.j) merged.back().exchange_area.value += entry.exchange_area.value;
    else merged.push_back(entry);
  }
  return {FormFactors(a.ids(), std::move(merged), a.rowSums()), compare(a, b).rms / 2};
}

// Seconds to `goal`: of the quickest run that reaches it, else along a line through the runs that no other beats in both time and error.
double secondsTo(double goal, std::vector<std::pair<double, double>> runs) {
  std::sort(runs.begin(), runs.end());
  for (const auto& [time, error] : runs)
    if (error <= goal) return time;
  std::vector<double> seconds, errors;
  for (const auto& [time, error] : runs)
    if (errors.empty() || error < errors.back()) seconds.push_back(time), errors.push_back(error);
  if (errors.size() < 3) return NAN;
  const PowerLaw law = fitPowerLaw(seconds, errors);
  return std::exp((std::log(goal) - law.intercept) / law.exponent);
}

void measureScene(const std::string& name, const Device& device, const Options& options) {
  const Scene scene = makeScene(name);
  const Case scene_case{device, scene, makeIds(scene, By::polygon, false)};
  const auto [reference, reference_error] = makeReference(name, scene_case, options.reference);
  fmt::print("# {}: {} polygons; rms error of the reference {:.1e}\n", name, scene_case.ids.count(), reference_error);
  std::array<std::vector<std::pair<double, double>>, 2> rms, largest;
  // Interleaved, so that both meet the same machine.
  for (int resolution : options.resolutions)
    for (uint32_t directions : options.directions)
      for (const bool closed_forms : {false, true}) {
        const auto [result, seconds] = scene_case.run(resolution, directions, 8, 1, closed_forms);
        const Difference error = compare(result, reference);
        fmt::print("{},{},{},{},{},{:.4g},{:.4g},{:.4g}\n", name, scene_case.ids.count(), closed_forms ? "on" : "off", resolution, directions, seconds, error.rms, error.largest);
        std::fflush(stdout);
        if (error.rms < 3 * reference_error) continue;
        rms[closed_forms].push_back({seconds, error.rms});
        largest[closed_forms].push_back({seconds, error.largest});
      }
  for (const bool closed_forms : {false, true}) {
    fmt::print("# {} closed forms {}: seconds to rms", name, closed_forms ? "on" : "off");
    for (double goal : kRmsGoals) fmt::print(" {:.0e}: {:.2g}", goal, secondsTo(goal, rms[closed_forms]));
    fmt::print("; to largest");
    for (double goal : kLargestGoals) fmt::print(" {:.0e}: {:.2g}", goal, secondsTo(goal, largest[closed_forms]));
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  using namespace viewpeel::bench;
  CLI::App app("Time to a given error, with and without closed forms", "share_error");
  Options options;
  app.add_option("--scene", options.scenes, "cube, office, room4")->check(CLI::IsMember({"cube", "office", "room4"}))->capture_default_str();
  app.add_option("--resolution", options.resolutions, "Spacings across the scene")->capture_default_str();
  app.add_option("--directions", options.directions, "Directions of a replicate")->capture_default_str();
  app.add_option("--reference", options.reference, "Directions of the reference where there is no closed form")->capture_default_str();
  app.add_option("--device", options.device.selector, "As for viewpeel");
  CLI11_PARSE(app, argc, argv);
  try {
    const Device device(options.device);
    printPlace(device, VIEWPEEL_SOURCE);
    fmt::print("scene,polygons,closed_forms,resolution,directions,seconds,rms_error,largest_error\n");
    for (const std::string& scene : options.scenes) measureScene(scene, device, options);
  } catch (const Error& error) {
    fmt::print(stderr, "share_error: {}\n", error.what());
    return 1;
  }
}
