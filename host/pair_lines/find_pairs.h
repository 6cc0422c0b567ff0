// A PairFinder finds which pairs of polygons may see each other, and which blockers are between the two.
//
// Patches are gathered in clusters first. A blocker outside the shaft of two clusters is in no line's way. A blocker
// that hides two clusters from each other hides all their pairs. Other clusters are divided into smaller ones (S.
// Teller, P. Hanrahan, Global visibility algorithms for illumination computations, 1993).
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "pair_lines/blocker_mesh.h"
#include "pair_lines/curtain.h"
#include "pair_lines/draw_lines.h"
#include "pair_lines/shafts.h"
#include "unoccluded/host_unoccluded.h"

namespace viewpeel {

// A PatchPair is a pair of patches whose unoccluded form factor is above 0, and which no single blocker hides.
struct PatchPair {
  uint32_t a, b;        // patches, a < b
  double exchange = 0;  // exchange area with nothing in between, unit-ball units squared
  // The pair's blockers are this range of PatchPairs::between; it is empty where nothing is in the way.
  double error = 0;  // bound on the error of `exchange`
  uint32_t first_blocker = 0, blocker_count = 0;
};

// At most this number of pairs is found. A pair takes some 250 bytes, with its plan and its counts.
constexpr size_t kMostPatchPairs = 20'000'000;
// Lists of patch pairs and blockers have room for this multiple: parts of pairs that are cut later then move no others.
constexpr double kRoomForCuts = 1.1;

// A FindingWork counts what a search has done. It is the same on all machines and for any number of threads.
struct FindingWork {
  uint64_t shafts = 0;  // made for two clusters, a patch and a cluster, or two patches
  uint64_t tests = 0;   // of one blocker with one of these shafts
};

struct PatchPairs {
  bool is_complete = true;             // false: there are more than kMostPatchPairs, and the lists are not to be used
  std::vector<PatchPair> pairs;        // sorted by (a, b), without hidden pairs
  std::vector<PlacedBlocker> between;  // blockers of all pairs
  FindingWork work;
};

// PairsAmong are found among some pairs of patches.
struct PairsAmong {
  std::vector<PatchPair> found;  // in any order, the same for any number of threads
  size_t decided = 0;            // how many are decided one by one, and not with all pairs of two clusters
};

// Returns a number above 0 where a blocker of the patch's plane lies in front of the patch.
inline int stepsInFront(const Blocker& blocker, const Patch& patch) {
  return (patch.along_plane_normal ? blocker.level : -blocker.level) - patch.height;
}

// Return whether a blocker of a patch's plane has more than an edge in common with the patch, and whether it covers it.
bool overlaps(const Blocker& blocker, const Patch& patch);
bool covers(const Blocker& blocker, const Patch& patch);

class PairFinder {
 public:
  //   In: scene: kept by reference; leaking, ends_on_blockers: as for makePatches()
  //   Cost: O(n log n) for most scenes.
  PairFinder(const Scene& scene, const Ids& ids, const LeakingFaces& leaking = {}, bool ends_on_blockers = false);

  const std::vector<Patch>& patches() const { return patches_; }
  const std::vector<Blocker>& blockers() const { return blockers_; }
  const BlockerMesh& mesh() const { return *mesh_; }
  // Adds a part of a patch to patches() and returns its index. Later searches pass over it.
  uint32_t add(const Patch& part) {
    patches_.push_back(part);
    return static_cast<uint32_t>(patches_.size() - 1);
  }
  // Returns whether coincident polygons are without an order, so that the one in front depends on a line's direction
  // (Coincidences). Then it is not defined which blockers are between two polygons.
  bool hasUnordered() const { return has_unordered_; }

  // Finds all pairs of patches of different faces where one emits and the other receives.
  //   In: stop: called now and then by one thread, may throw, may be empty; least_form_factor: pairs of polygons with a
  //   smaller unoccluded form factor from the smaller polygon are left out, with all their sides. Parts of two rows are
  //   kept, or all left out where the rows are so far from each other that the sum of all parts is below it, too
  //   Error: blockers that reach less deep than kTouchingShaft into a shaft count as outside it.
  //   Cost: a fraction of a microsecond a pair, and its unoccluded form factor; next to nothing for distant clusters
  //   below the least form factor. Tests: tests/unit/pair_lines_test.cpp.
  PatchPairs find(size_t threads, const std::function<void()>& stop = {}, double least_form_factor = 0) const;
  // Finds each of the given pairs that find() would also find.
  //   In: pairs: of indices of patches
  //   Error: find() may hide a row of patches behind a curtain that is not found for each of its pairs.
  //   Cost: on one thread 6 microseconds for each of 2,500 pairs against 190 blockers, 40 for each of 1,000 against
  //   2,700.
  PairsAmong findAmong(std::span<const std::pair<uint32_t, uint32_t>> pairs, size_t threads) const;

  // Returns a bound on what the rows of two patches exchange, over the area of the smaller row's sides.
  double mostBetweenRows(uint32_t p, uint32_t q) const;

 private:
  // An Extent is what bounds form factors of one row or several. Areas are of one side.
  struct Extent {
    Box box{glm::dvec3(INFINITY), glm::dvec3(-INFINITY)};
    double largest_area = 0;      // of a row
    bool is_flat = true;          // all patches lie in one plane, and look one way unless they are two-sided
    uint32_t patch = UINT32_MAX;  // one of the patches; UINT32_MAX: there are none yet
  };
  // A Node is a cluster of patches.
  struct Node {
    Box box;
    uint32_t first, end;  // of order_
    uint32_t left = 0, right = 0;
    uint32_t roles = 0;    // of all patches
    bool is_flat = false;  // all patches lie in one plane and look one way
    uint32_t patch = 0;    // one of its patches
    Extent rows;           // of the rows of its patches, each with all of its polygons

    bool isLeaf() const { return left == 0; }
    uint32_t size() const { return end - first; }
  };
  struct Task;
  class Search;
  BlockerList listAll() const;
  double mostBetween(const Extent& a, const Extent& b) const;
  void widen(Extent& extent, const Extent& by) const;
  void measureRows(const Ids& ids);
  uint32_t build(std::vector<uint32_t>& order, uint32_t first, uint32_t end);
  void findCovers();

  bool two_sided_;
  std::vector<Patch> patches_;
  std::vector<Extent> rows_;  // by Patch::id
  std::vector<Blocker> blockers_;
  std::unique_ptr<BlockerMesh> mesh_;
  std::vector<std::vector<uint32_t>> covers_;  // by patch: the blockers of its plane in front of it
  std::vector<bool> is_covered_;               // by patch: whether one blocker of covers_ covers all of it
  bool has_unordered_ = false;
  std::vector<uint32_t> largest_first_;  // indices of blockers
  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;  // indices of patches; each node has a range
  double normal_weight_ = 0;     // the distance that a difference of normals counts as
  HostUnoccluded unoccluded_;
};

}  // namespace viewpeel
