// The library starts one thread for each processor that it may use, and results do not depend on their number.
// ThreadSanitizer watches these tests in the preset tsan.
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/same_bits.h"
#include "engines/host_engine.h"
#include "estimator/find_prior.h"
#include "sums/neighbour_visibility.h"
#include "scene/rank_by_place.h"
#include "scenes/named_scenes.h"
#include "threads.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

cpu_set_t allowed() {
  cpu_set_t set;
  EXPECT_EQ(::sched_getaffinity(0, sizeof set, &set), 0);
  return set;
}

cpu_set_t firstOf(const cpu_set_t& set) {
  int first = 0;
  while (!CPU_ISSET(first, &set)) ++first;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  return one;
}

// Runs the work in a new thread. That thread, and all threads that it starts, may use only the processors of `set`.
void runOn(const cpu_set_t& set, const std::function<void()>& work) {
  std::jthread([&] {
    ASSERT_EQ(::sched_setaffinity(0, sizeof set, &set), 0);
    work();
  });
}

// Under `taskset -c 0` there is one thread.
TEST(Threads, AreAsManyAsProcessorsAllowed) {
  const cpu_set_t set = allowed();
  EXPECT_EQ(threadCount(), static_cast<size_t>(CPU_COUNT(&set)));
  runOn(firstOf(set), [] { EXPECT_EQ(threadCount(), 1u); });
}

// Shares out tasks where there is no room for the stack of another thread. Ends the process with status 0 where all
// tasks are done.
[[noreturn]] void shareOutWithoutRoom() {
  constexpr rlim_t kRoom = 1 << 20;  // a stack takes 8 MB
  std::ifstream pages("/proc/self/statm");
  rlim_t used = 0;
  pages >> used;
  const rlimit limit{used * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kRoom, RLIM_INFINITY};
  if (::setrlimit(RLIMIT_AS, &limit) != 0) std::_Exit(2);
  std::atomic<size_t> done = 0;
  shareOut(4, 100, 1, [&](size_t, size_t) { ++done; });
  std::_Exit(done == 100 ? 0 : 1);
}

TEST(Threads, OneDoesTheWorkWhereNoOtherCanBeStarted) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer takes address space at all times";
#endif
  EXPECT_EXIT(shareOutWithoutRoom(), testing::ExitedWithCode(0), "");
}

// Returns all processors of the machine, also where fewer are allowed to the test.
cpu_set_t allOf() {
  cpu_set_t all;
  CPU_ZERO(&all);
  for (int k = 0; k < CPU_SETSIZE; ++k) CPU_SET(k, &all);
  return all;
}

bool isAlone() {
  size_t threads = 0;
  runOn(allOf(), [&] { threads = threadCount(); });
  return threads < 2;
}

// Returns a cube in a cube, cut into 972 faces.
InputScene cubeInCubeInParts() {
  constexpr int kCuts = 9;
  InputScene input{"cube in cube, cut", {}, {}};
  for (const InputFace& face : ts::cubeInCube(0.3).faces)
    for (int x = 0; x < kCuts; ++x)
      for (int y = 0; y < kCuts; ++y) {
        const glm::dvec3 a = (face.corners[1] - face.corners[0]) / double(kCuts),
                         b = (face.corners[3] - face.corners[0]) / double(kCuts);
        ts::addFace(input, face.surface ? "inner" : "outer",
                    ts::parallelogram(face.corners[0] + double(x) * a + double(y) * b, a, b));
      }
  return input;
}

// A run with unoccluded form factors has the same bits on one processor and on all. It goes through lattices, pilots,
// pairs, sums by polygon and by surface, and form factors. The lists are long enough that several threads share them.
TEST(Threads, NeverChangeARunWithUnoccludedFormFactors) {
  if (isAlone()) GTEST_SKIP() << "there is one processor";
  const Scene scene = buildScene(cubeInCubeInParts());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto estimate = [&](By by) {
    const auto engine = makeHostEngine(scene, ids, {.resolution = 48, .count_blocked = true});
    FaceExchanges exchanges(nullptr, scene, ids);
    EstimateOptions options{.directions = 48, .replicates = 2};
    const FoundPrior found = findPrior(*engine, exchanges, scene, ids, groupAsOne(scene, 48), options,
                                       {choosePriorPilot(options).directions});
    EXPECT_EQ(threadsFor(found.prior.pairs.size()), threadCount()) << found.prior.pairs.size();
    options.prior = &found.prior;
    options.by = by;
    options.on_sums = [](const RunSums& sums, bool) {
      const size_t pairs =
          sums.hasPairsInVisible() ? sums.prior_sums->byFace().pairs().size() : sums.by_id.pairs().size();
      EXPECT_EQ(threadsFor(pairs), threadCount()) << pairs;
    };
    return estimateFormFactors(*engine, scene, ids, options);
  };
  for (const By by : {By::polygon, By::surface}) {
    std::optional<Estimate> on_one, on_all;
    runOn(firstOf(allowed()), [&] { on_one = estimate(by); });
    runOn(allOf(), [&] { on_all = estimate(by); });
    ASSERT_TRUE(on_one && on_all);
    expectSameBits(on_one->form_factors, on_all->form_factors);
    expectSameBits(on_one->between_surfaces, on_all->between_surfaces);
  }
}

// Most pairs here have no line. Their form factors are unoccluded form factors of whole rows times the visibility of
// neighbours.
TEST(Threads, NeverChangeRowsOfUnoccludedFormFactors) {
  if (isAlone()) GTEST_SKIP() << "there is one processor";
  const Scene scene = buildScene(cubeInCubeInParts());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeHostEngine(scene, ids, {.resolution = 24, .count_blocked = true, .thread_count = 1});
  VisibilitySums sums(ids);
  for (uint64_t replicate = 0; replicate < 2; ++replicate)
    sums.add(engine->count(sampleDirections(Sampler::fibonacci, 8, 1, replicate)));
  const std::vector<uint32_t> ranks = rankByPlace(scene, ids.of_polygon, ids.count());
  const NeighbourVisibility neighbours(sums, {}, ranks);
  FaceExchanges exchanges(nullptr, scene, ids);
  const ExchangeRow rows = exchanges.rows();
  std::optional<FormFactors> on_one, on_all;
  const auto make = [&] {
    return FormFactors(sums.ids(), sums.find({}, {}, 1, INFINITY, {}, {}, &neighbours, rows).entries, {});
  };
  runOn(firstOf(allowed()), [&] { on_one = make(); });
  runOn(allOf(), [&] { on_all = make(); });
  ASSERT_TRUE(on_one && on_all);
  EXPECT_GT(on_one->entries().size(), 2 * sums.pairs().size());
  expectSameBits(*on_one, *on_all);
}

}  // namespace
}  // namespace viewpeel
