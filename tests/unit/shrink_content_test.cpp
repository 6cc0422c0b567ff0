// These tests shrink results for the page: sums by surface equal sums by hand, and small form factors are left out.
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "report/shrink_content.h"
#include "report/survey_content.h"

namespace viewpeel {
namespace {

// Makes four rows: rows 0 and 1 are surface "a", row 2 is surface "b", row 3 is empty and has no polygon.
ReportContent makeContent() {
  ReportContent content;
  content.names = {"a[1]", "a[2]", "b", "nothing"};
  content.areas = {1, 3, 2, 0};
  content.starts = {0, 2, 3, 5, 5};
  content.to = {1, 2, 2, 0, 1};
  content.form_factors = {0.3, 0.4, 0.2, 0.2, 0.3};
  content.standard_errors = {0.03, 0.01, 0.02, 0.005, 0.03};
  content.lower = {0.2, 0.38, 0.1, 0.19, 0.15};
  content.upper = {0.32, 0.5, 0.25, 0.25, 0.375};
  content.columns = {{"environment", "1", {0.3, 0.5, 0.5, 0}}, {"temperature", "K", {300, 310, 320, 0}}};
  content.geometry.surface_names = {"a", "b"};
  content.geometry.first_corner = {0, 3, 6};
  content.geometry.corner_count = {3, 3, 3};
  content.geometry.row_of_polygon = {0, 1, 2};
  content.geometry.surface_of_polygon = {0, 0, 1};
  content.parameters = {{"unlisted_bound", "0"}};
  return content;
}

// F_IJ is the sum over i in I, j in J of A_i F_ij / A_I. The tolerance allows for three products, each rounded.
TEST(ShrinkContent, SurfacesHaveTheSumsOfTheirRows) {
  const ReportContent sums = addUpBySurface(makeContent());
  EXPECT_EQ(sums.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(sums.areas, (std::vector<double>{4, 2}));
  EXPECT_EQ(sums.starts, (std::vector<int64_t>{0, 2, 3}));
  EXPECT_EQ(sums.to, (std::vector<int32_t>{0, 1, 0}));
  const std::vector<double> form_factors = {(1 * 0.3) / 4, (1 * 0.4 + 3 * 0.2) / 4, 0.2 + 0.3};
  const std::vector<double> errors = {(1 * 0.03) / 4, (1 * 0.01 + 3 * 0.02) / 4, 0.005 + 0.03};
  const std::vector<double> lower = {0.2 / 4, (0.38 + 3 * 0.1) / 4, 0.19 + 0.15};
  const std::vector<double> upper = {0.32 / 4, (0.5 + 3 * 0.25) / 4, 0.25 + 0.375};
  ASSERT_TRUE(sums.hasIntervals());
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(sums.form_factors[k], form_factors[k], 1e-15);
    EXPECT_NEAR(sums.standard_errors[k], errors[k], 1e-15);
    EXPECT_NEAR(sums.lower[k], lower[k], 1e-15);
    EXPECT_NEAR(sums.upper[k], upper[k], 1e-15);
  }
  ASSERT_EQ(sums.columns.size(), 1u);  // means of temperatures would say little
  EXPECT_NEAR(sums.columns[0].values[0], (1 * 0.3 + 3 * 0.5) / 4, 1e-15);
  EXPECT_EQ(sums.geometry.row_of_polygon, (std::vector<int32_t>{0, 0, 1}));
  EXPECT_TRUE(sums.is_bounded);
  ASSERT_EQ(sums.notes.size(), 1u);
  EXPECT_NE(sums.notes[0].find("5 form factors between 4 rows do not fit a page"), std::string::npos) << sums.notes[0];
}

// Where a pair without an entry may add to a sum, the sum of the listed intervals alone would be too narrow.
TEST(ShrinkContent, SumsHaveNoIntervalWhereUnlistedPairsMayAdd) {
  ReportContent content = makeContent();
  content.parameters = {{"unlisted_bound", "0.01"}};
  const ReportContent sums = addUpBySurface(content);
  EXPECT_FALSE(sums.hasIntervals());
  EXPECT_EQ(sums.form_factors.size(), 3u);
}

TEST(ShrinkContent, TheSmallestAreLeftOutAndCounted) {
  ReportContent content;
  const int count = 1000;
  for (int row = 0; row < count; ++row) content.names.push_back("row"), content.areas.push_back(1);
  content.starts = {0};
  for (int row = 0; row < count; ++row) {
    for (int to = 0; to < count; to += 10) {
      content.to.push_back(to);
      content.form_factors.push_back(1e-3 * std::fmod((row * 100 + to) * 0.6180339887, 1.0));
      content.standard_errors.push_back(1e-5);
    }
    content.starts.push_back(static_cast<int64_t>(content.to.size()));
  }
  const ReportContent whole = content;
  const size_t width = 4, largest_bytes = pageBytesOfEntries(whole, width) / 3;
  leaveOutSmall(content, width, largest_bytes);
  EXPECT_LE(pageBytesOfEntries(content, width), largest_bytes);
  EXPECT_GT(pageBytesOfEntries(content, width),
            largest_bytes / 2);  // no more is left out than the bound of 5 bytes requires
  // Every form factor that stays is larger than every one that was left out.
  double least_kept = INFINITY, largest_gone = 0, largest_sum = 0;
  for (double value : content.form_factors) least_kept = std::min(least_kept, value);
  for (int row = 0; row < count; ++row) {
    double sum = 0;
    int64_t kept = content.starts[row];
    for (int64_t k = whole.starts[row]; k < whole.starts[row + 1]; ++k) {
      if (kept < content.starts[row + 1] && content.to[kept] == whole.to[k]) {
        EXPECT_EQ(content.form_factors[kept], whole.form_factors[k]);
        ++kept;
        continue;
      }
      sum += whole.form_factors[k];
      largest_gone = std::max(largest_gone, whole.form_factors[k]);
    }
    EXPECT_EQ(kept, content.starts[row + 1]);
    largest_sum = std::max(largest_sum, sum);
  }
  EXPECT_LT(largest_gone, least_kept);
  ASSERT_EQ(content.notes.size(), 1u);
  const std::string& note = content.notes[0];
  EXPECT_EQ(note.find(std::to_string(whole.entryCount() - content.entryCount()) + " of 100000 form factors"), 0u)
      << note;
  // The note's numbers have two digits, so that rounding changes them by 5 % at most.
  const double stated_sum = std::stod(note.substr(note.find("more than ") + 10));
  EXPECT_NEAR(stated_sum, largest_sum, 0.05 * largest_sum) << note;
}

TEST(SurveyContent, ErrorsAreBoundsWhereThereAreIntervals) {
  ReportContent content = makeContent();
  const std::vector<double> bounds = {0.3 - 0.2, 0.5 - 0.4, 0.2 - 0.1, 0.25 - 0.2, 0.3 - 0.15};
  EXPECT_EQ(statedErrors(content), bounds);
  const ReportSurvey survey = surveyErrors(statedErrors(content));
  EXPECT_EQ(survey.largest_error, bounds[4]);
  EXPECT_EQ(std::accumulate(survey.error_bins.begin(), survey.error_bins.end(), 0.0), 5);
  content.lower.clear(), content.upper.clear();
  EXPECT_EQ(statedErrors(content), content.standard_errors);
}

// Eight small triangles lie at the corners of a cube. A Z curve visits x first, then y, then z.
TEST(SurveyContent, PlacesAreInTheOrderOfAZCurve) {
  ReportContent content;
  const std::vector<int> corners = {6, 1, 7, 0, 4, 3, 5, 2};  // bits are z, y, x
  content.names.assign(corners.size() + 1, "row");            // the last has no polygon
  for (int corner : corners) {
    content.geometry.first_corner.push_back(static_cast<int32_t>(content.geometry.x.size()));
    content.geometry.corner_count.push_back(3);
    content.geometry.row_of_polygon.push_back(static_cast<int32_t>(content.geometry.row_of_polygon.size()));
    for (double x : {0.0, 0.01, 0.0}) {
      content.geometry.x.push_back((corner & 1) + x);
      content.geometry.y.push_back(corner >> 1 & 1);
      content.geometry.z.push_back(corner >> 2);
    }
  }
  std::vector<int32_t> expected(corners.begin(), corners.end());
  expected.push_back(8);
  EXPECT_EQ(ranksByPlace(content), expected);
}

}  // namespace
}  // namespace viewpeel
