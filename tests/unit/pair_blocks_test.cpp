// A list in blocks holds the same pairs as one sorted list, whatever is added and on however many threads.
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "sums/pair_blocks.h"
#include "threads.h"

namespace viewpeel {
namespace {

struct Pair {
  uint32_t i, j;
  int sum = 0;
};
using Sums = std::map<std::pair<uint32_t, uint32_t>, int>;

std::vector<Pair> listOf(const Sums& sums) {
  std::vector<Pair> list;
  for (const auto& [key, sum] : sums) list.push_back({key.first, key.second, sum});
  return list;
}

void expectSame(const PairBlocks<Pair>& blocks, const Sums& sums) {
  EXPECT_EQ(blocks.size(), sums.size());
  auto expected = sums.begin();
  for (const Pair& pair : blocks) {
    ASSERT_NE(expected, sums.end());
    EXPECT_EQ(keyOf(pair), expected->first);
    EXPECT_EQ(pair.sum, expected->second);
    ++expected;
  }
  EXPECT_EQ(expected, sums.end());
}

TEST(PairBlocks, AddsUpAsOneSortedListDoes) {
  const auto add = [](Pair& sum, const Pair& pair) { sum.sum += pair.sum; };
  std::mt19937 random(2);
  for (const uint32_t rows : {1u, 3u, 256u, 1000u})
    for (const size_t threads : {1, 4}) {
      limitThreads(threads);
      PairBlocks<Pair> blocks(rows), twice(rows);
      EXPECT_TRUE(blocks.empty());
      EXPECT_EQ(blocks.begin(), blocks.end());
      Sums sums, doubled;
      for (const size_t size : {0, 1, 30'000, 40'000}) {
        Sums more;
        for (size_t k = 0; k < size; ++k) more[{random() % rows, random() % 500}] += static_cast<int>(random() % 9);
        for (const auto& [key, sum] : more) sums[key] += sum;
        blocks.add(listOf(more), add);
        expectSame(blocks, sums);
      }
      for (const auto& [key, sum] : sums) doubled[key] = 2 * sum;
      for (int k = 0; k < 2; ++k) twice.add(blocks, add);
      expectSame(twice, doubled);
      expectSame(PairBlocks<Pair>(rows, listOf(sums)), sums);
      EXPECT_EQ(blocks.firsts().back(), sums.size());
      std::vector<int> found(blocks.size());
      blocks.forEachBlock([&](size_t k, size_t first) {
        for (const Pair& pair : blocks.block(k)) found[first++] = pair.sum;
      });
      EXPECT_TRUE(std::ranges::equal(found, sums, {}, {}, &Sums::value_type::second));
    }
  limitThreads(0);
}

}  // namespace
}  // namespace viewpeel
