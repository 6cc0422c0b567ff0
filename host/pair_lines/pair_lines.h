// PairLines draws lines between the two faces of each pair that something may block.
//
// A pair that nothing blocks has its unoccluded form factor; a pair that one blocker hides has 0. Both are exact. Each
// other pair gets as many lines as its error needs. A pair's lines do not depend on other pairs.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pair_lines/device_lines.h"
#include "pair_lines/find_pairs.h"
#include "pair_lines/uniform_lines.h"
#include "sums/line_sums.h"

namespace viewpeel {

// How an estimate finds the lines that a pair needs (PairLines::plan).
constexpr uint32_t kLinePilots = 8;  // of 16 lines each
// N lines that agree leave a share of at most ln(1 / p) / N to lines that do not, but for probability p. At p = 1e-3,
// with errors of four standard errors, N has to be this over the allowed standard error.
constexpr double kAgreeingLines = 1.75;
// 16 lines leave a visibility this standard error at most where their weights are as uneven as kUneven allows: eq. (46)
// and (47) with b = 1/2 and n = 3.2.
constexpr double kCertainError = 0.272;
constexpr double kLineRate = 0.8;  // a variance falls as N^-1.25: N lines for it are its power of -0.8

// PairLinesFigures say how many pairs and blockers were found.
struct PairLinesFigures {
  uint64_t clear = 0, partial = 0;  // pairs of faces
  uint64_t blockers = 0;            // joined from all polygons
};

class PairLines {
 public:
  // Prepares patches and blockers; find() does the search.
  //   In: scene, face_ids: referred to; face_ids: by face, with roles where a question restricts them; with_leak:
  //   whether pairs of faces and backs are looked for, too; threads: 0: one a core; stop: called between parts of the
  //   work, may throw, may be empty; device: draws the lines of replicates, the same bits; nullptr: the threads do
  PairLines(const Scene& scene, const Ids& face_ids, bool with_leak, uint64_t seed, size_t threads = 0,
            std::function<void()> stop = {}, const Device* device = nullptr);

  // Finds all pairs with an unoccluded form factor above 0 that nothing hides, sorted, without lines.
  //   In: least_form_factor: pairs are left out whose unoccluded form factor from the smaller face is below it
  //   Cost: as PairFinder::find.
  std::vector<LinePair> find(double least_form_factor = 0);
  PairLinesFigures figures() const;
  // Returns whether coincident polygons have no order (PairFinder). There are no pair lines then.
  bool hasUnordered() const { return finder_.hasUnordered(); }
  // Returns whether find() has met more pairs than kMostPatchPairs and kept none.
  bool hasTooMany() const { return !parts_.is_complete; }

  // Gives each pair lines, from pilots of 16 and 128 lines.
  //   In: pairs: as found; allowed: standard error that each pair may have, input units squared of exchange area; most
  //   pairs fall below it; replicates: in which the lines are drawn
  void plan(std::span<LinePair> pairs, const std::function<double(const LinePair&)>& allowed, uint32_t replicates);

  // Draws the lines of one replicate.
  //   In: pairs: as planned, all of find()'s; times: how many times its planned lines each pair draws, whatever its
  //   turn; empty: pairs draw once when it is their turn
  //   Out: counts, by pair; a function of seed, pair and replicate alone    Cost: some 5 to 50 ns a line.
  LineCounts count(std::span<const LinePair> pairs, uint64_t replicate, std::span<const uint32_t> times = {});

  // A part of a pair of faces: two of their patches that something may block.
  struct Part {
    uint32_t index;
    double exchange;  // with nothing in between, input units squared
  };
  // Returns the parts of a pair that something may block.    In: pair: an index into find()'s
  std::vector<Part> blockableParts(size_t pair) const;
  // Draws independent lines of one part.
  //   In: part: Part::index; series: different ones are independent; most_candidates: for one line
  //   Out: a function of seed, part and series alone; where a line takes more candidates, all lines are open
  UniformLineCount drawUniform(uint32_t part, uint64_t series, uint64_t lines, double most_candidates,
                               Vectors vectors) const;
  // Returns an estimate of the visibility of one part from 16 scrambled lines.    In, Out: as drawUniform
  double guessVisibility(uint32_t part, uint64_t series, Vectors vectors) const;
  size_t threads() const { return threads_; }
  void stopIfRequested() const {
    if (stop_) stop_();
  }

 private:
  struct Group {
    uint32_t first, count;  // of parts_
  };
  LineCount draw(const LinePair& pair, const Group& group, uint64_t replicate, uint32_t blocks, Vectors vectors) const;
  LineTask taskOf(const LinePair& pair, uint32_t part, uint64_t replicate, uint32_t blocks) const;
  template <class DrawnOf>
  LineCount combine(const LinePair& pair, const Group& group, uint32_t blocks, const DrawnOf& drawn_of) const;
  void openDevice(std::span<const LinePair> pairs, std::span<const LineCount> counts, uint64_t replicate);
  bool tryDevice(std::span<const LinePair> pairs, LineCounts& counts, uint64_t replicate);
  void drawOnDevice(std::span<const LinePair> pairs, std::span<LineCount> counts, uint64_t replicate);
  bool isPartial(const Group& group) const;
  void leaveOut(std::vector<LinePair>& pairs, double least_form_factor);
  std::array<uint32_t, 4> scramblesOf(const PatchPair& part, uint64_t replicate) const;
  double findNeed(LinePair& pair, const Group& group, double goal, Vectors vectors) const;
  void forEach(size_t count, const std::function<void(size_t)>& work) const;

  const Scene& scene_;
  const Ids& ids_;
  uint64_t seed_;
  size_t threads_;
  std::function<void()> stop_;
  PairFinder finder_;
  PatchPairs parts_;           // pairs of patches, by pairs of faces
  std::vector<Group> groups_;  // of each pair of faces
  const Device* device_;
  std::optional<DeviceLines> device_lines_;  // once lines were drawn on it, and were those of the processor
};

}  // namespace viewpeel
