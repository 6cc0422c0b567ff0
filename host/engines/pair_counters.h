// PairCounters holds the counters of pairs on a device, for engines `compute` and `graphics`.
#pragma once
#include <vector>

#include "sums/pair_count.h"
#include "vulkan/commands.h"

namespace viewpeel {

// PairCounters are counters of pairs of ids on a device, 64 bits each. They are dense, for all pairs, or a hash table
// of the pairs with counts. A pair has one counter, of facing lines. Where blocked pairs are counted it has a second
// one, of all lines on which the two fronts look at each other, blocked or not. Blocks of directions may have dense
// counters of their own.
class PairCounters {
 public:
  // Makes dense counters where they fit the budget (0: 1 GiB). Otherwise, if `may_be_sparse`, it makes a hash table of
  // `table_capacity` places (0: chosen by the number of ids), which may grow.
  //   Throws: Error limit where dense counters are needed and do not fit.
  PairCounters(const Device& device, uint32_t id_count, bool counts_blocked, uint64_t budget_bytes, bool may_be_sparse,
               uint32_t table_capacity = 0);

  bool isSparse() const { return capacity_ != 0; }
  uint32_t idCount() const { return id_count_; }
  VkDeviceAddress address() const { return counters_.address(); }
  uint32_t mask() const { return capacity_ - 1; }
  uint64_t sizeBytes() const;

  // Returns how many blocks of directions can have counters of their own: more than one where they are dense and small.
  uint32_t mostBlocks() const;
  // Returns the size of the dense counters of one block, after which the next block's follow.
  uint64_t blockBytes() const { return counter_count_ * wordsEach() * sizeof(uint64_t); }

  // Empties all counters, and makes room for this many blocks, at most mostBlocks().
  void start(Commands& commands, uint32_t blocks = 1);
  // Notes how many pairs a batch has added to the hash table.
  void notePairs(uint64_t pairs) {
    pairs_ += pairs;
    last_pairs_ = pairs;
  }
  // Returns whether the hash table may be more than half full after two more batches like the last one.
  bool isCrowded() const { return isSparse() && pairs_ > 0 && pairs_ + 2 * last_pairs_ > capacity_ / 2; }
  // Moves the counts of the hash table to the host and makes the table larger, where the device has room for it. No
  // count is lost. The device must be idle.
  void makeRoom(Commands& commands);
  // Makes the hash table larger; its counts are lost, and start() has to follow.
  //   Throws: Error limit where it would have too many places; Error memory where the device has no room for them.
  //     After this, start() makes a table of the old size.
  void enlarge();
  // Returns all counts since start(), where there is one block.
  PairCounts finish(Commands& commands);
  // Returns all counts since start(), of each block.
  std::vector<PairCounts> finishBlocks(Commands& commands);

 private:
  void allocate();
  uint64_t wordsEach() const { return (isSparse() ? 2 : 1) + (counts_blocked_ ? 1 : 0); }
  void clear(Commands& commands);
  std::vector<PairCounts> read(Commands& commands);
  PairCounts readPlaces(uint64_t begin, uint64_t end) const;
  std::vector<PairCounts> readDense(uint64_t first, uint64_t begin, uint64_t end) const;
  void takeBlocked(PairCounts& counts) const;

  const Device& device_;
  uint32_t id_count_;
  bool counts_blocked_;
  uint32_t capacity_ = 0;   // places of the hash table, a power of 2; 0 where counters are dense
  uint64_t counter_count_;  // dense counters of a block, or places of the hash table
  uint32_t blocks_ = 1;
  uint64_t pairs_ = 0;       // pairs in the hash table
  uint64_t last_pairs_ = 0;  // pairs that the last batch has added to it
  Buffer counters_, read_back_;
  // These counts were taken over from hash tables that became too small. As on the device, `blocked` is the number of
  // blocked and of facing lines together.
  PairCounts drained_;
};

}  // namespace viewpeel
