// These tests read what the program says of its plan, before it counts: time, promise, lines, directions.
#include <regex>

#include "tests/support/program.h"

namespace viewpeel {
namespace {

// Every plan states its time, and where its replicates do not reach the goal also the time that the goal takes.
TEST_F(Program, PlansSayWhatARunTakes) {
  const std::string plates = "plan " VIEWPEEL_SCENES "/plates.obj ";
  for (const char* options : {"--engine exact", "--directions 10 --resolution 16", "--directions 10 --pair lower upper",
                              "--epsilon 0.3 --pair-lines off"}) {
    const Result r = run(plates + options);
    EXPECT_EQ(r.status, 0) << r.output;
    EXPECT_NE(r.output.find(" s"), std::string::npos) << r.output;
    const std::string words = options;
    EXPECT_TRUE(std::regex_search(
        r.output,
        std::regex(words.ends_with("off") ? "plan       \\d+ blocks? of \\d+ directions? \\(.*\\) by Hoeffding"
                                          : "expected   ")))
        << r.output;
  }
  EXPECT_NE(run("plan " VIEWPEEL_SCENES "/street.obj --epsilon 0.3").output.find(" lines at most ("),
            std::string::npos);
  const Result r = run(plates + "--tolerance 1e-9 --seconds 1 --pair-lines off");
  EXPECT_NE(r.output.find("more than --seconds 1 allow; the run ends short of it"), std::string::npos) << r.output;
  EXPECT_EQ(run(plates + "--tolerance 0.1").output.find("takes about"), std::string::npos);
}

// Where nothing can block, and rows add up to 1, neither a promise nor an estimate takes lines, directions or rays. In
// an open scene directions of a promise see what leaves it, and rays of an estimate.
TEST_F(Program, WhatGeometryGivesTakesNoDirections) {
  const std::string cube = "compute " VIEWPEEL_SCENES "/cube.obj ", plates = "compute " VIEWPEEL_SCENES "/plates.obj ",
                    none = "no lines or directions: geometry gives every form factor";
  const std::vector<std::pair<std::string, std::string>> sees_outside = {
      {"", ", 256 directions"},
      {"--promise off", ", each with up to 32 rays of a polygon"},
      {"--epsilon 1e-3", ", 256 directions"},
      {"--by surface", ", 256 directions"},
      {"--from x0", ", 256 directions"}};
  for (const auto& [options, what] : sees_outside) {
    const Result r = run(cube + options);
    ASSERT_EQ(r.status, 0) << r.output;
    EXPECT_NE(r.output.find(none), std::string::npos) << options << r.output;
    EXPECT_NE(r.output.find(", 0 directions"), std::string::npos) << options << r.output;
    EXPECT_NE(r.output.find("outside    0 % of all"), std::string::npos) << options << r.output;
    const Result open = run(plates + (options == "--from x0" ? "--from lower" : options));
    EXPECT_EQ(open.output.find(none), std::string::npos) << options << open.output;
    EXPECT_NE(open.output.find(what), std::string::npos) << options << open.output;
  }
  // Without one of its walls the cube is open, and with a wall that looks outside it leaks.
  std::string walls = readFile(VIEWPEEL_SCENES "/cube.obj");
  const size_t last = walls.rfind("f ");
  std::ofstream(file("open.obj")) << walls.substr(0, last);
  walls.replace(last, walls.find('\n', last) - last, "f 4 5 6 3");
  std::ofstream(file("other.obj")) << walls;
  for (const char* name : {"open.obj", "other.obj"}) {
    const Result r = run("compute " + file(name));
    EXPECT_EQ(r.status, 0) << r.output;
    EXPECT_EQ(r.output.find(none), std::string::npos) << r.output;
  }
  // A run goes on from its checkpoint.
  const std::string kept = cube + "--tolerance 1e-3 --quiet --checkpoint " + file("c.h5") + " -o ";
  ASSERT_EQ(run(kept + file("a.csv")).output, "");
  ASSERT_EQ(run(kept + file("b.csv") + " --resume").output, "");
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
}

// The first line of the plan says whether the tolerance is a promise, and files have intervals where it is.
TEST_F(Program, SaysWhetherATolerancePromises) {
  const std::string street = "compute " VIEWPEEL_SCENES "/street.obj -o " + file("s.csv") + " --tolerance ";
  const std::string promise =
                        "\ngoal       a promise: every form factor, environment too, within 0.01 with probability 0.99",
                    estimate = "\ngoal       an estimate, largest error about ";
  const auto expect = [&](const std::string& options, const std::string& line, bool has_intervals) {
    const Result r = run(street + options);
    EXPECT_EQ(r.status, 0) << r.output;
    EXPECT_NE(r.output.find(line), std::string::npos) << options << ": " << r.output;
    const std::string csv = readFile(file("s.csv"));
    EXPECT_EQ(csv.find("from,to,form_factor,standard_error,lower,upper\n") == 0, has_intervals) << csv.substr(0, 80);
  };
  expect("1e-2", promise, true);
  expect("1e-2 --json", "\n  \"guarantee\": {\n    \"epsilon\": 0.01,\n    \"delta\": 0.01,", true);
  expect("3e-4", estimate + "0.0003, no promise: a promise would cost ", false);
  expect("3e-4 --json", "\"no_promise\": \"a promise would cost ", false);
  expect("1e-2 --promise off", estimate + "0.01, no promise: --promise off", false);
  expect("1e-2 --replicates 8", estimate + "0.01, no promise: --promise off, --replicates", false);
  expect("1e-2 --checkpoint " + file("s.h5"),
         estimate + "0.01, no promise: --promise off, --replicates or --checkpoint", false);
  EXPECT_NE(run("plan " VIEWPEEL_SCENES "/street.obj --tolerance 1e-2").output.find(promise), std::string::npos);
  for (const char* against : {"--seconds 9", "--relative 0.1", "--sampler iid", "--replicates 9"}) {
    const Result r = run(street + "1e-2 --promise on " + against);
    EXPECT_EQ(r.status, 2) << against;
    EXPECT_NE(r.output.find("--promise on needs a goal by --tolerance alone"), std::string::npos) << r.output;
  }
  EXPECT_EQ(run(street + "1e-2 --promise on --checkpoint " + file("t.h5")).status, 2);
  EXPECT_EQ(run("compute " VIEWPEEL_SCENES "/street.obj --epsilon 0.1 --promise off").status, 2);
}

// The line `pairs` says why no pair has lines of its own, also where the line `goal` has another reason.
TEST_F(Program, SaysWhyThereAreNoPairLines) {
  const std::string street = "compute " VIEWPEEL_SCENES "/street.obj --tolerance ",
                    none = "\npairs      no lines of their own: ";
  const auto expect = [&](const std::string& options, const std::string& why) {
    const Result r = run(street + options);
    EXPECT_EQ(r.status, 0) << r.output;
    if (why.empty()) EXPECT_EQ(r.output.find("no lines of their own"), std::string::npos) << options << r.output;
    else EXPECT_NE(r.output.find(none + why + "\n"), std::string::npos) << options << ": " << r.output;
  };
  expect("1e-2", "");
  expect("1e-2 --promise off", "");
  expect("0.05", "");
  expect("0.05 --engine exact", "--engine asks for common directions");
  expect("0.05 --sampling lattice --promise off", "--sampling asks for common directions");
  expect("1e-2 --pair-lines off --promise off", "--pair-lines off asks for common directions");
  const Result json = run(street + "0.05 --sampler iid --json");
  EXPECT_NE(json.output.find("\"no_pair_lines\": \"--sampler asks for common directions\""), std::string::npos)
      << json.output;
}

// The plan is by surface, as the run is. It once crashed here, with ids of 576 faces in arrays of 18 surfaces.
TEST_F(Program, PlansUnoccludedFormFactorsBySurface) {
  const std::string office = " " VIEWPEEL_SCENES "/office.obj --by surface --tolerance 2e-4";
  for (const char* command : {"plan", "compute --quiet"}) {
    const Result r = run(command + office);
    EXPECT_EQ(r.status, 0) << command << ": " << r.output;
  }
}

}  // namespace
}  // namespace viewpeel
