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
#include "estimator/guarantee.h"
#include "estimator/plan.h"
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
  Question question;
  bool whole_sphere = false;  // a sampler was asked for by name
  bool plans = true;          // directions and, where 0, resolution
  int resolution = 0, finest = 0;
  std::optional<double> epsilon;  // guarantee mode
  double delta = 0.01;
  Statistic statistic = Statistic::mean;
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
  void onBlock(const GuaranteeProgress& progress) {
    if (secondsSince(shown_) < 0.1) return;
    shown_ = Clock::now();
    fmt::print(stderr, "\r\033[Kblock {} of {} expected, {} at most, {:.1f} s", progress.blocks, progress.expected_blocks, progress.most_blocks, secondsSince(start_));
    std::fflush(stderr);
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
    estimate.asked_directions = [region, seed = estimate.seed](uint32_t count, uint64_t replicate) { return sampleRegion(region, count, seed, replicate); };
    return region.isEmpty() ? "but none in which a front of one sees a front of the other"
                            : fmt::format("in the pair's anti-convex-hull, {:.3g} % of a half sphere", region.solidAngle() / (2 * std::numbers::pi) * 100);
  }
  std::vector<uint32_t> emitter;
  for (const std::string& name : question.from) {
    const std::vector<uint32_t> polygons = findPolygons(scene, name);
    emitter.insert(emitter.end(), polygons.begin(), polygons.end());
  }
  estimate.asked_directions = [emitter, &scene, seed = estimate.seed](uint32_t count, uint64_t replicate) { return sampleEmitter(scene, emitter, count, seed, replicate); };
  const bool planar = std::all_of(emitter.begin(), emitter.end(), [&](uint32_t k) {
    const Polygon &a = scene.polygons[k], &b = scene.polygons[emitter[0]];
    return glm::dot(scene.planes[a.plane].normal, scene.planes[b.plane].normal) * (a.front_along_plane_normal == b.front_along_plane_normal ? 1 : -1) > 1 - 1e-9;
  });
  return planar ? "by the emitter's cosine" : "fibonacci";
}

// What a run works on.
struct Session {
  ProgramOptions& options;
  const Scene scene;
  Ids ids;
  std::string sampler;  // in words
  std::optional<Device> device;

  explicit Session(ProgramOptions& asked);
  bool talks() const { return !options.quiet && !options.json; }
  Lattices lattices() const;
  void describe() const;
};

Session::Session(ProgramOptions& asked) : options(asked), scene(loadScene(asked.scene)), ids(makeIds(scene, asked.by, asked.two_sided)), sampler(nameOf(asked.estimate.sampler)) {
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "viewpeel: warning: {}\n", warning);
  askOnlyFor(options.question, scene, ids);
  if (!ids.roles.empty() && options.engine == EngineKind::graphics)
    throw Error(ErrorCode::bad_usage, "--from, --pair and --blocker need --engine compute or exact");
  if (options.lattice.sampling == Sampling::scanline && options.engine != EngineKind::compute)
    throw Error(ErrorCode::bad_usage, "--sampling scanline needs --engine compute");
  if (options.finest && (options.engine != EngineKind::compute || !ids.roles.empty()))
    throw Error(ErrorCode::bad_usage, "--finest needs --engine compute and the whole matrix");
  if (!options.whole_sphere && (!options.question.pair.empty() || (!options.question.from.empty() && !options.two_sided)))
    sampler = askDirections(options.question, scene, options.two_sided, options.estimate);
  if (options.engine != EngineKind::exact) device.emplace(options.device);
}

Lattices Session::lattices() const {
  const auto make = [this](const std::vector<SizeGroup>& groups) -> std::unique_ptr<Engine> {
    if (!device) return reference::makeExactEngine(scene, ids);
    LatticeOptions lattice = options.lattice;
    lattice.resolution = groups[0].resolution;
    return groups.size() > 1 ? makeGroupedEngine(*device, scene, ids, lattice, groups) : makeLatticeEngine(options.engine, *device, scene, ids, lattice);
  };
  return {make, options.resolution, options.engine == EngineKind::compute && ids.roles.empty() && !options.resolution};
}

// The lattices of groups of polygons.
std::string describeGroups(const std::vector<SizeGroup>& groups, Sampling sampling) {
  std::string text = fmt::format("{} {} across", sampling == Sampling::scanline ? "scanlines" : "lattice", groups[0].resolution);
  for (size_t g = 1; g < groups.size();) {
    size_t windows = 0, polygons = 0;
    const int resolution = groups[g].resolution;
    for (; g < groups.size() && groups[g].resolution == resolution; ++g, ++windows) polygons += groups[g].polygons.size();
    text += fmt::format(", {} in {} window{} on {} polygons", resolution, windows, windows == 1 ? "" : "s", polygons);
  }
  return text;
}

void Session::describe() const {
  fmt::print("{}{}", device ? describeDevice(*device) : "device     none: exact areas on the CPU\n", describeScene(scene));
  std::fflush(stdout);
}

void describeSampling(const Session& session, const std::vector<SizeGroup>& groups) {
  const EstimateOptions& estimate = session.options.estimate;
  fmt::print("sampling   {} directions a replicate, {}; {}; seed {}\n", estimate.directions, session.sampler,
             session.device ? describeGroups(groups, session.options.lattice.sampling) : "exact areas", estimate.seed);
  std::fflush(stdout);
}

// What a plan promises, and how to have the same run again.
void describePlan(const Session& session, const Plan& plan) {
  const EstimateOptions& estimate = session.options.estimate;
  const std::string what = estimate.relative && !estimate.tolerance ? " of its form factor" : "";
  const std::string finest = plan.finest > plan.groups[0].resolution || plan.groups.size() > 1 ? fmt::format(" --finest {}", plan.finest) : "";
  fmt::print("expected   largest standard error {:.1e}{} after {} replicates, {:.2g} s (found out in {:.2g} s); the same again: --directions {} --resolution {}{}\n",
             plan.standard_error, what, estimate.replicates, plan.seconds, plan.pilot_seconds, plan.directions, plan.groups[0].resolution, finest);
  std::fflush(stdout);
}

Plan choosePlan(const Session& session) {
  const ProgramOptions& options = session.options;
  if (session.device && options.plans) return planEstimate(session.scene, session.ids, options.estimate, session.lattices());
  Plan plan;
  plan.directions = options.estimate.directions;
  const int resolution = options.resolution ? options.resolution : options.lattice.resolution;
  plan.groups = options.finest ? planGroups(session.scene, session.ids, resolution, options.finest, double(plan.directions) * double(options.estimate.replicates))
                               : groupBySize(session.scene, std::vector<double>(session.scene.polygons.size(), 1), resolution);
  plan.engine = session.lattices().make_engine(plan.groups);
  return plan;
}

// A time for people.
std::string inWords(double seconds) {
  if (seconds < 120) return fmt::format("{:.2g} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} minutes", seconds / 60);
  if (seconds < 48 * 3600) return fmt::format("{:.0f} hours", seconds / 3600);
  return fmt::format("{:.3g} days", seconds / 86400);
}

GuaranteeOptions guaranteeOptions(const Session& session) {
  const EstimateOptions& estimate = session.options.estimate;
  const Sampler independent = session.options.statistic == Statistic::median ? Sampler::iid : Sampler::jittered;
  return {*session.options.epsilon, session.options.delta, session.options.statistic, session.options.whole_sphere ? estimate.sampler : independent, estimate.seed, {}};
}

void describeGuarantee(const Session& session, const GuaranteePlan& plan) {
  const bool is_median = session.options.statistic == Statistic::median;
  fmt::print("goal       every form factor within {} with probability {}: {:.0f} bounds at once, a direction adds at most {:.2f}\n", plan.epsilon, 1 - plan.delta,
             plan.bounds, plan.largest_range);
  fmt::print("sampling   {} directions; {}; seed {}\n", nameOf(guaranteeOptions(session).sampler),
             session.device ? describeGroups(plan.groups, session.options.lattice.sampling) : "exact areas", session.options.estimate.seed);
  if (is_median) fmt::print("plan       median of {} runs of {} directions, {}\n", plan.runs, plan.run_directions, inWords(plan.most_seconds));
  else
    fmt::print("plan       blocks of {} directions: {} by Hoeffding's bound, {}; {} ({}) expected, {} ({}) at least, by Bernstein's\n", plan.block_directions, plan.most_blocks,
               inWords(plan.most_seconds), plan.expected_blocks, inWords(plan.expected_seconds), plan.least_blocks, inWords(plan.least_seconds));
  fmt::print("beside     directions: Hoeffding {}; Pellegrini's Lemma 1 {:.3g} for one pair, {:.3g} for all; median of runs {:.3g}\n", plan.hoeffding, plan.lemma_1,
             plan.lemma_1_all, double(plan.runs) * double(plan.run_directions));
  std::fflush(stdout);
}

GuaranteePlan chooseGuarantee(const Session& session) {
  const ProgramOptions& options = session.options;
  GuaranteePlan plan = planGuarantee(session.scene, session.ids, guaranteeOptions(session), session.lattices(), options.lattice.sampling, !session.device);
  if (options.estimate.seconds && plan.least_seconds > *options.estimate.seconds)
    throw Error(ErrorCode::bad_usage, fmt::format("a guarantee of {} takes {} at least, {} at most, more than --seconds {}; ask for a larger --epsilon, or an estimate by --tolerance",
                                                  plan.epsilon, inWords(plan.least_seconds), inWords(plan.most_seconds), *options.estimate.seconds));
  return plan;
}

int runCompute(ProgramOptions options) {
  for (const std::string& output : options.outputs) checkOutput(output);
  const bool show_progress = !options.quiet && ::isatty(STDERR_FILENO);
  ProgressLine progress(options.estimate);
  if (show_progress) {
    options.estimate.on_replicate = [&](const EstimateProgress& p) { progress.onReplicate(p); };
    if (!options.epsilon) options.lattice.on_batch = [&](uint64_t directions) { progress.onBatch(directions); };
  }
  options.lattice.measure_work = options.json;
  const Session session(options);
  if (session.talks()) session.describe();

  const auto start = Clock::now();
  Plan plan;
  GuaranteePlan guarantee;
  if (options.epsilon) guarantee = chooseGuarantee(session);
  else plan = choosePlan(session);
  Engine& engine = options.epsilon ? *guarantee.engine : *plan.engine;
  if (!options.epsilon) options.estimate.directions = plan.directions;
  if (show_progress) fmt::print(stderr, "\r\033[K");
  if (session.talks()) {
    if (options.epsilon) describeGuarantee(session, guarantee);
    else describeSampling(session, plan.groups);
    if (plan.pilot_seconds > 0) describePlan(session, plan);
  }
  const std::string division = engine.describePlan();
  if (options.verbose && session.talks()) fmt::print("{}", division);
  GuaranteeOptions guaranteed;
  if (options.epsilon) guaranteed = guaranteeOptions(session);
  if (show_progress) guaranteed.on_block = [&](const GuaranteeProgress& p) { progress.onBlock(p); };
  const Estimate estimate = options.epsilon ? guaranteeFormFactors(session.scene, session.ids, guaranteed, guarantee)
                                            : estimateFormFactors(engine, session.scene, session.ids, options.estimate);
  if (show_progress) fmt::print(stderr, "\r\033[K");
  if (session.device) checkValidation(*session.device);
  const double seconds = secondsSince(start);

  for (const std::string& output : options.outputs) writeFormFactors(estimate.form_factors, output);
  if (options.json) fmt::print("{}", asJson(options.scene, session.device ? session.device->description().name : "none", estimate, seconds, engine.work()));
  if (!session.talks()) return 0;
  if (options.verbose && engine.describePlan() != division) fmt::print("after a trial\n{}", engine.describePlan());
  if (estimate.form_factors.entries().empty()) fmt::print("\nNothing that was asked for sees anything: every form factor is 0.\n\n");
  else if (session.ids.splits_surfaces) fmt::print("\nlargest form factors\n{}\n", tabulateLargest(estimate.form_factors, 20));
  else fmt::print("\nlargest form factors between surfaces\n{}\n", tabulateLargest(estimate.between_surfaces, 20));
  fmt::print("{}", describeErrors(estimate));
  fmt::print("work       {} {}, {} directions, {:.2f} s\n", estimate.replicates, !estimate.guarantee ? "replicates" : options.statistic == Statistic::median ? "runs" : "blocks",
             estimate.directions, seconds);
  for (const std::string& output : options.outputs) fmt::print("written    {}\n", output);
  return 0;
}

// Everything but the run.
int runPlan(ProgramOptions options) {
  const Session session(options);
  session.describe();
  if (options.epsilon) {
    const GuaranteePlan plan = chooseGuarantee(session);
    describeGuarantee(session, plan);
    fmt::print("{}", plan.engine->describePlan());
    if (session.device) checkValidation(*session.device);
    return 0;
  }
  if (!session.device) throw Error(ErrorCode::bad_usage, "plans are made for devices; leave out --engine exact");
  const Plan plan = planEstimate(session.scene, session.ids, options.estimate, session.lattices());
  options.estimate.directions = plan.directions;
  describeSampling(session, plan.groups);
  describePlan(session, plan);
  fmt::print("{}", plan.engine->describePlan());
  checkValidation(*session.device);
  return 0;
}

std::string isPositive(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value) ? "" : text + " is not a number above 0";
}

// What `compute` and `plan` share.
std::shared_ptr<ProgramOptions> addOptions(CLI::App* command) {
  auto options = std::make_shared<ProgramOptions>();
  EstimateOptions& estimate = options->estimate;
  command->add_option("SCENE", options->scene, "Scene file: .obj, .stl or .ply")->required();
  const auto addGoal = [&](const std::string& name, std::optional<double>& goal, const std::string& text, const std::string& type) {
    command->add_option_function<double>(name, [&goal](const double& value) { goal = value; }, text)->type_name(type)->check(isPositive);
  };
  addGoal("--tolerance", estimate.tolerance, "Go on until the largest standard error of all form factors is at most this; 1e-3 unless another goal or --directions is given", "T");
  addGoal("--relative", estimate.relative, "Go on until the largest standard error is at most this share of its form factor, over those above --floor", "R");
  command->add_option("--floor", estimate.relative_floor, "Least form factor that --relative looks at")->type_name("F")->check(isPositive)->capture_default_str();
  addGoal("--seconds", estimate.seconds, "As many replicates as fit into this time, 2 at least; with a goal: stop short of it when time is up", "S");
  addGoal("--epsilon", options->epsilon, "Guarantee: every form factor within E with probability 1 - D; see --delta", "E");
  command->add_option("--delta", options->delta, "Probability with which a guarantee may fail")->type_name("D")->check(isPositive)->capture_default_str();
  addChoice(command, "--statistic", options->statistic, {{"mean", Statistic::mean}, {"median", Statistic::median}},
            "Of a guarantee: the mean of jittered directions, or the median of runs of independent ones");
  command->add_option("--directions", estimate.directions, "Directions per replicate, in place of a plan")
      ->type_name("N")->check(CLI::Range(1u, 1u << 30).description(""));
  command->add_option("--replicates", estimate.replicates, "Independent replicates, at least; their spread gives the standard errors")
      ->type_name("R")->check(CLI::Range(2u, 1u << 30).description(""))->capture_default_str();
  command->add_option("--resolution", options->resolution, "Lattice spacings across the scene's diameter; planned, or 64 with --directions")
      ->type_name("PX")->check(CLI::Range(1, kMaxResolution).description(""));
  command->add_option("--finest", options->finest, "With --directions and --resolution: spacings for the polygon that needs most of them, in windows; the others get their share")
      ->type_name("PX")->check(CLI::Range(1, kMaxWindowResolution).description(""));
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
  command->add_option("--seed", estimate.seed, "The same seed and plan give the same bits")->type_name("K")->capture_default_str();
  command->add_flag("--two-sided", options->two_sided, "Every polygon emits and receives on both sides");
  command->add_option("--device", options->device.selector, "Vulkan device: index, part of its name, cpu or gpu")->type_name("DEVICE");
  command->add_option("--batch", options->lattice.batch_directions, "Directions peeled at once; 0 chooses. Never changes the result")
      ->type_name("N")->capture_default_str();
  return options;
}

// What follows from the options given.
void settle(const CLI::App* command, ProgramOptions& options) {
  options.whole_sphere = command->get_option("--sampler")->count() > 0;
  options.plans = command->get_option("--directions")->count() == 0;
  if (options.finest && (options.plans || !options.resolution)) throw Error(ErrorCode::bad_usage, "--finest needs --directions and --resolution");
  const EstimateOptions& e = options.estimate;
  if (!options.epsilon && (command->get_option("--delta")->count() || command->get_option("--statistic")->count()))
    throw Error(ErrorCode::bad_usage, "--delta and --statistic are of a guarantee; give its --epsilon");
  if (options.epsilon && (e.tolerance || e.relative || !options.plans || options.finest || command->get_option("--replicates")->count()))
    throw Error(ErrorCode::bad_usage, "a guarantee plans for itself: leave out --tolerance, --relative, --directions, --finest and --replicates");
  if (options.plans && !e.tolerance && !e.relative && !e.seconds && options.engine != EngineKind::exact) options.estimate.tolerance = 1e-3;
}

}  // namespace

void addCompute(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("compute", "Compute the form factors of a scene");
  const auto options = addOptions(command);
  command->add_option("-o,--output", options->outputs, "Write the matrix: .csv or .mtx; may be given several times")
      ->type_name("FILE")->allow_extra_args(false);
  command->add_flag("--quiet", options->quiet, "Print nothing but errors and warnings");
  command->add_flag("--verbose", options->verbose, "Print how work and memory are divided, too");
  command->add_flag("--json", options->json, "Print the outcome and the work done as JSON");
  command->callback([=, &chosen] {
    settle(command, *options);
    chosen = [options] { return runCompute(*options); };
  });
}

void addPlan(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("plan", "Say what `compute` would do with the same options, how long it would take and in how much memory");
  const auto options = addOptions(command);
  command->callback([=, &chosen] {
    settle(command, *options);
    chosen = [options] { return runPlan(*options); };
  });
}

}  // namespace viewpeel::cli
