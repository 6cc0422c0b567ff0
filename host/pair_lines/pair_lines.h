// PairLines draws lines between the two faces of each pair that something may block.
//
// A pair that nothing blocks has its unoccluded form factor; a pair that one blocker hides has 0. Both are exact. Each
// other pair gets as many lines as its error needs. A pair's lines do not depend on other pairs.
#pragma once
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "pair_lines/cut_pairs.h"
#include "pair_lines/device_lines.h"
#include "pair_lines/uniform_lines.h"
#include "ranks/crew.h"
#include "sums/line_sums.h"

namespace viewpeel {

// PairLines::plan finds by these numbers how many lines a pair needs in an estimate.
constexpr uint32_t kLinePilots = 8;  // most pilots of a pair, of 16 lines each
// N times the allowed standard error must be at least this where N lines of a pair agree. If all are blocked, or all
// facing, the other kind has a share of at most ln(1 / p) / N of all lines, but for probability p. At p = 1e-3 this
// share is 7 / N; it may be four standard errors.
constexpr double kAgreeingLines = 1.75;
// The standard error of a visibility by 16 lines is at most this, where their weights are no more uneven than kUneven
// (pair_lines.cpp) allows: docs/method.md, eq. (46) and (47), with b = 1/2 and n = 3.2.
constexpr double kCertainError = 0.272;
constexpr double kLineRate = 0.8;  // 1 / 1.25: the variance falls as N^-1.25 with N lines

// PairLinesFigures say how many pairs and blockers were found.
struct PairLinesFigures {
  uint64_t clear = 0, partial = 0;  // pairs of faces without and with a blocker in between
  uint64_t blockers = 0;            // after neighbouring polygons were joined
};

// PairNumbers hold numbers of pairs of patches, of which at least one emits and the other receives.
struct PairNumbers {
  double facing = 0;   // with an unoccluded form factor above 0
  double decided = 0;  // the part of `facing` that PairLines::find() decides alone or in rows, not by clusters
  double found = 0;    // the part of `facing` that PairLines::find() would find: not proved to be hidden
  double large = 0;    // the part of `found` with an unoccluded form factor that is not small
  double blocked = 0;  // the part of `found` that something may block
  // The rest of `found` that find() keeps, too: of a face of several polygons, whose form factors are sums.
  double small_of_parts = 0;
};

// A PairSample is a random sample of pairs of patches, from which their numbers are estimated.
struct PairSample {
  struct Pair {
    double form_factor;    // unoccluded, from the smaller polygon
    bool is_blocked;       // whether something may block it
    double most_of_parts;  // bound on the form factor of its faces, where one of them has several polygons; else 0
  };
  double each = 0;  // number of pairs that one of the sample stands for
  size_t facing = 0, decided = 0;
  std::vector<Pair> found;  // as PairNumbers::found

  // Returns the numbers of pairs.    In: least_form_factor: of large pairs, unoccluded, from the smaller polygon
  PairNumbers numbersFor(double least_form_factor) const;
  // Returns the sum of the form factors, from the smaller polygon, of all pairs that are not large. Half of what
  // something may block is taken to be visible.
  double sumOfSmall(double least_form_factor) const;
};

// A VisibilityGuess comes from a few scrambled lines of one part of a pair, or from none.
struct VisibilityGuess {
  float visibility = 0.5f;
  float lines = 0;  // effective number: how many lines of equal weights would err as much
};

// A UniformTask asks for independent lines of one part of a pair.
struct UniformTask {
  uint32_t part;           // PairLines::Part::index
  VisibilityGuess guess;   // of open lines; drawUniform() sets it where all lines are open
  uint64_t series;         // lines of different series are independent
  uint64_t lines;          // to be added to `count`
  double most_candidates;  // of one line; where a line takes more, all lines are open
  UniformLineCount count = {};
};

// A StrataTask asks for lines in strata of one part of a pair.
struct StrataTask {
  uint32_t part;          // PairLines::Part::index
  float share;            // s of StrataSums, near the share of lines that nothing blocks
  uint64_t series;        // lines of different series are independent
  uint64_t cells;         // number wanted; 0: nothing is drawn
  StrataSums sums{};      // set by drawStrata(), as the next two are
  double efficiency = 0;  // the mean of x in `sums` has the expectation efficiency (visibility - share)
  double error = 0;       // bound on the rounding of the mean of x
};

class PairLines {
 public:
  // Prepares patches and blockers; find() does the search.
  //   In: scene, face_ids: kept by reference; face_ids: row and roles by face; leaking: whose pairs with backs find()
  //   finds, too; threads: 0: one a core; stop: called between parts of the work, may throw, may be empty; device:
  //   draws lines, with the same bits as threads do; nullptr: threads draw; crew: other ranks, which draw their share
  //   with the same bits; nullptr: there are none; ends_on_blockers: whether find() also finds pairs of a face that
  //   emits and one that only blocks
  PairLines(const Scene& scene, const Ids& face_ids, LeakingFaces leaking, uint64_t seed, size_t threads = 0,
            std::function<void()> stop = {}, const Device* device = nullptr, Crew* crew = nullptr,
            bool ends_on_blockers = false);

  // Finds all pairs with an unoccluded form factor above 0 that no single blocker hides, sorted. It plans no lines yet.
  //   In: least_form_factor: pairs with a smaller unoccluded form factor from the smaller face are left out
  //   Cost: as PairFinder::find.
  std::vector<LinePair> find(double least_form_factor = 0);
  const LeakingFaces& leakingFaces() const { return leaking_; }
  // Draws a sample of 4,096 pairs.
  //   Error: standard errors of PairNumbers are at most 0.8 % of all pairs of patches
  //   Cost: as PairFinder::findAmong.
  PairSample samplePairs() const;
  PairLinesFigures figures() const;
  // Returns what find() has done.
  const FindingWork& findingWork() const { return parts_.work; }
  // Returns whether coincident polygons have no order (PairFinder). Then pair lines cannot be used.
  bool hasUnordered() const { return finder_.hasUnordered(); }
  // Returns whether find() has found more pairs than kMostPatchPairs and kept none.
  bool hasTooMany() const { return !parts_.is_complete; }

  // Gives each pair its number of lines, by pilots of 16 and 128 lines.
  //   In: pairs: as found; allowed(pair): standard error that its exchange area may have, input units squared;
  //   replicates: number of replicates that draw these lines
  //   Error: most pairs keep to the standard error; pilots are rough, so that some exceed it.
  void plan(std::span<LinePair> pairs, const std::function<double(const LinePair&)>& allowed, uint32_t replicates);

  // Cuts pairs that need many lines, and plans the lines of their parts. A pair whose parts need no fewer lines stays
  // whole.
  //   In: pairs: with their plan; allowed, replicates: as for plan()    Out: pairs: as from cut()
  void cutAndPlan(std::span<LinePair> pairs, const std::function<double(const LinePair&)>& allowed,
                  uint32_t replicates);
  // Cuts each pair as often as its LinePair::cuts says, unless it has been cut. A pair that has been cut, and whose
  // `cuts` is 0 now, becomes whole again.
  //   In, out: pairs: all that find() found. A pair that is cut gets `exchange`, `clear`, `error` and `parts` of its
  //   parts that are not hidden    Cost: some 10 us a cut.
  void cut(std::span<LinePair> pairs) { crew_ ? cutOnRanks(pairs) : cutHere(pairs); }

  // Draws the lines of one replicate.
  //   In: pairs: all that find() found, with their plan; times: by pair, how many times it draws its planned lines in
  //   this replicate. Where `times` is empty, a pair draws them once in pair.period replicates
  //   Out: counts, by pair; a function of seed, pair and replicate alone    Cost: some 5 to 50 ns a line.
  LineCounts count(std::span<const LinePair> pairs, uint64_t replicate, std::span<const uint32_t> times = {});
  // Draws the lines of several replicates, each as count() does. Threads prepare a pair only once for all of them.
  //   In: replicate: the first    Out: counts of each replicate
  std::vector<LineCounts> countAhead(std::span<const LinePair> pairs, uint64_t replicate, size_t replicates);

  // A Part is two patches of a pair of faces that something may block.
  struct Part {
    uint32_t index;
    double exchange;    // unoccluded exchange area, input units squared
    uint32_t blockers;  // number between the patches
  };
  // Returns the parts of a pair that something may block.    In: pair: an index into the pairs of find()
  std::vector<Part> blockableParts(size_t pair) const;
  // Draws independent lines of one part.
  //   In: part: Part::index; series: different series are independent; most_candidates: for one line
  //   Out: a function of seed, part and series alone; all lines are open where one would take more candidates
  UniformLineCount drawUniform(uint32_t part, uint64_t series, uint64_t lines, double most_candidates,
                               Vectors vectors) const;
  // Estimates the visibility of one part from 16 scrambled lines.    In, Out: as drawUniform
  VisibilityGuess guessVisibility(uint32_t part, uint64_t series, Vectors vectors) const;
  // Draws the lines of all tasks, and adds them to their counts.
  void drawUniform(std::span<UniformTask> tasks) const;
  // Draws the lines of all tasks, and sets their sums.
  void drawStrata(std::span<StrataTask> tasks) const;
  size_t threads() const { return threads_; }
  void stopIfRequested() const {
    if (stop_) stop_();
  }

 private:
  struct Group {
    uint32_t first = 0, count = 0;  // of parts_; count is 0 where nothing can block the pair
    bool is_cut = false;
    bool has_back = false;  // whether the pair is one of a face and a back
  };
  // A Drawer holds the parts of one pair, ready to draw the lines of any replicate on the processor.
  class Drawer {
   public:
    Drawer(const PairLines& lines, const LinePair& pair, const Group& group);  // all are kept by reference
    LineCount draw(uint64_t replicate, uint32_t blocks, Vectors vectors) const;

   private:
    const PairLines& lines_;
    const LinePair& pair_;
    const Group& group_;
    std::vector<LineDrawer> of_parts_;  // of the parts that something may block
  };
  UniformLines uniformLinesOf(const PatchPair& part) const;
  uint64_t streamOf(const PatchPair& part, uint64_t series) const;
  LineWay wayOf(const LinePair& pair, const PatchPair& part) const;
  std::span<const PlacedBlocker> blockersOf(const PatchPair& part) const;
  LineTask taskOf(const LinePair& pair, uint32_t part, uint64_t replicate, uint32_t blocks) const;
  template <class DrawnOf>
  LineCount combine(const LinePair& pair, const Group& group, uint32_t blocks, const DrawnOf& drawn_of) const;
  void openDevice(std::span<const LinePair> pairs, std::span<const LineCount> counts, uint64_t replicate);
  bool tryDevice(std::span<const LinePair> pairs, LineCounts& counts, uint64_t replicate);
  void drawOnDevice(std::span<const LinePair> pairs, std::span<LineCount> counts, uint64_t replicate);
  std::vector<LineCounts> drawOnThreads(std::span<const LinePair> pairs, const LineCounts& due, uint64_t replicate,
                                        size_t replicates, bool is_further) const;
  bool isPartial(const Group& group) const;
  bool isNear(const Group& group) const;
  double costOf(const Group& group) const;
  double largestShareOf(const Group& group) const;
  std::vector<LinePair> findHere(double least_form_factor);
  void planHere(std::span<LinePair> pairs, size_t first, std::span<const double> goals, uint32_t replicates) const;
  LineCounts countHere(std::span<const LinePair> pairs, std::pair<size_t, size_t> range, uint64_t replicate,
                       std::span<const uint32_t> times);
  void drawUniformHere(std::span<UniformTask> tasks) const;
  void drawStrataHere(std::span<StrataTask> tasks) const;
  // These share the work of find, plan, count and draw with the other ranks (ranked_lines.cpp).
  void cutOnRanks(std::span<LinePair> pairs);
  std::vector<LinePair> findOnRanks(double least_form_factor);
  void planOnRanks(std::span<LinePair> pairs, std::span<const double> goals, uint32_t replicates) const;
  LineCounts countOnRanks(std::span<const LinePair> pairs, uint64_t replicate, std::span<const uint32_t> times);
  void drawUniformOnRanks(std::span<UniformTask> tasks) const;
  void drawStrataOnRanks(std::span<StrataTask> tasks) const;
  uint64_t hashOfParts() const;
  void requireSameParts(const std::vector<std::string>& answers) const;
  friend class LineServer;
  void leaveOut(std::vector<LinePair>& pairs, double least_form_factor);
  void forgetClearParts();
  std::array<uint32_t, 4> scramblesOf(const PatchPair& part, uint64_t replicate) const;
  bool chooseCuts(std::span<LinePair> pairs, uint32_t replicates) const;
  void cutHere(std::span<LinePair> pairs);
  void makeWhole(std::span<LinePair> pairs);
  std::vector<CutPart> blockedPartsOf(const Group& group) const;
  void replaceParts(LinePair& pair, Group& group, std::span<const PatchPair> parts, std::span<const CutPart> blockers);
  static constexpr double kHasPlan = -1;  // in place of a goal, which is above 0: the pair keeps its plan
  void planGoals(std::span<LinePair> pairs, std::span<const double> goals, uint32_t replicates) const;
  double findNeed(LinePair& pair, const Group& group, double goal, Vectors vectors) const;
  void forEach(size_t count, const std::function<void(size_t)>& work) const;

  const Scene& scene_;
  const Ids& ids_;
  LeakingFaces leaking_;
  bool ends_on_blockers_;
  uint64_t seed_;
  size_t threads_;
  std::function<void()> stop_;
  PairFinder finder_;
  PatchPairs parts_;           // of pairs of faces that something may block, grouped by these pairs
  std::vector<Group> groups_;  // the parts of each pair of faces
  struct Whole {
    LinePair pair;
    Group group;
  };
  std::map<uint32_t, Whole> wholes_;  // by index, what pairs that are cut were before
  const Device* device_;
  Crew* crew_;
  uint64_t pairs_sent_ = 0;                  // hash of the plans of pairs that the other ranks have
  std::optional<DeviceLines> device_lines_;  // set once the device has drawn lines with the processor's bits
};

}  // namespace viewpeel
