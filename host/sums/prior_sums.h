// PriorSums adds up a run that uses unoccluded form factors: visibilities by polygon, control variates between
// surfaces, and the pilots' prior.
#pragma once
#include <vector>

#include "sums/visibility_sums.h"

namespace viewpeel {

// A DirectedPair is a pair of faces with separate directions on a separate lattice. Lines of the common directions do
// not enter its form factor.
struct DirectedPair {
  uint32_t i, j;            // i < j, one of Prior::pairs
  uint32_t directions = 0;  // per replicate
  uint32_t resolution = 0;  // of the lattice
  uint32_t visibility = 0;  // in its controls; units of 2^-kVisibilityBits
  uint32_t line = 1;        // counts that one line adds
  double measure_area = 0;  // input units squared of one count, as RunSums has it for common directions
  double count_area = 0;    // the same along its direction

  bool operator==(const DirectedPair&) const = default;
};

// Takes control variates of pairs with separate directions.    In: both sorted    Throws: as takeControlVariates.
std::vector<ControlVariate> takeDirectedControlVariates(const PairCounts& counts,
                                                        const std::vector<DirectedPair>& directed);

// A Prior holds unoccluded exchange areas and visibilities, fixed before the first replicate of its run.
struct Prior {
  // The pairs are sorted. Without has_all_pairs they are the pairs that pilots hit, and those added when the run saw
  // them.
  std::vector<PairPrior> pairs;
  std::vector<uint64_t> lines;           // of faces: counts that one line adds (takeControlVariates)
  bool has_all_pairs = false;            // pairs without an entry cannot see each other
  std::vector<DirectedPair> directed{};  // sorted
  // Faces have these ranks by place (rankByPlace). Where it is empty, pairs that no line hit are not compared with
  // their neighbours.
  std::vector<uint32_t> ranks{};

  bool operator==(const Prior&) const = default;
};

class PriorSums {
 public:
  // Starts without replicates.
  //   In: ids by face and by surface; by: which of the two the form factors are for
  PriorSums(const Ids& face_ids, const Ids& surface_ids, By by, Prior prior);
  // Restores sums from a checkpoint.
  PriorSums(By by, Prior prior, VisibilitySums by_face, ControlVariateSums by_surface, ControlVariateSums directed);

  // Adds one replicate.
  //   In: counts: of common directions; directed: of the separate directions of Prior::directed
  //   Throws: as takeControlVariates.    Cost: O(nonzeros log nonzeros).
  void add(const PairCounts& counts, const PairCounts& directed);
  // Lists pairs of faces that saw each other on `least_lines` lines or more and have no entry in the prior yet.
  std::vector<PairPrior> pairsOutsidePrior(uint64_t least_lines = 0) const;
  // Adds unoccluded exchange areas of pairsOutsidePrior to the prior.    In: sorted, none of them in the prior
  void learn(const std::vector<PairPrior>& pairs);
  // Adds other replicates of the same run. Exchange areas may differ in rounding between devices. The areas of the part
  // with the first replicate stay.
  void add(const PriorSums& others, bool others_are_first);

  By by() const { return by_; }
  const Prior& prior() const { return prior_; }
  const VisibilitySums& byFace() const { return by_face_; }  // empty where the rows are surfaces
  const ControlVariateSums& surfaceControls() const { return by_surface_; }
  const ControlVariateSums& directed() const { return directed_; }  // by face
  // Returns true where both have the same visibilities in their prior, to the last bit.
  bool goesWith(const PriorSums& others) const;
  // Returns true where the same pairs have as many separate directions in both.
  bool directsAs(const PriorSums& others) const;

  // Finds form factors by polygon and their row sums.
  //   In: measure_area, count_area: as in ReplicateSums; counted: all lines of each row, of the same replicates
  //   sampled: entries of the pairs for which isCountedAlone holds
  //   row: exchange areas of pairs outside the prior; empty: such pairs are counted, or left out
  FormFactors byPolygon(double measure_area, double count_area, const ReplicateSums& counted,
                        const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row = {}) const;
  // Returns entries of the prior's pairs alone, one for each, before guesses are made to fit their rows.
  std::vector<FormFactors::Entry> ofPriorPairs(double measure_area, double count_area,
                                               const ReplicateSums& counted) const;
  // Finds form factors between surfaces.
  //   In: sampled: counted form factors of the same replicates, which stand where control variates add noise
  FormFactors bySurface(double measure_area, double count_area, const FormFactors& sampled) const;
  // Returns true where counts alone are the estimate of a pair of the prior (docs/method.md, eq. (42)).
  //   In: directions: of all replicates; count_area: as in ReplicateSums
  bool isCountedAlone(const PairPrior& pair, double directions, double count_area) const;
  // Returns control variates of faces, with the visibilities of the prior.
  ControlVariateSums faceControls() const { return by_face_.controls(visibilities_, prior_.lines); }
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
  // All four lists follow from prior_.
  std::vector<PairVisibility> visibilities_, surface_visibilities_;
  std::vector<PairVisibility> row_visibilities_;  // of environment and leak
  std::vector<PriorExchange> surface_exchanges_, directed_exchanges_;
};

}  // namespace viewpeel
