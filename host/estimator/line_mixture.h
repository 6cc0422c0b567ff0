// A LineMixture says which pairs of a run get lines of their own, and what counts the others: common directions, or
// rays of each polygon's own.
//
// A pair whose unoccluded form factor is far below the goal needs no lines of its own: common directions count it, and
// a count above the goal is cut to the goal. In scenes of many polygons nearly all pairs are of this kind.
// PairFinder::find leaves them out early. Derivation: docs/method.md, section 13, mixtures.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engines/lattice_options.h"
#include "estimator/estimate.h"
#include "pair_lines/pair_lines.h"
#include "sums/line_form_factors.h"
#include "sums/pair_count.h"

namespace viewpeel {

// A replicate has this number of common directions where each pair has lines.
constexpr uint32_t kLineRunDirections = 32;
// Lattices are chosen so that common directions count at most kCountedPairs pairs, or kCountedOfFace a face where that
// is more, 72 bytes each. Only where the coarsest lattice counts more are there up to kMostCountedPairs.
constexpr double kCountedPairs = 3e7, kCountedOfFace = 750, kMostCountedPairs = 1e8;
inline double enoughCounts(size_t face_count) {
  return std::clamp(kCountedOfFace * double(face_count), kCountedPairs, kMostCountedPairs);
}

struct LineMixture {
  double least_form_factor = 0;              // of pairs with lines, unoccluded, from the smaller face; 0: all pairs
  uint32_t directions = kLineRunDirections;  // of a replicate; with rays, the most rays of a polygon
  int resolution = 0;                        // of common directions; 0: that of a run in which all pairs have lines
  std::vector<uint32_t> rays{};              // of each face in a replicate, in place of common directions; or none

  bool hasRays() const { return !rays.empty(); }
  bool countsAll() const { return least_form_factor >= kAllCounted; }
};

// Returns the mixture in which common directions count the pairs that are small against the goal.
//   In: options: goals, replicates; mean_area: of polygons, in squares of the scene's radius
LineMixture mixtureFor(const EstimateOptions& options, double mean_area);

// Returns the unoccluded form factor, from the smaller face, from which on pairs have lines beside rays. Pairs below it
// are small against a tolerance or a relative error. For the root mean square of all errors they take less time by rays
// than by lines.
double leastFormFactorBesideRays(const EstimateOptions& options, size_t face_count);
// Returns the mixture in which rays count the pairs below this form factor, and see what leaves the scene.
//   In: options: goals; rays: as from planRays() or planRaysForRms()
LineMixture rayMixtureFor(const EstimateOptions& options, std::vector<uint32_t> rays);
// Returns the mixture in which rays count all pairs, and none has lines.    In: rays: as from planRays()
LineMixture raysAlone(std::vector<uint32_t> rays);

// Returns the share of all lines that leave the scene or end on backs.
double shareOutside(const PairCounts& counts);
// A line that passes an edge within rounding may count as leak or environment by mistake. A share outside of up to this
// value may consist of such lines alone.
constexpr double kGrazedOfScene = 1e-5;

// LineWork says how much work lines for all pairs would be, and how much common directions. It depends on the scene and
// the seed, not on measured times, so that the same seed gives the same bits.
struct LineWork {
  PairNumbers pairs;              // estimates; large: of at least the mixture's least form factor
  double pairs_of_direction = 0;  // pairs of faces that one common direction counts
};

// Returns false for scenes of so few faces that lines for all pairs take less than a twentieth of a second.
bool mayPayMixture(size_t face_count);

// Returns whether PairLines::find() can find all pairs within minutes, and keep them.
bool mayFindAll(const PairNumbers& pairs);

// Returns false where there may be too many pairs for lines, and common directions are sure to count too many pairs.
// Along a direction nearly every face sees another one on one side, so that at least a quarter as many pairs as faces
// are counted.
bool mayFit(const LineMixture& mixture, uint32_t replicates, size_t face_count);
// These are processor seconds of finding pairs and counting: with lines for all pairs, in a mixture with common
// directions, and in a mixture with this number of rays of all polygons, in all replicates.
//   Error: fits on some scenes and processors (line_mixture.cpp), within a factor of 2 there
double secondsOfLines(const PairNumbers& pairs, bool is_open);
double secondsWithDirections(const LineWork& work, const LineMixture& mixture, uint32_t replicates);
double secondsWithRays(const PairNumbers& pairs, double rays, bool is_open = true);
// Returns whether lines for all pairs of a closed scene take so little time that nothing else pays.
bool areLinesQuick(const PairNumbers& pairs);
// Returns whether all pairs get lines rather than the mixture. They do where lines for all cost little more time, or
// little time at all, because form factors by lines are far more exact.
bool paysLinesForAll(const LineWork& work, const LineMixture& mixture, uint32_t replicates);
// Returns whether the mixture with rays takes so much less time than lines for all pairs that these, which are far more
// exact, do not pay.
//   In: rays: of all polygons, in all replicates; may_promise: whether lines for all pairs may become a promise, which
//     is worth more; is_open: whether lines leave the scene
bool paysRays(const PairNumbers& pairs, double rays, bool may_promise, bool is_open = true);
// Returns how many rays all polygons need in all replicates where the goal is the root mean square of all errors:
// docs/method.md, eq. (48d).    In: form_factors: sum over the pairs that rays count, from the smaller face
double raysForRms(double form_factors, size_t face_count, double rms);
// Returns the processor seconds of so many rays.
double secondsOfRays(double rays);
// Returns whether between surfaces rays that count all pairs take less time than finding the large pairs, beside rays
// that count the others.
//   In: rays_alone, rays_beside: of all polygons, in all replicates
bool paysRaysAlone(const PairNumbers& pairs, size_t face_count, double rays_alone, double rays_beside);
// Returns whether rays that count all pairs take less time than finding pairs that get lines, and surveying the scene
// before. The goal is the root mean square of all errors.    In: rays: of all polygons, in all replicates
bool paysRaysAloneForRms(size_t face_count, double rays);
// Returns false where common directions alone cannot take less time than lines for the most pairs that there can be.
//   In: seconds: processor seconds of the directions
bool mayPayDirectionsAlone(size_t face_count, double seconds);
// Returns the processor seconds that common directions alone may take between surfaces: with more, pairs with lines are
// worth more.    In: is_large: whether a mixture would leave out the small pairs
double mostSecondsOfDirectionsAlone(const PairNumbers& pairs, size_t face_count, bool is_open, bool is_large,
                                    bool may_promise);
// Returns how many pairs common directions count, each along each direction that meets it.
double countedPairs(const LineWork& work, const LineMixture& mixture, uint32_t replicates);

}  // namespace viewpeel
