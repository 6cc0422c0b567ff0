// These tests check that planLines() keeps to a limit of lines, by which a run keeps to its `seconds`.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/plan_lines.h"
#include "scenes/generate.h"

namespace viewpeel {
namespace {

// With a tolerance of 1e-12 nearly all pairs want more lines than any pair may get (kMostLineBlocks), so that one
// relief of the goal does not suffice.
TEST(PlanLines, TheFinestGoalKeepsToTheLimit) {
  const Scene scene = buildScene(bench::roomWithBoxes(1));
  const Ids ids = makeIds(scene, By::polygon, false);
  PairLines lines(scene, ids, false, 1, 2, [] {});
  EstimateOptions options;
  options.tolerance = 1e-12;
  options.by = By::polygon;
  const auto planned = [&](double most_lines) {
    double all = 0;
    for (const LinePair& pair : planLines(lines, lines.find(0), ids, ids, options, false, most_lines))
      all += pair.linesIn(options.replicates);
    return all;
  };
  constexpr double kMostLines = 1e7;
  EXPECT_GT(planned(INFINITY), 100 * kMostLines);
  EXPECT_LE(planned(kMostLines), 2 * kMostLines);  // twice: kSlack of line_run.cpp
}

}  // namespace
}  // namespace viewpeel
