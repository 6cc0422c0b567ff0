// These tests check laws by which emissivity depends on the angle: their scale, their tables, and refusals.
#include "solve/directional_law.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

// Returns the mean over the hemisphere, weighted by the cosine, by the midpoint rule in the square of the sine:
// int g d(sin^2).
double meanOf(const DirectionalLaw& law) {
  const RelativeEmissivity g(law);
  constexpr int kCount = 100'000;
  double mean = 0;
  for (int k = 0; k < kCount; ++k) mean += g.at(std::sqrt(1 - (k + 0.5) / kCount)) / kCount;
  return mean;
}

// The midpoint rule is off by less than 1e-4: g is monotonic in a few pieces, of which each errs by at most its range
// over 100,000.
TEST(DirectionalLaw, TheMeanIsOne) {
  const DirectionalLaw table{.cosine_power = 0, .angles_deg = {0, 30, 60, 90}, .values = {0.5, 2, 1, 0}};
  for (const double power : {0.0, 0.5, 1.0, 2.0, 10.0}) EXPECT_NEAR(meanOf({.cosine_power = power}), 1, 1e-4) << power;
  EXPECT_NEAR(meanOf(table), 1, 1e-4);
  EXPECT_NEAR(RelativeEmissivity({.cosine_power = 2}).at(1), 2, 1e-15);
  EXPECT_NEAR(RelativeEmissivity({.cosine_power = 2}).at(0.5), 0.5, 1e-15);
  EXPECT_EQ(RelativeEmissivity({.cosine_power = 0}).at(0.3), 1);
}

// A table of cosines in steps of one degree is the law cos^1, to a linear interpolation's error of (pi / 180)^2 / 8.
TEST(DirectionalLaw, TablesAreLinearInTheAngle) {
  DirectionalLaw table;
  for (int degree = 0; degree <= 90; ++degree) {
    table.angles_deg.push_back(degree);
    table.values.push_back(7 * std::cos(degree * std::numbers::pi / 180));
  }
  const DirectionalLaw cosine{.cosine_power = 1};
  const RelativeEmissivity of_table(table), of_cosine(cosine);
  for (const double mu : {0.0, 0.01, 0.3, 0.7, 0.999, 1.0}) EXPECT_NEAR(of_table.at(mu), of_cosine.at(mu), 1.5 * 5e-5);
  EXPECT_NEAR(of_table.largest(), 1.5, 1e-4);
  const DirectionalLaw step{.cosine_power = 0, .angles_deg = {0, 60, 90}, .values = {1, 1, 0}};
  const RelativeEmissivity g(step);
  EXPECT_NEAR(g.at(std::cos(75 * std::numbers::pi / 180)), g.at(1) / 2, 1e-12);
  EXPECT_EQ(g.at(1), g.at(0.6));
  EXPECT_TRUE(RelativeEmissivity({.cosine_power = 0, .angles_deg = {0, 90}, .values = {3, 3}}).isConstant());
}

TEST(DirectionalLaw, EmissivitiesStayBelowOne) {
  EXPECT_EQ(findExcess(0.5, {.cosine_power = 2}), "");
  EXPECT_NE(findExcess(0.51, {.cosine_power = 2}).find("give 0.5 at most"), std::string::npos);
}

TEST(DirectionalLaw, FilesAreRead) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("viewpeel_law_" + std::to_string(::getpid()) + ".csv")).string();
  const auto read = [&](const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
    return readDirectionalLaw(file);
  };
  const std::string header = "angle_degrees,relative_emissivity\n";
  const DirectionalLaw law = read("# measured\n" + header + "0, 1\n45,0.5\r\n\n90,0\n");
  EXPECT_EQ(law.angles_deg, (std::vector<double>{0, 45, 90}));
  EXPECT_EQ(law.values, (std::vector<double>{1, 0.5, 0}));
  const struct {
    std::string text, part;
  } faults[] = {{"", "has no values"},
                {header, "has no values"},
                {"angle,value\n0,1\n90,1\n", ":1: the header is not angle_degrees"},
                {header + "0,1\n90\n", ":3: a line has an angle and a value"},
                {header + "0,1\n90,x\n", ":3: 'x' is not a number"},
                {header + "0,1\n80,1\n", "do not reach from 0 to 90"},
                {header + "0,1\n50,1\n40,1\n90,1\n", "the angle 40 does not ascend"},
                {header + "0,-1\n90,1\n", "not a number from 0 on"},
                {header + "0,0\n90,0\n", "are 0; give one above 0"}};
  for (const auto& fault : faults) try {
      read(fault.text);
      ADD_FAILURE() << fault.part;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find(fault.part), std::string::npos) << error.what();
    }
  std::filesystem::remove(file);
  EXPECT_THROW(readDirectionalLaw(file), Error);
}

}  // namespace
}  // namespace viewpeel
