// An MPI job of several ranks gives the bytes of a run alone, speaks with one voice, and ends together.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "tests/support/python.h"
#include "tests/support/running.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;
const std::string kStreet = VIEWPEEL_SCENES "/street.obj";

// Open MPI takes root only if told so twice, and more ranks than processors only if told so. It insists on a remote
// shell even where it needs none; any program stands in for it. MPICH needs nothing.
#if VIEWPEEL_HAS_OPEN_MPI
constexpr const char* kLauncher =
    "env OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_plm_rsh_agent=sh " VIEWPEEL_MPIRUN
    " --oversubscribe -n ";
constexpr const char* kRankVariable = "OMPI_COMM_WORLD_RANK";
#else
constexpr const char* kLauncher = VIEWPEEL_MPIRUN " -n ";
constexpr const char* kRankVariable = "PMI_RANK";
#endif
std::string launcher(int ranks) { return kLauncher + std::to_string(ranks); }

Result runRanks(int ranks, const std::string& arguments) { return run(arguments, launcher(ranks)); }

// Returns the lines of the output that begin with the word.
std::vector<std::string> linesOf(const std::string& output, const std::string& word) {
  std::vector<std::string> lines;
  std::istringstream in(output);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(word)) lines.push_back(line);
  return lines;
}

// Returns the parent of a process; 0 where it has ended.
pid_t parentOf(pid_t process) {
  const std::string status = readFile(fmt::format("/proc/{}/status", process)), word = "\nPPid:\t";
  const size_t at = status.find(word);
  return at == std::string::npos ? 0 : std::stoi(status.substr(at + word.size()));
}

// Returns the process of a rank of a running job.    In: job: process of mpirun, whose child or grandchild it is
pid_t findRank(pid_t job, int rank) {
  const std::string number = fmt::format("{}={}", kRankVariable, rank) + '\0';
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const pid_t process = std::stoi(name), parent = parentOf(process);
    if ((parent == job || (parent && parentOf(parent) == job)) &&
        readFile(entry.path() / "environ").find(number) != std::string::npos)
      return process;
  }
  return 0;
}

class RankProgram : public Program {
 protected:
  void expectBytesOfARunAlone(const std::string& options, const std::vector<int>& sizes) {
    SCOPED_TRACE(options);
    const std::string compute = "compute " + options + " --quiet -o ";
    const Result of_one = run(compute + file("alone.csv"));
    ASSERT_EQ(of_one.status, 0) << of_one.output;
    const std::string alone = readFile(file("alone.csv"));
    ASSERT_FALSE(alone.empty());
    for (const int ranks : sizes) {
      const Result shared = runRanks(ranks, compute + file("shared.csv"));
      EXPECT_EQ(shared.status, 0) << ranks << ": " << shared.output;
      EXPECT_EQ(shared.output, of_one.output) << ranks;  // warnings
      EXPECT_EQ(readFile(file("shared.csv")), alone) << ranks;
      fs::remove(file("shared.csv"));
    }
  }
  void waitForFile(Running& running, const std::string& name) {
    for (int turn = 0; turn < 600 && !fs::exists(file(name)) && !running.hasEnded(); ++turn) waitFor(0.05);
    ASSERT_TRUE(fs::exists(file(name))) << readFile(file("messages"));
  }
};

TEST_F(RankProgram, GivesTheBytesOfARunAlone) {
  expectBytesOfARunAlone(kStreet + " --directions 30 --replicates 3", {1, 2, 3, 5});
  expectBytesOfARunAlone(kStreet + " --tolerance 5e-3 --promise off", {2, 5});
  expectBytesOfARunAlone(kStreet + " --epsilon 1e-2 --by surface", {3});
  expectBytesOfARunAlone(kStreet + " --tolerance 1e-2", {3});  // a promise
  expectBytesOfARunAlone(VIEWPEEL_SCENES "/past_edge.obj --directions 64 --unoccluded on --relative 0.05 --floor 1e-4",
                         {2});  // pairs with directions of their own
}

TEST_F(RankProgram, CountsByComputeShaders) {
  expectBytesOfARunAlone(kStreet + " --engine compute --device cpu --directions 8 --replicates 2", {2});
}

// Ranks with different numbers of threads have different shares.
TEST_F(RankProgram, MayBeUneven) {
  const std::string options = "compute " + kStreet + " --directions 30 --replicates 3 --quiet -o ";
  ASSERT_EQ(run(options + file("alone.csv")).status, 0);
  const std::string rank = " " VIEWPEEL_PROGRAM " " + options + file("shared.csv") + " --threads ";
  const Result shared =
      run(options + file("shared.csv") + " --threads 1 :" + " -n 1" + rank + "3 : -n 2" + rank + "2", launcher(1));
  EXPECT_EQ(shared.status, 0) << shared.output;
  EXPECT_EQ(readFile(file("shared.csv")), readFile(file("alone.csv")));
}

TEST_F(RankProgram, SolvesAsARunAlone) {
  const std::string solve = "solve " VIEWPEEL_SCENES "/office.obj --materials " VIEWPEEL_SCENES
                            "/office_materials.csv --form-factors 5e-3 --quiet -o ";
  ASSERT_EQ(run(solve + file("alone.csv")).status, 0);
  ASSERT_EQ(runRanks(2, solve + file("shared.csv")).status, 0);
  EXPECT_EQ(readFile(file("shared.csv")), readFile(file("alone.csv")));
  const std::string products = "solve " VIEWPEEL_SCENES "/office.obj --materials " VIEWPEEL_SCENES
                               "/office_materials.csv --matrix-free on --quiet -o ";
  ASSERT_EQ(run(products + file("alone.csv")).status, 0);
  ASSERT_EQ(runRanks(3, products + file("shared.csv")).status, 0);
  EXPECT_EQ(readFile(file("shared.csv")), readFile(file("alone.csv")));
}

TEST_F(RankProgram, HasBlocksOfRows) {
  const std::string options = "compute " + kStreet + " --directions 30 --replicates 3 --unoccluded off --quiet -o ";
  ASSERT_EQ(run(options + file("alone.h5")).status, 0);
  const Result shared = runRanks(3, options + file("shared.h5") + " --row-blocks 3");
  ASSERT_EQ(shared.status, 0) << shared.output;
  const PythonResult judged = runPython(folder_, R"(
import h5py, numpy
a, b = h5py.File('alone.h5'), h5py.File('shared.h5')
def names(f):
    found = []
    f.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return sorted(found)
assert names(a) == names(b) and len(names(a)) > 15
for name in names(a):
    if a[name].dtype != h5py.ref_dtype: assert numpy.array_equal(a[name][:], b[name][:]), name
assert set(a.attrs) == set(b.attrs), set(a.attrs) ^ set(b.attrs)
)");
  EXPECT_EQ(judged.status, 0) << judged.output;
  const Result refused = run(options + file("a.csv") + " --row-blocks 2");
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.output.find("give -o NAME.h5"), std::string::npos) << refused.output;
  // A tolerance is planned, and the report reads the file.
  const std::string planned = "compute " + kStreet + " --tolerance 2e-2 --resolution 128 --quiet -o ";
  ASSERT_EQ(run(planned + file("b.h5") + " --row-blocks 2").status, 0);
  ASSERT_EQ(run("report " + file("b.h5") + " -o " + file("b.html")).status, 0);
}

// Rank 0 prints once, whatever all ranks have met.
TEST_F(RankProgram, SpeaksWithOneVoice) {
  const Result missing = runRanks(3, "compute " + file("missing.obj"));
  EXPECT_EQ(missing.status, 2);
  EXPECT_EQ(linesOf(missing.output, "viewpeel:").size(), 1u) << missing.output;
  const Result mistaken = runRanks(3, "compute " + kStreet + " --tolerence 1e-3");
  EXPECT_EQ(mistaken.status, 2);
  EXPECT_EQ(linesOf(mistaken.output, "viewpeel:").size(), 1u) << mistaken.output;
  const Result good = runRanks(3, "compute " + kStreet + " --tolerance 2e-2");
  EXPECT_EQ(good.status, 0);
  EXPECT_EQ(linesOf(good.output, "scene").size(), 1u) << good.output;
  EXPECT_EQ(linesOf(good.output, "ranks      3 ").size(), 1u) << good.output;
}

// An error of another rank ends the job with one line of rank 0, and what rank 0 alone does needs no other.
TEST_F(RankProgram, ErrorsOfOtherRanksEndTheJob) {
  const std::string rank = " : -n 1 " VIEWPEEL_PROGRAM " compute ";
  const Result other = run("compute " + kStreet + rank + VIEWPEEL_SCENES "/cube.obj", launcher(1));
  EXPECT_EQ(other.status, 2);
  ASSERT_EQ(linesOf(other.output, "viewpeel:").size(), 1u) << other.output;
  EXPECT_NE(other.output.find("viewpeel: rank 1: has read another scene than rank 0"), std::string::npos);
  const Result missing = run("compute " + kStreet + rank + file("missing.obj"), launcher(1));
  EXPECT_EQ(missing.status, 2);
  ASSERT_EQ(linesOf(missing.output, "viewpeel:").size(), 1u) << missing.output;
  EXPECT_NE(missing.output.find("viewpeel: rank 1: " + file("missing.obj")), std::string::npos);
  EXPECT_EQ(runRanks(2, "plan " + kStreet + " --quiet").output.find("rank"), std::string::npos);
}

// A killed rank ends the job. The checkpoint is whole, and other ranks go on from it, to the bytes of a run alone.
TEST_F(RankProgram, AKilledRankLeavesAWholeCheckpoint) {
  const std::string options = "compute " + kStreet + " --directions 16 --quiet --checkpoint ";
  {
    Running job(options + file("a.h5") + " --replicates 1000000 --checkpoint-seconds 0", file("messages"), "",
                launcher(3));
    waitForFile(job, "a.h5");
    const pid_t victim = findRank(job.pid(), 2);
    ASSERT_GT(victim, 0) << readFile(file("messages"));
    ::kill(victim, SIGKILL);
    EXPECT_NE(job.wait(), 0);
  }
  const std::string done = replicatesOf("a.h5");  // "0 to 17 (18)" or so
  const size_t last = done.find("to ");
  ASSERT_NE(last, std::string::npos) << done;
  const std::string all = fmt::format(" --replicates {}", std::stoul(done.substr(last + 3)) + 4);
  const Result resumed = runRanks(2, options + file("a.h5") + all + " --resume -o " + file("resumed.csv"));
  ASSERT_EQ(resumed.status, 0) << resumed.output;
  ASSERT_EQ(run("compute " + kStreet + " --directions 16 --quiet" + all + " -o " + file("alone.csv")).status, 0);
  EXPECT_EQ(readFile(file("resumed.csv")), readFile(file("alone.csv")));
}

// A signal to mpirun stops all ranks together, and rank 0 writes the results so far.
TEST_F(RankProgram, SignalsStopAllRanks) {
  Running job("compute " + kStreet + " --directions 16 --replicates 1000000 --checkpoint-seconds 0 --checkpoint " +
                  file("a.h5") + " -o " + file("a.csv"),
              file("messages"), "", launcher(3));
  waitForFile(job, "a.h5");
  waitFor(0.5);
  const auto start = Clock::now();
  job.send(SIGTERM);
  const int status = job.wait();
  EXPECT_TRUE(status != 0 || !VIEWPEEL_HAS_OPEN_MPI);  // MPICH's mpirun then ends with 0, whatever ranks say
  EXPECT_LT(secondsSince(start), kSoon);
  const std::string messages = readFile(file("messages"));
  const std::vector<std::string> lines = linesOf(messages, "viewpeel: stopped by SIGTERM");
  ASSERT_EQ(lines.size(), 1u) << messages;
  EXPECT_NE(lines[0].find("results are written"), std::string::npos) << messages;
  EXPECT_NE(replicatesOf("a.h5").find("0 to "), std::string::npos);
  EXPECT_TRUE(fs::exists(file("a.csv")));
}

}  // namespace
}  // namespace viewpeel
