#include "sums/pair_count.h"

#include <algorithm>
#include <numeric>

namespace viewpeel {

// Counts are first distributed by i (a counting sort). Then the few counts of each i are sorted by j.
PairCounts sortAndJoin(const PairCounts& counts, uint32_t id_count) {
  std::vector<size_t> ends(id_count + 1, 0);
  for (const PairCount& count : counts) ++ends[count.i + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  PairCounts sorted(counts.size());
  for (const PairCount& count : counts) sorted[ends[count.i]++] = count;
  size_t joined = 0;
  for (size_t first = 0; first < sorted.size();) {
    const size_t end = ends[sorted[first].i];
    std::sort(sorted.begin() + first, sorted.begin() + end, isBefore);
    for (size_t k = first; k < end; ++k) {
      if (joined && !isBefore(sorted[joined - 1], sorted[k])) sorted[joined - 1].add(sorted[k]);
      else sorted[joined++] = sorted[k];
    }
    first = end;
  }
  sorted.resize(joined);
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
