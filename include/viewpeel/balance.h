// Form factors of a closed scene whose rows sum to 1: those nearest to the measured ones.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Row sums of balanced form factors differ from 1 by at most this: what 10^7 roundings can come to, with room.
constexpr double kBalanceTolerance = 1e-12;

// In a closed scene about 1e-8 of all lines, those that graze an edge within rounding, may be counted as environment or
// leak. A share larger than this is an opening; a single line in 10^5 is not.
constexpr double kGrazingShare = 1e-5;

// Why balanceRows refuses a question.
constexpr const char* kBalanceNeedsEveryRow = "--balance needs every row; leave out --from, --pair and --blocker";

struct BalancedFormFactors {
  // The entries measured, in their order, and their standard errors; environment and leak are 0.
  FormFactors form_factors;
  // y_i of every row: A_i F_ij = max(0, c_ij + w_ij (y_i + y_j)), and max(0, c_ii + w_ii y_i) for what sees itself.
  std::vector<double> row_corrections;
  uint32_t steps = 0;  // of Newton's method

  // How far exchange areas x_ij are from the measured c_ij with their standard errors s_ij:
  double rms_change = 0;      // sqrt(sum (x_ij - c_ij)^2 / sum s_ij^2), 0 where all s_ij are 0
  double largest_change = 0;  // |x_ij - c_ij| / s_ij, over pairs whose s_ij is not 0
  // The form factor that changed most.
  double largest_form_factor_change = 0;
  uint32_t from = 0, to = 0;
};

// Finds x_ij = x_ji >= 0 with sum_j x_ij = A_i in every row i that minimise sum (x_ij - c_ij)^2 / w_ij over unordered
// pairs, c_ij = A_i F_ij as measured and w_ij its standard error, no more than c_ij itself. Least squares would divide
// by the variance, if errors were independent and their variances known. Where few lines tell, both are not: a standard
// error is rough, or a bound, and errors of a row go together, so that its square asks of the least known more than
// they can give. w_ij = c_ij, as of counts of independent lines, moves pairs whose unoccluded form factors are known as
// much as others. Both left larger errors where form factors are shares of unoccluded form factors (README, Accuracy).
//   In: form factors of all rows. Pairs of 0 stay 0; without a standard error w_ij = c_ij.
//   Out: see BalancedFormFactors; x_ij is one number, so A_i F_ij = A_j F_ji holds as before.
//   Error: row sums differ from 1 by at most kBalanceTolerance. In the norm minimised the result is no farther from the
//   true exchange areas
//     than c is, if every pair that sees each other was met: x is the nearest point of a convex set that they lie in.
//     Tests: tests/device/balance_test.cpp.
//   Throws: Error bad_usage where only some rows were asked for; bad_input where more than kGrazingShare of all lines
//   leave the scene or end on
//     backs, where a row has no pair, or where no x exists (rows that have met only rows of a smaller area in all):
//     more directions or a finer lattice; limit where Newton's method does not end.
//   Cost: a few Newton steps (3 to 5 in the scenes measured), each some dozens of O(nonzeros) products; memory 60 bytes
//   an entry.
//   Source: W. E. Deming & F. F. Stephan, On a least squares adjustment of a sampled frequency table when the expected
//     marginal totals are known, Ann. Math. Stat. 11(4), 1940, 427-444 (the adjustment); the solver's is in
//     balance.cpp.
BalancedFormFactors balanceRows(const FormFactors& measured);

}  // namespace viewpeel
