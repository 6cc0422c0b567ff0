#include "sums/pair_count.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "threads.h"

namespace viewpeel {
namespace {

constexpr size_t kRows = 64;  // that a thread sorts at a time

}  // namespace

// Counts are first distributed by i (a counting sort), in any order within one i. Then the few counts of each i are
// sorted by j.
PairCounts sortAndJoin(const std::vector<PairCounts>& lists, uint32_t id_count) {
  size_t all = 0;
  for (const PairCounts& list : lists) all += list.size();
  const size_t threads = threadsFor(all);
  std::vector<size_t> ends(id_count + 1, 0);
  shareOut(threads, lists.size(), 1, [&](size_t, size_t list) {
    for (const PairCount& count : lists[list])
      std::atomic_ref(ends[count.i + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  PairCounts sorted(all);
  shareOut(threads, lists.size(), 1, [&](size_t, size_t list) {
    for (const PairCount& count : lists[list])
      sorted[std::atomic_ref(ends[count.i]).fetch_add(1, std::memory_order_relaxed)] = count;
  });
  // The counts of row i are now between ends[i - 1] and ends[i].
  shareOut(threads, id_count, kRows, [&](size_t, size_t i) {
    std::sort(sorted.begin() + (i ? ends[i - 1] : 0), sorted.begin() + ends[i], isBefore);
  });
  const auto isSame = [](const PairCount& a, const PairCount& b) { return !isBefore(a, b); };
  auto last = std::adjacent_find(sorted.begin(), sorted.end(), isSame);
  if (last == sorted.end()) return sorted;
  for (auto count = last + 1; count != sorted.end(); ++count) {
    if (isSame(*last, *count)) last->add(*count);
    else *++last = *count;
  }
  sorted.erase(last + 1, sorted.end());
  return sorted;
}

PairCounts addCounts(const PairCounts& a, const PairCounts& b) {
  PairCounts sum;
  sum.reserve(a.size() + b.size());
  size_t at = 0;
  for (const PairCount& count : b) {
    while (at < a.size() && isBefore(a[at], count)) sum.push_back(a[at++]);
    sum.push_back(count);
    if (at < a.size() && !isBefore(count, a[at])) sum.back().add(a[at++]);
  }
  sum.insert(sum.end(), a.begin() + at, a.end());
  return sum;
}

}  // namespace viewpeel
