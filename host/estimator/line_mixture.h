// A LineMixture says which pairs of a run get lines of their own, and how many common directions count the others.
//
// A pair whose unoccluded form factor is far below the goal needs no lines: its counts along common directions, cut to
// the goal, are within the goal. Nearly all pairs of many polygons are of this kind, and they are left out before they
// are formed (PairFinder::find). Derivation: docs/method.md, section 13, mixtures.
#pragma once
#include <cstdint>

#include "engines/lattice_options.h"
#include "estimator/estimate.h"
#include "sums/pair_count.h"

namespace viewpeel {

// A replicate has so many common directions where each pair has lines.
constexpr uint32_t kLineRunDirections = 32;
constexpr double kMostCountedPairs = 3e7;  // in all directions: 72 bytes each

struct LineMixture {
  double least_form_factor = 0;              // of pairs with lines, unoccluded, from the smaller face; 0: all pairs
  uint32_t directions = kLineRunDirections;  // of a replicate
  int resolution = 0;                        // of common directions; 0: that of a run in which all pairs have lines
};

// Returns the mixture in which common directions count what is small against the goal.
//   In: options: goals, replicates; mean_area: of polygons, in squares of the scene's radius
LineMixture mixtureFor(const EstimateOptions& options, double mean_area);

// Returns the share of all lines that leave the scene or end on backs.
double shareOutside(const PairCounts& counts);
// Lines graze edges within rounding, and count as leak or environment then. Up to this share they may be all there are.
constexpr double kGrazedOfScene = 1e-5;

// LineWork says what the two ways have to do. It is a function of scene and seed, not of time, so that the same seed
// gives the same bits.
struct LineWork {
  double facing_pairs = 0;        // of faces, with an unoccluded form factor above 0; an estimate
  double pairs_of_direction = 0;  // that a common direction counts
};

// Returns false where common directions surely count too many pairs: along each of them nearly all faces see another.
bool mayFit(const LineMixture& mixture, uint32_t replicates, size_t face_count);
// Returns whether all pairs get lines: where this takes little more time than the mixture, for its form factors are far
// better than the goal asks for.
bool paysLinesForAll(const LineWork& work, const LineMixture& mixture, uint32_t replicates);
// Returns whether common directions count so many pairs that their sums do not fit into memory.
bool countsTooMany(const LineWork& work, const LineMixture& mixture, uint32_t replicates);

}  // namespace viewpeel
