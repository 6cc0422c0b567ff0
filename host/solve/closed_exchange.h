// Makes exchange areas whose rows add up to the rows' areas: docs/solve.md, eq. (3).
#pragma once
#include <vector>

#include <Eigen/SparseCore>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A ClosedExchange has x_ij and x_ie of all rows. What a row's measured entries lack is on its diagonal.
struct ClosedExchange {
  Eigen::SparseMatrix<double, Eigen::RowMajor> pairs;  // n x n, symmetric, the diagonal filled
  Eigen::VectorXd areas, environment;                  // of rows; environment is 0 in a closed scene
  bool is_open = false;
  double environment_share = 0;  // of all emitted radiation, that which leaves the scene
  double largest_lack = 0;       // the row sum that is farthest from 1 lacks this, or exceeds 1 where it is below 0
  uint32_t lacking_row = 0;
  // The environment of these rows is what their pairs leave of 1, so that the errors of the pairs are in it.
  std::vector<bool> environment_is_rest;
};

// Makes it from measured form factors.
//   In: form factors of all rows
//   Error: rounding. Tests: tests/unit/solve_heat_test.cpp.
//   Throws: Error bad_usage for some rows only; bad_input where more than kGrazingShare of all radiation ends on backs.
//   Cost: O(entries); memory 24 bytes an entry.
ClosedExchange closeRows(const FormFactors& form_factors);

}  // namespace viewpeel
