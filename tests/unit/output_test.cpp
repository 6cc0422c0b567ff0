#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "io/write_file.h"
#include <viewpeel/write.h>
#include "tests/support/random_form_factors.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

FormFactors exampleMatrix() {
  Ids ids;
  ids.names = {"floor", "wall, \"north\""};
  ids.areas = {3, 0.7};
  ids.surface = {0, 1};
  return {ids,
          {{0, 0, {0.3, 0.001}}, {0, 1, {1 / 3.0, 1e-4}}, {1, kEnvironment, {0.1, 0.01}}, {1, kLeak, {0.05, 0.02}}},
          {{1, 0}, {1, 0}}};
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Output, CsvHasOneNonzeroEntryALineBothWays) {
  std::ostringstream out;
  writeCsv(exampleMatrix(), out);
  const auto lines = linesOf(out.str());
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0], "from,to,form_factor,standard_error");
  EXPECT_EQ(lines[1].substr(0, 12), "floor,floor,");
  EXPECT_EQ(lines[2].substr(0, 26), "floor,\"wall, \"\"north\"\"\",0.");
  EXPECT_EQ(lines[3].substr(0, 26), "\"wall, \"\"north\"\"\",floor,0.");
  EXPECT_EQ(lines[4].find("\"wall, \"\"north\"\"\",environment,"), 0u);
  EXPECT_EQ(lines[5].find("\"wall, \"\"north\"\"\",leak,"), 0u);
}

TEST(Output, BalancedFormFactorsAreAColumnMore) {
  const FormFactors f = exampleMatrix();
  FormFactors::Entry moved = f.entries()[1];
  moved.exchange_area.value = 0.3;
  std::ostringstream plain, out;
  writeCsv(f, plain);
  writeCsv(f, out,
           std::make_unique<FormFactors>(f.ids(), std::vector{f.entries()[0], moved, f.entries()[2], f.entries()[3]},
                                         f.rowSums())
               .get());
  const auto lines = linesOf(out.str()), lines_before = linesOf(plain.str());
  ASSERT_EQ(lines.size(), lines_before.size());
  for (size_t k = 0; k < lines.size(); ++k) EXPECT_EQ(lines[k].substr(0, lines[k].rfind(',')), lines_before[k]);
  EXPECT_EQ(lines[0].substr(lines[0].rfind(',')), ",balanced_form_factor");
  EXPECT_EQ(std::stod(lines[2].substr(lines[2].rfind(',') + 1)), 0.3 / 3);
  EXPECT_EQ(std::stod(lines[3].substr(lines[3].rfind(',') + 1)), 0.3 / 0.7);
}

// Threads print the rows of large results in parts. All lines are there, in the order of rows and columns, and each has
// the numbers that a lookup gives.
TEST(Output, LargeResultsAreWrittenInOrder) {
  constexpr uint32_t kCount = 400;  // 113,000 entries, more than all threads print at once
  Ids ids;
  for (uint32_t i = 0; i < kCount; ++i) {
    ids.names.push_back(fmt::format("a[{}]", i + 1));
    ids.areas.push_back(0.1 + 0.01 * i);
    ids.surface.push_back(0);
    ids.requested.push_back(i % 7 != 0);
  }
  const FormFactors random = randomFormFactors(ids, 5, 0.7);
  std::vector<Interval> intervals;
  for (const FormFactors::Entry& entry : random.entries())
    intervals.push_back({0.9 * entry.exchange_area.value, 1.2 * entry.exchange_area.value});
  const FormFactors f(ids, random.entries(), random.rowSums(), intervals);
  std::string expected = "from,to,form_factor,standard_error,lower,upper\n";
  for (uint32_t i = 0; i < kCount; ++i)
    for (uint32_t k = 0; ids.requested[i] && k < kCount + 2; ++k) {
      const uint32_t j = k < kCount ? k : k == kCount ? kEnvironment : kLeak;
      const Measured value = f.formFactor(i, j);
      if (value.value == 0) continue;
      expected += fmt::format("{},{},{},{},{},{}\n", ids.names[i],
                              j == kEnvironment ? "environment"
                              : j == kLeak      ? "leak"
                                                : ids.names[j],
                              value.value, value.standard_error, f.interval(i, j).lower, f.interval(i, j).upper);
    }
  std::ostringstream out;
  writeCsv(f, out);
  EXPECT_TRUE(out.str() == expected);
}

// Numbers in text are read back as the same doubles.
TEST(Output, NumbersReadBackToTheSameBits) {
  const FormFactors f = exampleMatrix();
  std::ostringstream out;
  writeCsv(f, out);
  const std::string line = linesOf(out.str())[2];
  const size_t comma = line.rfind(',');
  EXPECT_EQ(std::stod(line.substr(comma + 1)), f.formFactor(0, 1).standard_error);
  EXPECT_EQ(std::stod(line.substr(line.rfind(',', comma - 1) + 1)), f.formFactor(0, 1).value);
}

TEST(Output, MatrixMarketIsSquareAndCountsItsEntries) {
  const FormFactors f = exampleMatrix();
  std::ostringstream out;
  writeMatrixMarket(f, out);
  const auto lines = linesOf(out.str());
  EXPECT_EQ(lines[0], "%%MatrixMarket matrix coordinate real general");
  size_t at = 1;
  while (lines[at][0] == '%') ++at;
  EXPECT_EQ(lines[at], "2 2 3");
  ASSERT_EQ(lines.size(), at + 4);
  std::istringstream entry(lines[at + 3]);
  int i = 0, j = 0;
  double value = 0;
  entry >> i >> j >> value;
  EXPECT_EQ(i, 2);
  EXPECT_EQ(j, 1);
  EXPECT_EQ(value, f.formFactor(1, 0).value);
}

class OutputFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("viewpeel_output_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(OutputFile, FailedWriteLeavesTheOldFileAndNothingElse) {
  const fs::path file = folder_ / "kept.csv";
  writeFile(file, [](std::ostream& out) { out << "old"; });
  EXPECT_THROW(writeFile(file,
                         [](std::ostream& out) {
                           out << "half";
                           throw std::runtime_error("interrupted");
                         }),
               std::runtime_error);
  std::ifstream in(file);
  std::string text;
  in >> text;
  EXPECT_EQ(text, "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(OutputFile, BadPlacesAreFoundBeforehand) {
  EXPECT_NO_THROW(checkOutput(folder_ / "good.mtx"));
  EXPECT_THROW(checkOutput(folder_ / "missing" / "a.csv"), Error);
  EXPECT_THROW(checkOutput(folder_ / "a.xyz"), Error);
  fs::create_directory(folder_ / "folder.csv");
  EXPECT_THROW(checkOutput(folder_ / "folder.csv"), Error);
}

TEST_F(OutputFile, BalancedMatrixHasASeparateFile) {
  const FormFactors f = exampleMatrix();
  writeFormFactors(f, folder_ / "a.mtx", &f);
  ASSERT_EQ(filesOf(folder_ / "a.mtx", true), (std::vector<fs::path>{folder_ / "a.mtx", folder_ / "a.balanced.mtx"}));
  EXPECT_EQ(filesOf(folder_ / "a.mtx", false).size(), 1u);
  EXPECT_EQ(filesOf(folder_ / "a.csv", true).size(), 1u);
  const auto textOf = [](const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  };
  std::ostringstream plain, balanced;
  writeMatrixMarket(f, plain);
  writeMatrixMarket(f, balanced, "balanced form factors");
  EXPECT_EQ(textOf(folder_ / "a.mtx"), plain.str());
  EXPECT_EQ(textOf(folder_ / "a.balanced.mtx"), balanced.str());
  EXPECT_THROW(checkOutput(folder_ / "a.balanced.mtx", true), Error);
  EXPECT_NO_THROW(checkOutput(folder_ / "a.balanced.mtx"));
}

}  // namespace
}  // namespace viewpeel
