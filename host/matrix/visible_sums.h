// What a run with closed forms has counted: controls of faces and between surfaces, and what was known beforehand.
#pragma once
#include <vector>

#include "matrix/control_sums.h"

namespace viewpeel {

// What is known before a run of a pair of faces, or of a face with environment or leak.
struct KnownPair {
  uint32_t i, j;               // i < j
  uint32_t share = 0;          // in the controls of faces; units of 2^-kShareBits
  uint32_t surface_share = 0;  // in those between surfaces: the same, or 0
  double exchange = 0;         // A_i F_ij with nothing in between, A_i for environment and leak; infinite where unknown, and shares 0

  bool operator==(const KnownPair&) const = default;
};

struct KnownShares {
  std::vector<KnownPair> pairs;  // sorted
  std::vector<uint64_t> lines;   // of faces: counts that one line adds (takeShares)
  bool has_all_pairs = false;    // pairs that are not there do not see each other

  bool operator==(const KnownShares&) const = default;
};

class VisibleSums {
 public:
  //   In: ids by face and by surface; by: which of the two form factors are asked for
  VisibleSums(const Ids& face_ids, const Ids& surface_ids, By by, KnownShares known);
  // As they were summed before.
  VisibleSums(By by, KnownShares known, ControlSums by_face, ControlSums by_surface);

  // One replicate.    Throws: as takeShares.    Cost: O(nonzeros log nonzeros).
  void add(const PairCounts& counts);
  // Other replicates of the same run. What closed forms gave may differ in rounding between devices: that of the one with the first replicate stays.
  void add(const VisibleSums& others, bool others_are_first);

  By by() const { return by_; }
  const KnownShares& known() const { return known_; }
  const ControlSums& byFace() const { return by_face_; }
  const ControlSums& bySurface() const { return by_surface_; }
  // Whether the shares, that is the integers, are the same.
  bool goesWith(const VisibleSums& others) const;

  //   In: sampled: of the same replicates and kind of ids, for row sums and where shares are of no use
  FormFactors formFactors(By by, double measure_area, const FormFactors& sampled) const;
  // With the shares in any case: of faces.
  FormFactors controlledFormFactors(double measure_area, const FormFactors& sampled) const;

 private:
  void prepare();

  By by_;
  KnownShares known_;
  ControlSums by_face_, by_surface_;
  // Made of known_.
  std::vector<PairShare> shares_, surface_shares_;
  std::vector<KnownExchange> exchanges_, surface_exchanges_;
};

}  // namespace viewpeel
