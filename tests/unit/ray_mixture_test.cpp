// In rough estimates of open scenes each polygon has rays of its own, and large pairs have lines. These tests compare
// such a run with a finer one by lines alone, with other numbers of threads, and with one that was stopped and resumed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/same_bits.h"
#include <viewpeel/compute.h>

#include "directions/sampler.h"
#include "estimator/line_mixture.h"
#include "estimator/plan_lines.h"
#include "estimator/plan_rays.h"
#include "pair_lines/pair_lines.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"
#include "sums/replicate_sums.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kGoal = 0.1, kRelativeGoal = 0.5, kMeanGoal = 1e-3;
constexpr size_t kReplicates = 8;  // planned

Scene city() { return buildScene(bench::triangulatedCity(1'000).scene); }

Request requestFor(double tolerance, size_t threads = 2) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.threads = static_cast<uint32_t>(threads);
  return request;
}

TEST(RayMixture, PaysWhereTheGoalIsRoughAndPairsAreMany) {
  const LineMixture mixture = rayMixtureFor({.tolerance = 0.03}, {64, 16, 32});
  EXPECT_TRUE(mixture.hasRays());
  EXPECT_DOUBLE_EQ(mixture.least_form_factor, 0.03 / kMostOfCounted);
  EXPECT_EQ(mixture.directions, 64u);
  // PairLines::samplePairs finds these numbers in the cities of 1,016, 6,604 and 19,994 triangles, for pairs above
  // 0.01, 0.01 and 0.0033. Lines for all pairs took 0.6, 17 and 183 s of CPU time. The search decides all these pairs
  // alone or in rows.
  const PairNumbers small{9.95e4, 9.95e4, 7.77e4, 4.66e3, 4.32e4}, medium{5.37e6, 5.37e6, 2.23e6, 3.73e4, 1.73e6},
      large{5.15e7, 5.15e7, 1.09e7, 4.88e5, 9.42e6};
  // A promise may cost more.
  EXPECT_TRUE(paysRays(medium, 5e7, false));
  EXPECT_FALSE(paysRays(medium, 5e7, true));
  // Rays of all polygons, at 8 replicates of so many of each, take some 2.5 and 20 s.
  const double few = 8 * 256 * 6'604.0, many = 8 * 2'048 * 6'604.0;
  EXPECT_TRUE(paysRays(medium, few, false));
  EXPECT_FALSE(paysRays(medium, many, false));
  EXPECT_FALSE(paysRays(small, few, false));
  EXPECT_TRUE(paysRays(large, many, false));
  EXPECT_FALSE(paysRays({100, 100, 100, 10, 10}, 1e3, false));  // lines take no time
  // In a city of 8,936 quads clusters hide each other, and nothing blocks most of the other pairs: lines take 6 s.
  const PairNumbers quads{7.67e6, 5.57e6, 3.87e6, 1.5e5, 6.2e5};
  EXPECT_FALSE(paysRays(quads, many / 2, false));
  PairNumbers without_clusters = quads;
  without_clusters.decided = without_clusters.facing, without_clusters.blocked = without_clusters.found;
  EXPECT_TRUE(paysRays(without_clusters, many / 2, false));
  PairNumbers of_parts = medium;
  of_parts.small_of_parts = of_parts.found - of_parts.large;  // the search leaves out no pair
  EXPECT_FALSE(paysRays(of_parts, few, false));
  EXPECT_TRUE(paysRays({2e8, 2e8, 1e8, 1e6, 1e7}, 1e10, false));  // too many pairs for lines
  // Between surfaces the large pairs of the largest city took 13 s beside rays, as long as 7.4e7 rays.
  EXPECT_TRUE(paysRaysAlone(large, 19'994, 6e7, 1e7));
  EXPECT_FALSE(paysRaysAlone(large, 19'994, 9e7, 1e7));
}

TEST(RayMixture, ErrorsKeepToTheToleranceAndAreWellStated) {
  const Scene scene = city();
  for (const bool two_sided : {false, true}) {
    SCOPED_TRACE(two_sided ? "two-sided" : "one-sided");
    Request request = requestFor(kGoal), fine = requestFor(kGoal / 100);
    request.two_sided = fine.two_sided = two_sided;
    const Result found = computeFormFactors(scene, request);
    ASSERT_TRUE(found.plan.pair_lines && found.plan.pair_lines->has_rays);
    EXPECT_TRUE(found.goal_reached);
    const FormFactors truth = computeFormFactors(scene, fine).form_factors;
    const Ids& ids = truth.ids();
    double largest = 0, squares = 0;
    size_t count = 0;
    for (const FormFactors::Entry& entry : truth.entries()) {
      const Measured value = found.form_factors.exchangeArea(entry.i, entry.j);
      const double error = std::abs(value.value - entry.exchange_area.value) / ids.smallerArea(entry.i, entry.j);
      largest = std::max(largest, error);
      if (entry.j != kEnvironment) continue;
      squares += std::pow((value.value - entry.exchange_area.value) / value.standard_error, 2), ++count;
    }
    EXPECT_LE(largest, kGoal);
    // Errors of environments over their standard errors have a mean square of 1.3 for R = 9 replicates (Student, R - 1
    // degrees of freedom), up to 0.1 more or less by chance, and below it where the surplus for unmet rays counts.
    EXPECT_GT(squares / double(count), 0.5);
    EXPECT_LT(squares / double(count), 1.5);
  }
}

// The goal is for form factors of at least the floor, environments among them. What is measured may be above the floor
// where the truth is below, and the other way round.
TEST(RayMixture, RelativeErrorsKeepToTheGoal) {
  const Scene scene = city();
  Request request = requestFor(1), fine = requestFor(kGoal / 100);
  request.goal = Relative{kRelativeGoal};
  const Result found = computeFormFactors(scene, request);
  ASSERT_TRUE(found.plan.pair_lines && found.plan.pair_lines->has_rays);
  EXPECT_TRUE(found.goal_reached);
  EXPECT_LE(found.largest_relative_error, kRelativeGoal / kErrorsInGoal);
  const FormFactors truth = computeFormFactors(scene, fine).form_factors;
  const Ids& ids = truth.ids();
  double largest = 0;
  size_t environments = 0;
  for (const FormFactors::Entry& entry : truth.entries()) {
    const double area = ids.smallerArea(entry.i, entry.j), value = entry.exchange_area.value / area,
                 measured = found.form_factors.exchangeArea(entry.i, entry.j).value / area;
    if (measured < request.relative_floor) continue;
    largest = std::max(largest, std::abs(measured - value) / measured);
    environments += entry.j == kEnvironment;
  }
  EXPECT_LE(largest, kRelativeGoal);
  EXPECT_GT(environments, ids.count() / 2);
}

// The lines of a row err by no more than one entry may, so that its sum is near 1.
TEST(RayMixture, LinesOfARowKeepToTheTolerance) {
  constexpr double kFineGoal = 0.05;
  const Scene scene = buildScene(bench::triangulatedCity(2'900).scene);
  const Result found = computeFormFactors(scene, requestFor(kFineGoal));
  ASSERT_TRUE(found.plan.pair_lines && found.plan.pair_lines->has_rays);
  const Ids& ids = found.form_factors.ids();
  std::vector<double> variances(ids.count());
  const std::vector<LinePair> with_lines = PairLines(scene, ids, {}, 1).find(found.plan.pair_lines->least_form_factor);
  auto pair = with_lines.begin();
  for (const FormFactors::Entry& entry : found.form_factors.entries()) {
    while (pair != with_lines.end() && keyOf(*pair) < keyOf(entry)) ++pair;
    if (pair == with_lines.end() || keyOf(*pair) != keyOf(entry)) continue;
    for (const uint32_t id : {entry.i, entry.j}) variances[id] += std::pow(entry.errorInSums() / ids.areas[id], 2);
  }
  EXPECT_LE(std::sqrt(std::ranges::max(variances)), kFineGoal / errorsInRowGoal(ids.count()));
}

TEST(RayMixture, BitsDependOnSeedsAlone) {
  const Scene scene = city();
  for (const Goal& goal : {Goal(Tolerance{kGoal}), Goal(RootMeanSquare{kMeanGoal})}) {
    Request request = requestFor(kGoal, 1);
    request.goal = goal;
    const FormFactors one = computeFormFactors(scene, request).form_factors;
    request.threads = 3;
    expectSameBits(computeFormFactors(scene, request).form_factors, one);
    request.seed = 2;
    EXPECT_NE(computeFormFactors(scene, request).form_factors.exchangeArea(0, kEnvironment).value,
              one.exchangeArea(0, kEnvironment).value);
  }
}

// Stops a run at some of its steps, and expects each to end with the same bits when it goes on.
//   In: stops: numbers of steps, from the last one where below 0    Out: number of steps
void expectSameBitsFromCheckpoints(const Request& request, std::initializer_list<int> stops, size_t at_least) {
  const Scene scene = city();
  FormFactorRun whole(scene, request);
  whole.makePlan();
  ASSERT_TRUE(whole.plan().pair_lines && whole.plan().pair_lines->has_rays);
  const std::filesystem::path folder = testing::TempDir();
  std::vector<std::filesystem::path> files;
  while (!whole.isDone()) {
    whole.step();
    files.push_back(folder / ("ray_mixture_" + std::to_string(files.size()) + ".h5"));
    whole.writeCheckpoint(files.back());
  }
  ASSERT_GE(files.size(), at_least);
  for (const int stop : stops) {
    SCOPED_TRACE(stop);
    FormFactorRun second(scene, request);
    second.resumeFrom(files[stop < 0 ? files.size() - static_cast<size_t>(-stop) : static_cast<size_t>(stop)]);
    second.makePlan();
    EXPECT_TRUE(second.plan().pair_lines && second.plan().pair_lines->has_rays);
    while (!second.isDone()) second.step();
    expectSameBits(second.result().form_factors, whole.result().form_factors);
  }
  for (const std::filesystem::path& file : files) std::filesystem::remove(file);
}

TEST(RayMixture, GoesOnFromACheckpoint) {
  // Some checkpoints are of a run whose rows that miss the goal have further rays.
  expectSameBitsFromCheckpoints(requestFor(kGoal), {2, int(kReplicates), -2}, kReplicates + 2);
  Request request = requestFor(kGoal);
  request.goal = RootMeanSquare{kMeanGoal};
  expectSameBitsFromCheckpoints(request, {2, int(kReplicates) - 2}, kReplicates);
}

// Lines for all pairs of this open room do not fit into memory. It has a small polygon. With a tiny one the scene has
// no rays, and the plan says why it has no pair lines.
TEST(RayMixture, IsForOpenScenesOfManyPairs) {
  constexpr double kFineGoal = 1e-2;
  InputScene room = bench::roomWithBoxes(5);
  std::erase_if(room.faces, [](const InputFace& face) {
    return std::ranges::all_of(face.corners, [](const glm::dvec3& corner) { return corner.z > 2.9; });
  });
  ts::addFace(room, "small", ts::parallelogram({1, 2, 2}, {1e-5, 0, 0}, {0, 1e-5, 0}));
  const Scene scene = buildScene(room);
  ASSERT_GT(scene.faces.size(), 8'000u);
  Request request;
  request.goal = Tolerance{kFineGoal};
  FormFactorRun run(scene, request);
  run.makePlan();
  ASSERT_TRUE(run.plan().pair_lines);
  EXPECT_TRUE(run.plan().pair_lines->has_rays);
  EXPECT_EQ(run.plan().pair_lines->least_form_factor, kFineGoal / kMostOfCounted);
  EXPECT_NE(run.plan().no_promise.find("twice the time of rays"), std::string::npos) << run.plan().no_promise;
  ts::addFace(room, "tiny", ts::parallelogram({1, 1, 2}, {1e-7, 0, 0}, {0, 1e-7, 0}));
  const Scene scene_with_tiny = buildScene(room);
  FormFactorRun with_tiny(scene_with_tiny, request);
  with_tiny.makePlan();
  EXPECT_FALSE(with_tiny.plan().pair_lines);
  EXPECT_NE(with_tiny.plan().no_promise.find("lines leave the scene"), std::string::npos)
      << with_tiny.plan().no_promise;
  EXPECT_EQ(with_tiny.plan().no_pair_lines, with_tiny.plan().no_promise);
}

// For a rough goal rays are quicker, and lines for all pairs would be much finer than it. A request for pair lines gets
// lines for all pairs. A relative goal beside the tolerance has rays, too.
TEST(RayMixture, IsForRoughGoalsOfLargeOpenScenes) {
  constexpr double kRoughGoal = 0.05;
  const Scene scene = buildScene(bench::city(8'600));
  Request request;
  request.goal = Tolerance{kRoughGoal};
  FormFactorRun run(scene, request);
  run.makePlan();
  ASSERT_TRUE(run.plan().pair_lines);
  EXPECT_TRUE(run.plan().pair_lines->has_rays);
  request.pair_lines = true;
  FormFactorRun with_lines(scene, request);
  with_lines.makePlan();
  ASSERT_TRUE(with_lines.plan().pair_lines);
  EXPECT_EQ(with_lines.plan().pair_lines->least_form_factor, 0);
  request.pair_lines.reset();
  request.goal = Tolerance{kRoughGoal, kRelativeGoal};
  FormFactorRun relative(scene, request);
  relative.makePlan();
  ASSERT_TRUE(relative.plan().pair_lines);
  EXPECT_TRUE(relative.plan().pair_lines->has_rays);
  EXPECT_EQ(relative.plan().pair_lines->least_form_factor, kRelativeGoal * request.relative_floor / kMostOfCounted);
}

// All rays of a polygon that looks up leave the scene. A polygon might see something that a few more rays would meet.
TEST(RayMixture, AnEnvironmentThatAllRaysReachIsNotCertain) {
  Ids ids;
  ids.names = {"up"}, ids.areas = {2.0}, ids.surface = {0};
  ReplicateSums sums(ids);
  sums.countRays({2.0});
  constexpr uint64_t kRays = 128, kCounts = 1'000;  // of a ray
  for (int replicate = 0; replicate < 8; ++replicate) sums.add({{0, kEnvironment, kRays * kCounts, 0}});
  const double unit = 2.0 / (2 * kCounts);  // A ray stands for the area 2, and 2 counts for a unit.
  const FormFactors found = sums.formFactors(unit / kRays, unit);
  ASSERT_EQ(found.entries().size(), 1u);
  EXPECT_NEAR(found.entries()[0].exchange_area.value, 2, 1e-12);
  EXPECT_NEAR(found.entries()[0].exchange_area.standard_error / 2, 1.0 / (8 * kRays), 0.1 / (8 * kRays));
}

// One large row varies from replicate to replicate by 8 of 128 rays, nine small rows by one ray. Rows weigh alike, for
// the large row says as much about the small ones as one of them does.
TEST(RayMixture, TheEfficiencyOfRaysIsThatOfAllRows) {
  constexpr uint64_t kRays = 128, kCounts = 1'000;  // of a ray, for each unit of area
  constexpr int kOf = 8;                            // replicates
  Ids ids;
  for (uint32_t k = 0; k < 10; ++k)
    ids.names.push_back(std::to_string(k)), ids.areas.push_back(k ? 1 : 1'000), ids.surface.push_back(0);
  ReplicateSums sums(ids);
  sums.countRays(ids.areas);
  for (int replicate = 0; replicate < kOf; ++replicate) {
    PairCounts counts;
    for (uint32_t k = 0; k < 10; ++k) {
      const uint64_t spread = k ? 1 : 8, rays = kRays / 2 + (replicate % 2 ? spread : -spread);
      counts.push_back({k, kEnvironment, rays * kCounts * static_cast<uint64_t>(ids.areas[k])});
    }
    sums.add(counts);
  }
  // A mean of eight counts of 64 +- d has the variance d^2 / 7, of independent rays 128 / 4 / 8. Eq. (12) adds the
  // variance of one ray to the sum of eight counts: 1 / 64 to that of their mean.
  const double unit = 1.0 / (2 * kCounts), independent = 128.0 / 4 / kOf,
               expected = (64.0 / 7 + 9 * 1.0 / 7) / (10 * independent);
  EXPECT_NEAR(sums.rayEfficiency(unit / kRays, unit), expected, 2.0 / (kOf * kOf) / independent);
}

// Row 0 has rays in five replicates, row 1 in two; the pair between them is counted in two.
TEST(RayMixture, FurtherReplicatesCountForTheirRowsAlone) {
  Ids ids;
  ids.names = {"a", "b"}, ids.areas = {2.0, 2.0}, ids.surface = {0, 1};
  ReplicateSums sums(ids), parts(ids);
  for (ReplicateSums* each : {&sums, &parts}) each->countRays({2.0, 2.0});
  sums.add({{0, 1, 10}, {0, kEnvironment, 100}, {1, kEnvironment, 50}});
  sums.add({{0, 1, 14}, {0, kEnvironment, 110}, {1, kEnvironment, 54}});
  for (const uint64_t count : {90, 105}) sums.addOutside({{0, kEnvironment, count}}, {true, false});
  parts.addOutside({{0, kEnvironment, 95}}, {true, false});
  sums.add(parts);
  EXPECT_EQ(sums.replicateCount(), 5u);
  EXPECT_EQ(sums.replicatesOf(0, 1), 2u);
  EXPECT_EQ(sums.replicatesOf(0, kEnvironment), 5u);
  EXPECT_EQ(sums.replicatesOf(1, kEnvironment), 2u);
  const FormFactors found = sums.formFactors(1);
  EXPECT_DOUBLE_EQ(found.exchangeArea(0, 1).value, 2 * 12);
  EXPECT_DOUBLE_EQ(found.exchangeArea(0, kEnvironment).value, 2 * 100);
  EXPECT_DOUBLE_EQ(found.exchangeArea(1, kEnvironment).value, 2 * 52);
  // Five counts with a variance of 62.5 and two with one of 8. What eq. (12) adds is below 2 % of it.
  EXPECT_NEAR(found.exchangeArea(0, kEnvironment).standard_error, 2 * std::sqrt(62.5 / 5), 0.02 * 2 * std::sqrt(12.5));
  EXPECT_NEAR(found.exchangeArea(1, kEnvironment).standard_error, 2 * std::sqrt(8.0 / 2), 0.05 * 2 * 2);
  // A row sum is that of replicates in which all rows have rays: 110 and 124 counts.
  EXPECT_DOUBLE_EQ(found.rowSums()[0].value, 2 * 117 / 2.0);
}

// Numbers of rays vary by a factor of 8 at most (kLeastShareOfRays). With these rays errors of environments are within
// the tolerance, and about as large in all rows that have more rays than the least.
TEST(RayMixture, RaysGoToRowsThatErr) {
  const Scene scene = city();
  const Ids ids = makeIds(scene, By::polygon, false);
  std::vector<uint32_t> row_of_face(ids.count());
  std::iota(row_of_face.begin(), row_of_face.end(), 0);
  constexpr double kFineGoal = 0.02;
  const auto planAll = [&](const std::vector<uint32_t>& rows, double goal, uint64_t seed, By by) {
    const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
    const EstimateOptions options{.replicates = kReplicates, .tolerance = goal, .seed = seed, .by = by};
    return RayPlanner(*engine, scene, ids, rows, seed, mayHaveRaysAlone(options)).plan(options);
  };
  const auto plan = [&](const std::vector<uint32_t>& rows, double goal, uint64_t seed = 1) {
    const PlannedRays planned = planAll(rows, goal, seed, By::polygon);
    EXPECT_TRUE(planned.alone.empty());  // lines must count the large pairs of polygons
    return planned.outside;
  };
  const std::vector<uint32_t> rays = plan(row_of_face, kFineGoal);
  const uint32_t least = std::ranges::min(rays), most = std::ranges::max(rays);
  EXPECT_GE(8 * least, most);
  EXPECT_GE(most, 4 * least);
  EXPECT_NE(plan(row_of_face, kFineGoal, 2), rays);
  const auto sumOf = [](const std::vector<uint32_t>& all) { return std::accumulate(all.begin(), all.end(), 0.0); };
  // Errors fall as N^-0.7, so half of them take 2.7 times the rays; numbers are rounded up by a third at most.
  EXPECT_NEAR(std::log2(sumOf(plan(row_of_face, kFineGoal / 2)) / sumOf(rays)), 1 / 0.7, std::log2(4 / 3.0));
  // A surface of many polygons errs less than each of them. They have equal numbers of rays.
  const std::vector<uint32_t> by_surface = plan(ids.surface, kFineGoal);
  EXPECT_LT(sumOf(by_surface), sumOf(rays));
  std::vector<uint32_t> of_surface(ids.count());
  for (uint32_t face = 0; face < ids.count(); ++face) of_surface[ids.surface[face]] = by_surface[face];
  for (uint32_t face = 0; face < ids.count(); ++face) EXPECT_EQ(by_surface[face], of_surface[ids.surface[face]]);
  // With rays alone a row has the rays of its environment at least.
  const std::vector<uint32_t> alone = planAll(ids.surface, kFineGoal, 1, By::surface).alone;
  const uint32_t most_of_surface = std::ranges::max(by_surface);
  for (uint32_t face = 0; face < ids.count(); ++face) {
    of_surface[ids.surface[face]] = alone[face];
    if (8 * by_surface[face] > most_of_surface) {
      EXPECT_GE(alone[face], by_surface[face]);
    }
  }
  for (uint32_t face = 0; face < ids.count(); ++face) EXPECT_EQ(alone[face], of_surface[ids.surface[face]]);
  // Numbers are rounded up by a third at most, and F (1 - F) is above 1/8, half of what the guess takes, for most rows.
  const double guess = guessRaysAlone(ids, {.replicates = kReplicates, .tolerance = kFineGoal, .by = By::surface});
  EXPECT_GE(guess, 0.75 * kReplicates * sumOf(alone));
  EXPECT_LE(guess, 2 * kReplicates * sumOf(alone));

  const std::unique_ptr<RayEngine> engine = makeRayEngine(scene, ids, {.thread_count = 2});
  engine->setRays(rays);
  ReplicateSums sums(ids);
  for (uint32_t r = 0; r < kReplicates; ++r) sums.add(engine->count(sampleDirections(Sampler::iid, most, 3, r)));
  const FormFactors found = sums.formFactors(engine->unitArea() * scene.scale * scene.scale / most),
                    truth = computeFormFactors(scene, requestFor(kFineGoal / 20)).form_factors;
  double largest = 0;
  for (const FormFactors::Entry& entry : truth.entries())
    if (entry.j == kEnvironment)
      largest = std::max(largest, std::abs(found.exchangeArea(entry.i, entry.j).value - entry.exchange_area.value) /
                                      ids.areas[entry.i]);
  EXPECT_LT(largest, kFineGoal);
  EXPECT_GT(largest, kFineGoal / 8);  // no more rays than the goal asks for
}

}  // namespace
}  // namespace viewpeel
