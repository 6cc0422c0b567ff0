#include <chrono>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/options.h"
#include "cli/summary.h"
#include "error.h"
#include "io/write_form_factors.h"
#include "matrix/closure.h"
#include "reference/exact_engine.h"

namespace viewpeel::cli {
namespace {

struct ProgramOptions {
  std::string scene;
  std::vector<std::string> outputs;
  By by = By::polygon;
  EngineKind engine = EngineKind::compute;
  LatticeOptions lattice;
  bool two_sided = false;
  DeviceOptions device;
  EstimateOptions estimate;
  Question question;
  bool whole_sphere = false;  // a sampler was asked for by name
  bool closure = false;
  bool quiet = false, verbose = false, json = false;
};

const std::vector<std::pair<std::string, Sampler>> kSamplers = {
    {"fibonacci", Sampler::fibonacci}, {"jittered", Sampler::jittered}, {"sobol", Sampler::sobol}, {"iid", Sampler::iid}};

std::string nameOf(Sampler sampler) {
  for (const auto& [name, value] : kSamplers)
    if (value == sampler) return name;
  return {};
}

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// One line on the terminal, rewritten after every batch of directions and every replicate.
class ProgressLine {
 public:
  explicit ProgressLine(const EstimateOptions& options) : options_(options) {}
  void onBatch(uint64_t directions) {
    directions_ = directions;
    show();
  }
  void onReplicate(const EstimateProgress& progress) {
    progress_ = progress;
    directions_ = 0;
    show();
  }

 private:
  void show() {
    if (secondsSince(shown_) < 0.1) return;
    shown_ = Clock::now();
    std::string goal = fmt::format("of {}", options_.replicates);
    if (options_.relative && progress_.replicates) goal = fmt::format("goal {:.1e} of a form factor", *options_.relative);
    else if (options_.seconds && progress_.replicates) goal = fmt::format("largest standard error {:.1e}, until {:.0f} s", progress_.largest_standard_error, *options_.seconds);
    else if (options_.tolerance && progress_.replicates) goal = fmt::format("largest standard error {:.1e}, goal {:.1e}", progress_.largest_standard_error, *options_.tolerance);
    fmt::print(stderr, "\r\033[Kreplicate {} {}, direction {} of {}, {:.1f} s", progress_.replicates + 1, goal, directions_, options_.directions, secondsSince(start_));
    std::fflush(stderr);
  }

  const EstimateOptions& options_;
  EstimateProgress progress_;
  uint64_t directions_ = 0;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
};

// Fewer directions where not everything is asked for. Returns how they are drawn, in words.
std::string askDirections(const Question& question, const Scene& scene, bool two_sided, EstimateOptions& estimate) {
  if (!question.pair.empty()) {
    const DirectionRegion region = findPairRegion(scene, findPolygons(scene, question.pair[0]), findPolygons(scene, question.pair[1]), two_sided);
    estimate.asked_directions = [region, &estimate](uint64_t replicate) { return sampleRegion(region, estimate.directions, estimate.seed, replicate); };
    return region.isEmpty() ? "but none in which a front of one sees a front of the other"
                            : fmt::format("in the pair's anti-convex-hull, {:.3g} % of a half sphere", region.solidAngle() / (2 * std::numbers::pi) * 100);
  }
  std::vector<uint32_t> emitter;
  for (const std::string& name : question.from) {
    const std::vector<uint32_t> polygons = findPolygons(scene, name);
    emitter.insert(emitter.end(), polygons.begin(), polygons.end());
  }
  estimate.asked_directions = [emitter, &scene, &estimate](uint64_t replicate) { return sampleEmitter(scene, emitter, estimate.directions, estimate.seed, replicate); };
  const bool planar = std::all_of(emitter.begin(), emitter.end(), [&](uint32_t k) {
    const Polygon &a = scene.polygons[k], &b = scene.polygons[emitter[0]];
    return glm::dot(scene.planes[a.plane].normal, scene.planes[b.plane].normal) * (a.front_along_plane_normal == b.front_along_plane_normal ? 1 : -1) > 1 - 1e-9;
  });
  return planar ? "by the emitter's cosine" : "fibonacci";
}

// Where closure is refused the form factors are written as measured.
ClosedFormFactors closeOrKeep(const FormFactors& measured, const std::vector<std::string>& outputs) {
  try {
    return closeRows(measured);
  } catch (const Error& error) {
    for (const std::string& output : outputs) writeFormFactors(measured, output);
    throw Error(error.code(), fmt::format("{}{}", error.what(), outputs.empty() ? "" : "; form factors were written as measured"));
  }
}

int runCompute(ProgramOptions options) {
  if (options.closure && !options.question.isEverything()) throw Error(ErrorCode::bad_usage, kClosureNeedsEveryRow);
  for (const std::string& output : options.outputs) checkOutput(output, options.closure);
  const Scene scene = loadScene(options.scene);
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "viewpeel: warning: {}\n", warning);
  Ids ids = makeIds(scene, options.by, options.two_sided);
  askOnlyFor(options.question, scene, ids);
  if (!ids.roles.empty() && options.engine == EngineKind::graphics)
    throw Error(ErrorCode::bad_usage, "--from, --pair and --blocker need --engine compute or exact");
  if (options.lattice.sampling == Sampling::scanline && options.engine != EngineKind::compute)
    throw Error(ErrorCode::bad_usage, "--sampling scanline needs --engine compute");
  std::string sampler = nameOf(options.estimate.sampler);
  if (!options.whole_sphere && (!options.question.pair.empty() || (!options.question.from.empty() && !options.two_sided)))
    sampler = askDirections(options.question, scene, options.two_sided, options.estimate);
  std::optional<Device> device;
  if (options.engine != EngineKind::exact) device.emplace(options.device);
  const bool talks = !options.quiet && !options.json;
  if (talks) {
    fmt::print("{}{}", device ? describeDevice(*device) : "device     none: exact areas on the CPU\n", describeScene(scene));
    fmt::print("sampling   {} directions a replicate, {}; {}; seed {}\n", options.estimate.directions, sampler,
               device ? fmt::format("{} {} across", options.lattice.sampling == Sampling::scanline ? "scanlines" : "lattice", options.lattice.resolution) : "exact areas",
               options.estimate.seed);
    std::fflush(stdout);
  }

  const auto start = Clock::now();
  const bool show_progress = !options.quiet && ::isatty(STDERR_FILENO);
  ProgressLine progress(options.estimate);
  if (show_progress) {
    options.estimate.on_replicate = [&](const EstimateProgress& p) { progress.onReplicate(p); };
    options.lattice.on_batch = [&](uint64_t directions) { progress.onBatch(directions); };
  }
  options.lattice.measure_work = options.json;
  const auto engine = device ? makeLatticeEngine(options.engine, *device, scene, ids, options.lattice) : reference::makeExactEngine(scene, ids);
  const std::string plan = engine->describePlan();
  if (options.verbose && talks) fmt::print("{}", plan);
  const Estimate estimate = estimateFormFactors(*engine, scene, ids, options.estimate);
  if (show_progress) fmt::print(stderr, "\r\033[K");
  if (device) checkValidation(*device);
  const double seconds = secondsSince(start);

  std::optional<ClosedFormFactors> closed;
  if (options.closure) closed = closeOrKeep(estimate.form_factors, options.outputs);
  for (const std::string& output : options.outputs) writeFormFactors(estimate.form_factors, output, closed ? &closed->form_factors : nullptr);
  if (options.json)
    fmt::print("{}", asJson(options.scene, device ? device->description().name : "none", estimate, seconds, engine->work(), closed ? &*closed : nullptr));
  if (!talks) return 0;
  if (options.verbose && engine->describePlan() != plan) fmt::print("after a trial\n{}", engine->describePlan());
  if (estimate.form_factors.entries().empty()) fmt::print("\nNothing that was asked for sees anything: every form factor is 0.\n\n");
  else if (ids.splits_surfaces) fmt::print("\nlargest form factors\n{}\n", tabulateLargest(estimate.form_factors, 20));
  else fmt::print("\nlargest form factors between surfaces\n{}\n", tabulateLargest(estimate.between_surfaces, 20));
  fmt::print("{}{}", describeErrors(estimate), closed ? describeClosed(*closed) : "");
  fmt::print("work       {} replicates, {} directions, {:.2f} s\n", estimate.replicates, estimate.directions, seconds);
  for (const std::string& output : options.outputs)
    for (const std::filesystem::path& file : filesOf(output, options.closure)) fmt::print("written    {}\n", file.string());
  return 0;
}

std::string isPositive(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value) ? "" : text + " is not a number above 0";
}

}  // namespace

void addCompute(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<ProgramOptions>();
  EstimateOptions& estimate = options->estimate;
  CLI::App* command = app.add_subcommand("compute", "Compute the form factors of a scene");
  command->add_option("SCENE", options->scene, "Scene file: .obj, .stl or .ply")->required();
  command->add_option("-o,--output", options->outputs, "Write the matrix: .csv or .mtx; may be given several times")
      ->type_name("FILE")->allow_extra_args(false);
  auto tolerance = std::make_shared<double>(0);
  CLI::Option* tolerance_option =
      command->add_option("--tolerance", *tolerance, "Go on until the largest standard error of all form factors is at most this")
          ->type_name("T")->check(isPositive);
  auto relative = std::make_shared<double>(0), seconds = std::make_shared<double>(0);
  CLI::Option* relative_option =
      command->add_option("--relative", *relative, "Go on until the largest standard error is at most this share of its form factor, over those above --floor")
          ->type_name("R")->check(isPositive);
  command->add_option("--floor", estimate.relative_floor, "Least form factor that --relative looks at")->type_name("F")->check(isPositive)->capture_default_str();
  CLI::Option* seconds_option =
      command->add_option("--seconds", *seconds, "As many replicates as fit into this time, 2 at least; with a goal: stop short of it when time is up")
          ->type_name("S")->check(isPositive);
  command->add_option("--directions", estimate.directions, "Directions per replicate")
      ->type_name("N")->check(CLI::Range(1u, 1u << 30).description(""))->capture_default_str();
  command->add_option("--replicates", estimate.replicates, "Independent replicates, at least; their spread gives the standard errors")
      ->type_name("R")->check(CLI::Range(2u, 1u << 30).description(""))->capture_default_str();
  command->add_option("--resolution", options->lattice.resolution, "Lattice spacings across the scene's diameter")
      ->type_name("PX")->check(CLI::Range(1, kMaxResolution).description(""))->capture_default_str();
  addChoice(command, "--by", options->by, {{"polygon", By::polygon}, {"surface", By::surface}}, "One row per polygon or per named surface");
  addChoice(command, "--engine", options->engine, {{"compute", EngineKind::compute}, {"graphics", EngineKind::graphics}, {"exact", EngineKind::exact}},
            "Depth peeling on a Vulkan device, in compute shaders or by its raster pipeline, or exact areas on the CPU");
  addChoice(command, "--sampling", options->lattice.sampling, {{"lattice", Sampling::lattice}, {"scanline", Sampling::scanline}},
            "Samples of a direction: lattice points, or lattice rows cut where polygons end (engine compute)");
  addChoice(command, "--sampler", estimate.sampler, kSamplers,
            "Directions over the sphere: rotated Fibonacci sets, one in each of as many cells, scrambled Sobol' points, or independent. Without it --from and "
            "--pair draw better ones");
  command->add_option("--from", options->question.from, "Only the rows of this surface or face; may be given several times")->type_name("NAME")->allow_extra_args(false);
  command->add_option("--pair", options->question.pair, "Only the form factors between two surfaces or faces")->type_name("A B")->expected(0, 2);
  command->add_option("--blocker", options->question.blockers, "A surface or face that only blocks; may be given several times")->type_name("NAME")->allow_extra_args(false);
  command->add_flag("--closure", options->closure, "Closed scenes: also the nearest form factors whose rows sum to 1, beside those measured");
  command->add_option("--seed", estimate.seed, "The same seed gives the same bits")->type_name("K")->capture_default_str();
  command->add_flag("--two-sided", options->two_sided, "Every polygon emits and receives on both sides");
  command->add_option("--device", options->device.selector, "Vulkan device: index, part of its name, cpu or gpu")->type_name("DEVICE");
  command->add_option("--batch", options->lattice.batch_directions, "Directions peeled at once; 0 chooses. Never changes the result")
      ->type_name("N")->capture_default_str();
  command->add_flag("--quiet", options->quiet, "Print nothing but errors and warnings");
  command->add_flag("--verbose", options->verbose, "Print how work and memory are divided, too");
  command->add_flag("--json", options->json, "Print the outcome and the work done as JSON");
  command->callback([=, &chosen] {
    if (tolerance_option->count()) options->estimate.tolerance = *tolerance;
    if (relative_option->count()) options->estimate.relative = *relative;
    if (seconds_option->count()) options->estimate.seconds = *seconds;
    options->whole_sphere = command->get_option("--sampler")->count() > 0;
    chosen = [options] { return runCompute(*options); };
  });
}

}  // namespace viewpeel::cli
