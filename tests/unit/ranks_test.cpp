// A run that several ranks share has the bits of a run alone, whatever its goal and however uneven the ranks are. Here
// ranks are threads; tests/program/ranks_test.cpp has processes of an MPI job.
#include <atomic>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/ranks.h>

#include "directions/sampler.h"
#include "engines/host_engine.h"
#include "ranks/crew.h"
#include "ranks/message.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_folder.h"
#include "tests/support/thread_ranks.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

Request onHost(Goal goal) {
  Request request;
  request.engine = EngineKind::host;
  request.goal = goal;
  request.threads = 1;
  return request;
}

// Rank r above 0 has `threads` threads, or r of them where that is 0.
Result computeOnRanks(uint32_t size, const Scene& scene, Request request, uint32_t threads = 1) {
  std::optional<Result> result;
  test::withRanks(
      size,
      [&](Ranks& ranks) {
        Request own = request;
        own.threads = threads ? threads : ranks.rank();
        serveRanks(ranks, scene, own);
      },
      [&](Ranks& ranks) {
        request.ranks = &ranks;
        result = computeFormFactors(scene, request);
      });
  return std::move(*result);
}

void expectSameBits(const Result& one, const Result& other, const std::string& what) {
  SCOPED_TRACE(what);
  ASSERT_EQ(one.form_factors.entries().size(), other.form_factors.entries().size());
  ASSERT_FALSE(one.form_factors.entries().empty());
  for (size_t k = 0; k < one.form_factors.entries().size(); ++k) {
    const FormFactors::Entry &a = one.form_factors.entries()[k], &b = other.form_factors.entries()[k];
    ASSERT_EQ(std::pair(a.i, a.j), std::pair(b.i, b.j)) << k;
    ASSERT_EQ(a.exchange_area.value, b.exchange_area.value) << a.i << " and " << a.j;
    ASSERT_EQ(a.exchange_area.standard_error, b.exchange_area.standard_error) << a.i << " and " << a.j;
  }
  EXPECT_EQ(one.replicates, other.replicates);
  EXPECT_EQ(one.directions, other.directions);
}

class RanksInAFolder : public TestFolder {};

struct Case {
  const char* name;
  Request request;
};

std::vector<Case> cases() {
  Request fixed = onHost(FixedAmount{.directions = 30, .replicates = 3}), windows = fixed, unoccluded = fixed,
          lines = onHost(Tolerance{5e-3}), cut = onHost(Tolerance{5e-4}), promise = onHost(Tolerance{1e-2}),
          guarantee = onHost(EpsilonDelta{2e-2}), strata = onHost(EpsilonDelta{5e-4}),
          // A plan of blocks depends on measured times, unless the request has both of its figures.
      blocks = onHost(EpsilonDelta{.epsilon = 0.2, .delta = 0.1, .range = 4, .block_directions = 40});
  windows.goal = FixedAmount{.directions = 30, .replicates = 3, .resolution = 64, .finest = 256};
  unoccluded.unoccluded = true;
  lines.promise = cut.promise = false;
  promise.promise = true;
  guarantee.by = By::surface;
  blocks.pair_lines = false;
  blocks.by = By::surface;
  return {{"directions", fixed},
          {"windows", windows},
          {"visibilities", unoccluded},
          {"pair lines to a tolerance", lines},
          {"lines of pairs that are cut", cut},
          {"a promise", promise},
          {"a guarantee by pair lines", guarantee},
          {"a guarantee by lines in strata", strata},
          {"a guarantee by blocks of directions", blocks}};
}

TEST(Ranks, GiveTheBitsOfARunAlone) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  for (const Case& of : cases()) {
    const Result alone = computeFormFactors(scene, of.request);
    for (const uint32_t size : {1u, 2u, 3u, 5u})
      expectSameBits(alone, computeOnRanks(size, scene, of.request), std::string(of.name) + " on ranks");
  }
}

TEST(Ranks, OfUnevenThreadsGiveTheSameBits) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  for (const Case& of : cases())
    expectSameBits(computeFormFactors(scene, of.request), computeOnRanks(4, scene, of.request, 0), of.name);
}

// Negative control: a run with another seed has other bits.
TEST(Ranks, AnotherSeedHasOtherBits) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  Request request = onHost(FixedAmount{.directions = 30, .replicates = 3});
  const Result one = computeOnRanks(2, scene, request);
  request.seed = 2;
  const Result other = computeOnRanks(2, scene, request);
  bool differs = one.form_factors.entries().size() != other.form_factors.entries().size();
  for (size_t k = 0; !differs && k < one.form_factors.entries().size(); ++k)
    differs = one.form_factors.entries()[k].exchange_area.value != other.form_factors.entries()[k].exchange_area.value;
  EXPECT_TRUE(differs);
}

// Rows and columns of a question have roles, which the other ranks need.
TEST(Ranks, AnswerQuestions) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/office.obj");
  Request from = onHost(FixedAmount{.directions = 30, .replicates = 3});
  from.question.from = {"lamp"};
  from.question.blockers = {"shelves"};
  Request pair = onHost(Tolerance{1e-3});
  pair.question.pair = {"lamp", "person"};
  for (const Request& request : {from, pair})
    expectSameBits(computeFormFactors(scene, request), computeOnRanks(3, scene, request), "question");
}

// Returns the error with which a run on these ranks begins.
Error refusalOnRanks(Ranks& ranks, const Scene& scene, Request request) {
  request.ranks = &ranks;
  try {
    FormFactorRun(scene, request);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "was not refused";
  return {ErrorCode::limit, ""};
}

TEST(Ranks, OfAnotherSceneAreRefused) {
  const Scene scene = buildScene(ts::parallelSquares()), other = buildScene(ts::insideOfCube());
  const Request request = onHost(FixedAmount{});
  test::withRanks(
      3, [&](Ranks& ranks) { serveRanks(ranks, ranks.rank() == 2 ? other : scene, request); },
      [&](Ranks& ranks) {
        const Error error = refusalOnRanks(ranks, scene, request);
        EXPECT_EQ(error.code(), ErrorCode::bad_usage);
        EXPECT_EQ(std::string(error.what()).rfind("rank 2: has read another scene", 0), 0u) << error.what();
      });
}

// Rank 0 ends with the error of a rank that has no scene, and the others end, too.
TEST(Ranks, ErrorsReachRank0) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Request request = onHost(FixedAmount{});
  test::withRanks(
      3,
      [&](Ranks& ranks) {
        if (ranks.rank() == 1) serveRanks(ranks, Error(ErrorCode::bad_input, "box.obj: cannot open"));
        else serveRanks(ranks, scene, request);
      },
      [&](Ranks& ranks) {
        const Error error = refusalOnRanks(ranks, scene, request);
        EXPECT_EQ(error.code(), ErrorCode::bad_input);
        EXPECT_STREQ(error.what(), "rank 1: box.obj: cannot open");
      });
}

// A run that is stopped keeps complete replicates, with the bits of a run alone. The next run on the same ranks is not
// affected by the stop.
TEST(Ranks, StopTogetherAndGoOn) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  const Request request = onHost(FixedAmount{.directions = 50, .replicates = 100'000});
  Request two = request;
  two.goal = FixedAmount{.directions = 50, .replicates = 2};
  test::withRanks(
      3, [&](Ranks& ranks) { serveRanks(ranks, scene, request); },
      [&](Ranks& ranks) {
        Request shared = request, after = two;
        shared.ranks = after.ranks = &ranks;
        std::atomic<uint64_t> replicates = 0;
        std::atomic<bool> counts = false;
        Observer observer;
        observer.on_progress = [&](const Progress& progress) { replicates = progress.replicates; };
        observer.on_count = [&](bool begins) { counts = begins; };
        observer.should_stop = [&] { return replicates >= 3 && counts; };  // within the fourth
        const Result stopped = computeFormFactors(scene, shared, observer);
        EXPECT_TRUE(stopped.interrupted);
        ASSERT_EQ(stopped.replicates, 3u);
        Request three = request;
        three.goal = FixedAmount{.directions = 50, .replicates = 3};
        expectSameBits(computeFormFactors(scene, three), stopped, "stopped");
        expectSameBits(computeFormFactors(scene, two), computeFormFactors(scene, after), "after");
      });
}

// A checkpoint of one number of ranks goes on with another.
TEST_F(RanksInAFolder, ResumeWithOthers) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  const auto file = folder_ / "kept.h5";
  Request request = onHost(Tolerance{5e-3});
  request.promise = false;
  const auto runFor = [&](uint32_t size, uint64_t most_replicates, bool resumes) {
    std::optional<Result> result;
    test::withRanks(
        size, [&](Ranks& ranks) { serveRanks(ranks, scene, request); },
        [&](Ranks& ranks) {
          Request shared = request;
          shared.ranks = &ranks;
          FormFactorRun run(scene, shared);
          if (resumes) run.resumeFrom(file);
          while (!run.isDone() && run.replicateCount() < most_replicates) run.step();
          run.writeCheckpoint(file);
          result = run.resultSoFar();
        });
    return std::move(*result);
  };
  runFor(3, 3, false);
  expectSameBits(computeFormFactors(scene, request), runFor(2, 1'000'000, true), "resumed");
}

// docs/clusters.md states the messages and bytes of a run of directions: 96 bytes a direction, 24 a pair that the
// directions of a rank met, and little more.
TEST(Ranks, MessagesAreAsLargeAsTheDocumentsSay) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  constexpr uint32_t kSize = 4, kDirections = 40, kReplicates = 3;
  Request request = onHost(FixedAmount{.directions = kDirections, .replicates = kReplicates});
  const auto measure = [&](uint32_t replicates) {
    request.goal = FixedAmount{.directions = kDirections, .replicates = replicates};
    return test::withRanks(
        kSize, [&](Ranks& ranks) { serveRanks(ranks, scene, request); },
        [&](Ranks& ranks) {
          Request shared = request;
          shared.ranks = &ranks;
          computeFormFactors(scene, shared);
        });
  };
  const auto [messages, bytes] = measure(kReplicates);
  const auto [more_messages, more_bytes] = measure(kReplicates + 1);
  EXPECT_EQ(more_messages - messages, 2 * (kSize - 1));
  // Another engine counts the pairs that a rank's ten directions of the last replicate meet.
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::unique_ptr<Engine> engine = makeHostEngine(scene, ids, {.sampling = Sampling::scanline});
  const std::vector<Direction> all = sampleDirections(Sampler::fibonacci, kDirections, request.seed, kReplicates);
  uint64_t expected = 0;
  for (uint32_t rank = 1; rank < kSize; ++rank) {
    const size_t pairs = engine->count(std::span(all).subspan(10 * rank, 10)).size();
    expected += 17 + 96 * 10 + 9 + 24 * pairs;
  }
  EXPECT_EQ(more_bytes - bytes, expected);
}

// --- what ranks say to each other -----------------------------------------------------------------------------------

TEST(Messages, AreReadAsTheyWereWritten) {
  const std::string message =
      MessageWriter().put(uint8_t(7)).putAll(std::vector<double>{1, -2.5}).putAll(std::string("desk")).take();
  MessageReader in(message);
  EXPECT_EQ(in.get<uint8_t>(), 7);
  EXPECT_EQ(in.getAll<double>(), (std::vector<double>{1, -2.5}));
  EXPECT_EQ(in.getText(), "desk");
  EXPECT_THROW(in.get<uint8_t>(), Error);
}

// A message that was cut off is an error at every length.
TEST(Messages, CutOffAreRefused) {
  const std::string message = MessageWriter().put(uint8_t(7)).putAll(std::vector<double>{1, -2.5}).take();
  for (size_t length = 0; length < message.size(); ++length) {
    const std::string part = message.substr(0, length);
    EXPECT_THROW(
        {
          MessageReader in(part);
          in.get<uint8_t>();
          in.getAll<double>();
        },
        Error)
        << length;
  }
}

// Crew::cut() gives every task to one rank, in order. A rank's share of the costs is that of its threads, to within one
// task.
TEST(Crew, CutsByCostAndThreads) {
  const std::vector<double> costs{1, 1, 10, 1, 1, 1, 1, 2, 2, 10, 1, 1};
  test::withRanks(
      3,
      [](Ranks& ranks) {
        // A rank of r threads, which greets.
        for (;;) {
          const std::optional<std::string> question = ranks.poll(0);
          if (!question) continue;
          const bool is_end = RankWork((*question)[0]) == RankWork::end;
          ranks.send(0, is_end ? MessageWriter().put(RankAnswer::ended).take()
                               : MessageWriter().put(RankAnswer::done).put(uint64_t(ranks.rank())).take());
          if (is_end) return;
        }
      },
      [&](Ranks& ranks) {
        const Crew crew(ranks, 0, 1, [] {});  // of 1, 1 and 2 threads
        const std::vector<size_t> cuts = crew.cut(costs);
        ASSERT_EQ(cuts.size(), 4u);
        EXPECT_EQ(cuts.front(), 0u);
        EXPECT_EQ(cuts.back(), costs.size());
        const double threads[] = {1, 1, 2};
        double largest = 10, all = 32;
        for (size_t rank = 0; rank < 3; ++rank) {
          ASSERT_LE(cuts[rank], cuts[rank + 1]);
          double cost = 0;
          for (size_t k = cuts[rank]; k < cuts[rank + 1]; ++k) cost += costs[k];
          EXPECT_NEAR(cost, all * threads[rank] / 4, largest) << rank;
        }
        EXPECT_EQ(crew.cut(std::vector<double>{}), (std::vector<size_t>{0, 0, 0, 0}));
        EXPECT_EQ(crew.cut(std::vector<double>(12, 1.0), false), (std::vector<size_t>{0, 4, 8, 12}));
      });
}

}  // namespace
}  // namespace viewpeel
