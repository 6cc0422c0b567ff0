// What unoccluded form factors and pilots say about a pair of faces before the run.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sums/control_variate_sums.h"

namespace viewpeel {

// Of a pair of faces, or of a face with environment or leak.
struct PairPrior {
  uint32_t i, j;  // i < j
  uint32_t visibility =
      0;  // in the controls of faces, and what a pair is taken for that no line met; units of 2^-kVisibilityBits
  uint32_t surface_visibility = 0;  // in those between surfaces: the same, or 0
  double exchange =
      0;  // A_i F_ij with nothing in between, A_i for environment and leak; infinite where unknown, and visibilities 0

  bool operator==(const PairPrior&) const = default;
};

// Which pairs that the run itself has met, and whose exchange areas were computed for that, count as visibilities of
// these. Where a pair that was not met has no entry, only those count so that every run meets: a visibility of a pair
// that few runs meet is right on the average of these, and its row adds up to too little on the average of all. What
// decides is known before the run: a pair's expected lines, L = N X / (2 h^2) for N directions and counts of area h^2,
// and directions, for one that sees it has 1 + 8/27 A / h^2 lines.
//   In: exchange: input units squared; area: the smaller of the two
inline bool isEstimatedByVisibility(double directions, double count_area, double exchange, double area) {
  constexpr double kLeastLines = 64, kLeastDirections = 16;
  const double lines = directions * exchange / (2 * count_area);
  return lines >= kLeastLines && lines / (1 + 8 / 27.0 * area / count_area) >= kLeastDirections;
}

// An exchange area with nothing in between, and what it may be off by; input units squared.
struct BoundedExchange {
  double area = 0, error = 0;
};

// What visibilities of it add back.    In: areas, lines: of faces
inline PriorExchange exchangeOf(const PairPrior& pair, uint32_t visibility, const std::vector<double>& areas,
                                const std::vector<uint64_t>& lines) {
  // Unoccluded form factors exceed areas by rounding.
  const double most = std::min({pair.exchange, areas[pair.i], pair.j < kEnvironment ? areas[pair.j] : INFINITY});
  return {pair.i, pair.j, most * visibility / kVisibilityOne, std::isinf(pair.exchange) ? INFINITY : most,
          lineOf(lines, pair.i, pair.j)};
}

}  // namespace viewpeel
