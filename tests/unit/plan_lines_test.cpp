// These tests check how many lines planLines() plans.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/plan_lines.h"
#include "scenes/generate.h"

namespace viewpeel {
namespace {

// Plans the lines of a scene's pairs, by polygon.
class Planned {
 public:
  Planned(const Scene& scene, bool two_sided, double tolerance)
      : ids_(makeIds(scene, By::polygon, two_sided)), lines_(scene, ids_, {}, 1, 2, [] {}) {
    options_.tolerance = tolerance;
    options_.by = By::polygon;
  }
  double lines(bool with_rows, double most_lines) {
    double all = 0;
    for (const LinePair& pair : planLines(lines_, lines_.find(0), ids_, ids_, options_, with_rows, most_lines))
      all += pair.linesIn(options_.replicates);
    return all;
  }

 private:
  Ids ids_;
  PairLines lines_;
  EstimateOptions options_;
};

// A run keeps to its `seconds` by a limit of lines. With a tolerance of 1e-12 nearly all pairs want more lines than any
// pair may get (kMostLineBlocks), so that one relief of the goal does not suffice.
TEST(PlanLines, TheFinestGoalKeepsToTheLimit) {
  const Scene scene = buildScene(bench::roomWithBoxes(1));
  Planned planned(scene, false, 1e-12);
  constexpr double kMostLines = 1e7;
  EXPECT_GT(planned.lines(false, INFINITY), 100 * kMostLines);
  EXPECT_LE(planned.lines(false, kMostLines), 2 * kMostLines);  // twice: kSlack of plan_lines.cpp
}

// In an open scene the plan has goals for the environments of rows, too, so that pairs get more lines.
TEST(PlanLines, RowsOfOpenScenesHaveGoals) {
  const Scene scene = buildScene(bench::randomTriangles(100));
  Planned planned(scene, true, 2e-2);
  EXPECT_GT(planned.lines(true, INFINITY), 1.2 * planned.lines(false, INFINITY));
}

}  // namespace
}  // namespace viewpeel
