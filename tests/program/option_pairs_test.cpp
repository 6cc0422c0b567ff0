// Options are tested in pairs: any two values of two options occur together in some run, on scenes like users' scenes.
//
// Runs are the rows of a covering array, which a greedy search makes (Cohen, Dalal, Fredman, Patton, IEEE Transactions
// on Software Engineering 23 (7), 1997). A run may end with status 0, and then its form factors are the scene's within
// their stated error. It may end with status 2 and one line on stderr, where its options contradict each other in a way
// that option_choices.cpp lists. No signal, other status or other refusal is allowed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/program/option_choices.h"
#include "tests/support/program.h"

namespace viewpeel {
namespace {

struct Entry {
  double value = 0, standard_error = 0;
};
using Matrix = std::map<std::pair<std::string, std::string>, Entry>;

Matrix readCsv(const std::string& text) {
  Matrix matrix;
  std::istringstream in(text);
  std::string line, word;
  for (std::getline(in, line); std::getline(in, line);) {
    std::vector<std::string> words;
    for (std::istringstream cells(line); std::getline(cells, word, ',');) words.push_back(word);
    matrix[{words.at(0), words.at(1)}] = {std::stod(words.at(2)), std::stod(words.at(3))};
  }
  return matrix;
}

// Stated holds the largest errors that a run allows itself.
struct Stated {
  double quantile = 0;          // number of standard errors that an error exceeds with probability kFalseAlarm
  std::optional<double> bound;  // on every form factor, where the run gives a guarantee
};

// All runs together compare some 10,000 form factors and row sums, so that one run of these tests in 1,000 raises a
// false alarm.
constexpr double kFalseAlarm = 1e-7;
constexpr double kRounding = 1e-9;  // error of a sum of 100 entries, and of corners snapped to 2^-15 of a spacing

double studentQuantile(uint64_t replicates) {
  return boost::math::quantile(
      boost::math::complement(boost::math::students_t(double(replicates) - 1), kFalseAlarm / 2));
}

// Returns a line for each form factor that differs from the truth by more than `stated` allows, and for each that was
// not requested.
std::vector<std::string> findDifferences(
    const Matrix& found, const Matrix& truth, const Stated& stated,
    const std::function<bool(const std::string&, const std::string&)>& is_requested) {
  Matrix all = truth;
  all.insert(found.begin(), found.end());
  std::vector<std::string> differences;
  for (const auto& [pair, unused] : all) {
    const Entry f = found.contains(pair) ? found.at(pair) : Entry{},
                t = truth.contains(pair) ? truth.at(pair) : Entry{};
    if (!is_requested(pair.first, pair.second)) {
      if (found.contains(pair))
        differences.push_back(fmt::format("{} to {}: was not asked for", pair.first, pair.second));
      continue;
    }
    const double most = stated.bound ? *stated.bound + stated.quantile * t.standard_error
                                     : stated.quantile * std::hypot(f.standard_error, t.standard_error);
    if (!(std::abs(f.value - t.value) <= most + kRounding))
      differences.push_back(fmt::format("{} to {}: {} +- {}, but {} +- {}, {} at most", pair.first, pair.second,
                                        f.value, f.standard_error, t.value, t.standard_error, most));
  }
  return differences;
}

// Returns a line for each row whose sum differs from 1 by more than the sum of its entries' allowed errors, which may
// all have one sign.
std::vector<std::string> findOpenRows(const Matrix& found, const Stated& stated) {
  std::map<std::string, Entry> rows;
  for (const auto& [pair, entry] : found) {
    rows[pair.first].value += entry.value;
    rows[pair.first].standard_error += stated.bound ? *stated.bound : stated.quantile * entry.standard_error;
  }
  std::vector<std::string> open;
  for (const auto& [name, row] : rows)
    if (!(std::abs(row.value - 1) <= row.standard_error + kRounding))
      open.push_back(fmt::format("row {} adds up to {}, {} at most", name, row.value, row.standard_error));
  return open;
}

// ---- runs

class OptionPairs : public Program {
 protected:
  struct Streams {
    int status;
    std::string out, err;
  };

  void SetUp() override {
    Program::SetUp();
    for (const std::string& scene : kAxes[1].choices) std::ofstream(file(scene + ".obj")) << makeScene(scene);
  }

  Streams start(const std::string& arguments) const {
    const int status = std::system(
        fmt::format("timeout 120 {} {} >{} 2>{} </dev/null", VIEWPEEL_PROGRAM, arguments, file("out"), file("err"))
            .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readFile(file("out")), readFile(file("err"))};
  }

  // Returns the exact engine's form factors. The exact engine shares neither lattice nor shaders with the other
  // engines. The test TruthEqualsTheClosedForm checks it against closed forms.
  const Matrix& truthOf(const std::string& scene, bool by_surface, bool two_sided) {
    const auto [at, is_new] = truths_.try_emplace({scene, by_surface, two_sided});
    if (!is_new) return at->second;
    const Streams r = start(fmt::format(
        "compute {} --engine exact --quiet --seed 77 --directions 1000 --replicates 16 -o {} {}{}",
        file(scene + ".obj"), file("truth.csv"), by_surface ? "--by surface " : "", two_sided ? "--two-sided" : ""));
    EXPECT_EQ(r.status, 0) << r.err;
    return at->second = readCsv(readFile(file("truth.csv")));
  }

  // A run ends with status 0 and nothing but warnings on stderr, or with a refusal that is listed.
  void checkStatus(const Choices& run, const Streams& r, const std::string& arguments) {
    const std::vector<std::string> says = refusalsOf(run);
    if (says.empty()) {
      EXPECT_EQ(r.status, 0) << arguments << "\n" << r.err;
      std::istringstream lines(r.err);
      for (std::string line; std::getline(lines, line);)
        EXPECT_EQ(line.find("viewpeel: warning: "), 0u) << arguments << "\n" << line;
      return;
    }
    EXPECT_EQ(r.status, 2) << arguments << "\n" << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << arguments << "\n" << r.err;
    EXPECT_TRUE(std::any_of(says.begin(), says.end(),
                            [&](const std::string& part) {
                              return r.err.find("viewpeel: ") == 0 && r.err.find(part) != std::string::npos;
                            }))
        << arguments << "\n"
        << r.err << "expected one of: " << fmt::format("{}", fmt::join(says, " | "));
  }

  static std::string commonArguments(const Choices& run) {
    std::string arguments;
    for (size_t axis = 0; axis + kOfCompute < kAxes.size(); ++axis)
      if (kAxes[axis].name != "scene" && !kAxes[axis].choices[run[axis]].empty())
        arguments += " " + kAxes[axis].choices[run[axis]];
    return arguments;
  }

  void checkCompute(const Choices& run) {
    const std::string csv = file("f.csv"), mtx = file("f.mtx"), checkpoint = file("run.h5"),
                      scene = choiceOf(run, "scene");
    for (const std::string& old : {csv, mtx, checkpoint, file("f.balanced.mtx")}) std::filesystem::remove(old);
    std::string arguments = "compute " + file(scene + ".obj") + commonArguments(run) + " -o " + csv;
    for (const char* axis : {"balance", "talk"})
      if (!choiceOf(run, axis).empty()) arguments += " " + choiceOf(run, axis);
    if (has(run, "matrix", "-o")) arguments += " -o " + mtx;
    if (has(run, "long run", "checkpoint")) arguments += " --checkpoint " + checkpoint;
    SCOPED_TRACE(arguments);
    Streams r = start(arguments);
    checkStatus(run, r, arguments);
    if (r.status != 0) return;
    if (has(run, "long run", "resume")) {
      r = start(arguments + " --resume");
      checkStatus(run, r, arguments + " --resume");
      if (r.status != 0) return;
    }
    EXPECT_EQ(r.out.empty(), has(run, "talk", "quiet")) << r.out;
    EXPECT_EQ(r.out.starts_with("{\n") && r.out.ends_with("\n}\n"), has(run, "talk", "json")) << r.out;
    const Matrix found = readCsv(readFile(csv));
    if (has(run, "matrix", "-o")) checkMatrix(readFile(mtx), found);
    checkErrors(run, found, r.out);
  }

  // The .mtx file has the values and row names of the .csv file.
  void checkMatrix(const std::string& text, const Matrix& found) {
    std::istringstream in(text);
    std::vector<std::string> names;
    size_t entries = 0, expected = 0;
    std::string line;
    while (std::getline(in, line) && line[0] == '%')
      if (line.size() > 2 && std::isdigit(line[2])) names.push_back(line.substr(line.rfind(' ') + 1));
    for (size_t row = 0, column = 0; std::getline(in, line); ++entries) {
      double value = 0;
      std::istringstream(line) >> row >> column >> value;
      const auto at = found.find({names.at(row - 1), names.at(column - 1)});
      ASSERT_NE(at, found.end()) << line;
      EXPECT_EQ(value, at->second.value) << line;
    }
    for (const auto& [pair, entry] : found) expected += pair.second != "environment" && pair.second != "leak";
    EXPECT_EQ(entries, expected);
  }

  void checkErrors(const Choices& run, const Matrix& found, const std::string& out) {
    const std::string question = choiceOf(run, "question");
    const auto isOf = [](const std::string& id, const std::string& surface) {
      return id == surface || id.starts_with(surface + "[");
    };
    const auto is_requested = [&](const std::string& from, const std::string& to) {
      if (question.starts_with("--from")) return isOf(from, "floor");
      if (question.starts_with("--pair"))
        return (isOf(from, "floor") && isOf(to, "ceiling")) || (isOf(from, "ceiling") && isOf(to, "floor"));
      return !question.starts_with("--blocker") || (!isOf(from, "ceiling") && !isOf(to, "ceiling"));
    };
    Stated stated{studentQuantile(16), {}};
    if (has(run, "goal", "--epsilon 0.2")) stated.bound = 0.2;
    if (has(run, "goal", "--epsilon 0.5")) stated.bound = 0.5;
    if (has(run, "goal", "--seconds")) {
      const std::optional<uint64_t> replicates = replicatesIn(out);
      if (!replicates) return;  // --quiet hides the number of replicates
      stated.quantile = std::max(stated.quantile, studentQuantile(*replicates));
    }
    const Matrix& truth = truthOf(choiceOf(run, "scene"), has(run, "by", "surface"), has(run, "sides", "two"));
    EXPECT_EQ(fmt::format("{}", fmt::join(findDifferences(found, truth, stated, is_requested), "\n")), "");
    const bool rows_are_whole = question.empty() || question.starts_with("--from");
    EXPECT_EQ(rows_are_whole ? fmt::format("{}", fmt::join(findOpenRows(found, stated), "\n")) : "", "");
  }

  static std::optional<uint64_t> replicatesIn(const std::string& out) {
    for (const char* before : {"\"replicates\": ", "work       "})
      if (const size_t at = out.find(before); at != std::string::npos)
        return std::strtoull(out.c_str() + at + std::string(before).size(), nullptr, 10);
    return {};
  }

  void checkGoal(const std::string& start) {
    size_t count = 0;
    for (const Choices& run : coverPairs(kAxes.size()))
      if (choiceOf(run, "goal").starts_with(start)) ++count, checkCompute(run);
    EXPECT_GT(count, 5u);
  }

 private:
  std::map<std::tuple<std::string, bool, bool>, Matrix> truths_;
};

TEST_F(OptionPairs, EveryPairIsInARun) {
  std::set<Pair> covered;
  const std::vector<Choices> runs = coverPairs(kAxes.size());
  size_t all = 0, refused = 0;
  for (const Choices& run : runs) {
    refused += !refusalsOf(run).empty();
    for (size_t i = 0; i < kAxes.size(); ++i)
      for (size_t j = i + 1; j < kAxes.size(); ++j) covered.insert({i, run[i], j, run[j]});
  }
  for (size_t i = 0; i < kAxes.size(); ++i)
    for (size_t j = i + 1; j < kAxes.size(); ++j) all += kAxes[i].choices.size() * kAxes[j].choices.size();
  EXPECT_EQ(covered.size(), all);
  EXPECT_GT(runs.size() - refused, 40u);
  EXPECT_TRUE(refusalsOf(Choices(kAxes.size(), 0)).empty());
}

TEST_F(OptionPairs, WithDirections) { checkGoal("--directions 60 --replicates 16"); }
TEST_F(OptionPairs, WithATolerance) { checkGoal("--tolerance"); }
TEST_F(OptionPairs, WithARelativeError) { checkGoal("--relative"); }
TEST_F(OptionPairs, WithAMeanOfAllErrors) { checkGoal("--rms"); }
TEST_F(OptionPairs, WithATime) { checkGoal("--seconds"); }
TEST_F(OptionPairs, WithAGuarantee) { checkGoal("--epsilon"); }

// Tries 600 random combinations of options. Run it with --gtest_also_run_disabled_tests after a change of options; it
// takes five minutes.
TEST_F(OptionPairs, DISABLED_AtRandom) {
  std::mt19937 random(1);
  for (int count = 0; count < 600;) {
    Choices run(kAxes.size());
    for (size_t axis = 0; axis < kAxes.size(); ++axis) run[axis] = random() % kAxes[axis].choices.size();
    if (refusalsOf(run).empty()) ++count, checkCompute(run);
  }
}

TEST_F(OptionPairs, OfAPlan) {
  for (const Choices& run : coverPairs(kAxes.size() - kOfCompute)) {
    const std::string arguments = "plan " + file(choiceOf(run, "scene") + ".obj") + commonArguments(run);
    const Streams r = start(arguments);
    checkStatus(run, r, arguments);
    const bool says_time = std::ranges::any_of(std::array{"\nexpected   ", "\nplan       "},
                                               [&](const char* part) { return r.out.find(part) != std::string::npos; });
    EXPECT_EQ(says_time, r.status == 0) << arguments << "\n" << r.out;
  }
}

// All other tests compare runs with the exact engine. This test compares the exact engine with closed forms: opposite
// and adjacent faces of a cube (Howell, C-11 and C-14), and a wall that no line passes.
TEST_F(OptionPairs, TruthEqualsTheClosedForm) {
  const double opposite = 0.199824895698, adjacent = (1 - opposite) / 4;
  for (const std::string scene : {"cube", "junctions", "plates"}) {
    const Matrix& truth = truthOf(scene, true, false);
    for (const auto& [pair, entry] : truth) {
      if (pair.second == "environment") continue;
      const bool is_opposite = std::set{pair.first, pair.second} == std::set<std::string>{"floor", "ceiling"};
      if (!is_opposite && pair.first != "floor") continue;
      EXPECT_NEAR(entry.value, is_opposite ? opposite : adjacent, studentQuantile(16) * entry.standard_error)
          << scene << " " << pair.second;
    }
    EXPECT_TRUE(truth.contains({"floor", "ceiling"}));
  }
  EXPECT_FALSE(truthOf("wall", false, false).contains({"partition_west", "partition_east"}));
  EXPECT_FALSE(truthOf("wall", false, false).contains({"partition_west", "east"}));
}

// Negative controls: the comparison finds a form factor that is off by 0.05, a missing one, one too many, and a row
// whose sum is off.
TEST_F(OptionPairs, WrongFormFactorsAreFound) {
  const Matrix truth = truthOf("box", false, false);
  const Stated stated{studentQuantile(16), {}};
  const auto all = [](const std::string&, const std::string&) { return true; };
  EXPECT_EQ(findDifferences(truth, truth, stated, all).size(), 0u);
  EXPECT_EQ(findOpenRows(truth, stated).size(), 0u);
  Matrix wrong = truth;
  wrong.at({"floor", "ceiling"}).value += 0.05;
  EXPECT_EQ(findDifferences(wrong, truth, stated, all).size(), 1u);
  EXPECT_EQ(findOpenRows(wrong, stated).size(), 1u);
  wrong = truth;
  wrong.erase({"floor", "ceiling"});
  EXPECT_EQ(findDifferences(wrong, truth, stated, all).size(), 1u);
  wrong = truth;
  wrong[{"floor", "floor"}] = {0.05, 1e-4};
  EXPECT_EQ(findDifferences(wrong, truth, stated, all).size(), 1u);
  EXPECT_EQ(findDifferences(
                truth, truth, stated,
                [](const std::string& from, const std::string&) {
                  return from != "floor";
                }).size() > 3,
            true);
}

}  // namespace
}  // namespace viewpeel
