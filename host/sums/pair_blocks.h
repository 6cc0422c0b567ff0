// PairBlocks is a long list of pairs of ids, to which threads can add at the same time.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "sums/add_pairs.h"
#include "threads.h"

namespace viewpeel {

// The rows of a result are divided into ranges, and the pairs (i, j) with i in one range are a block. The number of
// blocks does not depend on the number of threads.
class RowRanges {
 public:
  explicit RowRanges(size_t rows) : rows_(rows) {}
  size_t count() const { return std::min<size_t>(rows_, kMost); }
  // Returns the pairs of a block.    In: pairs: sorted by (i, j)
  template <class Pair>
  std::span<const Pair> of(const std::vector<Pair>& pairs, size_t block) const {
    const auto firstOf = [&](size_t range) {
      return std::ranges::lower_bound(pairs, rows_ * range / count(), {}, &Pair::i);
    };
    return {firstOf(block), firstOf(block + 1)};
  }

 private:
  static constexpr size_t kMost = 256;

  size_t rows_;
};

template <class Pair>
class PairBlocks {
 public:
  explicit PairBlocks(size_t rows) : ranges_(rows), blocks_(ranges_.count()) {}
  //   In: pairs: sorted by (i, j), with i < rows, every pair at most once
  PairBlocks(size_t rows, const std::vector<Pair>& pairs) : PairBlocks(rows) {
    for (size_t k = 0; k < blocks_.size(); ++k) {
      const std::span<const Pair> of_block = ranges_.of(pairs, k);
      blocks_[k].assign(of_block.begin(), of_block.end());
    }
  }

  const RowRanges& ranges() const { return ranges_; }
  const std::vector<Pair>& block(size_t k) const { return blocks_[k]; }
  size_t size() const {
    size_t size = 0;
    for (const std::vector<Pair>& block : blocks_) size += block.size();
    return size;
  }
  bool empty() const { return size() == 0; }
  // Returns the index in the list of each block's first pair, and then the size of the list.
  std::vector<size_t> firsts() const {
    std::vector<size_t> firsts(1, 0);
    for (const std::vector<Pair>& block : blocks_) firsts.push_back(firsts.back() + block.size());
    return firsts;
  }
  // Calls work(k, index of the first pair) for each block k, on all threads.
  template <class Work>
  void forEachBlock(const Work& work) const {
    const std::vector<size_t> first_of = firsts();
    shareOut(threadsFor(first_of.back()), blocks_.size(), 1, [&](size_t, size_t k) { work(k, first_of[k]); });
  }

  // Adds pairs to the list, block by block on all threads, as addPairs does.
  //   In: pairs: sorted by (i, j), with i < rows, every pair at most once; add_to: threads call it at the same time
  template <class Other, class AddTo>
  void add(const std::vector<Other>& pairs, const AddTo& add_to) {
    shareOut(threadsFor(pairs.size()), blocks_.size(), 1,
             [&](size_t, size_t k) { addPairs(blocks_[k], ranges_.of(pairs, k), add_to); });
  }
  template <class AddTo>
  void add(const PairBlocks& others, const AddTo& add_to) {
    others.forEachBlock([&](size_t k, size_t) { addPairs(blocks_[k], others.blocks_[k], add_to); });
  }

  // An Iterator goes through the pairs of all blocks in order.
  class Iterator {
   public:
    using value_type = Pair;
    using difference_type = std::ptrdiff_t;
    using iterator_category = std::forward_iterator_tag;
    using reference = const Pair&;
    using pointer = const Pair*;

    Iterator() = default;
    Iterator(const std::vector<std::vector<Pair>>& blocks, size_t block) : blocks_(&blocks), block_(block) { skip(); }
    reference operator*() const { return (*blocks_)[block_][at_]; }
    pointer operator->() const { return &**this; }
    Iterator& operator++() {
      ++at_;
      skip();
      return *this;
    }
    Iterator operator++(int) {
      const Iterator before = *this;
      ++*this;
      return before;
    }
    bool operator==(const Iterator&) const = default;

   private:
    void skip() {
      while (block_ < blocks_->size() && at_ == (*blocks_)[block_].size()) ++block_, at_ = 0;
    }
    const std::vector<std::vector<Pair>>* blocks_ = nullptr;
    size_t block_ = 0, at_ = 0;
  };
  Iterator begin() const { return {blocks_, 0}; }
  Iterator end() const { return {blocks_, blocks_.size()}; }

 private:
  RowRanges ranges_;
  std::vector<std::vector<Pair>> blocks_;
};

}  // namespace viewpeel
