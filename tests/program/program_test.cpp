// These tests run the program as users do, and check its exit status, messages and files.
#include <map>

#include "tests/support/program.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

TEST_F(Program, ComputesPlatesAndWritesBothFiles) {
  const Result r = run("compute " VIEWPEEL_SCENES "/plates.obj --resolution 32 --directions 100 -o " + file("p.csv") +
                       " -o " + file("p.mtx"));
  EXPECT_EQ(r.status, 0) << r.output;
  for (const char* part : {"device", "2 polygons", "form factor", "standard error", "closure", "environment"})
    EXPECT_NE(r.output.find(part), std::string::npos) << part << " not in:\n" << r.output;
  EXPECT_EQ(readFile(file("p.csv")).find("from,to,form_factor,standard_error\nlower,upper,0."), 0u)
      << readFile(file("p.csv"));
  EXPECT_EQ(readFile(file("p.mtx")).find("%%MatrixMarket"), 0u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);
}

TEST_F(Program, SameSeedSameFileWhateverBatchAndThreads) {
  const std::string scene =
      "compute " VIEWPEEL_SCENES "/cube.obj --quiet --resolution 40 --directions 60 --replicates 3 -o ";
  EXPECT_EQ(run(scene + file("a.csv"), "LP_NUM_THREADS=1").status, 0);
  EXPECT_EQ(run(scene + file("b.csv") + " --batch 7", "LP_NUM_THREADS=3").status, 0);
  EXPECT_EQ(run(scene + file("c.csv") + " --seed 2").status, 0);
  EXPECT_FALSE(readFile(file("a.csv")).empty());
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
  EXPECT_NE(readFile(file("a.csv")), readFile(file("c.csv")));
}

// The summary distinguishes a polygon that no line met from one that sees no other polygon.
TEST_F(Program, UnmetRowsAreNamed) {
  std::ofstream(file("speck.obj")) << "o floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no speck\nv 0.3 0.3 1\nv 0.3 "
                                      "0.30001 1\nv 0.30001 0.3 1\nf 4 5 6\n";
  const Result r = run("compute " + file("speck.obj") + " --directions 10 --resolution 16");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("\nunmet      1 of 2 rows (speck)"), std::string::npos) << r.output;
  EXPECT_EQ(run("compute " VIEWPEEL_SCENES "/plates.obj --directions 10 --resolution 16").output.find("unmet"),
            std::string::npos);
}

// Where no form factor reaches --floor, --relative has nothing to judge. The program warns of it.
TEST_F(Program, AFloorThatNothingReachesIsReported) {
  const std::string plates =
      "compute " VIEWPEEL_SCENES "/plates.obj --directions 20 --resolution 16 --quiet --relative 0.5 --floor ";
  EXPECT_NE(run(plates + "0.9").output.find("no form factor reaches --floor 0.9"), std::string::npos);
  EXPECT_EQ(run(plates + "0.1").output, "");
}

// This is the oldest published case with a wall without thickness (FACET, UCID-19887, 1983). Its two sides are a sheet
// unless the user says otherwise.
TEST_F(Program, TwoSidesOfAWallDoNotSeeEachOther) {
  std::ofstream(file("facet.obj"))
      << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
         "v .25 .75 .25\nv .75 .75 .25\nv .75 .75 .75\nv .25 .75 .75\n"
         "g s1\nf 1 2 3 4\ng s2\nf 3 2 6 7\ng s3\nf 7 6 5 8\ng s4\nf 4 8 5 1\ng s5\nf 3 7 8 4\ng s6\nf 1 5 6 2\n"
         "g s7\nf 9 10 11 12\ng s8\nf 12 11 10 9\n";
  const std::string facet =
      "compute " + file("facet.obj") + " --directions 60 --replicates 4 -o " + file("f.csv") + " ";
  for (const char* engine : {"host", "compute", "graphics", "exact"}) {
    const Result r = run(facet + "--engine " + engine + (std::string(engine) == "exact" ? "" : " --resolution 64"));
    EXPECT_EQ(r.status, 0) << r.output;
    EXPECT_NE(r.output.find("coincide   1 pair back to back"), std::string::npos) << r.output;
    EXPECT_EQ(readFile(file("f.csv")).find("s7,s8,"), std::string::npos) << engine;
    EXPECT_EQ(readFile(file("f.csv")).find("leak"), std::string::npos) << engine;
  }
  const Result solid = run(facet + "--solids s7");
  EXPECT_NE(solid.output.find("1 pair face to face"), std::string::npos) << solid.output;
  EXPECT_NE(readFile(file("f.csv")).find("s7,s8,"), std::string::npos);
  const Result wrong = run(facet + "--sheets s9");
  EXPECT_EQ(wrong.status, 2) << wrong.output;
  EXPECT_NE(wrong.output.find("has no surface 's9'"), std::string::npos) << wrong.output;
}

TEST_F(Program, QuietPrintsNothing) {
  const Result r = run("compute " VIEWPEEL_SCENES "/plates.obj --quiet --resolution 8 --directions 10 --replicates 2");
  EXPECT_EQ(r.status, 0);
  EXPECT_EQ(r.output, "");
}

// Wrong usage and wrong input end with status 2 and one line, which names the remedy.
TEST_F(Program, BadUsageAndInputEndWithOneLineAndStatus2) {
  std::ofstream(file("broken.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
  std::ofstream(file("taken.obj")) << "o environment\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string plates = "compute " VIEWPEEL_SCENES "/plates.obj ";
  const std::pair<std::string, std::string> cases[] = {
      {"", "subcommand"},
      {"compute", "SCENE"},
      {"compute " + file("missing.obj"), "missing.obj"},
      {"compute " + file("broken.obj"), "broken.obj:4"},
      {"compute " + file("taken.obj"), "environment"},
      {plates + "--resolution 0", "--resolution"},
      {plates + "--resolution 100000", "--resolution"},
      {plates + "--directions 0", "directions"},
      {plates + "--replicates 1", "replicates"},
      {plates + "--tolerance 0", "tolerance"},
      {plates + "--tolerance x", "--tolerance"},
      {plates + "--by face", "--by"},
      {plates + "--balance --from lower", "--from"},
      {plates + "--balance --pair lower upper", "--pair"},
      {plates + "--balance --blocker lower", "--blocker"},
      {plates + "--balance -o " + file("a.balanced.mtx"), ".balanced.mtx"},
      {plates + "--no-such-option", "--no-such-option"},
      {"compute " VIEWPEEL_SCENES "/office.obj --from 'desk[99]'", "'desk' has 30 faces, 'desk[1]' to 'desk[30]'"},
      {plates + "--from uper", "did you mean 'upper'?"},
      {plates + "-o " + file("a.xyz"), ".csv, .mtx, .npz"},
      {"compute " VIEWPEEL_SCENES "/office.obj --quiet --epsilon 1e-9", "epsilon"},
      {plates + "--epsilon 0.1 --resolution 64 --range 3", "--range"},
      {plates + "--epsilon 0.1 --statistic median --block 3", "--block"},
      {plates + "--engine exact --resolution 64", "--resolution"},
      {plates + "--directions 10 --resolution 64 --finest 32", "--finest 32 is coarser"},
  };
  for (const auto& [arguments, part] : cases) {
    const Result r = run(arguments);
    EXPECT_EQ(r.status, 2) << arguments << "\n" << r.output;
    EXPECT_NE(r.output.find(part), std::string::npos) << arguments << "\n" << r.output;
    EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << arguments << "\n" << r.output;
    EXPECT_EQ(r.output.find("viewpeel: "), 0u) << r.output;
  }
}

// Returns for each row of the .csv file, by its first column, the sum of the last column.
std::map<std::string, double> sumRows(const std::string& csv) {
  std::map<std::string, double> sums;
  std::istringstream in(csv);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) sums[line.substr(0, line.find(','))] += std::stod(line.substr(line.rfind(',') + 1));
  return sums;
}

TEST_F(Program, BalanceIsWrittenBesideWhatWasMeasured) {
  const std::string office = "compute " VIEWPEEL_SCENES "/office.obj --directions 200 ";
  const Result plain = run(office + "-o " + file("raw.csv") + " -o " + file("raw.mtx"));
  const Result balanced = run(office + "--balance -o " + file("c.csv") + " -o " + file("c.mtx"));
  EXPECT_EQ(plain.status, 0) << plain.output;
  EXPECT_EQ(balanced.status, 0) << balanced.output;
  EXPECT_NE(balanced.output.find("\nbalanced   row sums differ from 1 by at most"), std::string::npos)
      << balanced.output;
  EXPECT_NE(balanced.output.find("c.balanced.mtx"), std::string::npos) << balanced.output;
  EXPECT_EQ(plain.output.find("balanced   "), std::string::npos);
  EXPECT_EQ(readFile(file("raw.mtx")), readFile(file("c.mtx")));
  std::istringstream raw_lines(readFile(file("raw.csv"))), closed_lines(readFile(file("c.csv")));
  std::string a, b;
  while (std::getline(raw_lines, a)) {
    ASSERT_TRUE(std::getline(closed_lines, b));
    ASSERT_EQ(b.substr(0, b.rfind(',')), a);
  }
  const auto sums = sumRows(readFile(file("c.csv")));
  EXPECT_EQ(sums.size(), 576u);
  for (const auto& [row, sum] : sums)
    EXPECT_NEAR(sum, 1, 1.1e-12) << row;  // kBalanceTolerance, and rounding of 576 terms
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 5);
  const Result json = run("compute " VIEWPEEL_SCENES "/cube.obj --directions 20 --balance --json");
  EXPECT_NE(json.output.find("\"balanced\": {\n    \"largest\": "), std::string::npos) << json.output;
}

// Options keep their names of older versions as aliases.
TEST_F(Program, OlderNamesOfOptionsWork) {
  const std::string cube = "compute " VIEWPEEL_SCENES "/cube.obj --quiet --directions 20 --resolution 32 ";
  EXPECT_EQ(run(cube + "--unoccluded on --balance -o " + file("new.csv")).status, 0);
  EXPECT_EQ(run(cube + "--closed-forms on --closure -o " + file("old.csv")).status, 0);
  EXPECT_EQ(run(cube + "--unoccluded off --balance -o " + file("off.csv")).status, 0);
  // With the older option the column has its older name.
  std::string renamed = readFile(file("new.csv"));
  const size_t column = renamed.find("balanced_form_factor\n");
  ASSERT_NE(column, std::string::npos);
  EXPECT_EQ(readFile(file("old.csv")), renamed.replace(column, 8, "closed"));
  EXPECT_NE(readFile(file("off.csv")), readFile(file("new.csv")));
}

// The scene is open, which the program finds after the computation. The measured form factors are written all the same.
TEST_F(Program, RefusedBalanceKeepsWhatWasMeasured) {
  const std::string plates = "compute " VIEWPEEL_SCENES "/plates.obj --quiet --directions 20 ";
  const Result r = run(plates + "--balance -o " + file("p.csv"));
  EXPECT_EQ(r.status, 2);
  EXPECT_EQ(r.output.find("viewpeel: balance: 79."), 0u) << r.output;
  EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << r.output;
  EXPECT_EQ(run(plates + "-o " + file("q.csv")).status, 0);
  EXPECT_EQ(readFile(file("p.csv")), readFile(file("q.csv")));
}

TEST_F(Program, UnknownDeviceIsRefusedWithReasons) {
  const Result r = run("compute " VIEWPEEL_SCENES "/plates.obj --quiet --device nonsense");
  EXPECT_EQ(r.status, 1);
  EXPECT_NE(r.output.find("nonsense"), std::string::npos) << r.output;
  EXPECT_NE(r.output.find("not asked for"), std::string::npos) << r.output;
}

// These options need a Vulkan driver.
TEST_F(Program, NoDriverIsAClearError) {
  for (const char* options : {"--engine compute", "--engine graphics", "--device cpu"}) {
    const Result r = run(std::string("compute " VIEWPEEL_SCENES "/plates.obj --quiet ") + options,
                         "VK_DRIVER_FILES=/nowhere.json VK_ICD_FILENAMES=/nowhere.json");
    EXPECT_EQ(r.status, 1) << options;
    EXPECT_NE(r.output.find("mesa-vulkan-drivers"), std::string::npos) << r.output;
  }
}

TEST_F(Program, HostEngineComputesWithoutADevice) {
  const std::string plates = "compute " VIEWPEEL_SCENES "/plates.obj --quiet --replicates 4 -o ";
  const Result r = run(plates + file("planned.csv"), "VK_DRIVER_FILES=/nowhere.json VK_ICD_FILENAMES=/nowhere.json");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_EQ(r.output, "");
  EXPECT_EQ(readFile(file("planned.csv")).find("from,to,"), 0u);
}

// On a machine without a GPU the program does not load Vulkan's drivers to find one.
TEST_F(Program, DoesNotAskVulkanWhereThereIsNoGpu) {
  if (fs::exists("/dev/dri") || fs::exists("/dev/nvidiactl")) GTEST_SKIP() << "there may be a GPU";
  const std::string plates = "compute " VIEWPEEL_SCENES "/plates.obj --quiet --engine ", debug = "VK_LOADER_DEBUG=all";
  EXPECT_NE(run(plates + "compute", debug).output, "");
  EXPECT_EQ(run(plates + "auto", debug).output, "");
}

// The host engine and the compute engine write the same bytes. They differ in speed only.
TEST_F(Program, EnginesWriteTheSameFiles) {
  for (const char* options :
       {"--sampling lattice", "--sampling scanline", "--sampling scanline --resolution 32 --finest 512",
        "--sampling lattice --from floor", "--sampling scanline --two-sided --by surface"}) {
    const std::string office =
        std::string("compute " VIEWPEEL_SCENES "/office.obj --quiet --directions 20 --replicates 2 ") + options;
    ASSERT_EQ(run(office + " --engine compute -o " + file("compute.csv")).output, "");
    ASSERT_EQ(run(office + " --engine host -o " + file("host.csv")).output, "");
    EXPECT_TRUE(readFile(file("compute.csv")) == readFile(file("host.csv"))) << options;
    EXPECT_GT(readFile(file("host.csv")).size(), 1000u);
  }
}

// Pair lines drawn on a device have the bits of the processor's lines, in whole runs and in runs that begin on one and
// end on the other.
TEST_F(Program, PairLinesAreTheSameOnADevice) {
  const std::string street = "compute " VIEWPEEL_SCENES
                             "/street.obj --quiet --tolerance 2e-2 --sampling lattice "
                             "--pair-lines on --engine ";
  ASSERT_EQ(run(street + "host -o " + file("host.csv") + " --checkpoint " + file("host.h5")).output, "");
  ASSERT_EQ(run(street + "compute -o " + file("compute.csv") + " --checkpoint " + file("compute.h5")).output, "");
  EXPECT_TRUE(readFile(file("compute.csv")) == readFile(file("host.csv")));
  EXPECT_TRUE(readFile(file("compute.h5")) == readFile(file("host.h5")));
  EXPECT_GT(readFile(file("host.csv")).size(), 10000u);
  const std::string more = " --replicates 12 --resume -o " + file("more.csv") + " --checkpoint ";
  ASSERT_EQ(run(street + "host" + more + file("compute.h5")).output, "");
  const std::string by_host = readFile(file("more.csv"));
  ASSERT_EQ(run(street + "compute" + more + file("host.h5")).output, "");
  EXPECT_TRUE(readFile(file("more.csv")) == by_host);
  EXPECT_FALSE(by_host == readFile(file("host.csv")));
}

TEST_F(Program, ExactEngineComputesWithoutADevice) {
  const Result r =
      run("compute " VIEWPEEL_SCENES "/cube.obj --engine exact --directions 50 --replicates 4 -o " + file("e.csv"),
          "VK_DRIVER_FILES=/nowhere.json VK_ICD_FILENAMES=/nowhere.json");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("exact areas"), std::string::npos);
  EXPECT_EQ(readFile(file("e.csv")).find("from,to,"), 0u);
}

TEST_F(Program, CheckPassesOnAGoodScene) {
  const std::string check = "check " VIEWPEEL_SCENES "/cube.obj --resolution 32 --directions 2 --lattices 16";
  const Result r = run(check);
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("behave as claimed"), std::string::npos) << r.output;
  const Result json = run(check + " --json");
  EXPECT_EQ(json.status, 0);
  EXPECT_NE(json.output.find("\n  \"passes\": true,"), std::string::npos) << json.output;
}

// Where polygons pass through each other `check` warns and fails, and the exact engine refuses. Both name the place.
TEST_F(Program, InterpenetrationIsNamed) {
  std::ofstream(file("crossing.obj"))
      << "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 0.5 -1\nv 1 1.5 -1\nv 1 1.5 1\nv 1 0.5 1\n"
         "o table\nf 1 2 3 4\no blade\nf 5 6 7 8\n";
  const std::string what = "table and blade pass through each other at (1, 1, ";
  const Result check = run("check " + file("crossing.obj") + " --resolution 16 --directions 1 --lattices 8");
  EXPECT_EQ(check.status, 1);
  EXPECT_NE(check.output.find(what), std::string::npos) << check.output;
  const Result exact = run("compute --quiet --engine exact " + file("crossing.obj"));
  EXPECT_EQ(exact.status, 2);
  EXPECT_NE(exact.output.find(what), std::string::npos) << exact.output;
}

TEST_F(Program, DevicesListsThem) {
  const Result r = run("devices");
  EXPECT_EQ(r.status, 0);
  EXPECT_NE(r.output.find("usable"), std::string::npos) << r.output;
}

TEST_F(Program, APageThatIsThereIsReplaced) {
  const std::string command = "compute --quiet " VIEWPEEL_SCENES "/cube.obj -o " + file("cube.html");
  EXPECT_EQ(run(command).status, 0);
  const Result again = run(command + " --seed 2");
  EXPECT_EQ(again.status, 0) << again.output;
}

}  // namespace
}  // namespace viewpeel
