// These functions add sorted lists of pairs of ids to others in place, or map the ids to coarser ones (faces to
// surfaces).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/ids.h>

namespace viewpeel {

// Returns the key by which all lists of pairs are sorted.
template <class Pair>
std::pair<uint32_t, uint32_t> keyOf(const Pair& pair) {
  return {pair.i, pair.j};
}

// Calls add_to(sum, pair) for each of `pairs`, in any order, with the sum that has the pair's key. A pair without a sum
// gets a new one, Sum{i, j}, first.
//   In: sums, pairs: sorted by (i, j), every pair at most once
//   Cost: O(sums + pairs) work; memory for the new sums, and an eighth to spare.
template <class Sum, class Pairs, class AddTo>
void addPairs(std::vector<Sum>& sums, const Pairs& pairs, AddTo add_to) {
  size_t fresh = 0, from = 0;
  for (const auto& pair : pairs) {
    while (from < sums.size() && keyOf(sums[from]) < keyOf(pair)) ++from;
    if (from < sums.size() && keyOf(sums[from]) == keyOf(pair)) add_to(sums[from], pair);
    else ++fresh;
  }
  // Old sums move to their new places from the last one on, and new sums are put between them.
  from = sums.size();
  size_t to = from + fresh;
  if (to > sums.capacity()) sums.reserve(to + to / 8);  // by itself a vector would double, and many have GB
  sums.resize(to);
  for (auto pair = pairs.rbegin(); to > from; ++pair) {
    while (from > 0 && keyOf(*pair) < keyOf(sums[from - 1])) sums[--to] = std::move(sums[--from]);
    if (from > 0 && keyOf(*pair) == keyOf(sums[from - 1])) continue;
    sums[--to] = Sum{pair->i, pair->j};
    add_to(sums[to], *pair);
  }
}

// Returns the pairs with their ids mapped to coarser ones, sorted: id k becomes id_map[k]. Where several pairs get the
// same key, the first is kept and add_to(first, pair) adds each further one to it.
//   Cost: O(pairs) where there are few coarse ids, else O(pairs log pairs).
template <class Pair, class AddTo>
std::vector<Pair> mergePairs(const std::vector<Pair>& pairs, const std::vector<uint32_t>& id_map, AddTo add_to) {
  const auto precedes = [](const Pair& a, const Pair& b) { return keyOf(a) < keyOf(b); };
  const auto mapped = [&](Pair pair) {
    const uint32_t i = id_map[pair.i], j = pair.j < kEnvironment ? id_map[pair.j] : pair.j;
    pair.i = std::min(i, j), pair.j = std::max(i, j);
    return pair;
  };
  std::vector<Pair> merged;
  const size_t count = id_map.empty() ? 0 : size_t(*std::max_element(id_map.begin(), id_map.end())) + 1;
  if (count * (count + 2) <= 4 * pairs.size()) {
    std::vector<uint32_t> places(count * (count + 2), 0);  // 1 + index in `merged` of each coarse pair, or 0
    for (const Pair& fine : pairs) {
      const Pair pair = mapped(fine);
      uint32_t& place =
          places[pair.i * (count + 2) + (pair.j < kEnvironment ? pair.j : count + (pair.j - kEnvironment))];
      if (place) {
        add_to(merged[place - 1], pair);
      } else {
        merged.push_back(pair);
        place = static_cast<uint32_t>(merged.size());
      }
    }
    std::sort(merged.begin(), merged.end(), precedes);
    return merged;
  }
  std::vector<Pair> sorted;
  sorted.reserve(pairs.size());
  for (const Pair& fine : pairs) sorted.push_back(mapped(fine));
  if (!std::is_sorted(sorted.begin(), sorted.end(), precedes)) std::sort(sorted.begin(), sorted.end(), precedes);
  for (const Pair& pair : sorted) {
    if (!merged.empty() && !precedes(merged.back(), pair)) add_to(merged.back(), pair);
    else merged.push_back(pair);
  }
  return merged;
}

}  // namespace viewpeel
