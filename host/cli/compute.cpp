#include <chrono>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/options.h"
#include "cli/summary.h"
#include "error.h"
#include "io/write_form_factors.h"
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
  bool quiet = false;
};

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// One line on the terminal, rewritten after every replicate.
void showProgress(const EstimateProgress& progress, const EstimateOptions& options, Clock::time_point start) {
  std::string goal = fmt::format("of {}", options.replicates);
  if (options.tolerance) goal = fmt::format("largest standard error {:.1e}, goal {:.1e}", progress.largest_standard_error, *options.tolerance);
  fmt::print(stderr, "\r\033[Kreplicate {} {}, {:.1f} s", progress.replicates, goal, secondsSince(start));
  std::fflush(stderr);
}

int runCompute(ProgramOptions options) {
  for (const std::string& output : options.outputs) checkOutput(output);
  const Scene scene = loadScene(options.scene);
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "viewpeel: warning: {}\n", warning);
  const Ids ids = makeIds(scene, options.by, options.two_sided);
  std::optional<Device> device;
  if (options.engine != EngineKind::exact) device.emplace(options.device);
  if (!options.quiet) {
    fmt::print("{}{}", device ? describeDevice(*device) : "device     none: exact areas on the CPU\n", describeScene(scene));
    fmt::print("sampling   {} {} directions a replicate, {}, seed {}\n", options.estimate.directions,
               options.estimate.sampler == Sampler::fibonacci ? "fibonacci" : "iid",
               device ? fmt::format("lattice {} across", options.lattice.resolution) : "exact areas", options.estimate.seed);
    std::fflush(stdout);
  }

  const auto start = Clock::now();
  const bool show_progress = !options.quiet && ::isatty(STDERR_FILENO);
  if (show_progress)
    options.estimate.on_replicate = [&](const EstimateProgress& p) { showProgress(p, options.estimate, start); };
  const auto engine = device ? makeLatticeEngine(options.engine, *device, scene, ids, options.lattice) : reference::makeExactEngine(scene, ids);
  const Estimate estimate = estimateFormFactors(*engine, scene, ids, options.estimate);
  if (show_progress) fmt::print(stderr, "\r\033[K");
  if (device) checkValidation(*device);
  const double seconds = secondsSince(start);

  for (const std::string& output : options.outputs) writeFormFactors(estimate.form_factors, output);
  if (options.quiet) return 0;
  fmt::print("\nlargest form factors between surfaces\n{}\n{}", tabulateLargest(estimate.between_surfaces, 20), describeErrors(estimate));
  fmt::print("work       {} replicates, {} directions, {:.2f} s\n", estimate.replicates, estimate.directions, seconds);
  for (const std::string& output : options.outputs) fmt::print("written    {}\n", output);
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
  command->add_option("--directions", estimate.directions, "Directions per replicate")
      ->type_name("N")->check(CLI::Range(1u, 1u << 30).description(""))->capture_default_str();
  command->add_option("--replicates", estimate.replicates, "Independent replicates, at least; their spread gives the standard errors")
      ->type_name("R")->check(CLI::Range(2u, 1u << 30).description(""))->capture_default_str();
  command->add_option("--resolution", options->lattice.resolution, "Lattice spacings across the scene's diameter")
      ->type_name("PX")->check(CLI::Range(1, kMaxResolution).description(""))->capture_default_str();
  addChoice(command, "--by", options->by, {{"polygon", By::polygon}, {"surface", By::surface}}, "One row per polygon or per named surface");
  addChoice(command, "--engine", options->engine, {{"compute", EngineKind::compute}, {"graphics", EngineKind::graphics}, {"exact", EngineKind::exact}},
            "Depth peeling on a Vulkan device, in compute shaders or by its raster pipeline, or exact areas on the CPU");
  addChoice(command, "--sampler", estimate.sampler, {{"fibonacci", Sampler::fibonacci}, {"iid", Sampler::iid}},
            "Directions: rotated Fibonacci sets, or independent");
  command->add_option("--seed", estimate.seed, "The same seed gives the same bits")->type_name("K")->capture_default_str();
  command->add_flag("--two-sided", options->two_sided, "Every polygon emits and receives on both sides");
  command->add_option("--device", options->device.selector, "Vulkan device: index, part of its name, cpu or gpu")->type_name("DEVICE");
  command->add_option("--batch", options->lattice.batch_directions, "Directions peeled at once; 0 chooses. Never changes the result")
      ->type_name("N")->capture_default_str();
  command->add_flag("--quiet", options->quiet, "Print nothing but errors and warnings");
  command->callback([=, &chosen] {
    if (tolerance_option->count()) options->estimate.tolerance = *tolerance;
    chosen = [options] { return runCompute(*options); };
  });
}

}  // namespace viewpeel::cli
