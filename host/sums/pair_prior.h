// A PairPrior holds the unoccluded form factor of a pair of faces, and its visibility from pilots, before the run.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sums/control_variate_sums.h"

namespace viewpeel {

// Face i is paired with face j, or with environment or leak.
struct PairPrior {
  uint32_t i, j;  // i < j
  // The visibility has the unit 2^-kVisibilityBits. The controls of faces use it, and a pair that no line hit.
  uint32_t visibility = 0;
  // The controls between surfaces use this visibility: the same, or 0.
  uint32_t surface_visibility = 0;
  // The exchange area is A_i F_ij with nothing in between, A_i for environment and leak. It is infinite, with
  // visibilities of 0, where it is unknown.
  double exchange = 0;

  bool operator==(const PairPrior&) const = default;
};

// Returns true where a pair of the run itself, outside the pilots' prior, counts as a visibility: where every run hits
// it, docs/method.md, eq. (42). Beside pairs without an entry, a visibility that few runs measure would leave the sum
// of its row too low on the average.
//   In: exchange: input units squared; area: the smaller of the two
inline bool isEstimatedByVisibility(double directions, double count_area, double exchange, double area) {
  constexpr double kLeastLines = 64, kLeastDirections = 16;
  const double lines = directions * exchange / (2 * count_area);
  return lines >= kLeastLines && lines / (1 + 8 / 27.0 * area / count_area) >= kLeastDirections;
}

// A BoundedExchange is an exchange area with nothing in between, and a bound on its error; input units squared.
struct BoundedExchange {
  double area = 0, error = 0;
};

// Returns the part b A_i F_ij that a visibility b of the pair adds back.    In: areas, lines: of faces
inline PriorExchange exchangeOf(const PairPrior& pair, uint32_t visibility, const std::vector<double>& areas,
                                const std::vector<uint64_t>& lines) {
  // Unoccluded form factors exceed areas by rounding.
  const double most = std::min({pair.exchange, areas[pair.i], pair.j < kEnvironment ? areas[pair.j] : INFINITY});
  return {pair.i, pair.j, most * visibility / kVisibilityOne, std::isinf(pair.exchange) ? INFINITY : most,
          lineOf(lines, pair.i, pair.j)};
}

}  // namespace viewpeel
