// What a run with closed forms has counted: controls of faces and between surfaces, and what was known beforehand.
#pragma once
#include <vector>

#include "sums/share_sums.h"

namespace viewpeel {

// A pair of faces that directions of its own count, on a lattice of its own: what common directions see of it does not
// enter its form factor.
struct DirectedPair {
  uint32_t i, j;            // i < j, one of KnownShares::pairs
  uint32_t directions = 0;  // per replicate
  uint32_t resolution = 0;  // of the lattice
  uint32_t share = 0;       // in its controls; units of 2^-kShareBits
  uint32_t line = 1;        // counts that one line adds
  double measure_area = 0;  // input units squared of one count, as RunSums has it for common directions
  double count_area = 0;    // the same along its direction

  bool operator==(const DirectedPair&) const = default;
};

// Of pairs with directions of their own, sorted.    Throws: as takeShares.
std::vector<ControlCount> takeDirectedShares(const PairCounts& counts, const std::vector<DirectedPair>& directed);

struct KnownShares {
  std::vector<KnownPair> pairs;  // sorted; without has_all_pairs those that pilots met, and what the run sees beside
  std::vector<uint64_t> lines;   // of faces: counts that one line adds (takeShares)
  bool has_all_pairs = false;    // pairs that are not there do not see each other
  std::vector<DirectedPair> directed{};  // sorted
  std::vector<uint32_t> ranks{};  // of faces, by place (rankByPlace); empty: pairs that no line met are not compared
                                  // with their neighbours

  bool operator==(const KnownShares&) const = default;
};

class VisibleSums {
 public:
  //   In: ids by face and by surface; by: which of the two form factors are asked for
  VisibleSums(const Ids& face_ids, const Ids& surface_ids, By by, KnownShares known);
  // As they were summed before.
  VisibleSums(By by, KnownShares known, ShareSums by_face, ControlSums by_surface, ControlSums directed);

  // One replicate.    In: counts of common directions; of KnownShares::directed what their own have counted    Throws:
  // as takeShares.    Cost: O(nonzeros log nonzeros).
  void add(const PairCounts& counts, const PairCounts& directed);
  // Pairs of faces that saw each other and whose closed forms are not known, nor found out to be out of reach, with
  // shares of 0. but those that fewer lines told than `least`.
  std::vector<KnownPair> unknownPairs(uint64_t least_lines = 0) const;
  // Their closed forms.    In: sorted, and none of them known
  void learn(const std::vector<KnownPair>& pairs);
  // Other replicates of the same run. What closed forms gave may differ in rounding between devices: that of the one
  // with the first replicate stays.
  void add(const VisibleSums& others, bool others_are_first);

  By by() const { return by_; }
  const KnownShares& known() const { return known_; }
  const ShareSums& byFace() const { return by_face_; }  // empty where surfaces are asked for
  const ControlSums& surfaceControls() const { return by_surface_; }
  const ControlSums& directed() const { return directed_; }  // by face
  // Whether the shares, that is the integers, are the same.
  bool goesWith(const VisibleSums& others) const;
  // Whether the same pairs have as many directions of their own.
  bool directsAs(const VisibleSums& others) const;

  // Form factors by polygon and their row sums.
  //   In: measure_area, count_area as in ReplicateSums; counted: of the same replicates, all lines of each row;
  //   sampled: entries of pairs that isCountedAlone has
  //     row: closed forms of pairs that are not known; empty: what is not known is sampled, or left out
  FormFactors byPolygon(double measure_area, double count_area, const ReplicateSums& counted,
                        const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row = {}) const;
  // Those of known pairs alone, one entry for each, whose guesses do not fit their rows yet.
  std::vector<FormFactors::Entry> ofKnownPairs(double measure_area, double count_area,
                                               const ReplicateSums& counted) const;
  //   In: sampled: of the same replicates, where shares are of no use
  FormFactors bySurface(double measure_area, double count_area, const FormFactors& sampled) const;
  // Whether counts alone are the estimate of a known pair.    In: directions of all replicates; count_area as in
  // ReplicateSums
  bool isCountedAlone(const KnownPair& pair, double directions, double count_area) const;
  // Of faces, with the shares fixed beforehand.
  ControlSums faceControls() const { return by_face_.controls(shares_, known_.lines); }
  FormFactors controlledFormFactors(double measure_area, const FormFactors& sampled) const;

 private:
  void prepare();
  PairCounts withoutDirected(PairCounts counts) const;
  std::vector<FormFactors::Entry> directedEntries() const;
  ShareSums::Found find(double measure_area, double count_area, const ReplicateSums& counted,
                        const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row) const;

  By by_;
  KnownShares known_;
  ShareSums by_face_;
  ControlSums by_surface_, directed_;
  // Made of known_.
  std::vector<PairShare> shares_, surface_shares_;
  std::vector<PairShare> row_shares_;  // of environment and leak
  std::vector<KnownExchange> surface_exchanges_, directed_exchanges_;
};

}  // namespace viewpeel
