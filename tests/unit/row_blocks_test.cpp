// A matrix that is computed in blocks of rows has the bits of one that is in memory as a whole.
#include <viewpeel/row_blocks.h>

#include <algorithm>

#include <gtest/gtest.h>

#include <viewpeel/drop_below.h>
#include <viewpeel/error.h>
#include <viewpeel/ranks.h>
#include <viewpeel/read.h>
#include <viewpeel/write.h>

#include "io/hdf5_input.h"
#include "scenes/generate.h"
#include "tests/support/test_folder.h"
#include "tests/support/thread_ranks.h"

namespace viewpeel {
namespace {

class RowBlocks : public TestFolder {
 protected:
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  static Request fixed(By by = By::polygon) {
    Request request;
    request.by = by;
    request.engine = EngineKind::host;
    request.goal = FixedAmount{.directions = 20, .replicates = 3, .resolution = 64};
    request.threads = 1;
    return request;
  }
  RowBlocksSummary compute(const Scene& scene, const Request& request, uint32_t blocks, const std::string& name) {
    return computeRowBlocks(scene, {.request = request, .block_count = blocks, .output = file(name)});
  }
  // Compares all columns of two files.
  void expectSameColumns(const std::string& a, const std::string& b) {
    SCOPED_TRACE(a);
    Hdf5Input one(file(a), "result", ""), other(file(b), "result", "");
    for (const char* name :
         {"form_factors/data", "standard_errors/data", "area", "environment", "environment_standard_error", "leak",
          "leak_standard_error", "row_sum", "row_sum_standard_error"}) {
      const std::vector<double> values = one.read<double>(name);
      EXPECT_FALSE(values.empty()) << name;
      EXPECT_EQ(values, other.read<double>(name)) << name;
    }
    for (const char* name : {"form_factors/indices", "from"})
      EXPECT_EQ(one.read<int32_t>(name), other.read<int32_t>(name)) << name;
    for (const char* name : {"form_factors/indptr", "pair"})
      EXPECT_EQ(one.read<int64_t>(name), other.read<int64_t>(name)) << name;
    EXPECT_EQ(one.readTexts("name"), other.readTexts("name"));
  }
};

TEST_F(RowBlocks, GiveTheFileOfAWholeMatrix) {
  const Scene scene = buildScene(bench::city(400));
  for (const By by : {By::polygon, By::surface}) {
    Request request = fixed(by);
    request.unoccluded = false;
    const Result whole = computeFormFactors(scene, request);
    writeFormFactors({.form_factors = whole.form_factors, .scene = &scene}, file("whole.h5"));
    for (const uint32_t blocks : {1u, 2u, 7u, 1000u}) {
      const RowBlocksSummary found = compute(scene, request, blocks, "blocks.h5");
      expectSameColumns("blocks.h5", "whole.h5");
      EXPECT_EQ(found.largest_standard_error, whole.largest_standard_error);
      EXPECT_EQ(found.closure.largest_error, whole.closure.largest_error);
      EXPECT_EQ(found.environment_share, whole.environment_share);
      EXPECT_EQ(found.replicates, 3u);
      // Readers that verify the check sum take the file.
      EXPECT_EQ(readResult(file("blocks.h5")).form_factors.entries().size(), whole.form_factors.entries().size());
    }
  }
  Request other = fixed();
  other.seed = 2;
  compute(scene, other, 3, "other.h5");
  Hdf5Input one(file("other.h5"), "result", ""), two(file("blocks.h5"), "result", "");
  EXPECT_NE(one.read<double>("form_factors/data"), two.read<double>("form_factors/data"));
}

TEST_F(RowBlocks, AreSharedByRanks) {
  const Scene scene = buildScene(bench::city(300));
  const Request request = fixed();
  compute(scene, request, 1, "alone.h5");
  for (const uint32_t size : {2u, 3u, 5u})
    for (const uint32_t blocks : {1u, size, 2 * size + 1}) {
      test::withRanks(
          size, [&](Ranks& ranks) { serveRanks(ranks, scene, request); },
          [&](Ranks& ranks) {
            Request shared = request;
            shared.ranks = &ranks;
            compute(scene, shared, blocks, "shared.h5");
          });
      expectSameColumns("shared.h5", "alone.h5");
    }
}

TEST_F(RowBlocks, LeaveOutSmallPairs) {
  const Scene scene = buildScene(bench::city(300));
  Request request = fixed();
  request.unoccluded = false;
  const Result whole = computeFormFactors(scene, request);
  constexpr double kLeast = 2e-3;
  const DroppedBelow below = dropBelow(whole.form_factors, kLeast);
  writeFormFactors({.form_factors = below.kept, .scene = &scene, .dropped = &below.dropped}, file("whole.h5"));
  for (const uint32_t blocks : {1u, 4u}) {
    const RowBlocksSummary found = computeRowBlocks(
        scene, {.request = request, .block_count = blocks, .drop_below = kLeast, .output = file("blocks.h5")});
    expectSameColumns("blocks.h5", "whole.h5");
    Hdf5Input one(file("blocks.h5"), "result", ""), other(file("whole.h5"), "result", "");
    for (const char* name : {"dropped", "dropped_standard_error"})
      EXPECT_EQ(one.read<double>(name), other.read<double>(name)) << name;
    EXPECT_GT(found.dropped_pairs, 0u);
    EXPECT_EQ(found.dropped_pairs, below.dropped.pairs);
    EXPECT_EQ(found.most_dropped, std::ranges::max(one.read<double>("dropped")));
    EXPECT_EQ(found.largest_standard_error, whole.largest_standard_error);
  }
}

TEST_F(RowBlocks, ReachATolerance) {
  const Scene scene = buildScene(bench::city(200));
  Request request = fixed();
  for (const Goal& goal : {Goal(Tolerance{0.01}), Goal(Relative{0.2})}) {
    request.goal = goal;
    const RowBlocksSummary found = compute(scene, request, 5, "blocks.h5");
    // The file is that of the whole matrix, by the directions, replicates and resolution that the run has taken.
    Request same = request;
    same.unoccluded = false;
    same.goal = FixedAmount{static_cast<uint32_t>(found.directions / found.replicates),
                            static_cast<uint32_t>(found.replicates), found.resolution};
    const Result whole = computeFormFactors(scene, same);
    writeFormFactors({.form_factors = whole.form_factors, .scene = &scene}, file("whole.h5"));
    expectSameColumns("blocks.h5", "whole.h5");
    EXPECT_LE(goal.index() == 0 ? whole.largest_standard_error / 0.01 : whole.largest_relative_error / 0.2, 1);
  }
  // A goal that eight planned replicates do not reach takes more.
  request.goal = Tolerance{2e-3};
  request.amount = {.directions = 50, .resolution = 128};
  const RowBlocksSummary more = compute(scene, request, 3, "more.h5");
  EXPECT_GT(more.replicates, 8u);
  EXPECT_EQ(more.directions, 50 * more.replicates);
  EXPECT_LE(more.largest_standard_error, 2e-3);
  // Ranks take as many.
  test::withRanks(
      3, [&](Ranks& ranks) { serveRanks(ranks, scene, request); },
      [&](Ranks& ranks) {
        Request shared = request;
        shared.ranks = &ranks;
        EXPECT_EQ(compute(scene, shared, 7, "shared.h5").replicates, more.replicates);
      });
  expectSameColumns("shared.h5", "more.h5");
}

TEST_F(RowBlocks, RefuseWhatNeedsTheWholeMatrix) {
  const Scene scene = buildScene(bench::city(60));
  const auto refuses = [&](const Request& request, const std::string& part, uint32_t blocks = 2,
                           const std::string& name = "a.h5") {
    try {
      compute(scene, request, blocks, name);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_usage);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      return;
    }
    ADD_FAILURE() << "nothing says " << part;
  };
  Request guarantee = fixed(), from = fixed(), balance = fixed(), windows = fixed(), timed = fixed();
  guarantee.goal = EpsilonDelta{};
  timed.time_limit_s = 60;
  from.question.from = {scene.surfaces[0].name};
  balance.balance = true;
  windows.goal = FixedAmount{.directions = 20, .replicates = 3, .resolution = 64, .finest = 256};
  refuses(guarantee, "leave out --epsilon");
  refuses(timed, "leave out --seconds");
  refuses(from, "leave out --from");
  refuses(balance, "leave out --balance");
  refuses(windows, "leave out --finest");
  refuses(fixed(), "0 is not a number of blocks", 0);
  refuses(fixed(), "give -o NAME.h5", 2, "a.csv");
  EXPECT_THROW(computeRowBlocks(scene, {.request = fixed(), .drop_below = 1, .output = file("a.h5")}), Error);
}

TEST_F(RowBlocks, AStoppedRunWritesNothing) {
  const Scene scene = buildScene(bench::city(60));
  const RowBlocksSummary found = computeRowBlocks(scene, {.request = fixed(), .block_count = 2, .output = file("a.h5")},
                                                  {.should_stop = [] { return true; }});
  EXPECT_TRUE(found.interrupted);
  EXPECT_FALSE(std::filesystem::exists(file("a.h5")));
  EXPECT_THROW(compute(scene, fixed(), 2, "no_such_folder/a.h5"), Error);
  // The pilots of a plan may be stopped, too.
  Request planned = fixed();
  planned.goal = Tolerance{};
  int looks = 0;
  const RowBlocksSummary stopped =
      computeRowBlocks(scene, {.request = planned, .block_count = 2, .output = file("b.h5")},
                       {.should_stop = [&] { return ++looks > 3; }});
  EXPECT_TRUE(stopped.interrupted);
  EXPECT_EQ(stopped.replicates, 0u);
  EXPECT_FALSE(std::filesystem::exists(file("b.h5")));
}

}  // namespace
}  // namespace viewpeel
