// Lists of counts are sorted and added up, whatever their order and the number of threads.
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "sums/pair_count.h"
#include "threads.h"

namespace viewpeel {
namespace {

using Counts = std::map<std::pair<uint32_t, uint32_t>, std::pair<uint64_t, uint64_t>>;

Counts asMap(const PairCounts& counts) {
  Counts found;
  for (const PairCount& count : counts) {
    auto& [facing, blocked] = found[{count.i, count.j}];
    facing += count.count, blocked += count.blocked;
  }
  return found;
}

// Returns counts in no order. Pairs occur several times where there are more counts than pairs of ids.
PairCounts randomCounts(size_t size, uint32_t ids, uint64_t seed) {
  std::mt19937_64 random(seed);
  PairCounts counts;
  for (size_t k = 0; k < size; ++k) {
    const auto i = static_cast<uint32_t>(random() % ids);
    const uint32_t j = random() % 8 ? i + static_cast<uint32_t>(random() % (ids - i)) : kEnvironment;
    counts.push_back({i, j, 1 + random() % 100, random() % 100});
  }
  return counts;
}

TEST(PairCount, ListsInAnyOrderAreSortedAndJoined) {
  for (const auto& [size, ids] : {std::pair<size_t, uint32_t>{0, 5}, {1, 1}, {3000, 7}, {60'000, 500}})
    for (const size_t threads : {1, 4}) {
      limitThreads(threads);
      const std::vector<PairCounts> lists = {randomCounts(size, ids, 1), {}, randomCounts(size / 3, ids, 2)};
      PairCounts all = lists[0];
      all.insert(all.end(), lists[2].begin(), lists[2].end());
      const PairCounts joined = sortAndJoin(lists, ids);
      EXPECT_EQ(asMap(joined), asMap(all));
      EXPECT_EQ(joined.size(), asMap(all).size());  // each pair once
      EXPECT_TRUE(std::is_sorted(joined.begin(), joined.end(), isBefore));
    }
  limitThreads(0);
}

TEST(PairCount, SortedListsAreAddedUp) {
  const PairCounts a = sortAndJoin({randomCounts(900, 40, 3)}, 40), b = sortAndJoin({randomCounts(50, 40, 4)}, 40);
  PairCounts all = a;
  all.insert(all.end(), b.begin(), b.end());
  const PairCounts sum = addCounts(a, b);
  EXPECT_EQ(asMap(sum), asMap(all));
  EXPECT_EQ(sum.size(), asMap(all).size());
  EXPECT_TRUE(std::is_sorted(sum.begin(), sum.end(), isBefore));
}

}  // namespace
}  // namespace viewpeel
