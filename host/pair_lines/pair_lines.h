// Lines of their own for all pairs of faces that something may block.
//
// A pair that nothing blocks has its unoccluded form factor, a pair that one blocker hides has none, both exactly. All
// others get lines, each as many as its own error asks for. A pair's lines do not depend on other pairs.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "pair_lines/find_pairs.h"
#include "pair_lines/uniform_lines.h"
#include "sums/line_sums.h"

namespace viewpeel {

// What finding pairs came to.
struct PairLinesFigures {
  uint64_t clear = 0, partial = 0;  // pairs of faces
  uint64_t blockers = 0;            // that polygons were joined to
};

class PairLines {
 public:
  //   In: scene, face_ids: referred to; face_ids: by face, with roles where a question restricts them; with_leak:
  //   whether pairs of faces and backs are looked for, too; threads: 0: one a core; stop: called between parts of the
  //   work, may throw, may be empty
  PairLines(const Scene& scene, const Ids& face_ids, bool with_leak, uint64_t seed, size_t threads = 0,
            std::function<void()> stop = {});

  // All pairs with an unoccluded form factor above 0 that nothing hides, sorted, without lines.
  //   Cost: as PairFinder::find.
  std::vector<LinePair> find();
  PairLinesFigures figures() const;
  // As PairFinder has it: then there are no pair lines.
  bool hasUnordered() const { return finder_.hasUnordered(); }
  // After find(): whether there are more pairs than kMostPatchPairs. Then it has found none.
  bool hasTooMany() const { return !parts_.is_complete; }

  // Gives each pair lines, from pilots of 16 and 128 lines.
  //   In: pairs: as found; allowed: standard error that each pair may have, input units squared of exchange area; most
  //   pairs fall below it; replicates: in which the lines are drawn
  void plan(std::span<LinePair> pairs, const std::function<double(const LinePair&)>& allowed, uint32_t replicates);

  // Draws the lines of one replicate.
  //   In: pairs: as planned, all of find()'s; wanted: those that draw in this replicate, whatever their turn, and
  //   `times` as many lines as planned; empty: those whose turn it is
  //   Out: counts, by pair; a function of seed, pair and replicate alone    Cost: some 5 to 50 ns a line.
  LineCounts count(std::span<const LinePair> pairs, uint64_t replicate, const std::vector<bool>& wanted = {},
                   uint32_t times = 1);

  // A part of a pair of faces: two of their patches that something may block.
  struct Part {
    uint32_t index;
    double exchange;  // with nothing in between, input units squared
  };
  // Returns the parts of a pair that something may block.    In: pair: an index into find()'s
  std::vector<Part> blockableParts(size_t pair) const;
  // Draws independent lines of one part.
  //   In: part: Part::index; series: different ones are independent    Out: a function of seed, part and series alone
  UniformLineCount drawUniform(uint32_t part, uint64_t series, uint64_t lines, Vectors vectors) const;
  size_t threads() const { return threads_; }
  void stopIfRequested() const {
    if (stop_) stop_();
  }

 private:
  struct Group {
    uint32_t first, count;  // of parts_
  };
  LineCount draw(const LinePair& pair, const Group& group, uint64_t replicate, uint32_t times, Vectors vectors) const;
  bool isPartial(const Group& group) const;
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
};

}  // namespace viewpeel
