// This bench tests standard errors of form factors. Over many seeds it counts how often the 95 % interval, value +-
// t_0.975(R - 1) standard errors, holds the true form factor. It prints CSV on stdout, with a row for each scene,
// setting, rule when to stop, and class of entries.
//   coverage [--scene facing|edge|far|cube|blocked|parts|gap|office|room|city]... [--unoccluded] [--host]
//     [--directed R] [--sampler fibonacci|jittered|sobol|iid]... [--setting PXxN]... [--rule RULE]... [--seeds K]
//     [--device D]
//
// The truth of office, room and city is a long run of 16,384 directions on 256 scanlines. --host counts scanlines with
// the host engine, not lattice points with the compute engine. With --directed some pairs are directed pairs: pilots
// predict that they keep a run from a relative error of R. A rule R is a fixed number of replicates. A rule R:G counts
// at least R replicates, and continues until the largest standard error reaches a tolerance. The tolerance is chosen so
// that runs take G replicates in the mean.
//
// Entries are classed by the number of lattice points that a replicate is expected to count for them. With unoccluded
// form factors there is also a class of entries that something blocks in part, for other pairs are exact once a line
// met them. The class `met` has all entries that some replicate met. Entries of one run are correlated, so the standard
// error of a coverage comes from the spread between seeds. An entry without a line counts as covered where unmetBound()
// holds the truth. Where all pairs have a truth there are two more classes: `rows` are row sums, whose truth is 1, and
// `groups` are form factors between surfaces.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include <CLI/CLI.hpp>
#include <boost/math/distributions/students_t.hpp>

#include "engines/compute_engine.h"
#include "engines/host_engine.h"
#include <viewpeel/error.h>
#include "estimator/directed_pairs.h"
#include "estimator/find_prior.h"
#include "sums/add_pairs.h"
#include "bench/support/coverage_cases.h"
#include "bench/support/measure.h"
#include "scenes/shared_engine.h"

namespace viewpeel::bench {
namespace {

constexpr double kConfidence = 0.95, kNormalQuantile = 1.959964;
constexpr uint64_t kPilotSeed = 1'000'000'000;
constexpr uint32_t kPilots = 20, kPilotReplicates = 16;
constexpr std::array<double, 5> kCountEnds{0.3, 1, 3, 10, INFINITY};  // upper ends of the classes by expected counts
// A pair is blocked in part if more than this share of its unoccluded form factor is visible, and more than this share
// is blocked.
constexpr double kBlockedInPart = 1e-3;
const std::map<std::string, Sampler> kSamplers(kSamplerNames.begin(), kSamplerNames.end());

struct Options {
  std::vector<std::string> scenes{"facing", "edge", "far", "cube"}, samplers{"fibonacci", "jittered"},
      settings{"32x50"};
  std::vector<std::string> rules{"4", "8", "16", "8:12"};
  bool unoccluded = false, on_host = false;
  double directed = 0;
  uint32_t seeds = 200;
  DeviceOptions device;
};

// RememberingEngine counts each replicate once, and gives the counts again to every stopping rule.
class RememberingEngine : public Engine {
 public:
  explicit RememberingEngine(Engine& engine) : engine_(engine) {}
  void forget() { counts_.clear(); }
  // The next call of count() is for the first replicate.
  void startAgain() { next_ = 0; }
  PairCounts count(std::span<const Direction> directions) override {
    if (next_ == counts_.size()) counts_.push_back(engine_.count(directions));
    return counts_[next_++];
  }
  double unitArea() const override { return engine_.unitArea(); }

 private:
  Engine& engine_;
  std::vector<PairCounts> counts_;
  size_t next_ = 0;
};

struct Rule {
  uint32_t replicates = 0, goal_replicates = 0;  // goal_replicates 0: no goal
};

// Reads two numbers with a separator between them.
template <class First>
bool readPair(const std::string& text, char separator, First& first, uint32_t& second) {
  std::istringstream in(text);
  char between = 0;
  return in >> first >> between >> second && between == separator && in.peek() == EOF;
}

Rule ruleOf(const std::string& text) {
  Rule rule;
  if (!readPair(text.find(':') == std::string::npos ? text + ":0" : text, ':', rule.replicates, rule.goal_replicates) ||
      rule.replicates < 2)
    throw Error(ErrorCode::bad_usage, "--rule " + text + ": give R or R:G, R at least 2");
  return rule;
}

// Entry is a form factor, with the expected number of counts of a replicate.
struct Entry {
  double truth, expected_count, area;  // area: the smaller of the two, input units squared
  bool is_blocked_in_part = false;
};

struct RunOutcome {
  std::vector<Measured> factors;  // form factors of the entries
  std::vector<Measured> rows;     // row sums; empty where not all pairs have a truth
  std::vector<Measured> groups;   // between surfaces, as in sumBySurface
  std::vector<double> unmet_bounds;
  uint64_t replicates = 0;
};

// Tally counts the covered entries of one class.
class Tally {
 public:
  void startRun() { runs_.push_back({}); }
  void add(const Measured& measured, double truth, double quantile, double unmet_bound) {
    const double error = std::abs(measured.value - truth);
    Run& run = runs_.back();
    ++run.entries;
    run.covered += measured.value > 0 ? error <= quantile * measured.standard_error : truth <= unmet_bound;
    covered_normal_ += error <= kNormalQuantile * measured.standard_error;
    unmet_ += measured.value == 0;
    squares_ += error * error;
    if (truth > 0) relative_squares_ += error * error / (truth * truth);
    predicted_ += measured.standard_error * measured.standard_error;
  }
  // Prints nothing where the class is empty.
  void print(const std::string& key, double mean_replicates) const {
    double entries = 0, covered = 0, squares = 0;
    for (const Run& run : runs_) entries += run.entries, covered += run.covered;
    if (entries == 0) return;
    for (const Run& run : runs_) squares += std::pow(run.covered - covered / entries * run.entries, 2);
    const double n = double(runs_.size()), standard_error = std::sqrt(squares * n / (n - 1)) / entries;
    fmt::print("{},{:.1f},{:.1f},{:.2g},{:.2f},{:.2f},{:.2f},{:.3f},{:.2f}\n", key, entries / n, mean_replicates,
               std::sqrt(relative_squares_ / entries), 100 * covered / entries, 100 * standard_error,
               100 * covered_normal_ / entries, std::sqrt(predicted_ / squares_), 100 * unmet_ / entries);
  }

 private:
  struct Run {
    double entries = 0, covered = 0;
  };
  std::vector<Run> runs_;
  double covered_normal_ = 0, unmet_ = 0, squares_ = 0, relative_squares_ = 0, predicted_ = 0;
};

void report(const std::string& key, const std::vector<Entry>& entries, const Truths& group_truths,
            const std::vector<RunOutcome>& runs) {
  std::array<Tally, kCountEnds.size()> by_count;
  Tally nonzero, blocked_in_part, rows, groups;
  double mean_replicates = 0;
  for (const RunOutcome& run : runs) {
    mean_replicates += double(run.replicates) / double(runs.size());
    const double student =
        quantile(complement(boost::math::students_t(double(run.replicates - 1)), (1 - kConfidence) / 2));
    for (Tally& tally : by_count) tally.startRun();
    nonzero.startRun();
    blocked_in_part.startRun();
    rows.startRun();
    for (const Measured& row : run.rows) rows.add(row, 1, student, 0);
    groups.startRun();
    for (auto [group, k] = std::pair(group_truths.begin(), size_t(0)); k < run.groups.size(); ++group, ++k)
      groups.add(run.groups[k], group->second, student, 0);
    for (size_t k = 0; k < entries.size(); ++k) {
      const auto which =
          std::lower_bound(kCountEnds.begin(), kCountEnds.end(), entries[k].expected_count) - kCountEnds.begin();
      by_count[which].add(run.factors[k], entries[k].truth, student, run.unmet_bounds[k]);
      if (run.factors[k].value > 0) nonzero.add(run.factors[k], entries[k].truth, student, 0);
      if (entries[k].is_blocked_in_part)
        blocked_in_part.add(run.factors[k], entries[k].truth, student, run.unmet_bounds[k]);
    }
  }
  for (size_t k = 0; k < by_count.size(); ++k)
    by_count[k].print(fmt::format("{},to {} counts", key, kCountEnds[k]), mean_replicates);
  blocked_in_part.print(key + ",blocked in part", mean_replicates);
  nonzero.print(key + ",met", mean_replicates);
  rows.print(key + ",rows", mean_replicates);
  groups.print(key + ",groups", mean_replicates);
  std::fflush(stdout);
}

// Setting is an engine for one PXxN, with the entries whose intervals are judged.
struct Setting {
  Setting(const Case& scene_case, const Ids& ids, const std::string& text, const Device& device,
          const Options& options);

  int resolution = 0;
  EstimateOptions estimate;
  std::unique_ptr<Engine> engine;
  double count_area = 0;  // input units squared
  std::vector<Entry> entries;
};

Setting::Setting(const Case& scene_case, const Ids& ids, const std::string& text, const Device& device,
                 const Options& options) {
  if (!readPair(text, 'x', resolution, estimate.directions))
    throw Error(ErrorCode::bad_usage, "--setting " + text + ": give PXxN");
  const Scene& scene = scene_case.scene;
  LatticeOptions lattice{.resolution = resolution, .count_blocked = options.unoccluded};
  if (options.on_host) lattice.sampling = Sampling::scanline;
  engine = options.on_host ? makeHostEngine(scene, ids, lattice) : makeComputeEngine(device, scene, ids, lattice);
  count_area = engine->unitArea() * scene.scale * scene.scale;
  for (const auto& [pair, truth] : scene_case.truths)
    entries.push_back(
        {truth, truth * ids.areas[pair.first] * estimate.directions / (2 * count_area),
         std::min(ids.areas[pair.first], pair.second < kEnvironment ? ids.areas[pair.second] : INFINITY)});
}

// SamplerRuns makes the runs of one scene, setting and sampler with one engine.
class SamplerRuns {
 public:
  SamplerRuns(const Case& scene_case, const Ids& ids, const Setting& setting, Sampler sampler, const Device& device,
              const Options& options)
      : case_(scene_case),
        ids_(ids),
        setting_(setting),
        device_(device),
        options_(options),
        estimate_(setting.estimate),
        engine_(*setting.engine) {
    estimate_.sampler = sampler;
  }
  SamplerRuns(const SamplerRuns&) = delete;

  // Returns the largest standard error of one replicate, estimated from pilot runs with seeds of their own.
  double largestErrorOfReplicate() {
    double largest = 0;
    for (uint32_t pilot = 0; pilot < kPilots; ++pilot) {
      engine_.forget();
      largest +=
          run({kPilotReplicates}, 0, kPilotSeed + pilot).largest_standard_error * std::sqrt(kPilotReplicates) / kPilots;
    }
    return largest;
  }

  // Returns the outcomes of one seed, one for each rule of the command line.
  std::vector<RunOutcome> outcomesOf(uint64_t seed, double largest_error, const Truths& group_truths) {
    engine_.forget();
    std::vector<RunOutcome> outcomes;
    for (const std::string& text : options_.rules) {
      const Rule rule = ruleOf(text);
      const Estimate e = run(rule, largest_error / std::sqrt(rule.goal_replicates), seed);
      RunOutcome& outcome = outcomes.emplace_back();
      outcome.replicates = e.replicates;
      for (const Entry& entry : setting_.entries)
        outcome.unmet_bounds.push_back(unmetBound(entry.area, setting_.count_area, double(e.directions)));
      if (case_.has_all_pairs) {
        outcome.rows = e.form_factors.rowSums();
        for (const auto& [pair, truth] : group_truths)
          outcome.groups.push_back(e.between_surfaces.formFactor(pair.first, pair.second));
      }
      for (const auto& [pair, truth] : case_.truths)
        outcome.factors.push_back(e.form_factors.formFactor(pair.first, pair.second));
    }
    return outcomes;
  }

  // Marks the entries that something blocks in part. The prior of these scenes has all pairs.
  void markBlockedInPart(std::vector<Entry>& entries) const {
    size_t k = 0;
    for (const auto& [pair, truth] : case_.truths) {
      const auto prior =
          std::ranges::lower_bound(found_.prior.pairs, pair, {}, [](const PairPrior& at) { return keyOf(at); });
      if (prior != found_.prior.pairs.end() && keyOf(*prior) == pair) {
        const double visibility = truth * ids_.areas[pair.first] / prior->exchange;
        entries[k].is_blocked_in_part =
            pair.second < kEnvironment && visibility > kBlockedInPart && visibility < 1 - kBlockedInPart;
      }
      ++k;
    }
  }

  uint64_t runCount() const { return runs_; }
  uint64_t directedRunCount() const { return directed_runs_; }

 private:
  Estimate run(const Rule& rule, double tolerance, uint64_t seed) {
    estimate_.replicates = rule.replicates;
    estimate_.tolerance = rule.goal_replicates ? std::optional(tolerance) : std::nullopt;
    estimate_.seed = seed;
    if (options_.unoccluded && prior_seed_ != seed) findPriorOf(seed);
    estimate_.pairs = pairs_ ? &*pairs_ : nullptr;
    estimate_.prior = options_.unoccluded ? &found_.prior : nullptr;
    engine_.startAgain();
    return estimateFormFactors(engine_, case_.scene, ids_, estimate_);
  }

  void findPriorOf(uint64_t seed) {
    EstimateOptions pilot = estimate_;
    if (options_.directed > 0) {
      pairs_.emplace(case_.scene, ids_, seed,
                     [this](const Scene& scene, const Ids& pair_ids, const LatticeOptions& lattice) {
                       return pairEngine(scene, pair_ids, lattice);
                     });
      pilot.pairs = &*pairs_;
      pilot.relative = options_.directed;
      pilot.relative_floor = 1e-5;
      pilot.tolerance.reset();
    }
    FaceExchanges exchanges(options_.on_host ? nullptr : &device_, case_.scene, ids_);
    found_ = findPrior(*setting_.engine, exchanges, case_.scene, ids_, groupAsOne(case_.scene, setting_.resolution),
                       pilot, {choosePriorPilot(pilot).directions});
    prior_seed_ = seed;
    ++runs_;
    directed_runs_ += !found_.prior.directed.empty();
  }

  // Resolution and window identify the engine of a pair in these scenes, so each engine is made once for all seeds.
  std::unique_ptr<Engine> pairEngine(const Scene& scene, const Ids& pair_ids, const LatticeOptions& lattice) {
    std::unique_ptr<Engine>& made = pair_engines_[{lattice.resolution, lattice.window.radius}];
    if (!made) made = makeComputeEngine(device_, scene, pair_ids, lattice);
    return std::make_unique<SharedEngine>(*made);
  }

  const Case& case_;
  const Ids& ids_;
  const Setting& setting_;
  const Device& device_;
  const Options& options_;
  EstimateOptions estimate_;
  RememberingEngine engine_;
  FoundPrior found_;
  std::optional<PairSampler> pairs_;
  std::map<std::pair<int, double>, std::unique_ptr<Engine>> pair_engines_;
  uint64_t prior_seed_ = 0, directed_runs_ = 0, runs_ = 0;
};

void measureCase(const std::string& name, const Device& device, const Options& options) {
  const Case scene_case = makeCase(name);
  const Ids ids = makeIds(scene_case.scene, By::polygon, false);
  const Truths group_truths = sumBySurface(scene_case.truths, ids, makeIds(scene_case.scene, By::surface, false));
  for (const std::string& text : options.settings) {
    Setting setting(scene_case, ids, text, device, options);
    for (const std::string& sampler : options.samplers) {
      SamplerRuns runs(scene_case, ids, setting, kSamplers.at(sampler), device, options);
      const double largest_error = runs.largestErrorOfReplicate();
      std::vector<std::vector<RunOutcome>> outcomes(options.rules.size());
      for (uint64_t seed = 1; seed <= options.seeds; ++seed) {
        std::vector<RunOutcome> of_seed = runs.outcomesOf(seed, largest_error, group_truths);
        for (size_t k = 0; k < outcomes.size(); ++k) outcomes[k].push_back(std::move(of_seed[k]));
      }
      if (options.directed > 0)
        fmt::print("# {}: directed pairs in {} of {} runs\n", name, runs.directedRunCount(), runs.runCount());
      if (options.unoccluded) runs.markBlockedInPart(setting.entries);
      for (size_t k = 0; k < options.rules.size(); ++k)
        report(fmt::format("{},{},{},{},{}", name, sampler, setting.resolution, setting.estimate.directions,
                           options.rules[k]),
               setting.entries, group_truths, outcomes[k]);
    }
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  using namespace viewpeel::bench;
  CLI::App app("How often 95 % intervals hold the true form factor", "coverage");
  Options options;
  app.add_option("--scene", options.scenes,
                 "facing, edge, far, cube, blocked, parts, gap; by a long run: office, room, city")
      ->check(CLI::IsMember({"facing", "edge", "far", "cube", "blocked", "parts", "gap", "office", "room", "city"}))
      ->capture_default_str();
  app.add_flag("--unoccluded", options.unoccluded, "Unoccluded form factors times visibilities");
  app.add_flag("--host", options.on_host, "Scanlines of the host engine");
  app.add_option(
         "--directed", options.directed,
         "With unoccluded form factors: directions of their own for pairs that keep a run from this relative error")
      ->check(CLI::PositiveNumber);
  app.add_option("--sampler", options.samplers, "fibonacci, jittered, sobol, iid")
      ->check(CLI::IsMember(kSamplers))
      ->capture_default_str();
  app.add_option("--setting", options.settings, "PXxN: lattice spacings and directions of a replicate")
      ->capture_default_str();
  app.add_option("--rule", options.rules, "R, or R:G: replicates, or at least R and on to the tolerance that takes G")
      ->capture_default_str();
  app.add_option("--seeds", options.seeds, "Runs of each")->capture_default_str();
  app.add_option("--device", options.device.selector, "As for viewpeel");
  CLI11_PARSE(app, argc, argv);
  try {
    const Device device(options.device);
    printPlace(device, VIEWPEEL_SOURCE);
    fmt::print(
        "scene,sampler,resolution,directions,rule,class,entries,replicates,relative_rms_error,coverage_percent,"
        "coverage_standard_error,"
        "normal_coverage_percent,standard_error_over_rms_error,unmet_percent\n");
    for (const std::string& scene : options.scenes) measureCase(scene, device, options);
  } catch (const Error& error) {
    fmt::print(stderr, "coverage: {}\n", error.what());
    return 1;
  }
}
