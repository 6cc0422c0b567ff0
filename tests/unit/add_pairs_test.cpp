#include "sums/add_pairs.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace viewpeel {
namespace {

struct Total {
  uint32_t i, j;
  uint64_t sum = 0;
};

using Pairs = std::vector<std::pair<std::pair<uint32_t, uint32_t>, uint64_t>>;

// addPairs() is compared with a std::map, on lists that share few pairs, many, all or none, and on empty lists.
TEST(AddPairs, SumsEqualAMap) {
  std::mt19937_64 random(5);
  for (int run = 0; run < 200; ++run) {
    const uint32_t ids = 1 + static_cast<uint32_t>(random() % 12);
    std::vector<Total> sums;
    std::map<std::pair<uint32_t, uint32_t>, uint64_t> expected;
    for (int list = 0; list < 6; ++list) {
      const uint64_t one_in = 1 + random() % 8;
      std::vector<Total> added;
      for (uint32_t i = 0; i < ids; ++i)
        for (uint32_t j = i; j < ids; ++j)
          if (random() % one_in == 0) added.push_back({i, j, 1 + random() % 100});
      for (const Total& pair : added) expected[{pair.i, pair.j}] += pair.sum;
      addPairs(sums, added, [](Total& sum, const Total& pair) { sum.sum += pair.sum; });
      Pairs found;
      for (const Total& sum : sums) found.push_back({{sum.i, sum.j}, sum.sum});
      EXPECT_EQ(found, Pairs(expected.begin(), expected.end()));
    }
  }
}

}  // namespace
}  // namespace viewpeel
