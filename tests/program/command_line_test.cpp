// A wrong command line is refused in one line, which suggests the word that the user may have meant.
#include <regex>

#include <fmt/format.h>

#include "tests/support/program.h"

namespace viewpeel {
namespace {

const std::string kCube = VIEWPEEL_SCENES "/cube.obj";

TEST_F(Program, MistypedWordsAreCorrectedInOneLine) {
  struct Case {
    std::string arguments, first, last;
  };
  for (const Case& c : std::vector<Case>{
           {"comput " + kCube, "'comput' is neither a command nor a file; did you mean compute?", "viewpeel --help'"},
           {"nothing.obj", "'nothing.obj' is neither a command nor a file; commands are compute", "viewpeel --help'"},
           {"", "A subcommand is required; name one of compute, ", "viewpeel --help'"},
           {"compute " + kCube + " --tol 1", "there is no option --tol; did you mean --tolerance?", "compute --help'"},
           {"compute " + kCube + " --two_sided", "there is no option --two_sided; did you mean --two-sided?",
            "compute --help'"},
           {"plan " + kCube + " --resoluton=9", "there is no option --resoluton; did you mean --resolution?",
            "plan --help'"},
           {"compute " + kCube + " --zzzzzzz", "there is no option --zzzzzzz; see", "compute --help'"},
           {"devices one two", "'one' is not expected", "devices --help'"},
           {"compute " + kCube + " --directions", "--directions: write it as --directions N", "compute --help'"},
           {"compute " + kCube + " -o", "--output: write it as --output FILE", "compute --help'"},
           {"compute " + kCube + " --up 0,1", "--up: write it as --up X,Y,Z", "compute --help'"},
           {"compute " + kCube + " --seed 1 --seed 2", "--seed: write it once, as --seed K", "compute --help'"},
           {"compute " + kCube + " --promise maybe", "--promise: 'maybe' is not one of on|off", "compute --help'"}}) {
    const Result r = run(c.arguments);
    EXPECT_EQ(r.status, 2) << c.arguments;
    EXPECT_EQ(r.output.find("viewpeel: " + c.first), 0u) << r.output;
    EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << r.output;
    EXPECT_EQ(r.output.substr(r.output.size() - c.last.size() - 1), c.last + "\n") << r.output;
  }
}

TEST_F(Program, ASceneAloneIsComputed) {
  const std::string rest = " --directions 16 --quiet -o ";
  const Result r = run(kCube + rest + file("a.csv"));
  EXPECT_EQ(r.status, 0) << r.output;
  ASSERT_EQ(run("compute " + kCube + rest + file("b.csv")).status, 0);
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
  EXPECT_NE(readFile(file("a.csv")), "");
}

TEST_F(Program, ThreadsAreLimited) {
  const Result r = run(kCube + " --threads 1 --directions 16");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_EQ(r.output.find("device     processor, 1 thread\n"), 0u) << r.output;
  EXPECT_EQ(run(kCube + " --threads 0").status, 2);
}

TEST_F(Program, FilesThatWereThereAreSaidToBeReplaced) {
  const std::string arguments = kCube + " --directions 16 -o " + file("a.csv");
  EXPECT_NE(run(arguments).output.find("\nwritten    " + file("a.csv")), std::string::npos);
  const Result again = run(arguments);
  EXPECT_NE(again.output.find("\nreplaced   " + file("a.csv")), std::string::npos) << again.output;
  EXPECT_EQ(again.output.find("kept       nothing"), std::string::npos) << again.output;
  EXPECT_NE(run(kCube + " --directions 16").output.find("\nkept       nothing but this summary"), std::string::npos);
}

// Exit status 3 and "goal_reached" in --json tell scripts that a run ended before its goal.
TEST_F(Program, AMissedGoalIsNoSuccess) {
  const std::string office = VIEWPEEL_SCENES "/office.obj --by surface --pair-lines off --replicates 2 ";
  const Result missed = run(office + "--tolerance 1e-9 --seconds 0.5 --quiet -o " + file("a.csv"));
  EXPECT_EQ(missed.status, 3) << missed.output;
  EXPECT_NE(missed.output.find("viewpeel: the goal was not reached in time: largest standard error "),
            std::string::npos)
      << missed.output;
  EXPECT_NE(readFile(file("a.csv")), "");
  EXPECT_NE(run(office + "--tolerance 1e-9 --seconds 0.5 --json").output.find("\"goal_reached\": false"),
            std::string::npos);
  for (const char* goal : {"--tolerance 0.05", "--tolerance 0.05 --seconds 100", "--seconds 0.3", "--directions 30"}) {
    const Result reached = run(office + goal + " --json");
    EXPECT_EQ(reached.status, 0) << goal << reached.output;
    EXPECT_NE(reached.output.find("\"goal_reached\": true"), std::string::npos) << goal << reached.output;
    EXPECT_NE(reached.output.find("\"interrupted\": false"), std::string::npos) << goal << reached.output;
  }
}

TEST_F(Program, JsonIsUtf8WhateverNamesAre) {
  std::ofstream(file("odd\xff.obj")) << "o a\xff\xc3\xa9\xed\xa0\x80\\\"b\n"
                                        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no c\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 6 5 4\n";
  const std::string scene = file("odd\xff.obj");
  const Result r = run(fmt::format("'{}' --directions 16 --json", scene));
  ASSERT_EQ(r.status, 0) << r.output;
  std::ofstream(file("out.json")) << r.output;
  const std::string command =
      fmt::format("/usr/bin/python3 -c \"import json; json.load(open('{}', encoding='utf-8'))\"", file("out.json"));
  EXPECT_EQ(std::system(command.c_str()), 0) << r.output;
}

TEST_F(Program, WholeNumbersMayHaveExponents) {
  const std::string plates = VIEWPEEL_SCENES "/plates.obj -q ";
  ASSERT_EQ(run(plates + "--directions 1e2 --replicates 2e0 -o " + file("a.csv")).status, 0);
  ASSERT_EQ(run(plates + "--directions 100 --replicates 2 -o " + file("b.csv")).status, 0);
  EXPECT_EQ(readFile(file("a.csv")), readFile(file("b.csv")));
  for (const char* number : {"1e10", "0", "1.5", "-1", "nan", "inf", "2e", "many"}) {
    const Result r = run(plates + "--directions " + number);
    EXPECT_EQ(r.status, 2) << number;
    EXPECT_NE(r.output.find(fmt::format("{} is not a whole number from 1 to 1073741824", number)), std::string::npos)
        << r.output;
  }
}

TEST_F(Program, VersionNamesTheCommit) {
  const Result r = run("--version");
  EXPECT_EQ(r.status, 0);
  EXPECT_TRUE(std::regex_match(r.output, std::regex("viewpeel [0-9.]+( \\(commit [0-9a-f]+\\))?\n"))) << r.output;
}

// The plan and --only environment count no pairs, so they look for leaks by rays before anything else.
TEST_F(Program, LeaksAreWarnedOfWherePairsAreNotCounted) {
  for (const char* words : {"plan ", "compute --only environment --tolerance 0.05 "}) {
    const std::string street = words + std::string(VIEWPEEL_SCENES "/street.obj -q ");
    EXPECT_EQ(run(street).output, "");
    EXPECT_NE(run(street + "--flip pavement_east").output.find("pavement_east looks the wrong way"), std::string::npos);
    EXPECT_EQ(run(street + "--flip pavement_east --two-sided").output, "");
  }
}

}  // namespace
}  // namespace viewpeel
