// Users make mistakes in scene files, options and outputs. The program reports each in one line with file and place,
// exits with status 2 or 1, and leaves no half-written file. Runs use the exact engine, which needs no device.
#include <fmt/format.h>
#include <sys/stat.h>

#include "tests/support/program.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

const std::string kPlates = "compute " VIEWPEEL_SCENES "/plates.obj ";
const std::string kExact = " --quiet --engine exact --directions 1 --replicates 2 ";
const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
// Root may read and write every file, unless setpriv takes these capabilities away.
const std::string kWithoutRights = ::geteuid() == 0 ? "setpriv --bounding-set -dac_override,-dac_read_search" : "";

class BadInput : public Program {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return fmt::format("'{}'", file(name));
  }
  static void expectOneLine(const Result& r, int status, const std::string& start, const std::string& part) {
    EXPECT_EQ(r.status, status) << r.output;
    EXPECT_EQ(r.output.find("viewpeel: " + start), 0u) << r.output << "does not start with " << start;
    EXPECT_NE(r.output.find(part), std::string::npos) << r.output << "does not say " << part;
    EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << r.output;
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(BadInput, ScenesAreRefusedInOneLine) {
  const struct {
    std::string name, text, place, part;
  } cases[] = {
      {"empty.obj", "", "", "empty"},
      {"no_faces.obj", kTriangle, "", "no faces"},
      {"garbage.obj",
       std::string("\x7f"
                   "ELF\2\1\1\0\0\xff\n\xfe",
                   12),
       ":1", "not a statement"},
      {"garbage.stl", std::string(200, '\xa5'), "",
       "not STL text, and its size does not fit the 2779096485 binary facets of its header"},
      {"garbage.ply", std::string(200, '\xa5'), ":1", "not a PLY file"},
      {"utf16.obj", std::string("\xff\xfe#\0\n\0v\0 \0", 10), ":1", "not a statement"},
      {"huge_index.obj", kTriangle + "f 1 2 4294967298\n", ":4", "4294967298 is out of range"},
      {"nan.obj", "v 0 0 nan\n", ":1", "'nan' is not a finite number"},
      {"large.obj", "v 1e308 0 0\nv 1e308 1e308 0\nv 0 1e308 0\nf 1 2 3\n", "", "radius of 7.07e+307"},
      {"larger.obj", "v 1.7e308 0 0\nv -1.7e308 0 0\nv 0 1.7e308 1\nf 1 2 3\n", "", "radius of inf"},
      {"small.obj", "v 0 0 0\nv 1e-170 0 0\nv 0 1e-170 0\nf 1 2 3\n", "", "radius of 7.07e-171"},
      {"line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "", "no area"},
      {"crossing.obj", kTriangle + "v 1 1 0\nv 2 3 0\nf 1 4 2 3 5\n", ":6", "crosses itself"},
      {"obj_as.stl", kTriangle + "f 1 2 3\n", "", "header"},
      {"obj_as.ply", kTriangle + "f 1 2 3\n", ":1", "not a PLY file"},
      {"environment.obj", kTriangle + "o environment\nf 1 2 3\n", ":5", "'environment', which stands for something"},
      {"leak.obj", kTriangle + "o leak\nf 1 2 3\n", ":5", "'leak', which stands for something else"},
      {"up.obj", kTriangle + "o environment:up\nf 1 2 3\n", ":5", "'environment:up', which stands for something"},
      {"down.obj", kTriangle + "g environment:down\nf 1 2 3\n", ":5", "'environment:down', which stands for"},
      {"no_extension", kTriangle + "f 1 2 3\n", "", "unknown format"},
  };
  for (const auto& c : cases)
    expectOneLine(run("compute " + write(c.name, c.text) + kExact), 2, file(c.name) + c.place + ": ", c.part);
}

TEST_F(BadInput, FilesThatAreNone) {
  fs::create_directory(file("folder.obj"));
  fs::create_symlink("loop.obj", file("loop.obj"));
  fs::create_symlink("nowhere.obj", file("dangling.obj"));
  ASSERT_EQ(::mkfifo(file("pipe.obj").c_str(), 0600), 0);
  write("secret.obj", kTriangle + "f 1 2 3\n");
  fs::permissions(file("secret.obj"), fs::perms::none);
  for (const auto& [name, part] : {std::pair("missing.obj", "no such file"),
                                   {"folder.obj", "is a directory"},
                                   {"loop.obj", "cannot be read"},
                                   {"dangling.obj", "no such file"},
                                   {"pipe.obj", "not a regular file"},
                                   {"secret.obj", "Permission denied"}})
    expectOneLine(run("compute " + file(name) + kExact, kWithoutRights), 2, file(name) + ": ", part);
}

// These files are unusual but valid, and give the results of the usual file.
TEST_F(BadInput, OddScenesAreRead) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no Tür \"süd\"\nf 1 2 3 4\n";
  std::string windows = square;
  for (size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) windows.insert(at, 1, '\r');
  ASSERT_EQ(run("compute " + write("square.obj", square) + kExact + "-o " + file("square.csv")).status, 0);
  const std::string expected = readFile(file("square.csv"));
  EXPECT_EQ(expected.find("from,to,form_factor,standard_error\n\"Tür \"\"süd\"\"\",environment,"), 0u) << expected;
  for (const auto& [name, text] : {std::pair<std::string, std::string>("Tür süd.obj", square),
                                   {"windows.obj", windows},
                                   {"mark.obj", "\xEF\xBB\xBF" + square},
                                   {"UPPER.OBJ", square},
                                   {"no_end.obj", square.substr(0, square.size() - 1)}}) {
    const Result r = run("compute " + write(name, text) + kExact + "-o " + file("a.csv"));
    EXPECT_EQ(r.status, 0) << name << r.output;
    EXPECT_EQ(r.output, "") << name;
    EXPECT_EQ(readFile(file("a.csv")), expected) << name;
    fs::remove(file("a.csv"));
  }
}

// Scenes that are not closed solids are computed, and the summary shows their faults.
TEST_F(BadInput, OpenAndInsideOutScenesShowInTheSummary) {
  const std::string cube = readFile(VIEWPEEL_SCENES "/cube.obj");
  const auto replaced = [&](const std::string& old, const std::string& text) {
    return std::string(cube).replace(cube.find(old), old.size(), text);
  };
  const auto shown = [&](const std::string& name, const std::string& text) {
    const Result r = run("compute " + write(name, text) + " --engine exact --directions 50 --replicates 2");
    EXPECT_EQ(r.status, 0) << r.output;
    return r.output;
  };
  // One of the cube's six faces looks outwards. Its own radiation, a sixth of all, leaves the scene. Radiation that
  // arrives at it, another sixth, ends on its back.
  const std::string flipped = shown("flipped.obj", replaced("f 1 2 3 4", "f 4 3 2 1"));
  EXPECT_NE(flipped.find("surfaces, open"), std::string::npos) << flipped;
  EXPECT_NE(flipped.find("16.7 % of all emitted radiation leaves the scene, 16.7 % ends on backs"), std::string::npos)
      << flipped;
  const std::string fin = shown("fin.obj", cube + "o fin\nv -1 0.5 -1\nf 1 2 9\n");  // three faces share an edge
  EXPECT_NE(fin.find("surfaces, open"), std::string::npos) << fin;
}

TEST_F(BadInput, OptionsOutOfRangeContradictoryOrRepeated) {
  const std::pair<std::string, std::string> cases[] = {
      {"--seed -1", "--seed: -1 is not a whole number"},
      {"--seed 18446744073709551616", "--seed: 18446744073709551616 is not a whole number"},
      {"--seed 1.5", "--seed: 1.5 is not a whole number"},
      {"--batch -1", "--batch"},
      {"--directions 4294967297", "--directions"},
      {"--directions 1 --directions 2", "--directions"},
      {"--tolerance nan", "--tolerance: nan is not a number above 0"},
      {"--relative 1e400", "--relative: 1e400"},
      {"--seconds -1", "--seconds: -1"},
      {"--floor 5", "--floor: 5 is not a number from 0 to 1"},
      {"--first-replicate -1", "--first-replicate"},
      {"--checkpoint c.h5 --checkpoint-seconds nan", "--checkpoint-seconds: nan"},
      {"--checkpoint-seconds 1", "requires --checkpoint"},
      {"--resume", "requires --checkpoint"},
      {"--engine exact --engine compute", "--engine"},
      {"--quiet --verbose", "excludes"},
      {"--from lower --pair lower upper", "use one of them"},
      {"--pair lower", "two names"},
      {"--by 'a\nb'", "--by: 'a?b' is not one of"},
      {"--epsilon 2", "between 0 and 1"},
      {"--epsilon 0.3 --delta 1", "between 0 and 1"},
      {"--delta 0.1", "--epsilon"},
      {"-o " + file("a.csv") + " -o " + file("./a.csv"), "two outputs have this name"},
      {"-o " + file("a.csv") + " --checkpoint " + file("a.csv"), "two outputs have this name"},
      {"--balance -o " + file("a.mtx") + " --checkpoint " + file("a.balanced.mtx"), "two outputs have this name"},
      {"another.obj", "no such file"},
  };
  for (const auto& [options, part] : cases) expectOneLine(run(kPlates + options), 2, "", part);
  EXPECT_EQ(files(), std::vector<std::string>{});
}

TEST_F(BadInput, OutputsThatCannotBeWrittenAreFoundFirst) {
  fs::create_directory(file("folder.csv"));
  fs::create_directory(file("locked"));
  fs::permissions(file("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  fs::create_symlink("/dev/full", file("device.csv"));
  std::ofstream(file("kept.csv")) << "old\n";
  const std::vector<std::string> before = files();
  for (const auto& [name, part] : {std::pair<std::string, std::string>("missing/a.csv", "No such file or directory"),
                                   {"folder.csv", "it is a directory"},
                                   {"locked/a.csv", "Permission denied"},
                                   {"device.csv", "not a regular file"},
                                   {"kept.csv/a.csv", "Not a directory"}}) {
    const std::string options = " --engine exact --directions 1 -o " + file("kept.csv") + " -o " + file(name);
    expectOneLine(run(kPlates + options, kWithoutRights), 2, file(name) + ": cannot write: ", part);
    if (name != "device.csv")  // it would count as a checkpoint that exists
      expectOneLine(run(kPlates + "--engine exact --checkpoint " + file(name), kWithoutRights), 2,
                    file(name) + ": cannot write: ", part);
  }
  // A limit of 2 KiB for each file simulates a disk with less room than one block.
  expectOneLine(run(kPlates + kExact + "-o " + file("kept.csv"), "trap '' XFSZ; ulimit -f 4;"), 2,
                file("kept.csv") + ": cannot write: ", "File too large");
  EXPECT_EQ(files(), before);
  EXPECT_EQ(readFile(file("kept.csv")), "old\n");
}

// The disk is full halfway. The old file stays, no half-written file remains, and the other outputs are written.
TEST_F(BadInput, FullDiskKeepsTheOldFileAndTheOtherOutputs) {
  const std::string office = "compute " VIEWPEEL_SCENES "/office.obj --by surface" + kExact;
  ASSERT_EQ(run(office + "-o " + file("a.csv") + " -o " + file("a.mtx")).status, 0);
  const uintmax_t csv_bytes = fs::file_size(file("a.csv")), mtx_bytes = fs::file_size(file("a.mtx"));
  ASSERT_GT(csv_bytes, mtx_bytes + 1024);
  std::ofstream(file("b.csv")) << "old\n";
  const Result r = run(office + "-o " + file("b.csv") + " -o " + file("b.mtx"),
                       fmt::format("trap '' XFSZ; ulimit -f {};", (csv_bytes + mtx_bytes) / 2 / 512));
  expectOneLine(r, 1, file("b.csv") + ": cannot write: ", "File too large");
  EXPECT_EQ(readFile(file("b.csv")), "old\n");
  EXPECT_EQ(readFile(file("b.mtx")), readFile(file("a.mtx")));
  EXPECT_EQ(files(), (std::vector<std::string>{"a.csv", "a.mtx", "b.csv", "b.mtx"}));
  for (const std::string& what : {kPlates + "--engine exact --directions 1 --json", std::string("devices")})
    EXPECT_EQ(run(what + " >/dev/full").status, 1) << what;
}

}  // namespace
}  // namespace viewpeel
