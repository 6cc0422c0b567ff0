// Balanced form factors of a closed scene have rows that sum to 1, and are the nearest to the measured ones.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Row sums of balanced form factors differ from 1 by at most this much, the sum of 10^7 roundings with room to spare.
constexpr double kBalanceTolerance = 1e-12;

// Lines that graze an edge within rounding, about 1e-8 of all in a closed scene, may be counted as environment or leak.
// A share larger than this is an opening; a single line in 10^5 is not.
constexpr double kGrazingShare = 1e-5;

// The program and balanceRows refuse a question with this message.
constexpr const char* kBalanceNeedsEveryRow = "--balance needs every row; leave out --from, --pair and --blocker";

struct BalancedFormFactors {
  // They have the entries measured, in their order, and their standard errors; environment and leak are 0.
  FormFactors form_factors;
  // Every row i has its y_i: A_i F_ij = max(0, c_ij + w_ij (y_i + y_j)), and A_i F_ii = max(0, c_ii + w_ii y_i) where
  // it sees itself.
  std::vector<double> row_corrections;
  uint32_t steps = 0;  // of Newton's method

  // The changes are of exchange areas x_ij from the measured c_ij with their standard errors s_ij.
  double rms_change = 0;      // sqrt(sum (x_ij - c_ij)^2 / sum s_ij^2), 0 where all s_ij are 0
  double largest_change = 0;  // |x_ij - c_ij| / s_ij, over pairs whose s_ij is not 0
  // The form factor from `from` to `to` changed most.
  double largest_form_factor_change = 0;
  uint32_t from = 0, to = 0;
};

// Finds the balanced exchange areas of docs/method.md, section 10: x_ij = x_ji >= 0 with sum_j x_ij = A_i in every row.
//   Among these it takes the x_ij that minimise sum (x_ij - c_ij)^2 / w_ij over unordered pairs, eq. (33). Here c_ij =
//     A_i F_ij as measured, and w_ij is its standard error, no more than c_ij itself. The section says why w_ij is
//     neither the variance nor c_ij.
//   In: form factors of all rows. Pairs of 0 stay 0; without a standard error w_ij = c_ij.
//   Out: see BalancedFormFactors; x_ij is one number, so A_i F_ij = A_j F_ji holds as before.
//   Error: row sums differ from 1 by at most kBalanceTolerance. In the norm of eq. (33) x is no farther from the true
//     exchange areas than c is, if lines hit every pair that sees each other. It is the nearest point of a convex set
//     that holds them. Tests: tests/unit/balance_test.cpp.
//   Throws: Error bad_usage for a question without all rows; bad_input where more than kGrazingShare of all lines leave
//     the scene or end on backs; bad_input where a row has no pair, or no x exists (a set of rows is larger in area
//     than all its partners): more directions or a finer lattice; limit where Newton's method does not end.
//   Cost: a few Newton steps (3 to 5 in the scenes measured), each some dozens of O(nonzeros) products; memory 60 bytes
//     an entry.
//   Source: W. E. Deming & F. F. Stephan, On a least squares adjustment of a sampled frequency table when the expected
//     marginal totals are known, Ann. Math. Stat. 11(4), 1940, 427-444 (the adjustment). The solver's source is in
//     balance.cpp.
BalancedFormFactors balanceRows(const FormFactors& measured);

}  // namespace viewpeel
