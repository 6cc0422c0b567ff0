#include "run/setup.h"

#include <algorithm>
#include <cstdlib>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "engines/engine_factory.h"
#include "engines/host_engine.h"
#include "engines/ranked_engine.h"
#include <viewpeel/error.h>
#include "estimator/find_prior.h"
#include "estimator/plan_lines.h"
#include "io/checkpoint.h"
#include "run/rules.h"
#include "scene/interpenetration.h"
#include "threads.h"
#include "vulkan/gpu_nodes.h"

namespace viewpeel {
namespace {

constexpr double kLeastOfEpsilon = 0.999;  // pairs below this multiple of epsilon, unoccluded, get no lines

// Returns goals, replicates, seed and time limit. Directions and sampler are settled later.
EstimateOptions estimateOptionsOf(const Request& request) {
  EstimateOptions estimate;
  const Amount amount = amountOf(request);
  estimate.directions = amount.directions ? amount.directions : kUsualDirections;
  estimate.replicates = amount.replicates;
  estimate.is_exact = amount.is_exact;
  estimate.sampler = request.sampler.value_or(Sampler::fibonacci);
  estimate.relative_floor = request.relative_floor;
  estimate.seed = request.seed;
  estimate.first_replicate = request.first_replicate;
  estimate.by = request.by;
  estimate.seconds = request.time_limit_s;
  if (const auto* tolerance = std::get_if<Tolerance>(&request.goal)) {
    estimate.tolerance = tolerance->standard_error;
    estimate.relative = tolerance->relative;
  } else if (const auto* relative = std::get_if<Relative>(&request.goal)) {
    estimate.relative = relative->standard_error;
  } else if (const auto* rms = std::get_if<RootMeanSquare>(&request.goal)) {
    estimate.rms = rms->standard_error;
  } else if (const auto* seconds = std::get_if<Seconds>(&request.goal)) {
    estimate.seconds = std::min(seconds->seconds, request.time_limit_s.value_or(seconds->seconds));
  }
  return estimate;
}

bool hasGpu() {
  // Asking Vulkan loads all its drivers, which takes 0.2 s and 50 MB, a software driver's compiler among them.
  if (!hasGpuNode("/dev")) return false;
  try {
    for (const DeviceDescription& found : listDevices())
      if (found.refusal.empty() && found.kind != "cpu") return true;
  } catch (const Error&) {  // no Vulkan driver is installed
  }
  return false;
}

bool isPlanar(const Scene& scene, const std::vector<uint32_t>& polygons) {
  return std::all_of(polygons.begin(), polygons.end(), [&](uint32_t k) {
    const Polygon &a = scene.polygons[k], &b = scene.polygons[polygons[0]];
    return glm::dot(scene.planes[a.plane].normal, scene.planes[b.plane].normal) *
               (a.front_along_plane_normal == b.front_along_plane_normal ? 1 : -1) >
           1 - 1e-9;
  });
}

// Adds the surfaces that the scene's file calls blockers to the question's blockers.
Request withBlockersOf(const Scene& scene, Request request) {
  std::vector<std::string>& blockers = request.question.blockers;
  for (const std::string& name : scene.blockers)
    if (std::ranges::find(blockers, name) == blockers.end()) blockers.push_back(name);
  return request;
}

}  // namespace

Amount amountOf(const Request& request) {
  const auto* fixed = std::get_if<FixedAmount>(&request.goal);
  return fixed ? Amount{fixed->directions, fixed->replicates, fixed->resolution, fixed->finest} : request.amount;
}

Setup::Setup(const Scene& scene, Request request, std::function<void(uint64_t)> on_batch, std::function<void()> stop)
    : scene_(scene),
      request_(withBlockersOf(scene, std::move(request))),
      estimated_goal_(request_.goal),
      stop_(std::move(stop)),
      ids_(makeIds(scene, request_.by, request_.two_sided)),
      face_ids_(makeIds(scene, By::polygon, request_.two_sided)),
      sampler_(nameOf(request_.sampler.value_or(Sampler::fibonacci))),
      estimate_(estimateOptionsOf(request_)) {
  checkRequest(request_);
  const Amount amount = amountOf(request_);
  plans_ = amount.directions == 0;
  resolution_ = amount.resolution;
  finest_ = amount.finest;
  lattice_.batch_directions = request_.batch_directions;
  lattice_.thread_count = request_.threads;
  lattice_.measure_work = request_.measure_work;
  lattice_.on_batch = std::move(on_batch);
  lattice_.stop = stop_;
  restrictToQuestion(request_.question, scene_, ids_);
  settleUnoccluded();
  chooseEngine();
  settlePairLines();
  requireWhatEnginesHave();
  settleDirections();
  if (guarantee() && !pair_lines_) sampler_ = nameOf(guaranteeOptions().sampler);
  if (engine_ == EngineKind::compute || engine_ == EngineKind::graphics) device_.emplace(request_.device);
  make_engine_ = isExact() ? request_.exact_engine : latticeEngines(engine_, device());
  if (!request_.ranks || request_.ranks->size() == 1) return;
  const size_t threads = request_.threads ? request_.threads : threadCount();
  crew_ = std::make_unique<Crew>(*request_.ranks, fingerprint(scene_), threads, stop_);
  make_engine_ = rankedEngines(*crew_, std::move(make_engine_), engine_);
}

// Decides whether to use unoccluded form factors (docs/speed.md). Between surfaces they pay for small tolerances only:
// counts of surfaces vary less than counts of their parts. Where lines hit many fronts, as with two-sided polygons,
// counting blocked pairs costs more than it gains. A guarantee would have to compute all unoccluded form factors before
// its first look at a bound.
void Setup::settleUnoccluded() {
  const bool pays =
      !request_.two_sided && !guarantee() &&
      (request_.by == By::polygon || (estimate_.tolerance && *estimate_.tolerance <= kSurfaceUnoccludedTolerance));
  unoccluded_by_default_ = !request_.unoccluded;
  unoccluded_possible_ = mayUseUnoccluded(request_);
  unoccluded_ = request_.unoccluded.value_or(plans_ && unoccluded_possible_ && pays &&
                                             scene_.faces.size() <= kMostUnoccludedFaces);
  if (!guarantee() || !unoccluded_ || pairCount(scene_.faces.size()) <= kMostPriorPairs) return;
  throw Error(ErrorCode::bad_usage,
              fmt::format("a guarantee with unoccluded form factors computes them for all pairs of polygons: "
                          "{} at most, and there are {}; add --unoccluded off",
                          kMostPriorPairs, pairCount(scene_.faces.size())));
}

// Decides whether to use pair lines. In large scenes a guarantee has them, and so may a tolerance of the whole matrix:
// there the plan says which pairs get them (line_mixture.h).
void Setup::settlePairLines() {
  settleTimed(mayUsePairLines(request_));  // reasonAgainstPairLines() looks at the tolerance
  no_pair_lines_ = reasonAgainstPairLines();
  const bool is_promise = request_.promise.value_or(false);  // then pair lines are used whatever they cost
  pair_lines_ = request_.pair_lines.value_or(is_promise || no_pair_lines_.empty());
  settleTimed(pair_lines_);
  if (pair_lines_) restrictToQuestion(request_.question, scene_, face_ids_);
}

// Gives a run whose goal is a time a tolerance where it has pair lines, until the plan knows what the time allows. By
// common directions alone such a run has none.
void Setup::settleTimed(bool has_pair_lines) {
  if (!std::holds_alternative<Seconds>(request_.goal)) return;
  estimate_.is_timed = has_pair_lines;
  estimate_.tolerance = has_pair_lines ? std::optional(kCoarsestTimed) : std::nullopt;
}

// Returns why pair lines are not used by default; empty where they are.
std::string Setup::reasonAgainstPairLines() const {
  if (const std::string option = optionAgainstPairLines(request_); !option.empty())
    return fmt::format("{} asks for common directions", option);
  if (!mayUsePairLines(request_)) return "the goal does not say how large an error may be";
  if (!isLarge() || leastFormFactor() > 0 || plansWhichPairs() || estimate_.rms) return "";
  return "the scene has too many polygons";
}

bool Setup::isLarge() const { return scene_.faces.size() > kMostPairLineFaces; }

bool Setup::plansWhichPairs() const {
  if (guarantee() || request_.promise.value_or(false) || !(estimate_.tolerance || estimate_.relative)) return false;
  const bool is_everything = request_.question.isEverything(), by_polygon = request_.by == By::polygon;
  if (!isLarge())
    return is_everything && by_polygon && !request_.lines_for_all && !request_.pair_lines.value_or(false) &&
           mayPayMixture(face_ids_.count());
  return !is_everything || mayFit(mixture(), estimate_.replicates, face_ids_.count());
}

bool Setup::mayCountSurfaces() const {
  // A software device would take many times as long as the processor's threads, which draw lines in any case.
  const bool is_quick = engine_ == EngineKind::host ||
                        (engine_ == EngineKind::compute && device_ && device_->description().kind != "cpu");
  return is_quick && request_.by == By::surface && estimate_.tolerance && !estimate_.relative && !estimate_.seconds &&
         request_.question.isEverything() && !guarantee() && !unoccluded_ && plans_ && !isExact() &&
         !request_.pair_lines && !request_.lines_for_all && !request_.promise.value_or(false) &&
         optionAgainstPairLines(request_).empty() && mayPayMixture(face_ids_.count());
}

void Setup::countSurfaces() {
  counts_surfaces_ = true;
  if (estimate_.tolerance) *estimate_.tolerance /= kErrorsInGoal;
}

LineMixture Setup::mixture() const {
  double area = 0;
  for (const double of_face : face_ids_.areas) area += of_face;
  return mixtureFor(estimate_, area / double(face_ids_.count()) / (scene_.scale * scene_.scale));
}

double Setup::leastFormFactor() const {
  const auto* goal = std::get_if<EpsilonDelta>(&estimated_goal_);
  // Sums over surfaces, and sums of rows, may consist of many pairs below the limit. So both need lines for all pairs.
  const bool needs_few = goal && request_.by == By::polygon && !goal->rows && !request_.pair_lines.value_or(false);
  return needs_few && isLarge() ? kLeastOfEpsilon * goal->epsilon : 0;
}

// A software device draws lines only on request: the processor's threads are faster.
const Device* Setup::lineDevice() const {
  const bool is_requested = request_.engine == EngineKind::compute;
  return engine_ == EngineKind::compute && (is_requested || device_->description().kind != "cpu") ? device() : nullptr;
}

void Setup::promise(bool rows) {
  request_.goal = EpsilonDelta{.epsilon = *estimate_.tolerance, .delta = kPromiseDelta, .rows = rows};
}

void Setup::takeBackPromise() { request_.goal = estimated_goal_; }

void Setup::leaveOutPairLines() {
  pair_lines_ = false;
  settleTimed(pair_lines_);
  if (guarantee()) sampler_ = nameOf(guaranteeOptions().sampler);
}

// Chooses compute shaders on a GPU, else the processor's threads. Shaders through a software driver would be many times
// slower (docs/speed.md). The counts are the same.
void Setup::chooseEngine() {
  engine_ = request_.engine;
  if (engine_ == EngineKind::automatic) {
    const bool names_device = !request_.device.selector.empty() || std::getenv("VIEWPEEL_DEVICE");
    engine_ = names_device || hasGpu() ? EngineKind::compute : EngineKind::host;
  }
  const bool has_prior = unoccluded_ && request_.by == By::polygon;
  if (!request_.sampling) {
    lattice_.sampling = engine_ == EngineKind::host ? chooseSampling(scene_, ids_, has_prior) : Sampling::lattice;
    return;
  }
  lattice_.sampling = *request_.sampling;
  if (lattice_.sampling != Sampling::scanline) return;
  if (const std::vector<Interpenetration> crossings = findInterpenetrations(scene_, kCrossingDepth); !crossings.empty())
    throw Error(ErrorCode::bad_usage,
                describe(scene_, crossings.front()) + ", and scanlines cannot order them; say --sampling lattice");
}

void Setup::requireWhatEnginesHave() const {
  const bool has_windows = engine_ == EngineKind::compute || engine_ == EngineKind::host;
  if (!ids_.roles.empty() && engine_ == EngineKind::graphics)
    throw Error(ErrorCode::bad_usage, "--from, --pair and --blocker need --engine compute, host or exact");
  if (lattice_.sampling == Sampling::scanline && !has_windows)
    throw Error(ErrorCode::bad_usage, "--sampling scanline needs --engine compute or host");
  if (finest_ && (!has_windows || !ids_.roles.empty()))
    throw Error(ErrorCode::bad_usage, "--finest needs --engine compute or host and the whole matrix");
  if (finest_ > maxWindowResolution(lattice_.sampling))
    throw Error(ErrorCode::bad_usage,
                fmt::format("scanlines cannot be finer than {}; give a coarser --finest, or --sampling lattice",
                            kMaxScanlineResolution));
}

// Chooses directions for a question: fewer are needed than for all pairs, unless the request names a sampler.
void Setup::settleDirections() {
  const Question& question = request_.question;
  if (request_.sampler) return;
  if (!question.pair.empty()) {
    const DirectionRegion region = findPairRegion(scene_, findPolygons(scene_, question.pair[0]),
                                                  findPolygons(scene_, question.pair[1]), request_.two_sided);
    estimate_.drawn_directions = [region, seed = request_.seed](uint32_t count, uint64_t replicate) {
      return sampleRegion(region, count, seed, replicate);
    };
    sampler_ = region.isEmpty() ? "but none in which a front of one sees a front of the other"
                                : fmt::format("in the pair's anti-convex-hull, {:.3g} % of a half sphere",
                                              region.solidAngle() / (2 * std::numbers::pi) * 100);
    return;
  }
  if (question.from.empty() || request_.two_sided) return;
  std::vector<uint32_t> emitter;
  for (const std::string& name : question.from) {
    const std::vector<uint32_t> polygons = findPolygons(scene_, name);
    emitter.insert(emitter.end(), polygons.begin(), polygons.end());
  }
  estimate_.drawn_directions = [emitter, &scene = scene_, seed = request_.seed](uint32_t count, uint64_t replicate) {
    return sampleEmitter(scene, emitter, count, seed, replicate);
  };
  sampler_ = isPlanar(scene_, emitter) ? "by the emitter's cosine" : "fibonacci";
}

std::string Setup::deviceName() const {
  return isExact() ? "none" : device_ ? device_->description().name : "processor";
}

GuaranteeOptions Setup::guaranteeOptions() const {
  const EpsilonDelta& goal = *guarantee();
  GuaranteeOptions options;
  options.epsilon = goal.epsilon;
  options.delta = goal.delta;
  options.statistic = goal.statistic;
  options.sampler = request_.sampler.value_or(goal.statistic == Statistic::median ? Sampler::iid : Sampler::jittered);
  options.seed = request_.seed;
  options.range = goal.range;
  options.block_directions = goal.block_directions;
  options.unoccluded = unoccluded_;
  options.device = device();
  return options;
}

void Setup::adoptPlan(const Settings& stored) {
  if (stored.empty()) return;
  pair_lines_ = findSetting(stored, "--pair-lines") == "on";
  settleTimed(pair_lines_);
  if (findSetting(stored, kAimsAtLargestError)) countSurfaces();
  if (unoccluded_by_default_ && unoccluded_possible_) {
    unoccluded_ = findSetting(stored, "--unoccluded") == "on";
    unoccluded_by_default_ = false;
  }
  const auto figureOf = [&](const char* name) {
    const std::optional<std::string> figure = findSetting(stored, name);
    return figure ? std::strtod(figure->c_str(), nullptr) : 0;
  };
  if (auto* goal = std::get_if<EpsilonDelta>(&request_.goal)) {
    if (!(goal->range > 0)) goal->range = figureOf("--range");
    if (!goal->block_directions) goal->block_directions = static_cast<uint32_t>(figureOf("--block"));
  } else if (plans_ && !isExact() && (figureOf("--directions") >= 1 || pair_lines_)) {
    plans_ = false;
    estimate_.directions = static_cast<uint32_t>(figureOf("--directions"));
    if (!resolution_) resolution_ = static_cast<int>(figureOf("--resolution"));
    finest_ = static_cast<int>(figureOf("--finest"));
  }
}

bool Setup::mayHaveWindows() const {
  return (engine_ == EngineKind::compute || engine_ == EngineKind::host) && ids_.roles.empty();
}

Lattices Setup::lattices() const {
  Lattices lattices{make_engine_, lattice_, resolution_, mayHaveWindows() && !resolution_, nullptr};
  lattices.lattice.count_blocked = usesUnoccluded();
  if (usesUnoccluded()) lattices.face_ids = &face_ids_;
  return lattices;
}

PairSampler Setup::pairSampler() const {
  LatticeOptions lattice = lattice_;
  lattice.measure_work = false;
  lattice.on_batch = [this](uint64_t) { stop_(); };
  return PairSampler(scene_, face_ids_, request_.seed, make_engine_, lattice);
}

}  // namespace viewpeel
