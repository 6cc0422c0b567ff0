// This bench measures the error that each method reaches in a given time. All methods compute all form factors of a
// scene, viewpeel and its rivals, in one run on one machine. It prints CSV on stdout.
//   error_time [--scene NAME]... [--method NAME]... [--full] [--seconds S] [--reference-seconds S]
//   [--reference-method M [--reference-amount A]] [--rounds K] [--repeats K] [--view3d PROGRAM] [--view3d-most N]
//   [--cache DIR] [--device D]
// Methods are made in methods.cpp. `planned` is the program's default, planned_directions leaves out pair lines, and
// fixed leaves out the plan. The time of these three includes the whole start. fibonacci, jittered and iid also exist
// with unoccluded form factors. host and host_unoccluded are scanlines on the processor; there are scanline, graphics
// and exact too. Rivals are rays_random, rays_sobol, double_area_random and double_area_sobol (embree_rays.h, where
// Embree is installed), hemicube (hemicube.h) and view3d (view3d.h). Rivals are verified first (verify_rivals.h).
// Each method climbs a ladder of growing work until its next run would take longer than --seconds. Short runs are
// repeated with other seeds. A round climbs all ladders.
// Columns: `seconds` is the time from a method that is ready to its result. setup_seconds is the time that makes it
// ready (kernels compiled, trees built). Errors are explained in exchange_matrix.h. environment_* are errors of
// environment and leak together, as the method states them, or as 1 less the row. reference_error is the rms error of
// the reference. `chosen` lists parameters that a method chose itself. waiting_share is the share of `seconds` in which
// the calling thread does not compute. `passes` are shares of the time on the device, measured over other directions.
// The reference is a run by directions without pair lines, or by --reference-method. Embree's rays are no reference
// below 3e-3: rays start a little off the edge that two triangles share, so that kerbs in city1000 are off by 2.3e-3
// for any number of rays. A reference is limited by time, so one in --cache that was made on a busy machine is poor and
// should be deleted.
// bench/plot makes tables of times to errors.
#include <algorithm>
#include <fstream>
#include <optional>
#include <set>

#include <CLI/CLI.hpp>

#include <viewpeel/error.h>
#include "scenes/generate.h"
#include "scenes/triangulated_city.h"
#include "bench/support/measure.h"
#include "memory.h"
#include "bench/rivals/methods.h"
#include "bench/rivals/ray_ladders.h"
#include "bench/rivals/reference_matrix.h"
#include "bench/rivals/verify_rivals.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kMostRepeats = 8;
constexpr double kHopeless = 20;  // a method whose shortest run takes this times --seconds gets no finer lattices

struct Options {
  std::vector<std::string> scenes{"plates", "cube", "office"}, methods;
  std::string reference_method;  // empty: viewpeel itself
  double seconds = 0.5, reference_seconds = 20;
  std::optional<double> reference_amount;
  uint32_t rounds = 1;
  uint64_t repeats = kMostRepeats;  // repeats of a short run within a round
  std::string cache = "build/references";
  MethodOptions method;
  DeviceOptions device;
};

// Returns a named scene. Its faces are quadrilaterals or triangles, so that faces are polygons.
Scene makeScene(const std::string& name) {
  const auto office = [](uint32_t refine) {
    return buildScene(refined(loadScene(VIEWPEEL_SOURCE "/scenes/office.obj"), refine));
  };
  if (name == "plates") return buildScene(twoPlates(1));
  if (name == "cube") return buildScene(cubeOfPatches(4));
  if (name == "office") return office(1);
  if (name == "office2") return office(2);
  if (name == "office4") return office(4);
  if (name == "room") return buildScene(roomWithBoxes(1));
  if (name == "room2") return buildScene(roomWithBoxes(2));
  if (name == "room4") return buildScene(roomWithBoxes(4));
  if (name == "city1000") return buildScene(triangulatedCity(1000).scene);
  if (name == "city2900") return buildScene(triangulatedCity(2900).scene);
  if (name == "city4200") return buildScene(triangulatedCity(4200).scene);
  if (name == "city6600") return buildScene(triangulatedCity(6600).scene);
  if (name == "city") return buildScene(city(5000));
  return buildScene(spreadOfSizes());
}
const std::vector<std::string> kScenes{"plates", "cube",  "sizes", "office",   "office2",  "office4",  "city",
                                       "room",   "room2", "room4", "city1000", "city2900", "city4200", "city6600"};

bool hasClosedForms(const std::string& scene) { return scene == "plates" || scene == "cube"; }

// Resets the peak of memory, where the system allows it.
void resetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

double peakMib() {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kib = 0;
  while (status >> word)
    if (word == "VmHWM:") status >> kib;
  return kib / 1024;
}

std::string inQuotes(const std::string& text) { return "\"" + text + "\""; }

bool isRequested(const std::string& method, const Options& options) {
  return options.methods.empty() ||
         std::find(options.methods.begin(), options.methods.end(), method) != options.methods.end();
}

struct Place {
  std::string commit, device, driver;
};

// Returns the first four columns of a row: commit, device, driver, number of processors.
std::string describe(const Place& place, const Ladder& ladder) {
  const std::string device = ladder.on_device ? place.device : "CPU";
  const std::string driver =
      ladder.on_device                                                                             ? place.driver
      : ladder.method == "view3d" || ladder.method == "exact" || ladder.method.starts_with("host") ? "none"
                                                                                                   : describeRays();
  return fmt::format("{},{},{},{}", place.commit, inQuotes(device), inQuotes(driver),
                     std::thread::hardware_concurrency());
}

// Runs one method with growing work, and prints a row a run. Returns the first run's seconds, or 0 if it was refused.
double climb(const Ladder& ladder, const std::string& scene_name, const std::vector<double>& areas,
             const ReferenceMatrix& reference, uint64_t round, const Place& place, const Options& options) {
  double first_seconds = 0;
  try {
    const Runner runner = ladder.set_up();
    double least_s_per_cost = INFINITY;
    for (size_t k = 0; k < ladder.rungs.size(); ++k) {
      const Ladder::Rung& rung = ladder.rungs[k];
      // The first runs have fixed costs, which do not grow with the amount.
      if (k > 0 && rung.cost * least_s_per_cost > (k < 3 ? 4 : 1) * options.seconds) break;
      double spent_s = 0;
      for (uint64_t repeat = 0;
           repeat < options.repeats && (repeat == 0 || spent_s * double(repeat + 1) / double(repeat) < options.seconds);
           ++repeat) {
        const uint64_t seed = round * kMostRepeats + repeat + 1;
        resetPeak();
        const Outcome outcome = runner.run(rung.amount, seed);
        const double seconds = outcome.time.seconds;
        if (first_seconds == 0) first_seconds = seconds;
        spent_s += seconds;
        least_s_per_cost = std::min(least_s_per_cost, seconds / rung.cost);
        const std::string parameters = fmt::format("{}{}={:.10g}", ladder.parameters, ladder.amount_name, rung.amount);
        const double device_mib = double(runner.profile.device_bytes) / (1 << 20), peak_mib = peakMib();
        const MatrixError error = errorOf(outcome.exchange, reference.exchange, areas);
        const RestError rest_error =
            errorOfRest(outcome.rest.empty() ? restOf(outcome.exchange, areas) : outcome.rest, reference.rest, areas);
        const std::string standard_error = outcome.standard_error ? fmt::format("{:.4g}", *outcome.standard_error) : "";
        fmt::print("{},{},{},{},{},{},{},{},", describe(place, ladder), scene_name, reference.exchange.count(),
                   ladder.method, seed, inQuotes(parameters), inQuotes(runner.chosen + outcome.chosen), round);
        fmt::print("{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{},{:.3g},", runner.setup_seconds, seconds, error.rms,
                   error.largest, error.weighted_rms, error.weighted_largest, standard_error, reference.error.rms);
        fmt::print("{:.4g},{:.4g},{:.3f},{:.0f},{:.0f},{},", outcome.time.cpu_seconds, outcome.time.host_seconds,
                   1 - outcome.time.host_seconds / seconds, peak_mib, device_mib, inQuotes(runner.profile.passes));
        fmt::print("{:.4g},{:.4g},{:.3g}\n", rest_error.rms, rest_error.largest,
                   std::max(reference.error.largest, reference.largest_rest_error));
        std::fflush(stdout);
      }
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::limit && error.code() != ErrorCode::bad_input) throw;
    fmt::print("# {} {}{} refused: {}\n", scene_name, ladder.parameters, ladder.method, error.what());
  }
  return first_seconds;
}

ReferenceMatrix makeReference(const Device& device, const Scene& scene, const std::string& name,
                              const std::vector<Ladder>& ladders, const Options& options) {
  if (hasClosedForms(name)) return referenceByClosedForms(scene);
  if (options.reference_method.empty())
    return referenceByLongRun(device, scene, name, options.reference_seconds, options.cache);
  for (const Ladder& ladder : ladders)
    if (ladder.method == options.reference_method)
      return referenceByMethod(ladder, scene, name, {options.reference_seconds, options.reference_amount},
                               options.cache);
  throw Error(ErrorCode::bad_usage,
              fmt::format("--reference-method {}: no such method here; choose one of methods.cpp, those of Embree only "
                          "where it is installed",
                          options.reference_method));
}

void measureScene(const std::string& name, const Device& device, const Place& place, const Options& options) {
  const Scene scene = makeScene(name);
  if (scene.faces.size() != scene.polygons.size()) throw Error(ErrorCode::check, name + ": faces were split");
  std::vector<double> areas;
  for (const Polygon& polygon : scene.polygons) areas.push_back(polygon.area);
  const std::vector<Ladder> ladders = makeLadders(device, scene, options.method);
  const ReferenceMatrix reference = makeReference(device, scene, name, ladders, options);
  fmt::print("# {}: {} polygons; reference: {}; its own error: rms {:.1e}, largest {:.1e}\n", name,
             scene.polygons.size(), reference.source, reference.error.rms, reference.error.largest);
  std::fflush(stdout);
  std::set<std::string> too_slow;  // methods whose shortest run takes too long; their finer lattices take longer still
  for (uint64_t round = 0; round < options.rounds; ++round)
    for (const Ladder& ladder : ladders) {
      if (!isRequested(ladder.method, options)) continue;
      if (too_slow.contains(ladder.method)) {
        fmt::print("# {} {}{} left out: a coarser one took more than {} times --seconds\n", name, ladder.parameters,
                   ladder.method, kHopeless);
        continue;
      }
      if (climb(ladder, name, areas, reference, round, place, options) > kHopeless * options.seconds)
        too_slow.insert(ladder.method);
    }
}

void run(const Options& options) {
  const Device device(options.device);
  printPlace(device, VIEWPEEL_SOURCE);
  const Place place{commitOf(VIEWPEEL_SOURCE), device.description().name, device.description().driver};
  const std::vector<std::string> rivals = rivalNames();
  if (std::any_of(rivals.begin(), rivals.end(), [&](const std::string& rival) { return isRequested(rival, options); }))
    verifyRivals(device);
  fmt::print(
      "commit,device,driver,cores,scene,n,method,seed,parameters,chosen,round,setup_seconds,seconds,rms_error,max_"
      "error,weighted_rms_error,"
      "weighted_max_error,standard_error,reference_error,cpu_seconds,host_seconds,waiting_share,resident_mib,device_"
      "mib,passes,environment_rms_error,environment_max_error,reference_max_error\n");
  for (const std::string& scene : options.scenes) measureScene(scene, device, place, options);
  if (!device.validationErrors().empty()) throw Error(ErrorCode::device, device.validationErrors().front());
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  keepFreedMemory();
  bench::Options options;
  CLI::App app("Error of all form factors of a scene against time, viewpeel and its rivals: CSV on stdout",
               "error_time");
  app.add_option("--scene", options.scenes,
                 "plates, cube, sizes, office, office2, office4, city, room, room2, room4, city1000, city2900, "
                 "city4200, city6600")
      ->check(CLI::IsMember(bench::kScenes))
      ->allow_extra_args(false)
      ->capture_default_str();
  app.add_option("--method", options.methods, "Only these")->allow_extra_args(false);
  app.add_flag("--full", options.method.full, "Every resolution");
  app.add_option("--seconds", options.seconds, "The longest run of a method")
      ->check(CLI::PositiveNumber)
      ->take_last()
      ->capture_default_str();
  app.add_option("--reference-seconds", options.reference_seconds, "Of a long run where there are no closed forms")
      ->check(CLI::PositiveNumber)
      ->take_last()
      ->capture_default_str();
  app.add_option(
         "--reference-method", options.reference_method,
         "Another method than viewpeel to compute references with; its first ladder, --reference-seconds in all")
      ->take_last();
  app.add_option("--reference-amount", options.reference_amount,
                 "What each of the eight runs of --reference-method gets, such as a tolerance, in place of a time")
      ->take_last();
  app.add_option("--rounds", options.rounds, "Of all ladders, each with other seeds")
      ->check(CLI::PositiveNumber)
      ->take_last()
      ->capture_default_str();
  app.add_option("--repeats", options.repeats, "Of a run that is shorter than --seconds, with other seeds, at most")
      ->check(CLI::Range(uint64_t(1), bench::kMostRepeats))
      ->take_last()
      ->capture_default_str();
  app.add_option("--view3d", options.method.view3d, "View3D's program, run as PROGRAM IN.vs3 OUT.txt");
  app.add_option("--view3d-most", options.method.view3d_most_polygons, "Polygons; in larger scenes View3D is left out")
      ->take_last()
      ->capture_default_str();
  app.add_option("--cache", options.cache, "Directory for references, and for View3D's files")->capture_default_str();
  app.add_option("--device", options.device.selector, "As for viewpeel");
  CLI11_PARSE(app, argc, argv);
  options.method.work_directory = options.cache;
  try {
    bench::run(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error_time: {}\n", error.what());
    return 1;
  }
}
