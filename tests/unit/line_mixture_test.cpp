// These tests judge runs in which pairs of large form factors have lines of their own and common directions count all
// others. They compare such a run with a finer one in which all pairs have lines. They also compare it with the same
// run on another number of threads, with one that was stopped and resumed, and with sums over surfaces.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

#include "tests/support/same_bits.h"
#include <viewpeel/compute.h>

#include "engines/host_engine.h"
#include "estimator/line_mixture.h"
#include "estimator/line_run.h"
#include "estimator/plan_lines.h"
#include "io/checkpoint.h"
#include "pair_lines/find_pairs.h"
#include "scenes/generate.h"
#include "scenes/shared_engine.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"

namespace viewpeel {
namespace {

constexpr double kGoal = 1e-2;

EstimateOptions optionsOf(double tolerance, By by = By::polygon) {
  EstimateOptions options;
  options.tolerance = tolerance;
  options.by = by;
  return options;
}

// All pairs get lines where there are few pairs. Where there are many, they do only if directions would cost as much.
TEST(LineMixture, IsTakenWherePairsAreMany) {
  const LineMixture mixture = mixtureFor(optionsOf(kGoal), 1e-4);
  EXPECT_EQ(mixture.least_form_factor, kGoal / kMostOfCounted);
  EXPECT_GE(mixture.directions * 8, 4 / kGoal);
  EXPECT_GT(mixture.resolution, LatticeOptions{}.resolution);
  EXPECT_TRUE(paysLinesForAll({{1e4, 1e4, 1e4, 1e3}, 1e2}, mixture, 8));  // takes little time anyway
  EXPECT_FALSE(paysLinesForAll({{2e6, 2e6, 1e6, 1e5}, 1e3}, mixture, 8));
  EXPECT_TRUE(paysLinesForAll({{2e6, 2e6, 1e6, 1e6}, 1e3}, mixture, 8));  // nearly all pairs are large
  EXPECT_TRUE(paysLinesForAll({{2e6, 2e6, 1e6, 1e5}, 3e4}, mixture, 8));  // directions take as long
  EXPECT_FALSE(mayPayMixture(100));
  EXPECT_TRUE(mayPayMixture(1'000));
  EXPECT_FALSE(paysLinesForAll({{3e7, 3e7, 2.0 * kMostPatchPairs}, 1e7}, mixture, 8));
  EXPECT_TRUE(mayFindAll({3e7, 3e7, double(kMostPatchPairs)}));
  EXPECT_FALSE(mayFindAll({3e7, 3e7, 1.1 * kMostPatchPairs}));
  EXPECT_FALSE(mayFindAll({2e8, 2e8, 1e6}));
  EXPECT_EQ(countedPairs({{1e6, 1e6, 1e6}, 7e4}, mixture, 8), 7e4 * 8 * mixture.directions);
  EXPECT_TRUE(mayFit(mixture, 8, 600'000));
  EXPECT_FALSE(mayFit(mixture, 8, 1'200'000));
  const LineMixture fine = mixtureFor(optionsOf(kGoal / 100), 1e-4);
  EXPECT_TRUE(mayFit(fine, 8, 10'000));  // lines for all pairs may do
  EXPECT_FALSE(mayFit(fine, 8, 20'000));
  EstimateOptions relative;
  relative.relative = 0.1;
  relative.relative_floor = 0.01;
  EXPECT_NEAR(mixtureFor(relative, 1e-4).least_form_factor, 1e-3 / kMostOfCounted, 1e-12);
}

TEST(LineMixture, FewLinesThatLeaveAClosedSceneGraze) {
  EXPECT_EQ(shareOutside({{0, 1, 500'000, 0}, {0, kEnvironment, 3, 0}, {1, kLeak, 2, 0}}), 5 / 1'000'005.0);
  EXPECT_LE(shareOutside({{0, 1, 500'000, 0}, {0, kEnvironment, 3, 0}}), kGrazedOfScene);
  EXPECT_GT(shareOutside({{0, 1, 500'000, 0}, {0, kEnvironment, 30, 0}}), kGrazedOfScene);
  EXPECT_EQ(shareOutside({}), 0);
}

// A GrazingEngine adds one line to the counts of a face. The line leaves the scene, as one that grazes an edge may.
class GrazingEngine : public SharedEngine {
 public:
  GrazingEngine(Engine& engine, uint32_t id) : SharedEngine(engine), id_(id) {}
  PairCounts count(std::span<const Direction> directions) override {
    PairCounts counts = SharedEngine::count(directions);
    const PairCount grazing{id_, kEnvironment, 1, 0};
    const auto place = std::ranges::find_if(
        counts, [&](const PairCount& count) { return std::pair(count.i, count.j) >= std::pair(id_, kEnvironment); });
    counts.insert(place, grazing);
    return counts;
  }

 private:
  uint32_t id_;
};

// The room has 2,496 quads. These tests make mixtures themselves, with goals, lattices and engines of their own.
class MixedRoom : public testing::Test {
 protected:
  struct Run {
    RunSums sums;
    bool is_reached;
  };

  static void SetUpTestSuite() {
    scene_ = std::make_unique<Scene>(buildScene(bench::roomWithBoxes(2)));
    ids_ = std::make_unique<Ids>(makeIds(*scene_, By::polygon, false));
    engine_ = makeHostEngine(*scene_, *ids_, {.resolution = 256, .sampling = Sampling::lattice});
    Request request;
    request.goal = Tolerance{kGoal / 10};
    request.promise = false;
    request.seed = 7;
    truth_ = std::make_unique<Result>(computeFormFactors(*scene_, request));
    mixed_ = std::make_unique<Run>(mix(kGoal / kMostOfCounted));
  }
  static void TearDownTestSuite() { mixed_.reset(), truth_.reset(), engine_.reset(), ids_.reset(), scene_.reset(); }

  // Runs a mixture.
  //   In: replicates: at most; resumed: the first of them, or nullptr
  static Run mix(double least_form_factor, By by = By::polygon, size_t threads = 2, uint64_t replicates = 100,
                 const RunSums* resumed = nullptr, Engine* engine = nullptr) {
    EstimateOptions options = optionsOf(kGoal, by);
    options.directions = mixtureFor(options, 1).directions;
    options.resumed = resumed;
    PairLines lines(*scene_, *ids_, {}, options.seed, threads, [] {});
    const Ids ids = makeIds(*scene_, by, false);
    std::vector<LinePair> pairs = planLines(lines, lines.find(least_form_factor), *ids_, ids, options, false, INFINITY);
    LineRun run(engine ? *engine : *engine_, *scene_, *ids_, lines, std::move(pairs), least_form_factor, options);
    while (!run.isDone() && run.sums().replicateCount() < replicates) run.step();
    return {run.sums(), run.isReached()};
  }

  // Returns the largest error of form factors between polygons, each from the smaller polygon of its pair.
  static double largestError(const FormFactors& found) {
    double largest = 0;
    const auto compare = [&](const FormFactors& of, const FormFactors& other) {
      for (const FormFactors::Entry& entry : of.entries()) {
        if (entry.j >= kEnvironment) continue;
        const double error = entry.exchange_area.value - other.exchangeArea(entry.i, entry.j).value;
        largest = std::max(largest, std::abs(error) / ids_->smallerArea(entry.i, entry.j));
      }
    };
    compare(found, truth_->form_factors);
    compare(truth_->form_factors, found);
    return largest;
  }

  static inline std::unique_ptr<Scene> scene_;
  static inline std::unique_ptr<Ids> ids_;
  static inline std::unique_ptr<Engine> engine_;
  static inline std::unique_ptr<Result> truth_;
  static inline std::unique_ptr<Run> mixed_;
};

// No entry errs by more than the goal. If common directions also count pairs as large as the goal, the test finds an
// error above the goal.
TEST_F(MixedRoom, ErrsByTheGoalAtMost) {
  ASSERT_EQ(truth_->plan.pair_lines->least_form_factor, 0);
  EXPECT_TRUE(mixed_->is_reached);
  const FormFactors found = mixed_->sums.formFactors();
  EXPECT_LE(largestError(found), kGoal);
  uint64_t counted = 0;
  for (const ReplicateSums::PairSum& pair : mixed_->sums.by_id.pairs()) counted += pair.j < kEnvironment;
  EXPECT_GT(counted, found.entries().size() / 2);
  EXPECT_GT(largestError(mix(3 * kGoal).sums.formFactors()), kGoal);
}

// A pair that few directions met errs by what one of them counts, even if two replicates agree. Without that, 3 in
// 1,000 entries of two replicates, and 4 in 100,000 of eight, err by more than five stated errors.
TEST_F(MixedRoom, ErrorsHoldWhereFewDirectionsMeetAPair) {
  constexpr double kMostBeyond = 1e-5;
  for (const uint64_t replicates : {2, 8}) {
    const FormFactors found = mix(kGoal / kMostOfCounted, By::polygon, 2, replicates).sums.formFactors();
    uint64_t beyond = 0;
    for (const FormFactors::Entry& entry : found.entries()) {
      const Measured there = truth_->form_factors.exchangeArea(entry.i, entry.j), here = entry.exchange_area;
      beyond += std::abs(here.value - there.value) > 5 * std::hypot(here.standard_error, there.standard_error);
    }
    EXPECT_LE(double(beyond), kMostBeyond * double(found.entries().size())) << replicates;
  }
}

// Student's t of 7 degrees of freedom is above 5 in 1.6 of 1,000 cases. Rows would fall short by more than a tenth
// without the counted pairs.
TEST_F(MixedRoom, RowsAddUpByChance) {
  int beyond = 0;
  double worst = 0, mean = 0, mean_of_lines = 0;
  const FormFactors found = mixed_->sums.formFactors();
  const double count = double(found.rowSums().size());
  for (const Measured& row : found.rowSums()) {
    beyond += std::abs(row.value - 1) > 5 * row.standard_error;
    worst = std::max(worst, std::abs(row.value - 1));
    mean += (row.value - 1) / count;
  }
  for (const FormFactors::Entry& entry : mixed_->sums.lines->entries())
    for (const uint32_t id : {entry.i, entry.j}) mean_of_lines += entry.exchange_area.value / ids_->areas[id] / count;
  EXPECT_LE(beyond, 0.005 * count);
  EXPECT_GT(worst, 1e-4);
  EXPECT_NEAR(mean, 0,
              0.01);  // cutting takes 5 % off the largest counted pairs, less off others: docs/method.md, mixtures
  EXPECT_LT(mean_of_lines, 0.9);
}

// A row of a closed room adds up to 1. Its counted pairs make up V_c / V of what it lacks, to a tenth of its standard
// error (calibrate_counts.h). No form factor errs by more than the goal then, either. Pairs with lines do not move.
TEST_F(MixedRoom, CountedPairsFitTheirRows) {
  const RunSums& sums = mixed_->sums;
  const FormFactors before = sums.formFactors(), after = makeEstimate(sums, 0.01).form_factors;
  const std::vector<Measured> counted = sums.by_id.measureRows(sums.measure_area);
  double largest_before = 0, largest_after = 0;
  for (uint32_t i = 0; i < ids_->count(); ++i) {
    const Measured was = before.rowSums()[i], is = after.rowSums()[i];
    const double left = 1 - std::pow(counted[i].standard_error / was.standard_error, 2);
    EXPECT_LE(std::abs(is.value - 1), left * std::abs(was.value - 1) + 0.1 * was.standard_error + 1e-12) << i;
    largest_before = std::max(largest_before, std::abs(was.value - 1));
    largest_after = std::max(largest_after, std::abs(is.value - 1));
  }
  EXPECT_LT(largest_after, largest_before / 4);
  EXPECT_LE(largestError(after), kGoal);
  auto line = sums.lines->pairs().begin();
  size_t moved = 0;
  for (const FormFactors::Entry& entry : after.entries()) {
    const double was = before.exchangeArea(entry.i, entry.j).value, is = entry.exchange_area.value;
    while (line != sums.lines->pairs().end() && keyOf(*line) < keyOf(entry)) ++line;
    const bool has_lines = line != sums.lines->pairs().end() && keyOf(*line) == keyOf(entry);
    if (has_lines || entry.j >= kEnvironment) {
      EXPECT_EQ(is, was) << entry.i << " " << entry.j;
    } else {
      EXPECT_LE(is, kGoal * ids_->smallerArea(entry.i, entry.j)) << entry.i << " " << entry.j;
      moved += is != was;
    }
  }
  EXPECT_GT(moved, after.entries().size() / 2);
}

// The room is closed, and a line grazes an edge in each replicate. The row's environment is its count, and within the
// goal of 0. As 1 less the row sum it would have the error of all counted pairs, and no number of directions would
// bring this error to the goal.
TEST_F(MixedRoom, EndsWhereLinesGraze) {
  const FormFactors found = mixed_->sums.formFactors();
  const auto& rows = found.rowSums();
  const auto worst = std::ranges::min_element(rows, {}, &Measured::value);
  const auto id = static_cast<uint32_t>(worst - rows.begin());
  ASSERT_GT(1 - worst->value, kGoal);
  GrazingEngine engine(*engine_, id);
  const Run run = mix(kGoal / kMostOfCounted, By::polygon, 2, 100, nullptr, &engine);
  EXPECT_TRUE(run.is_reached);
  EXPECT_EQ(run.sums.replicateCount(), mixed_->sums.replicateCount());
  const Measured environment = run.sums.formFactors().formFactor(id, kEnvironment);
  EXPECT_GT(environment.value, 0);
  EXPECT_LE(environment.value, kGoal);
  EXPECT_LE(errorsInRowGoal(ids_->count()) * environment.standard_error, kGoal);
}

TEST_F(MixedRoom, ThreadsAndStopsDoNotMatter) {
  const FormFactors found = mixed_->sums.formFactors();
  const double least = kGoal / kMostOfCounted;
  expectSameBits(found, mix(least, By::polygon, 3).sums.formFactors());
  const Run first = mix(least, By::polygon, 2, 3);
  ASSERT_EQ(first.sums.replicateCount(), 3u);
  expectSameBits(found, mix(least, By::polygon, 2, 100, &first.sums).sums.formFactors());
}

// Sums over surfaces take both kinds of pairs. The truth errs by a tenth of the goal.
TEST_F(MixedRoom, SurfacesHaveBothKinds) {
  const Run surfaces = mix(kGoal / kMostOfCounted, By::surface);
  EXPECT_TRUE(surfaces.is_reached);
  const FormFactors found = surfaces.sums.formFactors(), &truth = truth_->between_surfaces;
  const FormFactors lines(truth.ids(), surfaces.sums.lines->entriesOfResult(), {});
  double largest = 0, largest_of_lines = 0;
  for (const FormFactors::Entry& entry : truth.entries()) {
    const double area = truth.ids().smallerArea(entry.i, entry.j);
    largest =
        std::max(largest, std::abs(found.exchangeArea(entry.i, entry.j).value - entry.exchange_area.value) / area);
    const double of_lines = lines.exchangeArea(entry.i, entry.j).value;
    largest_of_lines = std::max(largest_of_lines, std::abs(of_lines - entry.exchange_area.value) / area);
  }
  EXPECT_LE(largest, 1.1 * kGoal);
  EXPECT_GT(largest_of_lines, 3 * kGoal);
}

Request requestOf(double tolerance) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.engine = EngineKind::host;
  return request;
}

// Of 9,984 quads nearly all pairs are counted. The run goes on from a checkpoint to the same bits.
TEST(MixtureRuns, GoOnFromACheckpoint) {
  const Scene scene = buildScene(bench::roomWithBoxes(4));
  FormFactorRun whole(scene, requestOf(kGoal));
  whole.makePlan();
  const PlanSummary& plan = whole.plan();
  ASSERT_TRUE(plan.pair_lines);
  EXPECT_EQ(plan.pair_lines->least_form_factor, kGoal / kMostOfCounted);
  EXPECT_FALSE(plan.no_promise.empty());
  EXPECT_EQ(plan.no_pair_lines, "");
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "line_mixture.h5";
  for (int k = 0; k < 3; ++k) whole.step();
  whole.writeCheckpoint(file);
  while (!whole.isDone()) whole.step();
  const Result result = whole.result();
  EXPECT_TRUE(result.goal_reached);
  EXPECT_EQ(result.unmet_bound, kGoal / kMostOfCounted);

  EXPECT_EQ(readCheckpoint(file).sums.lines->leastFormFactor(), kGoal / kMostOfCounted);
  FormFactorRun second(scene, requestOf(kGoal));
  second.resumeFrom(file);
  while (!second.isDone()) second.step();
  // Pairs without lines may err by the checkpoint's goal, so it does not serve a smaller one.
  FormFactorRun finer(scene, requestOf(0.9 * kGoal)), coarser(scene, requestOf(2 * kGoal));
  finer.resumeFrom(file);
  coarser.resumeFrom(file);
  EXPECT_THROW(finer.makePlan(), Error);
  EXPECT_NO_THROW(coarser.makePlan());
  std::filesystem::remove(file);
  expectSameBits(second.result().form_factors, result.form_factors);
}

// Returns the largest error of the entries of some rows, from the smaller id of each, with environment and leak.
double largestErrorOfRows(const FormFactors& found, const FormFactors& truth) {
  double largest = 0;
  const auto compare = [&](const FormFactors& of, const FormFactors& other) {
    for (const FormFactors::Entry& entry : of.entries()) {
      if (!truth.ids().isRequested(entry.i) && (entry.j >= kEnvironment || !truth.ids().isRequested(entry.j))) continue;
      const double error = entry.exchange_area.value - other.exchangeArea(entry.i, entry.j).value;
      largest = std::max(largest, std::abs(error) / truth.ids().smallerArea(entry.i, entry.j));
    }
  };
  compare(found, truth);
  compare(truth, found);
  return largest;
}

// In a city most pairs are hidden, and finding the others takes seconds. So all of them have lines, and so has the sky.
// The truth has some rows, at a fifth of the goal, by lines of another seed. A question of these rows has lines, too.
TEST(MixtureRuns, AllPairsOfAnOpenCityHaveLines) {
  const Scene scene = buildScene(bench::city(8'600));
  ASSERT_GT(scene.faces.size(), 8'000u);
  const Result result = computeFormFactors(scene, requestOf(kGoal));
  ASSERT_TRUE(result.plan.pair_lines) << result.plan.no_promise;
  EXPECT_EQ(result.plan.pair_lines->least_form_factor, 0);
  EXPECT_TRUE(result.goal_reached);
  Request of_rows = requestOf(kGoal / 5);
  of_rows.promise = false;
  of_rows.seed = 7;
  const std::vector<std::string>& names = result.form_factors.ids().names;
  for (size_t k = 0; k < 24; ++k) of_rows.question.from.push_back(names[(2 * k + 1) * names.size() / 48]);
  const Result truth = computeFormFactors(scene, of_rows);
  EXPECT_TRUE(truth.plan.pair_lines) << truth.plan.no_pair_lines;
  EXPECT_LE(largestErrorOfRows(result.form_factors, truth.form_factors), kGoal);
  std::vector<FormFactors::Entry> faulty = result.form_factors.entries();
  std::erase_if(faulty, [](const FormFactors::Entry& entry) { return entry.j == kEnvironment; });
  EXPECT_GT(largestErrorOfRows({result.form_factors.ids(), faulty, {}}, truth.form_factors), kGoal);
  of_rows.goal = Tolerance{1e-4};
  of_rows.question = {};
  FormFactorRun fine(scene, of_rows);
  fine.makePlan();
  EXPECT_TRUE(fine.plan().pair_lines) << fine.plan().no_promise;
}

// An estimate of a closed room leaves out lines of small pairs. A promise does not, nor does a request for pair lines
// or for sums, nor a run that nothing but geometry decides. The plan's options make the same plan again.
TEST(MixtureRuns, EstimatesOfSmallRoomsAreMixtures) {
  const Scene room = buildScene(bench::roomWithBoxes(2)), cube = buildScene(bench::cubeOfPatches(12));
  const auto planOf = [](const Scene& scene, Request request) {
    FormFactorRun run(scene, request);
    run.makePlan();
    EXPECT_TRUE(run.plan().pair_lines || run.plan().line_guarantee) << run.plan().no_pair_lines;
    return run.plan();
  };
  Request request = requestOf(kGoal);
  request.promise = false;
  const PlanSummary mixture = planOf(room, request);
  EXPECT_EQ(mixture.pair_lines->least_form_factor, kGoal / kMostOfCounted);
  EXPECT_EQ(optionsOf(mixture), "--promise off");
  const PlanSummary exact = planOf(cube, request);
  EXPECT_EQ(exact.pair_lines->least_form_factor, 0);
  EXPECT_EQ(exact.directions, 0u);
  request.lines_for_all = true;
  EXPECT_EQ(planOf(room, request).pair_lines->least_form_factor, 0);
  request.lines_for_all = false;
  request.pair_lines = true;
  const PlanSummary lines = planOf(room, request);
  EXPECT_EQ(lines.pair_lines->least_form_factor, 0);
  EXPECT_EQ(optionsOf(lines), "--pair-lines on");
  const PlanSummary promise = planOf(room, requestOf(kGoal));
  ASSERT_TRUE(promise.line_guarantee);
  EXPECT_EQ(promise.line_guarantee->least_form_factor, 0);
}

}  // namespace
}  // namespace viewpeel
