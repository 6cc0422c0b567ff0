// A run may be split into parts, on one machine or several. `merge` turns the parts into the bytes of one whole run.
#include <fmt/format.h>
#include <glm/vec3.hpp>

#include "tests/support/running.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class Parts : public Program {};

class PartsOfARun : public Parts, public testing::WithParamInterface<const char*> {};

INSTANTIATE_TEST_SUITE_P(Parts, PartsOfARun, testing::Values("", "--unoccluded on ", "--unoccluded on --by surface "),
                         [](const auto& options) { return fmt::format("Options{}", options.index); });

TEST_P(PartsOfARun, MergeToOneRun) {
  const std::string options =
      std::string("compute " VIEWPEEL_SCENES "/office.obj --quiet --directions 30 ") + GetParam();
  ASSERT_EQ(run(options + "--replicates 9 -o " + file("whole.csv") + " -o " + file("whole.mtx") + " --checkpoint " +
                file("whole.h5"))
                .status,
            0);
  for (const auto& [first, count] : {std::pair("0", "2"), {"2", "4"}, {"6", "3"}})
    ASSERT_EQ(run(options + "--replicates " + count + " --first-replicate " + first + " --checkpoint " +
                  file(std::string("p") + first + ".h5"))
                  .status,
              0);
  for (const std::string order : {"0 2 6", "6 2 0", "2 6 0"}) {
    std::string inputs;
    for (char part : order)
      if (part != ' ') inputs += fmt::format(" {}", file(fmt::format("p{}.h5", part)));
    fs::remove(file("m.h5"));
    const Result merged = run("merge --quiet" + inputs + " -o " + file("m.csv") + " -o " + file("m.mtx") +
                              " --checkpoint " + file("m.h5"));
    EXPECT_EQ(merged.status, 0);
    EXPECT_EQ(merged.output, "");
    for (const char* kind : {"csv", "mtx", "h5"}) {
      EXPECT_FALSE(readFile(file(std::string("m.") + kind)).empty());
      EXPECT_EQ(readFile(file(std::string("m.") + kind)), readFile(file(std::string("whole.") + kind)))
          << kind << " of " << order;
    }
  }
  // A run goes on from the merged replicates 0 to 5, and ends with the bytes of a run without parts.
  EXPECT_EQ(run("merge --quiet " + file("p2.h5") + " " + file("p0.h5") + " --checkpoint " + file("q.h5")).status, 0);
  EXPECT_EQ(run(options + "--replicates 12 --resume --checkpoint " + file("q.h5") + " -o " + file("q.csv")).status, 0);
  EXPECT_EQ(run(options + "--replicates 12 -o " + file("r.csv")).status, 0);
  EXPECT_EQ(readFile(file("q.csv")), readFile(file("r.csv")));
}

// A pair with directions of its own has the same bits for every batch size, and in one run or in parts. Parts with the
// same goal choose the same pairs; parts with another goal are refused.
TEST_F(Parts, DirectedPairsGoOnAndMerge) {
  const std::string all = "compute " VIEWPEEL_SCENES
                          "/past_edge.obj --directions 512 --resolution 64 --unoccluded on --floor 1e-4 ",
                    options = all + "--relative 0.05 ";
  const Result whole = run(options + "-o " + file("whole.csv") + " --checkpoint " + file("whole.h5"));
  ASSERT_EQ(whole.status, 0);
  EXPECT_NE(whole.output.find("directions of its own"), std::string::npos) << whole.output;
  const std::string csv = readFile(file("whole.csv")), h5 = readFile(file("whole.h5"));
  EXPECT_EQ(run(options + "--batch 7 -o " + file("batch.csv")).status, 0);
  EXPECT_EQ(readFile(file("batch.csv")), csv);
  EXPECT_EQ(run(options + "--seconds 1e-6 --checkpoint " + file("part.h5")).status, 3);
  EXPECT_NE(readFile(file("part.h5")), h5);
  EXPECT_EQ(run(options + "--resume --checkpoint " + file("part.h5") + " -o " + file("resumed.csv")).status, 0);
  EXPECT_EQ(readFile(file("resumed.csv")), csv);
  EXPECT_EQ(readFile(file("part.h5")), h5);
  EXPECT_EQ(run(options + "--seconds 1e-6 --first-replicate 1000 --checkpoint " + file("later.h5")).status, 3);
  EXPECT_EQ(run("merge --quiet " + file("later.h5") + " " + file("whole.h5") + " -o " + file("merged.csv")).status, 0);
  EXPECT_NE(readFile(file("merged.csv")), csv);
  EXPECT_EQ(run(all + "--relative 0.005 --seconds 1e-6 --first-replicate 1000 --checkpoint " + file("other.h5")).status,
            3);
  const Result refused = run("merge --quiet " + file("other.h5") + " " + file("whole.h5"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.output.find("give all parts of a run the same goal"), std::string::npos) << refused.output;
}

// A part counts exactly its replicates, whatever the goal. Merged parts have the bits of one run.
TEST_F(Parts, PartsCountExactlyTheirReplicates) {
  const std::string directions = kComputeOffice + "--directions 30 ";
  ASSERT_EQ(run(directions + "--replicates 9 -o " + file("whole.csv")).status, 0);
  std::string inputs;
  for (const char* part : {"1", "2", "3"}) {
    inputs += fmt::format(" {}", file(fmt::format("{}.h5", part)));
    ASSERT_EQ(
        run(directions + "--replicates 3 --part " + part + "/3 --checkpoint " + file(std::string(part) + ".h5")).status,
        0);
  }
  ASSERT_EQ(run("merge --quiet" + inputs + " -o " + file("merged.csv")).status, 0);
  EXPECT_EQ(readFile(file("merged.csv")), readFile(file("whole.csv")));

  // A goal out of reach adds no replicates to a part, with common directions or with pair lines.
  for (const std::string method : {"--pair-lines off", "--pair-lines on"}) {
    const std::string goal = "compute " VIEWPEEL_SCENES "/cube.obj --two-sided --quiet --tolerance 1e-5 " + method;
    const std::string first = goal + " --replicates 3 --part 1/2 --checkpoint " + file("a.h5"),
                      second = goal + " --replicates 3 --first-replicate 3 --checkpoint " + file("b.h5");
    EXPECT_EQ(run(first).status, 0) << run(first).output;
    EXPECT_EQ(run(second).status, 0);
    EXPECT_EQ(replicatesOf("a.h5"), "0 to 2") << method;
    EXPECT_EQ(replicatesOf("b.h5"), "3 to 5") << method;
    fs::remove(file("a.h5"));
    fs::remove(file("b.h5"));
  }
  for (const char* part : {"0/2", "3/2", "1", "1/", "a/b", "1/2/3", "-1/2", "1/0"}) {
    const Result refused = run(directions + "--part " + part);
    EXPECT_EQ(refused.status, 2) << part;
    EXPECT_NE(refused.output.find(std::string("--part: '") + part + "' is not a part like 2/8"), std::string::npos)
        << refused.output;
  }
}

// Lines that end on a --blocker are kept in checkpoints, and their pairs are in no result. What leaves the scene from
// other rows is as in a run in which these buildings have rows.
TEST_F(Parts, BlockersStayOutOfResultsOfCheckpoints) {
  const std::string all = "compute " VIEWPEEL_SCENES "/street.obj --quiet --promise off --tolerance 3e-3 ",
                    some = all + "--blocker building_e1 --blocker roof_e1 ";
  const auto environments = [&](const std::string& csv) {
    std::map<std::string, double> values;
    std::istringstream lines(readFile(file(csv)));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(csv == "all.csv" || line.find("_e1") == std::string::npos) << line;
      const size_t column = line.find(",environment,"), value = column + std::strlen(",environment,");
      if (column != std::string::npos) values[line.substr(0, column)] = std::stod(line.substr(value));
    }
    return values;
  };
  ASSERT_EQ(run(all + "-o " + file("all.csv")).status, 0);
  ASSERT_EQ(run(some + "-o " + file("some.csv") + " --checkpoint " + file("some.h5")).status, 0);
  EXPECT_NE(run("merge " + file("some.h5")).output.find("lines of"), std::string::npos);
  const auto of_all = environments("all.csv"), of_some = environments("some.csv");
  EXPECT_GT(of_some.size(), 200u);
  for (const auto& [row, value] : of_some) EXPECT_NEAR(of_all.at(row), value, 2 * 3e-3) << row;
  ASSERT_EQ(run("merge --quiet " + file("some.h5") + " -o " + file("merged.csv")).status, 0);
  EXPECT_EQ(readFile(file("merged.csv")), readFile(file("some.csv")));
  for (const std::string part : {"1", "2"})
    ASSERT_EQ(run(some + "--replicates 4 --part " + part + "/2 --checkpoint " + file(part + ".h5")).status, 0);
  ASSERT_EQ(run("merge --quiet " + file("2.h5") + " " + file("1.h5") + " -o " + file("both.csv")).status, 0);
  ASSERT_EQ(run(some + "--replicates 8 --resume --part 1/1 --checkpoint " + file("1.h5") + " -o " + file("resumed.csv"))
                .status,
            0);
  EXPECT_EQ(readFile(file("both.csv")), readFile(file("resumed.csv")));
  EXPECT_EQ(environments("both.csv").size(), of_some.size());
}

// Parts of a run in which large pairs have lines and common directions count all others. They merge to the bytes of a
// run that goes on to all replicates alone. In the closed box a small slab hides parts of a large one.
TEST_F(Parts, PartsOfAMixtureMergeToOneRun) {
  constexpr int kCuts = 37;
  std::ofstream scene(file("box.obj"));
  const auto rectangle = [&](glm::dvec3 at, glm::dvec3 u, glm::dvec3 v, int cuts) {
    for (int k = 0; k < cuts * cuts; ++k) {
      const glm::dvec3 a = at + (double(k / cuts) * u + double(k % cuts) * v) / double(cuts);
      for (const glm::dvec3& p : {a, a + u / double(cuts), a + (u + v) / double(cuts), a + v / double(cuts)})
        scene << fmt::format("v {} {} {}\n", p.x, p.y, p.z);
      scene << "f -4 -3 -2 -1\n";
    }
  };
  const auto box = [&](glm::dvec3 low, double x, double y, double z, int cuts, bool inwards) {
    const glm::dvec3 sides[3] = {{x, 0, 0}, {0, y, 0}, {0, 0, z}};
    for (int k = 0; k < 3; ++k) {
      glm::dvec3 u = sides[(k + 1) % 3], v = sides[(k + 2) % 3];
      if (!inwards) std::swap(u, v);
      rectangle(low, u, v, cuts);
      rectangle(low + sides[k], v, u, cuts);
    }
  };
  box({0, 0, 0}, 1, 1, 1, kCuts, true);
  box({0.3, 0.2, 0.45}, 0.4, 0.5, 0.1, 1, false);
  box({0.4, 0.3, 0.2}, 0.2, 0.3, 0.1, 1, false);
  scene.close();
  const std::string options = "compute " + file("box.obj") + " --tolerance 0.02 --checkpoint ";
  std::string inputs;
  for (const std::string part : {"1", "2", "3"}) {
    const Result r = run(options + file(part + ".h5") + " --replicates 2 --part " + part + "/3");
    ASSERT_EQ(r.status, 0) << r.output;
    EXPECT_NE(r.output.find("may be blocked in part"), std::string::npos) << r.output;
    EXPECT_NE(r.output.find("all other pairs have form factors below 0.0067"), std::string::npos) << r.output;
    inputs = fmt::format(" {}{}", file(part + ".h5"), inputs);
  }
  ASSERT_EQ(run("merge --quiet" + inputs + " -o " + file("merged.mtx") + " --checkpoint " + file("merged.h5")).status,
            0);
  fs::copy_file(file("1.h5"), file("whole.h5"));
  ASSERT_EQ(
      run(options + file("whole.h5") + " --quiet --resume --replicates 6 --part 1/1 -o " + file("whole.mtx")).status,
      0);
  EXPECT_EQ(replicatesOf("whole.h5"), "0 to 5");
  EXPECT_TRUE(readFile(file("merged.mtx")) == readFile(file("whole.mtx")));
  EXPECT_TRUE(readFile(file("merged.h5")) == readFile(file("whole.h5")));
  ASSERT_EQ(run("merge --quiet " + file("1.h5") + " " + file("3.h5") + " -o " + file("two.mtx")).status, 0);
  EXPECT_FALSE(readFile(file("two.mtx")) == readFile(file("whole.mtx")));
}

// This scene has so many polygons that its checkpoint leaves out the unoccluded form factors of pairs that few lines
// met. `merge` computes them again from the scene. Without the scene it takes the plain counts of pairs with few lines,
// leaves out pairs without lines, and warns.
TEST_F(Parts, PartsOfManyPolygonsMergeWithTheirScene) {
  constexpr int kCuts = 54;
  const auto writeScene = [&](const std::string& name, double height) {
    std::ofstream scene(file(name));
    const auto square = [&](const char* surface, double x, double y, double z, double edge, bool up) {
      scene << fmt::format("o {}\nv {} {} {}\nv {} {} {}\nv {} {} {}\nv {} {} {}\nf {}\n", surface, x, y, z, x + edge,
                           y, z, x + edge, y + edge, z, x, y + edge, z, up ? "-4 -3 -2 -1" : "-1 -2 -3 -4");
    };
    for (int y = 0; y < kCuts; ++y)
      for (int x = 0; x < kCuts; ++x) square("floor", x, y, 0, 1, true);
    square("lamp", 20, 20, height, 6, false);
    square("screen", 24, 16, height / 2, 9, true);
  };
  writeScene("scene.obj", 30);
  writeScene("other.obj", 31);
  const std::string options =
      "compute " + file("scene.obj") +
      " --quiet --unoccluded on --directions 16 --resolution 64 --sampling scanline --checkpoint ";
  ASSERT_EQ(run(options + file("whole.h5") + " --replicates 5 -o " + file("whole.csv")).status, 0);
  ASSERT_EQ(run(options + file("a.h5") + " --replicates 2").status, 0);
  ASSERT_EQ(run(options + file("b.h5") + " --replicates 3 --first-replicate 2").status, 0);
  const std::string merge = "merge --quiet " + file("b.h5") + " " + file("a.h5") + " -o ";
  const Result with = run(merge + file("with.csv") + " --scene " + file("scene.obj")),
               without = run(merge + file("without.csv")),
               other = run(merge + file("no.csv") + " --scene " + file("other.obj"));
  EXPECT_EQ(with.status, 0) << with.output;
  EXPECT_EQ(with.output, "");
  EXPECT_EQ(readFile(file("with.csv")), readFile(file("whole.csv")));
  EXPECT_EQ(without.status, 0);
  EXPECT_NE(without.output.find("give the scene by --scene FILE"), std::string::npos) << without.output;
  EXPECT_LT(readFile(file("without.csv")).size(), readFile(file("whole.csv")).size());
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.output.find("another scene"), std::string::npos) << other.output;
  EXPECT_FALSE(fs::exists(file("no.csv")));
}

}  // namespace
}  // namespace viewpeel
