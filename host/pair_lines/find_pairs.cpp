#include "pair_lines/find_pairs.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <numeric>
#include <optional>

#include <glm/glm.hpp>

#include "pair_lines/corners.h"
#include "threads.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr size_t kTasks = 256;      // least number of tasks to share out to threads
constexpr size_t kPartsAmong = 16;  // in which threads search among some pairs, whatever the number of threads
constexpr size_t kFewBlockers = 8;  // so few blockers are tested with each pair at once, without clusters
constexpr size_t kRowShaft = 2;     // a row of at least this number of patches gets a shaft of its own,
constexpr size_t kRowCurtain = 3;   // and for a row of at least this number a curtain is looked for

using PlacedPair = std::pair<uint32_t, uint32_t>;  // places of two patches in PairFinder::order_

}  // namespace

// A Task is two clusters, and the blockers that may be between them.
struct PairFinder::Task {
  uint32_t a, b;
  BlockerList between;
};

// A Search divides one task until all its pairs are found, in one thread.
class PairFinder::Search {
 public:
  // Begins a search.    In: least_form_factor: as in find(); pair_count: counts the pairs of all searches
  Search(const PairFinder& finder, double least_form_factor, std::atomic<size_t>& pair_count)
      : finder_(finder),
        least_of_side_(least_form_factor * (finder.two_sided_ ? 2 : 1)),
        pair_count_(pair_count),
        curtain_(finder.blockers_, *finder.mesh_) {}

  // Appends the tasks of a pair of smaller clusters to `next`, or finds the pairs of patches in two leaves.
  void divide(const Task& task, std::vector<Task>& next) {
    if (node(task.a).isLeaf() && node(task.b).isLeaf()) return findLeaf(task.a, task.b, task.between);
    forEachPart(task.a, task.b, [&](uint32_t m, uint32_t n) {
      Task& part = next.emplace_back(Task{m, n, {}});
      if (!keepBetween(task.between, m, n, part.between)) next.pop_back();
    });
  }

  // Finds all pairs of patches in two clusters.    In: depth: of the recursion; each depth has a list of blockers
  void search(uint32_t a, uint32_t b, const BlockerList& between, size_t depth = 0) {
    if (pair_count_ > kMostPatchPairs) return;
    if (node(a).isLeaf() && node(b).isLeaf()) return findLeaf(a, b, between);
    if (lists_.size() <= depth) lists_.emplace_back();
    BlockerList& part = lists_[depth];
    forEachPart(a, b, [&](uint32_t m, uint32_t n) {
      if (keepBetween(between, m, n, part)) search(m, n, part, depth + 1);
    });
  }

  // Searches two clusters as search() does, but for these pairs alone. It changes their order.
  void searchAmong(uint32_t a, uint32_t b, const BlockerList& between, std::span<PlacedPair> pairs, size_t depth = 0) {
    if (node(a).isLeaf() && node(b).isLeaf()) {
      decided += pairs.size();
      for (const auto& [p, q] : pairs) findFacing(finder_.order_[p], finder_.order_[q], between);
      return;
    }
    if (lists_.size() <= depth) lists_.emplace_back();
    BlockerList& part = lists_[depth];
    forEachPart(a, b, [&](uint32_t m, uint32_t n) {
      const auto has = [&](uint32_t k, uint32_t place) { return node(k).first <= place && place < node(k).end; };
      const auto end = std::partition(pairs.begin(), pairs.end(), [&](const PlacedPair& pair) {
        return (has(m, pair.first) && has(n, pair.second)) || (has(m, pair.second) && has(n, pair.first));
      });
      if (end != pairs.begin() && keepBetween(between, m, n, part))
        searchAmong(m, n, part, {pairs.begin(), end}, depth + 1);
    });
  }

  PatchPairs found;
  size_t decided = 0;  // pairs that searchAmong() decides one by one

 private:
  const Node& node(uint32_t k) const { return finder_.nodes_[k]; }
  static double sizeOf(const Box& box) {
    const dvec3 size = box.high - box.low;
    return glm::dot(size, size);
  }

  // Divides the larger of two clusters and calls do_part(m, n) with each part and the other cluster.
  template <class Do>
  void forEachPart(uint32_t of_a, uint32_t of_b, const Do& do_part) const {
    const Node &a = node(of_a), &b = node(of_b);
    const auto doPart = [&](uint32_t m, uint32_t n) {
      if (mayFace(node(m), node(n)) && !areFar(node(m).rows, node(n).rows)) do_part(m, n);
    };
    if (of_a == of_b) {
      doPart(a.left, a.left), doPart(a.left, a.right), doPart(a.right, a.right);
    } else if (b.isLeaf() || (!a.isLeaf() && sizeOf(a.box) >= sizeOf(b.box))) {
      doPart(a.left, of_b), doPart(a.right, of_b);
    } else {
      doPart(of_a, b.left), doPart(of_a, b.right);
    }
  }

  static bool isBehind(const Patch& patch, const Box& box) {
    const dvec3 middle = 0.5 * (box.low + box.high), reach = 0.5 * (box.high - box.low);
    return glm::dot(patch.normal, middle) + glm::dot(glm::abs(patch.normal), reach) < patch.offset - kTouchingShaft;
  }

  // Returns whether a patch of one cluster and one of the other may have their fronts towards each other.
  bool mayFace(const Node& a, const Node& b) const {
    if (!mayExchange(a.roles, b.roles)) return false;
    return !(a.is_flat && isBehind(finder_.patches_[a.patch], b.box)) &&
           !(b.is_flat && isBehind(finder_.patches_[b.patch], a.box));
  }

  const Extent& rowOf(uint32_t p) const { return finder_.rows_[finder_.patches_[p].id]; }

  // Returns whether all rows of two ends exchange less than least_of_side_ of the smaller one's area.
  bool areFar(const Extent& a, const Extent& b) const {
    return least_of_side_ > 0 && finder_.mostBetween(a, b) < least_of_side_;
  }

  // Returns whether the polygons of two patches exchange less than least_of_side_ of the smaller one's area, between
  // all sides of two-sided polygons.    In: exchange: of the two patches
  bool areSmall(const Patch& a, const Patch& b, double exchange) {
    const double least = least_of_side_ * std::min(a.area, b.area);
    if (exchange >= least || a.is_part || b.is_part) return false;
    if (!finder_.two_sided_) return true;
    // A plane that cuts the other polygon has a part of it on either side. All sides add the terms in one order, and
    // so agree on the sum.
    double of_all_sides = 0;
    for (const uint32_t side_a : {a.side & ~1u, a.side | 1u})
      for (const uint32_t side_b : {b.side & ~1u, b.side | 1u})
        of_all_sides += finder_.unoccluded_.findClosely({side_a, side_b}, work_).area;
    return of_all_sides < least;
  }

  // Copies the blockers between two clusters to `to`. Returns false where one of them hides a cluster from the other.
  bool keepBetween(const BlockerList& from, uint32_t m, uint32_t n, BlockerList& to) {
    ++found.work.shafts, found.work.tests += from.size();
    const Box &a = node(m).box, &b = node(n).box;
    Shaft(a, b).keepInside(from, to, vectors_);
    return m == n || Corners(a, b).findHider(finder_.blockers_, to, vectors_) == UINT32_MAX;
  }

  // Finds the pairs of two leaves: for each patch of the larger leaf, its row of patches of the other.
  void findLeaf(uint32_t of_a, uint32_t of_b, const BlockerList& between) {
    const bool is_same = of_a == of_b, is_swapped = sizeOf(node(of_a).box) < sizeOf(node(of_b).box);
    const Node &a = node(is_swapped ? of_b : of_a), &b = node(is_swapped ? of_a : of_b);
    for (uint32_t k = a.first; k < a.end; ++k) {
      const uint32_t p = finder_.order_[k];
      if (areFar(rowOf(p), b.rows) || isBehind(finder_.patches_[p], b.box)) continue;
      const auto row = std::span(finder_.order_).subspan(b.first, b.size()).subspan(is_same ? k + 1 - b.first : 0);
      if (between.size() > kFewBlockers) findRow(p, row, is_same, between);
      else
        for (const uint32_t q : row) findFacing(p, q, between);
    }
  }

  // Finds the pairs of a patch with a row of patches.    In: is_same: whether all of them are of one leaf
  void findRow(uint32_t p, std::span<const uint32_t> row, bool is_same, const BlockerList& between) {
    const Patch& patch = finder_.patches_[p];
    facing_.clear();
    Box box{dvec3(INFINITY), dvec3(-INFINITY)};
    for (const uint32_t q : row) {
      const Patch& other = finder_.patches_[q];
      if (!areFacing(patch, other)) continue;
      facing_.push_back(q);
      box.low = glm::min(box.low, other.low), box.high = glm::max(box.high, other.high);
    }
    const BlockerList* list = &between;
    if (facing_.size() >= kRowShaft) {
      if (!is_same && isHiddenRow(patch, box, between)) return;
      const Shaft shaft(patch, box);
      shaft.keepInside(between, row_, vectors_);
      ++found.work.shafts, found.work.tests += between.size();
      if (!is_same && facing_.size() >= kRowCurtain && curtain_.hides(patch, box, shaft, row_, vectors_)) return;
      list = &row_;
    }
    for (const uint32_t q : facing_) findPair(p, q, *list);
  }

  // Returns whether one blocker hides a patch from a whole box. A blocker that hid the last patch often hides the next.
  bool isHiddenRow(const Patch& patch, const Box& box, const BlockerList& between) {
    const Corners corners(patch, box);
    if (corners.areHidden(finder_.blockers_[last_row_hider_], vectors_)) return true;
    const uint32_t hider = corners.findHider(finder_.blockers_, between, vectors_);
    if (hider == UINT32_MAX) return false;
    last_row_hider_ = hider;
    return true;
  }

  // Returns whether lines may run between the fronts of two patches.
  static bool areFacing(const Patch& a, const Patch& b) {
    if (!mayExchange(a.roles, b.roles)) return false;
    if (a.plane == b.plane) return a.along_plane_normal != b.along_plane_normal && a.height + b.height < 0;
    const auto hasCornerInFront = [](const Patch& of, const Patch& other) {
      for (uint32_t k = 0; k < other.corner_count; ++k)
        if (glm::dot(of.normal, other.corners[k]) > of.offset) return true;
      return false;
    };
    return hasCornerInFront(a, b) && hasCornerInFront(b, a);
  }

  // Finds a pair of patches if they face each other.
  void findFacing(uint32_t p, uint32_t q, const BlockerList& from) {
    if (!areFar(rowOf(p), rowOf(q)) && areFacing(finder_.patches_[p], finder_.patches_[q])) findPair(p, q, from);
  }

  // Finds a pair of patches that face each other.
  void findPair(uint32_t one, uint32_t other, const BlockerList& from) {
    const auto [p, q] = std::minmax(one, other);
    if (areFar(rowOf(p), rowOf(q))) return;
    // Where small pairs are left out, most of the pairs here are small, and few are hidden.
    std::optional<HostUnoccluded::Found> exchange;
    if (least_of_side_ > 0 && isLeftOut(p, q, exchange)) return;
    const size_t before = found.between.size();
    if (isHidden(p, q, from) || (!exchange && isLeftOut(p, q, exchange))) {
      found.between.resize(before);
      return;
    }
    ++pair_count_;
    const auto count = static_cast<uint32_t>(found.between.size() - before);
    found.pairs.push_back({p, q, exchange->area, exchange->error, static_cast<uint32_t>(before), count});
  }

  // Returns whether two patches exchange nothing with nothing in between, or so little that they are left out.
  //   Out: exchange: of the two
  bool isLeftOut(uint32_t p, uint32_t q, std::optional<HostUnoccluded::Found>& exchange) {
    const Patch &a = finder_.patches_[p], &b = finder_.patches_[q];
    exchange = finder_.unoccluded_.findClosely({a.side, b.side}, work_);
    return !(exchange->area > 0) || areSmall(a, b, exchange->area);
  }

  // Returns whether a blocker or a curtain hides two patches from each other. Else it appends the blockers between the
  // two to found.between.    In: p, q: p < q
  bool isHidden(uint32_t p, uint32_t q, const BlockerList& from) {
    const Patch &a = finder_.patches_[p], &b = finder_.patches_[q];
    if (a.plane == b.plane) {
      // Both patches lie in one plane. Of the blockers that cover the first patch, only the ones that lie in front of
      // the second patch, too, are between the two: their level (levelOf) is between the patches' heights.
      for (const uint32_t k : finder_.covers_[p])
        if (stepsInFront(finder_.blockers_[k], b) > 0) found.between.push_back({k, BlockerPlace::over_first});
      return false;
    }
    if (finder_.is_covered_[p] || finder_.is_covered_[q]) return true;
    between_.clear();
    PatchShaft shaft(a, b);
    ++found.work.shafts, found.work.tests += from.size();
    // The blocker that hid the last pair often hides the next one.
    if (from.size() > 0 && shaft.isHiddenBy(finder_.blockers_[last_hider_], vectors_)) return true;
    if (shaft.isHidden(finder_.blockers_, from, between_, vectors_)) {
      last_hider_ = between_.back();
      return true;
    }
    if (curtain_.hides(a, b, shaft, between_, vectors_)) return true;
    for (const uint32_t k : between_) found.between.push_back({k, BlockerPlace::between});
    for (const uint32_t k : finder_.covers_[p]) found.between.push_back({k, BlockerPlace::over_first});
    for (const uint32_t k : finder_.covers_[q]) found.between.push_back({k, BlockerPlace::over_second});
    return false;
  }

  const PairFinder& finder_;
  double least_of_side_;  // least form factor, of a polygon with one side
  std::atomic<size_t>& pair_count_;
  UnoccludedWork work_;
  Curtain curtain_;
  std::vector<uint32_t> between_;
  std::deque<BlockerList> lists_;  // a list of blockers for each depth of the recursion
  BlockerList row_;
  std::vector<uint32_t> facing_;  // patches of a leaf that face the patch whose row it is
  uint32_t last_hider_ = 0, last_row_hider_ = 0;
  Vectors vectors_ = widestVectors();
};

// Returns a bound on what a row of one extent and a row of the other exchange, over the area of the smaller row. Let
// the distance between points of the two extents be at least d, and let the points of one be at most h above the planes
// of the other. Then this share is at most min(1, h_a / d) min(1, h_b / d) A / (pi d^2), where A is the larger area.
// With h on either side of a plane this bounds the sum over all sides of two-sided polygons.
double PairFinder::mostBetween(const Extent& a, const Extent& b) const {
  const dvec3 gap = glm::max(dvec3(0), glm::max(a.box.low - b.box.high, b.box.low - a.box.high));
  const double square = glm::dot(gap, gap);
  if (!(square > 0)) return INFINITY;
  const auto cosineOver = [&](const Extent& end, const Box& box) {
    if (!end.is_flat) return 1.0;
    const Patch& patch = patches_[end.patch];
    const dvec3 middle = 0.5 * (box.low + box.high), reach = 0.5 * (box.high - box.low);
    const double height = glm::dot(patch.normal, middle) - patch.offset,
                 extent = glm::dot(glm::abs(patch.normal), reach),
                 highest = (two_sided_ ? std::abs(height) : height) + extent;
    return std::min(1.0, (std::max(highest, 0.0) + kTouchingShaft) / std::sqrt(square));
  };
  return std::max(a.largest_area, b.largest_area) / (std::numbers::pi * square) * cosineOver(a, b.box) *
         cosineOver(b, a.box);
}

double PairFinder::mostBetweenRows(uint32_t p, uint32_t q) const {
  return mostBetween(rows_[patches_[p].id], rows_[patches_[q].id]) / (two_sided_ ? 2 : 1);
}

// Returns the list of all blockers, the largest first.
BlockerList PairFinder::listAll() const {
  BlockerList all;
  all.clear(blockers_.size());
  for (const uint32_t k : largest_first_) all.add(k, blockers_[k]);
  all.close();
  return all;
}

PairsAmong PairFinder::findAmong(std::span<const std::pair<uint32_t, uint32_t>> pairs, size_t threads) const {
  if (pairs.empty()) return {};
  std::vector<uint32_t> places(patches_.size());
  for (uint32_t k = 0; k < order_.size(); ++k) places[order_[k]] = k;
  std::vector<PlacedPair> placed;
  for (const auto& [p, q] : pairs) placed.emplace_back(std::minmax(places[p], places[q]));
  std::ranges::sort(placed);  // pairs of the same clusters are then in one part
  std::atomic<size_t> found_count = 0;
  const BlockerList all = listAll();
  std::vector<PairsAmong> parts(kPartsAmong);
  shareOut(threads, parts.size(), 1, [&](size_t, size_t k) {
    const auto firstOf = [&](size_t part) { return placed.size() * part / parts.size(); };
    Search search(*this, 0, found_count);
    search.searchAmong(0, 0, all, std::span(placed).subspan(firstOf(k), firstOf(k + 1) - firstOf(k)));
    parts[k] = {std::move(search.found.pairs), search.decided};
  });
  PairsAmong among;
  for (const PairsAmong& part : parts) {
    among.found.insert(among.found.end(), part.found.begin(), part.found.end());
    among.decided += part.decided;
  }
  return among;
}

PatchPairs PairFinder::find(size_t threads, const std::function<void()>& stop, double least_form_factor) const {
  if (nodes_.empty()) return {};
  // One thread divides tasks until there are enough for all threads. Then each thread takes one task after another.
  std::atomic<size_t> found_count = 0;
  Search first(*this, least_form_factor, found_count);
  std::vector<Task> tasks = {{0, 0, listAll()}};
  while (!tasks.empty() && tasks.size() < kTasks) {
    std::vector<Task> next;
    bool is_divided = false;
    for (const Task& task : tasks) {
      is_divided |= !nodes_[task.a].isLeaf() || !nodes_[task.b].isLeaf();
      first.divide(task, next);
    }
    tasks = std::move(next);
    if (!is_divided) break;
  }
  std::vector<PatchPairs> parts(tasks.size() + 1);
  parts.back() = std::move(first.found);
  shareOut(
      threads, tasks.size(), 1,
      [&](size_t, size_t k) {
        Search search(*this, least_form_factor, found_count);
        search.search(tasks[k].a, tasks[k].b, tasks[k].between);
        tasks[k] = {};
        parts[k] = std::move(search.found);
      },
      [&](size_t) {
        if (stop) stop();
      });

  PatchPairs all;
  all.is_complete = found_count <= kMostPatchPairs;
  if (!all.is_complete) return all;
  // Pairs are distributed by a (a counting sort), and then sorted by b.
  std::vector<size_t> ends(patches_.size() + 1, 0);
  size_t between_count = 0;
  for (const PatchPairs& part : parts) {
    for (const PatchPair& pair : part.pairs) ++ends[pair.a + 1];
    between_count += part.between.size();
  }
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  all.pairs.resize(ends.back());
  all.between.reserve(static_cast<size_t>(kRoomForCuts * double(between_count)));
  for (PatchPairs& part : parts) {
    const auto offset = static_cast<uint32_t>(all.between.size());
    for (PatchPair pair : part.pairs) {
      pair.first_blocker += offset;
      all.pairs[ends[pair.a]++] = pair;
    }
    all.between.insert(all.between.end(), part.between.begin(), part.between.end());
    all.work.shafts += part.work.shafts, all.work.tests += part.work.tests;
    part = {};
  }
  shareOut(threads, patches_.size(), 64, [&](size_t, size_t a) {
    std::ranges::sort(all.pairs.begin() + (a ? ends[a - 1] : 0), all.pairs.begin() + ends[a], {}, &PatchPair::b);
  });
  return all;
}

}  // namespace viewpeel
