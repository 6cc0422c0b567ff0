// closeRows() makes exchange areas whose rows add up to the rows' areas: docs/solve.md, eq. (3).
#pragma once
#include <string>
#include <vector>

#include <Eigen/SparseCore>

#include <viewpeel/form_factors.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// An environment larger than this many standard errors is real: a normal error exceeds it once in 147,000 cases.
constexpr double kErrorsOfOpenScene = 4.5;

// A ClosedExchange has the exchange areas x_ij between all rows, and x_ie with the environment. A row's lack, by which
// its entries miss its area, is on its diagonal.
struct ClosedExchange {
  Eigen::SparseMatrix<double, Eigen::RowMajor> pairs;  // n x n, symmetric, the diagonal filled
  Eigen::VectorXd areas, environment;                  // of rows; environment is 0 in a closed scene
  bool is_open = false;
  double environment_share = 0;  // share of all emitted radiation that leaves the scene
  double largest_lack = 0;       // the lack of the row whose sum is farthest from 1; below 0 where the sum exceeds 1
  uint32_t lacking_row = 0;
  // A row is true here if its environment is 1 less its pairs, so that its error follows from theirs: bool[row].
  std::vector<bool> environment_is_rest;
};

// Makes closed exchange areas of measured form factors.
//   In: form factors of all rows
//   Error: rounding. Tests: tests/unit/solve_heat_test.cpp.
//   Throws: Error bad_usage for some rows only; bad_input where more than kGrazingShare of all radiation ends on backs.
//   Cost: O(entries); memory 24 bytes an entry.
ClosedExchange closeRows(const FormFactors& form_factors);

// Refuses form factors of which more than kGrazingShare of all radiation ends on backs.
//   In: scene: of the form factors; nullptr: the cause is not looked for
void requireNoLeak(const FormFactors& form_factors, const Scene* scene);

// Refuses a scene with leak, and says why it leaks.
//   In: share: of all emitted radiation; row: name of the row with the largest part; scene: nullptr where unknown
[[noreturn]] void refuseLeak(double share, const std::string& row, const Scene* scene);

}  // namespace viewpeel
