// While a caller goes through one sorted list of pairs, a PairWalk finds the pairs with the same keys in another.
#pragma once
#include <algorithm>
#include <utility>

#include "sums/add_pairs.h"

namespace viewpeel {

template <class Iterator>
class PairWalk {
 public:
  //   In: pairs: sorted by (i, j), every pair at most once; they must live as long as the walk
  template <class Pairs>
  explicit PairWalk(const Pairs& pairs) : at_(pairs.begin()), end_(pairs.end()) {}

  // Returns the pair with the key of this one, or nullptr.    In: pair: keys must not fall from one call to the next
  template <class Pair>
  auto find(const Pair& pair) -> decltype(&*std::declval<Iterator>()) {
    while (at_ != end_ && keyOf(*at_) < keyOf(pair)) ++at_;
    return at_ != end_ && keyOf(*at_) == keyOf(pair) ? &*at_ : nullptr;
  }

 private:
  Iterator at_, end_;
};

template <class Pairs>
PairWalk(const Pairs& pairs) -> PairWalk<decltype(pairs.begin())>;

// Returns whether two lists have a pair of the same key.    In: a, b: sorted by (i, j)
template <class PairsA, class PairsB>
bool haveSharedKey(const PairsA& a, const PairsB& b) {
  PairWalk walk(a);
  return std::any_of(b.begin(), b.end(), [&](const auto& pair) { return walk.find(pair) != nullptr; });
}

}  // namespace viewpeel
