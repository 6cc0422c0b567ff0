// Sums of pairs: sorted lists to which others, sorted alike, are added in place.
#pragma once
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace viewpeel {

// add_to(sum, pair) for each of `pairs`, whose sum is Sum{i, j} where there was none.
//   In: sums and pairs sorted by (i, j), every pair at most once    Cost: O(sums + pairs); memory for the sums that are new.
template <class Sum, class Pairs, class AddTo>
void addPairs(std::vector<Sum>& sums, const Pairs& pairs, AddTo add_to) {
  const auto keyOf = [](const auto& pair) { return std::pair(pair.i, pair.j); };
  std::vector<Sum> fresh;
  auto at = sums.begin();
  for (const auto& pair : pairs) {
    while (at != sums.end() && keyOf(*at) < keyOf(pair)) ++at;
    const bool is_there = at != sums.end() && keyOf(*at) == keyOf(pair);
    if (!is_there) fresh.push_back(Sum{pair.i, pair.j});
    add_to(is_there ? *at : fresh.back(), pair);
  }
  if (fresh.empty()) return;
  const auto old_count = static_cast<std::ptrdiff_t>(sums.size());
  sums.insert(sums.end(), fresh.begin(), fresh.end());
  std::inplace_merge(sums.begin(), sums.begin() + old_count, sums.end(), [&](const Sum& a, const Sum& b) { return keyOf(a) < keyOf(b); });
}

}  // namespace viewpeel
