// PriorSums adds up the counts of a run that uses unoccluded form factors. By polygon it estimates visibilities,
// between surfaces it uses control variates. The prior is what pilots found before the run.
#pragma once
#include <vector>

#include "sums/visibility_sums.h"

namespace viewpeel {

// A DirectedPair is a pair of faces whose form factor comes from separate directions and lattices (docs/method.md,
// section 8), not from common directions.
struct DirectedPair {
  uint32_t i, j;            // i < j; the pair is also in Prior::pairs
  uint32_t directions = 0;  // number of its directions in each replicate
  uint32_t resolution = 0;  // lattice spacings across the unit ball's diameter
  uint32_t visibility = 0;  // visibility in its control variates, in units of 2^-kVisibilityBits
  uint32_t line = 1;        // counts that one line adds
  double measure_area = 0;  // as in ReplicateSums, for its directions, input units squared
  double count_area = 0;    // as in ReplicateSums, for its directions, input units squared

  bool operator==(const DirectedPair&) const = default;
};

// Returns the control variates of directed pairs in one replicate.
//   In: counts, directed: sorted by (i, j); counts has no other pairs    Throws: as takeControlVariates.
std::vector<ControlVariate> takeDirectedControlVariates(const PairCounts& counts,
                                                        const std::vector<DirectedPair>& directed);

// A Prior holds the unoccluded exchange areas and visibilities of pairs, fixed before the first replicate of the run.
struct Prior {
  // The list holds pairs of faces, sorted by (i, j). Without has_all_pairs they are the pairs that pilots met, and
  // further pairs that learn() adds during the run.
  std::vector<PairPrior> pairs;
  std::vector<uint64_t> lines;           // as in lineOf, by face
  bool has_all_pairs = false;            // whether pairs that are not in `pairs` cannot see each other
  std::vector<DirectedPair> directed{};  // sorted by (i, j)
  // Faces have these ranks by place, as rankByPlace() returns them. Where the list is empty, pairs that no line met do
  // not take their neighbours' visibility.
  std::vector<uint32_t> ranks{};

  bool operator==(const Prior&) const = default;
};

class PriorSums {
 public:
  // Makes sums of no replicates.
  //   In: face_ids, surface_ids: rows by face and by surface; by: which of the two the result has
  PriorSums(const Ids& face_ids, const Ids& surface_ids, By by, Prior prior);
  // Restores sums from a checkpoint.
  PriorSums(By by, Prior prior, VisibilitySums by_face, ControlVariateSums by_surface, ControlVariateSums directed);

  // Adds one replicate.
  //   In: counts: counts of pairs of faces along common directions; directed: counts of each of Prior::directed along
  //     its directions
  //   Throws: as takeControlVariates.    Cost: O(n log n) for n counts.
  void add(const PairCounts& counts, const PairCounts& directed);
  // Returns the pairs of faces that are not in the prior, with a facing line and `least_lines` lines or more, facing or
  // blocked. Their unoccluded exchange areas are not known yet, and are set to 0.
  std::vector<PairPrior> pairsOutsidePrior(uint64_t least_lines = 0) const;
  // Adds pairs to the prior, with the unoccluded exchange areas that the caller has computed.
  //   In: pairs: sorted by (i, j), none of them in the prior
  void learn(const std::vector<PairPrior>& pairs);
  // Adds other replicates of the same run. Exchange areas of the two priors may differ by rounding, where they come
  // from different devices. The exchange areas of the part with the first replicate are kept.
  //   In: others_are_first: whether `others` has the first replicate
  void add(const PriorSums& others, bool others_are_first);

  By by() const { return by_; }
  const Prior& prior() const { return prior_; }
  const VisibilitySums& byFace() const { return by_face_; }  // has no pairs where rows of the result are surfaces
  const ControlVariateSums& surfaceControls() const { return by_surface_; }
  const ControlVariateSums& directed() const { return directed_; }  // sums of directed pairs of faces
  // Returns whether the priors of both have the same visibilities, to the last bit, so that the two can be added.
  bool goesWith(const PriorSums& others) const;
  // Returns whether both have the same directed pairs, with as many directions on the same lattices.
  bool directsAs(const PriorSums& others) const;

  // Returns form factors by polygon, with their row sums, after calibrateRows.
  //   In: measure_area, count_area: as in ReplicateSums; counted: sums of the same replicates, whose row sums are used;
  //     sampled: entries, from counts alone, of pairs outside the prior and of pairs with isCountedAlone; row: computes
  //     exchange areas of pairs outside the prior; where it is empty these pairs have only their `sampled` entry, if
  //     any
  FormFactors byPolygon(double measure_area, double count_area, const ReplicateSums& counted,
                        const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row = {}) const;
  // Returns one entry for each pair of the prior, before calibrateRows.
  std::vector<FormFactors::Entry> ofPriorPairs(double measure_area, double count_area,
                                               const ReplicateSums& counted) const;
  // Returns form factors between surfaces, from control variates.
  //   In: sampled: form factors of the same replicates from counts alone, which chooseBetter takes where control
  //     variates add noise
  FormFactors bySurface(double measure_area, double count_area, const FormFactors& sampled) const;
  // Returns whether a pair of the prior is estimated by its counts alone (docs/method.md, eq. (42)).
  //   In: directions: number of directions in all replicates; count_area: as in ReplicateSums
  bool isCountedAlone(const PairPrior& pair, double directions, double count_area) const;
  // Returns the sums of the control variates of pairs of faces, with the visibilities of the prior.
  ControlVariateSums faceControls() const { return by_face_.controls(visibilities_, prior_.lines); }
  // Returns form factors between faces from these control variates, with the row sums of `sampled`.
  FormFactors controlledFormFactors(double measure_area, const FormFactors& sampled) const;

 private:
  void prepare();
  PairCounts withoutDirected(PairCounts counts) const;
  std::vector<FormFactors::Entry> directedEntries() const;
  VisibilitySums::Found find(double measure_area, double count_area, const ReplicateSums& counted,
                             const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row) const;

  By by_;
  Prior prior_;
  VisibilitySums by_face_;
  ControlVariateSums by_surface_, directed_;
  // prepare() makes these five lists from prior_.
  std::vector<PairVisibility> visibilities_, surface_visibilities_;
  std::vector<PairVisibility> row_visibilities_;  // the prior's pairs with environment and leak
  std::vector<PriorExchange> surface_exchanges_, directed_exchanges_;
};

}  // namespace viewpeel
