// balanceRows() changes the measured form factors of a closed scene as little as possible, so that every row sums to 1.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Row sums of balanced form factors differ from 1 by at most this much. Rounding a sum of 10^7 terms takes less.
constexpr double kBalanceTolerance = 1e-12;

// A line that grazes an edge within rounding may be counted as environment or leak. In a closed scene this befalls
// about 1e-8 of all lines. A larger share than kGrazingShare means that the scene has an opening.
constexpr double kGrazingShare = 1e-5;

// The program and balanceRows refuse a question with this message.
constexpr const char* kBalanceNeedsEveryRow = "--balance needs every row; leave out --from, --pair and --blocker";

struct BalancedFormFactors {
  // The balanced form factors have the entries of the measured ones, in the same order, and their standard errors.
  // Environment and leak are 0.
  FormFactors form_factors;
  // row_corrections has the multipliers y_i: double[row]. A_i F_ij = max(0, c_ij + w_ij (y_i + y_j)). A row that sees
  // itself has A_i F_ii = max(0, c_ii + w_ii y_i).
  std::vector<double> row_corrections;
  uint32_t steps = 0;  // steps that Newton's method took

  // Two measures say how far the exchange areas x_ij are from the measured c_ij, whose standard errors are s_ij.
  double rms_change = 0;      // sqrt(sum (x_ij - c_ij)^2 / sum s_ij^2), 0 where all s_ij are 0
  double largest_change = 0;  // |x_ij - c_ij| / s_ij, over pairs whose s_ij is not 0
  // The form factor from id `from` to id `to` changed most, by this much.
  double largest_form_factor_change = 0;
  uint32_t from = 0, to = 0;
};

// Finds the balanced exchange areas of docs/method.md, section 10: x_ij = x_ji >= 0 with sum_j x_ij = A_i in every row.
//   Among these it takes the x_ij that minimise sum (x_ij - c_ij)^2 / w_ij over unordered pairs, eq. (33). Here c_ij =
//     A_i F_ij as measured, and w_ij is its standard error, no more than c_ij itself. The section says why w_ij is
//     neither the variance nor c_ij.
//   In: measured: form factors of all rows. A pair of 0 stays 0. A pair without a standard error has w_ij = c_ij.
//   Out: see BalancedFormFactors; x_ij is one number, so A_i F_ij = A_j F_ji holds as before.
//   Error: row sums differ from 1 by at most kBalanceTolerance. If lines hit every pair that sees each other, x is no
//     farther from the true exchange areas than c is, in the norm of eq. (33): x is the nearest point of a convex set
//     that holds the true ones. Tests: tests/unit/balance_test.cpp.
//   Throws: Error bad_usage for a question without all rows; bad_input where more than kGrazingShare of all lines leave
//     the scene or end on backs; bad_input where a row has no pair, or no x exists because some rows have more area
//     than all their partners (more directions or a finer lattice help); limit where Newton's method does not converge.
//   Cost: 3 to 5 Newton steps in the scenes measured, each of some dozens of products of O(nonzeros); 60 bytes of
//     memory an entry.
//   Source: W. E. Deming & F. F. Stephan, On a least squares adjustment of a sampled frequency table when the expected
//     marginal totals are known, Ann. Math. Stat. 11(4), 1940, 427-444 (the adjustment). The solver's source is in
//     balance.cpp.
BalancedFormFactors balanceRows(const FormFactors& measured);

}  // namespace viewpeel
