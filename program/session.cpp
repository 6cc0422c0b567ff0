#include "program/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>

#include "program/interrupts.h"
#include "program/summary.h"
#include "engines/host_engine.h"
#include "error.h"
#include "reference/exact/exact_engine.h"

namespace viewpeel::program {
namespace {

constexpr uint64_t kTrial = uint64_t(1) << 40;  // a replicate number that no run reaches
constexpr double kTrialSeconds = 0.5;
constexpr double kSurfaceShareTolerance = 2e-4;
constexpr size_t kMostSharedFaces = 20'000;  // beyond which blocked pairs take gigabytes

const std::vector<std::pair<std::string, Sampler>> kSamplers = {
    {"fibonacci", Sampler::fibonacci}, {"jittered", Sampler::jittered}, {"sobol", Sampler::sobol}, {"iid", Sampler::iid}};

std::string nameOf(Sampler sampler) {
  for (const auto& [name, value] : kSamplers)
    if (value == sampler) return name;
  return {};
}

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

// The lattices of groups of polygons.
std::string describeGroups(const std::vector<SizeGroup>& groups, Sampling sampling) {
  std::string text = fmt::format("{} {} across", sampling == Sampling::scanline ? "scanlines" : "lattice", groups[0].resolution);
  for (size_t g = 1; g < groups.size();) {
    size_t windows = 0, polygons = 0;
    const int resolution = groups[g].resolution;
    for (; g < groups.size() && groups[g].resolution == resolution; ++g, ++windows) polygons += groups[g].polygons.size();
    text += fmt::format(", {} in {} on {}", resolution, counted(windows, "window"), counted(polygons, "polygon"));
  }
  return text;
}

// A time for people.
std::string inWords(double seconds) {
  if (seconds < 120) return fmt::format("{:.2g} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} minutes", seconds / 60);
  if (seconds < 48 * 3600) return fmt::format("{:.0f} hours", seconds / 3600);
  return fmt::format("{:.3g} days", seconds / 86400);
}

std::string isPositive(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value) ? "" : text + " is not a number above 0";
}

}  // namespace

Session::Session(ProgramOptions& asked) : options(asked), scene(loadScene(asked.scene, asked.scene_options)), ids(makeIds(scene, asked.estimate.by, asked.two_sided)), face_ids(makeIds(scene, By::polygon, asked.two_sided)), sampler(nameOf(asked.estimate.sampler)) {
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "viewpeel: warning: {}\n", warning);
  askOnlyFor(options.question, scene, ids);
  if (scene.faces.size() > kMostSharedFaces && options.closed_forms_by_default) options.closed_forms = false;
  chooseEngine();
  if (!ids.roles.empty() && options.engine == EngineKind::graphics)
    throw Error(ErrorCode::bad_usage, "--from, --pair and --blocker need --engine compute, host or exact");
  if (options.lattice.sampling == Sampling::scanline && !hasWindows())
    throw Error(ErrorCode::bad_usage, "--sampling scanline needs --engine compute or host");
  if (options.finest && (!hasWindows() || !ids.roles.empty()))
    throw Error(ErrorCode::bad_usage, "--finest needs --engine compute or host and the whole matrix");
  if (options.finest > maxWindowResolution(options.lattice.sampling))
    throw Error(ErrorCode::bad_usage, fmt::format("scanlines cannot be finer than {}; give a coarser --finest, or --sampling lattice", kMaxScanlineResolution));
  if (options.epsilon && *options.closed_forms && pairCount(scene.faces.size()) > kMostKnownPairs) {
    if (!options.closed_forms_by_default)
      throw Error(ErrorCode::bad_usage, fmt::format("a guarantee with closed forms needs those of all pairs of polygons: {} at most, not {}; say --closed-forms off", kMostKnownPairs,
                                                    pairCount(scene.faces.size())));
    options.closed_forms = false;
  }
  if (!options.whole_sphere && (!options.question.pair.empty() || (!options.question.from.empty() && !options.two_sided)))
    sampler = askDirections(options.question, scene, options.two_sided, options.estimate);
  if (!isExact() && options.engine != EngineKind::host) device.emplace(options.device);
}

// Compute shaders on a GPU; on a processor its own threads are many times faster than the shaders are through a software driver (README). The counts are the same.
void Session::chooseEngine() {
  if (options.engine == EngineKind::automatic) {
    options.engine = EngineKind::compute;
    if (options.device.selector.empty() && !std::getenv("VIEWPEEL_DEVICE")) {
      bool has_gpu = false;
      try {
        for (const DeviceDescription& found : listDevices()) has_gpu = has_gpu || (found.refusal.empty() && found.kind != "cpu");
      } catch (const Error&) {  // no driver
      }
      if (!has_gpu) options.engine = EngineKind::host;
    }
  }
  options.lattice.sampling = options.sampling.value_or(options.engine == EngineKind::host ? chooseSampling(scene, ids, usesClosedForms() && options.estimate.by == By::polygon) : Sampling::lattice);
}

Lattices Session::lattices() const {
  const auto make = [this](const std::vector<SizeGroup>& groups) -> std::unique_ptr<Engine> {
    if (isExact()) return reference::makeExactEngine(scene, ids, {.on_direction = stopIfInterrupted});
    LatticeOptions lattice = options.lattice;
    lattice.resolution = groups[0].resolution;
    lattice.count_blocked = usesClosedForms();
    const Ids& counted = usesClosedForms() ? face_ids : ids;
    const auto makeOne = [this](const Scene& of, const Ids& own_ids, const LatticeOptions& own) { return makeLatticeEngine(options.engine, deviceOrNone(), of, own_ids, own); };
    return groups.size() > 1 ? makeGroupedEngine(makeOne, scene, counted, lattice, groups) : makeOne(scene, counted, lattice);
  };
  Lattices lattices{make, options.resolution, hasWindows() && ids.roles.empty() && !options.resolution, options.lattice.sampling, {}};
  if (usesClosedForms()) {
    lattices.id_of_face.resize(face_ids.count());
    for (uint32_t k = 0; k < scene.polygons.size(); ++k) lattices.id_of_face[face_ids.of_polygon[k]] = ids.of_polygon[k];
  }
  return lattices;
}

MakePairEngine Session::pairEngines() const {
  return [this](const Ids& pair_ids, int resolution, const Window& window) {
    LatticeOptions lattice = options.lattice;
    lattice.resolution = resolution;
    lattice.window = window;
    lattice.count_blocked = true;
    lattice.measure_work = false;
    lattice.on_batch = [](uint64_t) { stopIfInterrupted(); };
    return makeLatticeEngine(options.engine, deviceOrNone(), scene, pair_ids, lattice);
  };
}

GuaranteeOptions Session::guaranteeOptions() const {
  GuaranteeOptions asked;
  asked.epsilon = *options.epsilon;
  asked.delta = options.delta;
  asked.statistic = options.statistic;
  asked.sampler = options.whole_sphere ? options.estimate.sampler : options.statistic == Statistic::median ? Sampler::iid : Sampler::jittered;
  asked.seed = options.estimate.seed;
  asked.range = options.range;
  asked.block_directions = options.block;
  asked.closed_forms = usesClosedForms();
  asked.device = deviceOrNone();
  return asked;
}

Plan Session::plan() const {
  if (!isExact() && options.plans) {
    Plan plan = planEstimate(scene, ids, options.estimate, lattices());
    if (!plan.counts_too_large) return plan;
    if (!options.closed_forms_by_default)
      throw Error(ErrorCode::bad_usage, "polygons differ too much in size for closed forms at this goal: counts would be too large; say --closed-forms off, or ask for less");
    plan.engine.reset();
    options.closed_forms = false;
    return planEstimate(scene, ids, options.estimate, lattices());
  }
  Plan plan;
  plan.directions = options.estimate.directions;
  plan.finest = options.finest;
  const int resolution = options.resolution ? options.resolution : options.lattice.resolution;
  plan.groups = options.finest ? planGroups(scene, ids, options.lattice.sampling, resolution, options.finest, plan.directions) : groupAsOne(scene, resolution);
  plan.engine = lattices().make_engine(plan.groups);
  return plan;
}

GuaranteePlan Session::planGuarantee() const {
  GuaranteePlan plan = viewpeel::planGuarantee(scene, ids, guaranteeOptions(), lattices(), isExact());
  if (options.estimate.seconds && plan.least_seconds > *options.estimate.seconds)
    throw Error(ErrorCode::bad_usage, fmt::format("a guarantee of {} takes {} at least, {} at most, more than --seconds {}; ask for a larger --epsilon, or an estimate by --tolerance",
                                                  plan.epsilon, inWords(plan.least_seconds), inWords(plan.most_seconds), *options.estimate.seconds));
  return plan;
}

void Session::describe() const {
  fmt::print("{}{}", isExact() ? "device     none: exact areas on the CPU\n" : options.engine == EngineKind::host ? describeProcessor() : describeDevice(*device), describeScene(scene));
  std::fflush(stdout);
}

std::string Session::describe(const Plan& plan) const {
  const EstimateOptions& estimate = options.estimate;
  std::string text = fmt::format("sampling   {} a replicate, {}; {}; seed {}\n", counted(plan.directions, "direction"), sampler,
                                       isExact() ? "exact areas" : describeGroups(plan.groups, options.lattice.sampling), estimate.seed);
  if (!(plan.pilot_seconds > 0)) return text;
  text += fmt::format("expected   largest standard error {:.1e}{} after {} replicates, counted in {} (found out in {}); the same again: --directions {} --resolution {}{}\n",
                            plan.standard_error, estimate.relative && !estimate.tolerance ? " of its form factor" : "", estimate.replicates, inWords(plan.seconds),
                            inWords(plan.pilot_seconds), plan.directions, plan.groups[0].resolution,
                            fmt::format("{}{}{}", plan.groups.size() > 1 ? fmt::format(" --finest {}", plan.finest) : "", options.lattice.sampling == Sampling::scanline ? " --sampling scanline" : "",
                                        usesClosedForms() ? " --closed-forms on" : ""));
  const double goal = estimate.tolerance ? *estimate.tolerance : estimate.relative.value_or(INFINITY);
  if (plan.standard_error > goal) {  // errors fall with the root of the number of replicates
    const double more = std::pow(plan.standard_error / goal, 2), seconds = more * plan.seconds;
    text += fmt::format("           {:.1e} takes about {:.3g} replicates, {}{}\n", goal, std::ceil(more * estimate.replicates), inWords(seconds),
                        estimate.seconds && seconds > *estimate.seconds ? fmt::format(": more than --seconds {} allow; the run ends short of it", *estimate.seconds) : "");
  }
  if (!plan.barely_met.empty())
    text += fmt::format("           {} ({}{}) {} too small even for the finest lattice there is: {} may go unmet\n", counted(plan.barely_met.size(), "row"), ids.names[plan.barely_met[0]],
                        plan.barely_met.size() > 1 ? ", ..." : "", plan.barely_met.size() > 1 ? "are" : "is", plan.barely_met.size() > 1 ? "they" : "it");
  return text;
}

std::string Session::describeTime(const Plan& plan) const {
  const EstimateOptions& estimate = options.estimate;
  const auto directionsOf = [&](uint32_t count) {
    return estimate.asked_directions ? estimate.asked_directions(count, kTrial).directions : sampleDirections(estimate.sampler, count, estimate.seed, kTrial);
  };
  double each = 0;
  uint32_t count = std::min(4u, plan.directions);
  for (uint32_t turn = 0; turn < 2; ++turn, count = std::clamp(static_cast<uint32_t>(kTrialSeconds / each), 1u, plan.directions)) {
    if (turn == 0) plan.engine->count(directionsOf(count));  // kernels are compiled and tuned
    const auto start = std::chrono::steady_clock::now();
    plan.engine->count(directionsOf(count));
    each = std::max(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 1e-9) / count;
  }
  return fmt::format("{} for {}", inWords(each * plan.directions * estimate.replicates), counted(estimate.replicates, "replicate"));
}

std::string Session::describe(const GuaranteePlan& plan) const {
  const bool is_median = options.statistic == Statistic::median;
  std::string text = fmt::format("goal       every form factor within {} with probability {}: {} at once, a direction adds at most {:.2f}\n", plan.epsilon, 1 - plan.delta,
                                 counted(static_cast<uint64_t>(plan.bounds), "bound"), plan.largest_range);
  text += fmt::format("sampling   {} directions; {}; seed {}\n", nameOf(guaranteeOptions().sampler), isExact() ? "exact areas" : describeGroups(plan.groups, options.lattice.sampling),
                      options.estimate.seed);
  if (is_median) text += fmt::format("plan       median of {} of {}, {}\n", counted(plan.runs, "run"), counted(plan.run_directions, "direction"), inWords(plan.most_seconds));
  else
    text += fmt::format("plan       blocks of {}: {} ({}) by Hoeffding's bound; by Bernstein's {} ({}) expected, {} ({}) at least; the same again:{} --block {}\n",
                        counted(plan.block_directions, "direction"), plan.most_blocks, inWords(plan.most_seconds), plan.expected_blocks, inWords(plan.expected_seconds), plan.least_blocks,
                        inWords(plan.least_seconds), isExact() ? "" : options.resolution ? fmt::format(" --resolution {}", options.resolution) : fmt::format(" --range {}", plan.range),
                        plan.block_directions);
  if (plan.share_bounds) text += fmt::format("closed     forms of {} pairs of polygons, shares of {} from a pilot\n", plan.known.pairs.size(), std::count_if(plan.known.pairs.begin(), plan.known.pairs.end(), [](const KnownPair& pair) { return pair.share > 0; }));
  return text + fmt::format("beside     directions: Hoeffding {}; Pellegrini's Lemma 1 {:.3g} for one pair, {:.3g} for all; median of runs {:.3g}\n", plan.hoeffding, plan.lemma_1,
                            plan.lemma_1_all, double(plan.runs) * double(plan.run_directions));
}

std::string Session::describe(const VisibleShares& known) const {
  uint64_t whole = 0;
  uint64_t pairs = 0;
  for (const KnownPair& pair : known.known.pairs) {
    pairs += pair.j < kEnvironment;
    whole += pair.j < kEnvironment && pair.share == kShareOne;
  }
  std::string text = fmt::format("closed     forms of {} of polygons in {:.2g} s; {} of them never blocked in a pilot of {:.2g} s{}\n", counted(pairs, "pair"), known.closed_form_seconds, whole,
                                 known.pilot_seconds, known.unreached ? fmt::format("; {} more are sampled alone", known.unreached) : "");
  const std::vector<DirectedPair>& directed = known.known.directed;
  uint64_t directions = 0;
  for (const DirectedPair& pair : directed) directions += pair.directions;
  if (!directed.empty())
    text += fmt::format("directed   {} that the others hardly meet {} directions of {} own, {} a replicate in all (found out in {:.2g} s)\n", counted(directed.size(), "pair"),
                        directed.size() == 1 ? "has" : "have", directed.size() == 1 ? "its" : "their", directions, known.directed_seconds);
  return text;
}

// An option that changes counts has its line here, or in what calls this.
Settings Session::settings() const {
  const Question& question = options.question;
  Settings all = {
      {"version", VIEWPEEL_VERSION},
      {"scene", identityOf(scene)},
      {"--by", options.estimate.by == By::polygon ? "polygon" : "surface"},
      {"--two-sided", options.two_sided ? "yes" : "no"},
      {"--from", fmt::format("{}", fmt::join(question.from, ", "))},
      {"--pair", fmt::format("{}", fmt::join(question.pair, ", "))},
      {"--blocker", fmt::format("{}", fmt::join(question.blockers, ", "))},
      {"--seed", std::to_string(options.estimate.seed)},
      {"--sampling", isExact() ? "exact areas" : options.lattice.sampling == Sampling::scanline ? "scanline" : "lattice"},
      {"--sampler", options.epsilon ? nameOf(guaranteeOptions().sampler) : sampler},
  };
  addSettings(options.scene_options, all);
  if (!options.epsilon) return all;
  if (options.statistic == Statistic::median) throw Error(ErrorCode::bad_usage, "--checkpoint keeps means only; leave out --statistic median");
  all.insert(all.end(), {{"--epsilon", fmt::format("{}", *options.epsilon)}, {"--delta", fmt::format("{}", options.delta)}});
  return all;
}

Settings Session::settings(const Plan& plan) const {
  Settings all = settings();
  all.push_back({"--closed-forms", usesClosedForms() ? "on" : "off"});
  all.insert(all.end(), {{"--directions", std::to_string(plan.directions)},
                         {"--resolution", isExact() ? "any" : std::to_string(plan.groups[0].resolution)},
                         {"--finest", plan.groups.size() > 1 ? std::to_string(plan.finest) : "0"}});
  return all;
}

Settings Session::settings(const GuaranteePlan& plan) const {
  Settings all = settings();
  all.push_back({"--closed-forms", usesClosedForms() ? "on" : "off"});
  all.insert(all.end(), {{"--resolution", std::to_string(options.resolution)},
                         {"--range", fmt::format("{}", plan.range)},
                         {"--block", std::to_string(plan.block_directions)}});
  return all;
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
  command->add_option("--floor", estimate.relative_floor, "Least form factor that --relative looks at")->type_name("F")->check(isPositive)->check([](const std::string& text) { return isNumber(text, 0, 1); })->capture_default_str();
  addGoal("--seconds", estimate.seconds, "As many replicates as fit into this time, 2 at least; with a goal: stop short of it when time is up", "S");
  addGoal("--epsilon", options->epsilon, "Guarantee: every form factor within E with probability 1 - D; see --delta", "E");
  command->add_option("--delta", options->delta, "Probability with which a guarantee may fail")->type_name("D")->check(isPositive)->capture_default_str();
  command->add_option("--range", options->range, "Of a guarantee: lattices so fine that a direction adds at most about this to a form factor; chosen")
      ->type_name("M")->check(CLI::Range(2.001, 100.0).description(""));
  command->add_option("--block", options->block, "Of a guarantee: directions of a block; chosen")->type_name("N")->check(CLI::Range(1u, 1u << 16).description(""));
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
  addSceneOptions(command, options->scene_options);
  addChoice(command, "--by", options->estimate.by, {{"polygon", By::polygon}, {"surface", By::surface}}, "One row per polygon or per named surface");
  addChoice(command, "--engine", options->engine, {{"auto", EngineKind::automatic}, {"compute", EngineKind::compute}, {"host", EngineKind::host}, {"graphics", EngineKind::graphics}, {"exact", EngineKind::exact}},
            "Depth peeling on a Vulkan device, in compute shaders or by its raster pipeline; the same counts on the processor's threads (host); or exact areas there. "
            "auto: compute on a GPU, or on the --device named, else host");
  addChoice<std::optional<Sampling>>(command, "--sampling", options->sampling, {{"auto", std::nullopt}, {"lattice", Sampling::lattice}, {"scanline", Sampling::scanline}},
            "Samples of a direction: lattice points, or lattice rows cut where polygons end. auto: the quicker ones for the engine and scene");
  addChoice(command, "--sampler", estimate.sampler, kSamplers,
            "Directions over the sphere: rotated Fibonacci sets, one in each of as many cells, scrambled Sobol' points, or independent. Without it --from and "
            "--pair draw better ones");
  command->add_option_function<std::string>("--closed-forms", [options](const std::string& word) { options->closed_forms = word == "on"; },
                                            "Sample only the share of the lines between two polygons that nothing blocks: without occlusion form factors are closed forms. "
                                            "Planned runs do, where they can")
      ->type_name("on|off")->check(CLI::IsMember({"on", "off"}).description(""));
  command->add_option("--from", options->question.from, "Only the rows of this surface or face; may be given several times")->type_name("NAME")->allow_extra_args(false);
  command->add_option("--pair", options->question.pair, "Only the form factors between two surfaces or faces")->type_name("A B")->expected(0, 2);
  command->add_option("--blocker", options->question.blockers, "A surface or face that only blocks; may be given several times")->type_name("NAME")->allow_extra_args(false);
  command->add_option("--first-replicate", estimate.first_replicate, "Count replicates from this one on: parts of a run, for viewpeel merge")
      ->type_name("K")->check(CLI::Range(uint64_t(0), uint64_t(1) << 39).description(""))->capture_default_str();
  command->add_option("--seed", estimate.seed, "The same seed and plan give the same bits")->type_name("K")->check(isWholeNumber)->capture_default_str();
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
  if (options.finest && options.finest < options.resolution)
    throw Error(ErrorCode::bad_usage, fmt::format("--finest {} is coarser than --resolution {}, which all polygons get; give a finer one, or leave it out", options.finest, options.resolution));
  if (options.finest && (options.plans || !options.resolution)) throw Error(ErrorCode::bad_usage, "--finest needs --directions and --resolution");
  const EstimateOptions& e = options.estimate;
  const bool can_use = options.engine != EngineKind::graphics && options.engine != EngineKind::exact && options.question.isEverything() &&
                       (!options.epsilon || (options.estimate.by == By::polygon && options.statistic == Statistic::mean));
  if (options.closed_forms.value_or(false) && !can_use)
    throw Error(ErrorCode::bad_usage, "--closed-forms on needs the whole matrix and --engine compute or host; of a guarantee also --by polygon and --statistic mean");
  // Between surfaces counts vary less than their parts: there shares pay for small tolerances only. Where lines meet many fronts, as with two-sided polygons, blocked pairs
  // cost more than they gain, and a guarantee's tests of lattices each wait for closed forms of all pairs (README).
  const bool pays = !options.two_sided && !options.epsilon && (options.estimate.by == By::polygon || (e.tolerance && *e.tolerance <= kSurfaceShareTolerance));
  options.closed_forms_by_default = !options.closed_forms.has_value();
  options.closed_forms_possible = can_use;
  options.closed_forms = options.closed_forms.value_or(options.plans && can_use && pays);
  for (const char* name : {"--delta", "--statistic", "--range", "--block"})
    if (!options.epsilon && command->get_option(name)->count()) throw Error(ErrorCode::bad_usage, fmt::format("{} is of a guarantee; give its --epsilon", name));
  if (options.epsilon && (*options.epsilon >= 1 || options.delta >= 1)) throw Error(ErrorCode::bad_usage, "--epsilon and --delta have to lie between 0 and 1");
  if (options.epsilon && (e.tolerance || e.relative || !options.plans || options.finest || e.first_replicate || command->get_option("--replicates")->count()))
    throw Error(ErrorCode::bad_usage, "a guarantee plans for itself: leave out --tolerance, --relative, --directions, --finest, --replicates and --first-replicate");
  if (options.engine == EngineKind::exact && (options.resolution || options.range > 0)) throw Error(ErrorCode::bad_usage, "--engine exact has no lattice; leave out --resolution and --range");
  if (options.resolution && options.range > 0) throw Error(ErrorCode::bad_usage, "--range chooses the --resolution of a guarantee; give one of the two");
  if (options.statistic == Statistic::median && options.block) throw Error(ErrorCode::bad_usage, "--statistic median has runs, not blocks; leave out --block");
  if (options.plans && !e.tolerance && !e.relative && !e.seconds && options.engine != EngineKind::exact) options.estimate.tolerance = 1e-3;
}

}  // namespace viewpeel::program
