// These tests make the driver, the device or memory fail, start a second run, or interrupt the program. It ends with
// one line, and keeps the replicates that it counted.
#include <algorithm>

#include <fmt/format.h>

#include "tests/support/running.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

// Returns environment variables that load the layer of fault_layer.cpp, which makes `fault` happen. Validation is off,
// for the layer breaks its rules on purpose. Mesa's device selection is off too, for it crashes without devices.
std::string withFault(const std::string& fault) {
  return "NODEVICE_SELECT=1 VK_LAYER_PATH=" VIEWPEEL_FAULT_LAYER
         " VK_INSTANCE_LAYERS=VK_LAYER_VIEWPEEL_faults VIEWPEEL_VALIDATION=0 VIEWPEEL_FAULT=" +
         fault;
}

const std::string kSteady = kComputeOffice + "--engine compute --directions 50 --resolution 64 --batch 25 ";

class Fault : public Program {
 protected:
  void expectOneLine(const Result& result, int status, const std::vector<std::string>& parts) {
    EXPECT_EQ(result.status, status) << result.output;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
    EXPECT_EQ(result.output.find("viewpeel: "), 0u) << result.output;
    for (const std::string& part : parts) EXPECT_NE(result.output.find(part), std::string::npos) << result.output;
  }
  // Returns the number of replicates in a checkpoint that begins with replicate 0; 0 without a checkpoint.
  uint64_t replicateCountOf(const std::string& name) const {
    const std::string kFirst = "0 to ", held = replicatesOf(name);
    return held.starts_with(kFirst) ? std::stoul(held.substr(kFirst.size())) + 1 : 0;
  }
  std::string writeSheets() const {
    std::ofstream out(file("sheets.obj"));
    for (int k = 0; k < 200; ++k)
      out << fmt::format("v 0 0 {0}\nv 1 0 {0}\nv 1 1 {0}\nv 0 1 {0}\nf -4 -3 -2 -1\n", 0.01 * k);
    return file("sheets.obj");
  }
  // Returns the number of directions that are on the device at once, from the line `plan` that follows `after`.
  static unsigned atOnce(const Result& result, const char* after) {
    unsigned batches = 0, directions = 0;
    std::string word;
    std::istringstream plan(result.output.substr(
        std::min(result.output.find("plan       ", result.output.find(after)), result.output.size())));
    EXPECT_TRUE(plan >> word >> batches >> word >> directions) << result.output;
    return batches * directions;
  }
  // Writes squares of random size at random places. A device takes some time for every direction of such a scene, and
  // so does reading the file.
  std::string writeLargeScene(int count) const {
    std::ofstream out(file("large.obj"));
    uint64_t state = 1;
    const auto random = [&] {
      return double((state = state * 6364136223846793005u + 1442695040888963407u) >> 40) / 1.7e7;
    };
    for (int k = 0; k < count; ++k) {
      const double x = random(), y = random(), z = random(), edge = 0.02 + 0.05 * random();
      out << fmt::format("v {0} {1} {2}\nv {3} {1} {2}\nv {3} {4} {2}\nv {0} {4} {2}\nf -4 -3 -2 -1\n", x, y, z,
                         x + edge, y + edge);
    }
    return file("large.obj");
  }
};

// The tests below need the layer: it is loaded, and without a fault it changes no result.
TEST_F(Fault, LayerIsUsed) {
  const Result listed = run("devices", withFault("version"));
  EXPECT_NE(listed.output.find("needs Vulkan 1.3"), std::string::npos) << listed.output;
  EXPECT_EQ(run(kSteady + "-o " + file("a.csv"), withFault("")).status, 0);
  EXPECT_EQ(run(kSteady + "-o " + file("b.csv")).status, 0);
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
}

TEST_F(Fault, NoUsableDeviceIsReportedWithTheReason) {
  const std::string plates = "compute " VIEWPEEL_SCENES "/plates.obj --quiet --engine compute";
  expectOneLine(run(plates, "VK_DRIVER_FILES=/nowhere.json VK_ICD_FILENAMES=/nowhere.json"), 1,
                {"no Vulkan driver found; install"});
  expectOneLine(run(plates, withFault("none")), 1, {"no Vulkan driver found; install"});
  const std::string check = "check " VIEWPEEL_SCENES "/plates.obj --directions 1 --lattices 8 --resolution 16 ";
  expectOneLine(run(check, withFault("none")), 1, {"no Vulkan driver found; install", "--engine host"});
  EXPECT_EQ(run(check + "--engine host", withFault("none")).status, 0);
  expectOneLine(run(plates, withFault("version")), 1,
                {"no usable device: 0: ", "(needs Vulkan 1.3)", "viewpeel devices"});
  expectOneLine(run(plates, withFault("feature")), 1, {"no usable device: 0: ", "lacks shaderInt64"});
}

// A device without timestamps cannot say how long its passes take. The counts are the same.
TEST_F(Fault, ADeviceWithoutAClockCountsTheSame) {
  for (const char* options :
       {"--engine compute --directions 20 ", "--engine compute --unoccluded on --directions 20 "}) {
    ASSERT_EQ(run(kComputeOffice + options + "-o " + file("with.csv")).status, 0);
    ASSERT_EQ(run(kComputeOffice + options + "-o " + file("without.csv"), withFault("clock")).status, 0) << options;
    EXPECT_EQ(readFile(file("without.csv")), readFile(file("with.csv"))) << options;
  }
}

// The device is lost at the first submission, while planning, or later. A run that goes on from the checkpoint then
// writes the bytes of a run without fault.
TEST_F(Fault, LostDeviceKeepsTheCheckpoint) {
  ASSERT_EQ(run(kSteady + "-o " + file("whole.csv")).status, 0);
  uint64_t most = 0;
  for (int submission : {1, 9, 20}) {
    const std::string options =
        kSteady + "--checkpoint-seconds 0 -o " + file("a.csv") + " --checkpoint " + file("a.h5");
    expectOneLine(run(options, withFault(fmt::format("lost:{}", submission))), 1,
                  {"the device was lost; run again, or choose another with --device"});
    EXPECT_FALSE(fs::exists(file("a.csv")));
    most = std::max(most, replicateCountOf("a.h5"));
    ASSERT_EQ(run(options + " --resume").status, 0) << submission;
    EXPECT_EQ(readFile(file("a.csv")), readFile(file("whole.csv"))) << submission;
    fs::remove(file("a.csv"));
    fs::remove(file("a.h5"));
  }
  EXPECT_GE(most, 1u);  // at least one run had kept a replicate
  for (const std::string planned : {"--tolerance 1e-3 --engine compute", "--epsilon 0.1 --engine compute",
                                    "--unoccluded on --engine compute", "--engine graphics --directions 20"})
    expectOneLine(run(kComputeOffice + planned, withFault("lost:8")), 1, {"the device was lost"});
}

// The device is lost while it draws pair lines, or has less and less memory. Where it has none for pair lines, the
// processor draws them, to the same bytes.
TEST_F(Fault, PairLinesOutliveTheDevice) {
  const std::string street =
      "compute " VIEWPEEL_SCENES
      "/street.obj --quiet --tolerance 2e-2 --seconds 1000 --pair-lines on --engine compute -o " +
      file("a.csv");  // with a time limit the first replicate is drawn, and saved, before the others
  ASSERT_EQ(run(street, withFault("")).status, 0);
  const std::string whole = readFile(file("a.csv"));
  const std::string kept = street + " --checkpoint-seconds 0 --checkpoint " + file("a.h5");
  uint64_t most = 0;
  for (int submission : {4, 8, 11}) {
    fs::remove(file("a.csv"));
    expectOneLine(run(kept, withFault(fmt::format("lost:{}", submission))), 1, {"the device was lost"});
    most = std::max(most, replicateCountOf("a.h5"));
    ASSERT_EQ(run(kept + " --resume").status, 0) << submission;
    EXPECT_TRUE(readFile(file("a.csv")) == whole) << submission;
    fs::remove(file("a.h5"));
  }
  EXPECT_GE(most, 1u);
  for (const int kib : {4096, 1024, 256, 1}) {
    fs::remove(file("a.csv"));
    ASSERT_EQ(run(street, withFault(fmt::format("space:{}", kib))).status, 0) << kib;
    EXPECT_TRUE(readFile(file("a.csv")) == whole) << kib;
  }
}

TEST_F(Fault, LackOfDeviceMemoryIsAClearError) {
  for (const std::string planned :
       {"--directions 50 --engine compute", "--tolerance 1e-3 --pair-lines off --engine compute",
        "--epsilon 0.1 --engine compute", "--unoccluded on --engine compute", "--engine graphics --directions 20"})
    for (int allocation : {1, 12})
      expectOneLine(run(kComputeOffice + planned, withFault(fmt::format("memory:{}", allocation))), 1,
                    {"cannot allocate", "try a smaller"});
}

// The device's memory shrinks from run to run. It holds the planned batches, then only smaller ones, then still smaller
// ones once the lists of tiles grow, and at last not even one direction. Sheets above one another make the lists long.
// Every run that ends writes the same bytes.
TEST_F(Fault, LackOfDeviceMemoryMakesBatchesSmaller) {
  const std::string options =
      "compute --engine compute " + writeSheets() +
      " --two-sided --sampling lattice --directions 16 --resolution 128 --batch 8 --replicates 2 --verbose -o " +
      file("a.csv");
  ASSERT_EQ(run(options, withFault("")).status, 0);
  const std::string whole = readFile(file("a.csv"));
  int as_planned = 0, smaller = 0, smaller_later = 0, refused = 0;
  // The 32 MiB buffer in which counters are read back is added, for it exists before any batch.
  for (double mib = 20; mib > 0.3; mib = mib / 1.5 - 0.1) {
    fs::remove(file("a.csv"));
    const Result result = run(options, withFault(fmt::format("space:{}", int((32 + mib) * 1024))));
    if (result.status != 0) {
      EXPECT_EQ(result.status, 1) << result.output;
      EXPECT_NE(result.output.find("\nviewpeel: one direction at a time does not fit: "), std::string::npos)
          << result.output;
      ++refused;
      continue;
    }
    EXPECT_EQ(readFile(file("a.csv")), whole) << mib;
    const unsigned first = atOnce(result, "sampling"), last = atOnce(result, "after a trial");
    as_planned += first == 16 && last == 16;
    smaller += first < 16;
    smaller_later += last < first;
  }
  EXPECT_GT(as_planned, 0);
  EXPECT_GT(smaller, 0);
  EXPECT_GT(smaller_later, 0);
  EXPECT_GT(refused, 0);
}

// The number of texels that a device can address shrinks from run to run. Batches shrink as well, for the length of
// lists depends on the batch.
TEST_F(Fault, ListsTooLongToAddressMakeBatchesSmaller) {
  const std::string options =
      "compute --engine compute " + writeSheets() +
      " --two-sided --sampling lattice --directions 16 --resolution 128 --batch 8 --replicates 2 --verbose -o " +
      file("a.csv");
  ASSERT_EQ(run(options, withFault("")).status, 0);
  const std::string whole = readFile(file("a.csv"));
  int as_planned = 0, smaller = 0, refused = 0;
  for (uint32_t texels = 1u << 17; texels >= 1u << 13; texels /= 2) {
    fs::remove(file("a.csv"));
    const Result result = run(options, withFault(fmt::format("texels:{}", texels)));
    if (result.status != 0) {
      EXPECT_EQ(result.status, 1) << result.output;
      EXPECT_NE(result.output.find(fmt::format(
                    "\nviewpeel: one direction at a time does not fit: polygons reach more than {} tiles", texels)),
                std::string::npos)
          << result.output;
      ++refused;
      continue;
    }
    EXPECT_EQ(readFile(file("a.csv")), whole) << texels;
    const unsigned last = atOnce(result, "after a trial");
    as_planned += last == 16;
    smaller += last < 16;
  }
  EXPECT_GT(as_planned, 0);
  EXPECT_GT(smaller, 0);
  EXPECT_GT(refused, 0);
}

// A signal ends the program within two seconds while it reads a scene, plans, integrates unoccluded form factors, or
// counts one long batch of any engine.
TEST_F(Fault, SignalEndsALargeRunWithinTwoSeconds) {
  const std::string large = "compute " + writeLargeScene(100'000) + " --quiet ";
  const std::pair<std::string, double> runs[] = {
      {large, 0.2},
      {large, 2.5},
      {large + "--engine compute", 2.5},
      {large + "--directions 1000 --resolution 1000 --engine compute --by surface", 2.5},
      {large + "--directions 1000 --resolution 1000 --by surface", 2.5},
      {large + "--engine graphics --by surface --directions 1000 --resolution 256", 2.5},
      {large + "--engine exact --directions 10", 1.5},
      {"compute " VIEWPEEL_SCENES "/office.obj --quiet --tolerance 1e-5", 1}};
  for (const auto& [options, after] : runs) {
    Running running(options + " -o " + file("a.csv"), file("messages"));
    waitFor(after);
    ASSERT_FALSE(running.hasEnded()) << options << readFile(file("messages"));
    const auto start = Clock::now();
    running.send(SIGINT);
    EXPECT_EQ(running.wait(), 130) << options << readFile(file("messages"));
    EXPECT_LT(secondsSince(start), kSoon) << options;
    // A warning may precede this line, for some squares lie in one plane by chance.
    EXPECT_NE(readFile(file("messages")).find("viewpeel: stopped by SIGINT, "), std::string::npos)
        << readFile(file("messages"));
  }
}

// One batch here takes longer than a run may take to stop. The replicates counted before it are written within that
// time.
TEST_F(Fault, SignalInALongBatchKeepsTheReplicatesBefore) {
  const std::string options =
      "compute " + writeLargeScene(15'000) +
      " --quiet --by surface --two-sided --engine graphics --directions 1 --resolution 8 --replicates 100000 ";
  Running running(options + "--checkpoint-seconds 0 -o " + file("a.csv") + " --checkpoint " + file("a.h5"),
                  file("messages"));
  while (!running.hasEnded() && replicateCountOf("a.h5") < 2) waitFor(0.2);
  const auto start = Clock::now();
  running.send(SIGTERM);
  EXPECT_EQ(running.wait(), 143) << readFile(file("messages"));
  EXPECT_LT(secondsSince(start), kSoon);
  EXPECT_NE(readFile(file("messages")).find("results are written"), std::string::npos) << readFile(file("messages"));
  EXPECT_EQ(run("merge --quiet " + file("a.h5") + " -o " + file("b.csv")).status, 0);
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
}

// Two runs share one checkpoint. One of them is refused, or warns that its checkpoint was not kept. The file never
// mixes replicates of both.
TEST_F(Fault, TwoRunsDoNotDisturbEachOther) {
  const std::string options = kSteady + "--checkpoint-seconds 0 --checkpoint " + file("a.h5") + " --replicates ";
  {
    Running first(options + "60", file("first")),
        second(options + "60", file("second"));  // both start without a checkpoint
    const int a = first.wait(), b = second.wait();
    EXPECT_EQ(std::min(a, b), 0) << readFile(file("first")) << readFile(file("second"));
    EXPECT_GE(std::max(a, b), 1) << readFile(file("first")) << readFile(file("second"));
    const std::string message = readFile(file(a == 0 ? "second" : "first"));
    EXPECT_TRUE(message.find("another run has put its own there") != std::string::npos ||
                message.find("there is a checkpoint already") != std::string::npos)
        << message;
    EXPECT_EQ(replicateCountOf("a.h5"), 60u);
  }
  {
    Running first(options + "100000 --resume", file("first"));
    while (!first.hasEnded() && replicateCountOf("a.h5") < 62) waitFor(0.1);
    expectOneLine(run(options + "70 --resume"), 2, {"another run is keeping its checkpoint there"});
    first.send(SIGTERM);
    EXPECT_EQ(first.wait(), 143);
  }
  // Each output is written whole: where two runs write one file, the later one's remains.
  Running first(kSteady + "-o " + file("a.csv"), file("first")),
      second(kSteady + "-o " + file("a.csv"), file("second"));
  EXPECT_EQ(first.wait(), 0);
  EXPECT_EQ(second.wait(), 0);
  EXPECT_EQ(run(kSteady + "-o " + file("b.csv")).status, 0);
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
}

}  // namespace
}  // namespace viewpeel
