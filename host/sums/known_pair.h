// What closed forms and pilots know of a pair of faces.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sums/control_sums.h"

namespace viewpeel {

// Of a pair of faces, or of a face with environment or leak.
struct KnownPair {
  uint32_t i, j;               // i < j
  uint32_t share = 0;          // in the controls of faces, and what a pair is taken for that no line met; units of 2^-kShareBits
  uint32_t surface_share = 0;  // in those between surfaces: the same, or 0
  double exchange = 0;         // A_i F_ij with nothing in between, A_i for environment and leak; infinite where unknown, and shares 0

  bool operator==(const KnownPair&) const = default;
};

// An exchange area with nothing in between, and what it may be off by; input units squared.
struct BoundedExchange {
  double area = 0, error = 0;
};

// What shares of it add back.    In: areas, lines: of faces
inline KnownExchange exchangeOf(const KnownPair& pair, uint32_t share, const std::vector<double>& areas, const std::vector<uint64_t>& lines) {
  // Closed forms exceed areas by rounding.
  const double most = std::min({pair.exchange, areas[pair.i], pair.j < kEnvironment ? areas[pair.j] : INFINITY});
  return {pair.i, pair.j, most * share / kShareOne, std::isinf(pair.exchange) ? INFINITY : most, lineOf(lines, pair.i, pair.j)};
}

}  // namespace viewpeel
