// Long runs lose no replicate. The program is killed or interrupted, continues, and writes the bytes of an undisturbed
// run.
#include <random>

#include <fmt/format.h>

#include "tests/support/running.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class LongRun : public Program {};

// These tests kill the program at random times: within a replicate, while it writes the checkpoint, or while it starts.
class KilledRun : public LongRun, public testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(LongRun, KilledRun, testing::Values("off", "on"),
                         [](const auto& unoccluded) { return fmt::format("Unoccluded_{}", unoccluded.param); });

TEST_P(KilledRun, AnywhereAndResumedIsTheSameRun) {
  const auto seed = std::random_device{}();
  std::printf("seed %u\n", seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const std::string options =
      kComputeOffice + "--directions 100 --replicates 40 --checkpoint-seconds 0 --unoccluded " + GetParam() + " ";
  ASSERT_EQ(run(options + "-o " + file("whole.csv") + " --checkpoint " + file("whole.h5")).status, 0);

  const std::string resumed = options + "-o " + file("a.csv") + " --checkpoint " + file("a.h5") + " --resume";
  const auto waitForCheckpoint = [&](Running& running, const std::string& old) {
    while (!running.hasEnded() && readFile(file("a.h5")) == old) waitFor(0.002);
  };
  int kills = 0;
  while (kills < 7) {
    const std::string old = readFile(file("a.h5"));
    Running running(resumed, file("messages"));
    // Every third kill comes at any time after the start. The others wait for a new checkpoint, so that the run gets
    // on.
    if (kills % 3 == 2) waitFor(std::uniform_real_distribution(0.0, 0.4)(random));
    else waitForCheckpoint(running, old);
    waitFor(std::uniform_real_distribution(0.0, 0.15)(random));
    if (running.hasEnded()) break;
    running.send(SIGKILL);
    const int status = running.wait();
    if (status == 0) break;  // the run ended before the signal came
    EXPECT_EQ(status, -SIGKILL);
    ++kills;
    EXPECT_FALSE(fs::exists(file("a.csv")));
  }
  EXPECT_GE(kills, 2);
  EXPECT_EQ(replicatesOf("a.h5").find("0 to "), 0u) << replicatesOf("a.h5");  // the killed runs kept a checkpoint
  const Result last = run(resumed);
  EXPECT_EQ(last.status, 0) << last.output;
  EXPECT_EQ(replicatesOf("a.h5"), "0 to 39");
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("whole.csv")));
  EXPECT_EQ(readFile(file("a.h5")), readFile(file("whole.h5")));
}

// A replicate takes minutes here. The program stops within seconds all the same.
TEST_F(LongRun, SignalsStopItWithinSeconds) {
  for (const auto& [signal, name] :
       {std::pair(SIGINT, "SIGINT"), std::pair(SIGTERM, "SIGTERM"), std::pair(SIGHUP, "SIGHUP")}) {
    Running running(kComputeOffice + "--directions 300000 -o " + file("a.csv") + " --checkpoint " + file("a.h5"),
                    file("messages"));
    waitFor(3);
    const auto start = Clock::now();
    running.send(signal);
    EXPECT_EQ(running.wait(), 128 + signal) << readFile(file("messages"));
    EXPECT_LT(secondsSince(start), kSoon);
    EXPECT_EQ(readFile(file("messages")),
              std::string("viewpeel: stopped by ") + name + ", 0 replicates done; too few to write results\n");
    EXPECT_FALSE(fs::exists(file("a.h5")) || fs::exists(file("a.csv")));
  }
}

TEST_F(LongRun, InterruptedIsWrittenAndResumed) {
  for (const std::string engine : {"compute", "graphics", "exact"}) {
    const std::string options = kComputeOffice + "--directions 20 --replicates 5000 --engine " + engine +
                                " --checkpoint " + file(engine + ".h5") + " ";
    {
      Running running(options + "--checkpoint-seconds 0 -o " + file("a.csv"), file("messages"));
      while (!running.hasEnded() && !fs::exists(file(engine + ".h5"))) waitFor(0.01);
      const std::string first = readFile(file(engine + ".h5"));
      while (!running.hasEnded() && readFile(file(engine + ".h5")) == first) waitFor(0.01);
      running.send(SIGTERM);
      EXPECT_EQ(running.wait(), 143) << engine << readFile(file("messages"));
    }
    const std::string messages = readFile(file("messages"));
    EXPECT_NE(messages.find(engine + ".h5 has what was counted, go on with --resume; results are written\n"),
              std::string::npos)
        << messages;
    EXPECT_EQ(std::count(messages.begin(), messages.end(), '\n'), 1) << messages;
    // The results equal the results of one run with this number of replicates.
    EXPECT_EQ(run("merge --quiet " + file(engine + ".h5") + " -o " + file("merged.csv")).status, 0);
    EXPECT_EQ(readFile(file("a.csv")), readFile(file("merged.csv")));
    const std::string replicates = replicatesOf(engine + ".h5");
    ASSERT_EQ(replicates.find("0 to "), 0u) << replicates;
    const std::string done = std::to_string(std::stoul(replicates.substr(5)) + 1);
    EXPECT_EQ(
        run(kComputeOffice + "--directions 20 --engine " + engine + " --replicates " + done + " -o " + file("one.csv"))
            .status,
        0);
    EXPECT_EQ(readFile(file("a.csv")), readFile(file("one.csv")));
  }
}

// Slurm announces the end of a job by SIGUSR1. The run then writes the results so far, goes on, and ends with the bytes
// of an undisturbed run.
TEST_F(LongRun, ResultsAreWrittenOnRequestAndTheRunGoesOn) {
  const std::string options = kComputeOffice + "--directions 20 --replicates 400 ";
  ASSERT_EQ(run(options + "-o " + file("whole.csv")).status, 0);
  Running running(options + "-o " + file("a.csv") + " --checkpoint-seconds 0 --checkpoint " + file("a.h5"),
                  file("messages"));
  while (!running.hasEnded() && !fs::exists(file("a.h5"))) waitFor(0.01);
  EXPECT_FALSE(fs::exists(file("a.csv")));
  while (!running.hasEnded() && !fs::exists(file("a.csv"))) {
    running.send(SIGUSR1);
    waitFor(0.05);
  }
  const std::string early = readFile(file("a.csv"));
  EXPECT_EQ(running.wait(), 0);
  EXPECT_NE(readFile(file("messages")).find(" so far are written; the run goes on\n"), std::string::npos)
      << readFile(file("messages"));
  EXPECT_NE(early, readFile(file("whole.csv")));
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("whole.csv")));
}

// A run under nohup ignores the hang-up signal of its terminal.
TEST_F(LongRun, AnIgnoredHangUpStaysIgnored) {
  Running running(kComputeOffice + "--directions 20 --replicates 300 -o " + file("a.csv") + " --checkpoint-seconds 0 " +
                      "--checkpoint " + file("a.h5"),
                  file("messages"), "trap '' HUP; ");
  while (!running.hasEnded() && !fs::exists(file("a.h5"))) waitFor(0.01);
  running.send(SIGHUP);
  EXPECT_EQ(running.wait(), 0) << readFile(file("messages"));
  EXPECT_TRUE(fs::exists(file("a.csv")));
}

// A plan depends on measured times, so a second plan may differ. The checkpoint keeps the plan, and the resumed run
// follows it. The plan of pair lines does not depend on times, and is kept as well.
TEST_F(LongRun, PlansAndGuaranteesAreResumed) {
  const std::pair<std::string, std::vector<std::string>> runs[] = {
      {kComputeOffice + "--tolerance 2e-3 ", {"--pair-lines"}},
      {kComputeOffice + "--tolerance 2e-3 --pair-lines off ", {"--directions", "--resolution", "--finest"}},
      {"compute " VIEWPEEL_SCENES "/office.obj --quiet --tolerance 3e-2 --pair-lines off ",
       {"--directions", "--resolution", "--finest", "--unoccluded"}},
      {"compute " VIEWPEEL_SCENES "/plates.obj --quiet --epsilon 0.03 --pair-lines off ", {"--range", "--block"}}};
  int k = 0;
  for (const auto& [options, chosen] : runs) {
    const std::string name = "c" + std::to_string(k++) + ".h5", checkpoint = options + "--checkpoint " + file(name);
    {
      Running running(checkpoint + " --checkpoint-seconds 0", file("messages"));
      while (!running.hasEnded() && !fs::exists(file(name))) waitFor(0.002);
      running.send(SIGKILL);
      running.wait();
    }
    const std::string shown = run("merge " + file(name)).output;
    ASSERT_EQ(run(checkpoint + " --resume -o " + file("resumed.csv")).status, 0);
    std::string same = options;
    for (const std::string& option : chosen) {
      const std::string value = shownValue(shown, option);
      ASSERT_NE(value, shown) << option << " is missing";
      if (value != "0") same += option + " " + value + " ";
    }
    ASSERT_EQ(run(same + "-o " + file("whole.csv")).status, 0) << same;
    EXPECT_EQ(readFile(file("resumed.csv")), readFile(file("whole.csv"))) << same;
    EXPECT_FALSE(readFile(file("whole.csv")).empty());
  }
}

// A checkpoint that is damaged, or of another run, is refused in one line with status 2. The file does not change.
TEST_F(LongRun, WrongCheckpointsAreRefused) {
  std::ofstream(file("scene.obj"))
      << "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nv 0 0 1\nv 0 1 1\nv 1 0 1\nf 4 5 6\n";
  std::ofstream(file("other.obj"))
      << "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nv 0 0 2\nv 0 1 2\nv 1 0 2\nf 4 5 6\n";
  std::ofstream(file("no.h5")) << "not a checkpoint";
  const std::string exact = " --quiet --engine exact --directions 5 --checkpoint ";
  const std::string scene = "compute " + file("scene.obj") + exact + file("a.h5");
  ASSERT_EQ(run(scene).status, 0);
  ASSERT_EQ(run("compute " + file("scene.obj") + exact + file("b.h5") + " --first-replicate 12").status, 0);
  ASSERT_EQ(run("merge --quiet " + file("a.h5") + " " + file("b.h5") + " --checkpoint " + file("gap.h5")).status, 0);
  const std::string planned =
      "compute " + file("scene.obj") + " --quiet --tolerance 0.1 --pair-lines off --checkpoint " + file("planned.h5");
  ASSERT_EQ(run(planned).status, 0);
  const std::string lines =
      "compute " + file("scene.obj") + " --quiet --tolerance 0.1 --checkpoint " + file("lines.h5");
  ASSERT_EQ(run(lines).status, 0);
  ASSERT_EQ(run("compute " + file("scene.obj") + " --quiet --directions 5 --checkpoint " + file("lattice.h5")).status,
            0);
  const std::string before = readFile(file("a.h5"));
  const std::pair<std::string, std::string> cases[] = {
      {scene, "--resume, or remove it"},
      {"compute " + file("other.obj") + exact + file("a.h5") + " --resume", "scene is '2 polygons"},
      {scene + " --resume --seed 2", "--seed is '1' there, '2' here"},
      {scene + "  --resume --two-sided", "--two-sided"},
      {scene + "  --resume --by surface", "--by"},
      {"compute " + file("scene.obj") + " --quiet --directions 5 --resume --unoccluded on --checkpoint " +
           file("lattice.h5"),
       "--unoccluded is 'off' there, 'on' here"},
      {scene + "  --resume --sampler iid", "--sampler"},
      {scene + "  --resume --from a", "--from"},
      {scene + "  --resume --pair a b", "--pair"},
      {scene + "  --resume --blocker a", "--blocker"},
      {"compute " + file("scene.obj") + " --quiet --engine exact --directions 6 --resume --checkpoint " + file("a.h5"),
       "--directions is '5' there, '6' here"},
      {"compute " + file("scene.obj") + " --quiet --engine host --directions 5 --resume --checkpoint " + file("a.h5"),
       "--sampling is 'exact areas' there, 'scanline' here"},
      {scene + "  --resume --first-replicate 3", "--first-replicate 3"},
      {"compute " + file("scene.obj") + exact + file("gap.h5") + " --resume", "0 to 7, 12 to 19"},
      {planned + " --resume --resolution 2000", "--resolution is '"},
      {lines + " --resume --resolution 2000", "--resolution asks for common directions"},
      {"compute " + file("scene.obj") + exact + file("no.h5") + " --resume", "another file"},
      {"compute " + file("scene.obj") + " --resume", "--checkpoint"},
      {"merge " + file("a.h5") + " " + file("no.h5"), "another file"},
      {"merge " + file("b.h5") + " --checkpoint " + file("a.h5"), "there is a checkpoint already"},
      {"merge " + file("missing.h5"), "No such file"},
      {"merge " + file("a.h5") + " -o " + file("a.xyz"), ".csv, .mtx, .npz"},
  };
  for (const auto& [arguments, part] : cases) {
    const Result r = run(arguments);
    EXPECT_EQ(r.status, 2) << arguments << "\n" << r.output;
    EXPECT_NE(r.output.find(part), std::string::npos) << arguments << "\n" << r.output;
    EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << arguments << "\n" << r.output;
    EXPECT_EQ(r.output.find("viewpeel: "), 0u) << r.output;
  }
  // The refusal comes before the plan: a plan for another goal would take its time first.
  for (const char* other : {"--seed 2", "--two-sided", "--epsilon 0.5 --pair-lines off"}) {
    const Result r = run("compute " + file("scene.obj") + " --resume --checkpoint " + file("planned.h5") + " " + other);
    EXPECT_EQ(r.status, 2) << r.output;
    EXPECT_NE(r.output.find("a checkpoint of another run"), std::string::npos) << r.output;
    EXPECT_EQ(r.output.find("sampling   "), std::string::npos) << r.output;
  }
  EXPECT_EQ(readFile(file("a.h5")), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()),
            9);  // two scenes, seven checkpoints, and no leftovers
  // With the same options the run goes on.
  EXPECT_EQ(run(scene + " --resume --replicates 10").status, 0);
  EXPECT_EQ(replicatesOf("a.h5"), "0 to 9");
}

// No file may grow beyond 40 x 512 bytes here. The old checkpoint stays, the results are written, and the exit status
// is 1.
TEST_F(LongRun, FullDiskCostsTheCheckpointAlone) {
  const std::string options = "compute " VIEWPEEL_SCENES
                              "/office.obj --by surface --quiet --engine exact --directions 5 --checkpoint " +
                              file("a.h5");
  ASSERT_EQ(run(options).status, 0);
  const std::string before = readFile(file("a.h5"));
  ASSERT_GT(before.size(), 20480u);
  const Result r = run(options + " --resume --replicates 12 -o " + file("a.csv"), "trap '' XFSZ; ulimit -f 40;");
  EXPECT_EQ(r.status, 1) << r.output;
  EXPECT_NE(r.output.find("viewpeel: warning: checkpoint: " + file("a.h5") + ": cannot write: File too large"),
            std::string::npos)
      << r.output;
  EXPECT_EQ(readFile(file("a.h5")), before);
  EXPECT_EQ(run("compute " VIEWPEEL_SCENES
                "/office.obj --by surface --quiet --engine exact --directions 5 --replicates 12 -o " +
                file("b.csv"))
                .status,
            0);
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 3);
}

}  // namespace
}  // namespace viewpeel
