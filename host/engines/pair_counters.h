// PairCounters holds counters of pairs on the device: a dense table, or a hash table where a dense one does not fit.
#pragma once
#include <vector>

#include "sums/pair_count.h"
#include "vulkan/commands.h"

namespace viewpeel {

// PairCounters are counters of all pairs of ids on the device, 64 bits each: dense, or a hash table of the pairs with
// counts. A pair has one of facing lines, or two: the second counts all lines on which the two face each other, blocked
// or not. Blocks of directions may have dense counters of their own.
class PairCounters {
 public:
  // Makes dense counters where their bytes fit the budget (0: 1 GiB), else, if `may_be_sparse`, a hash table of
  // `table_capacity` places at first (0 chooses).
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
  // Returns the size of the dense counters of one block; the next block's follow.
  uint64_t blockBytes() const { return counter_count_ * wordsEach() * sizeof(uint64_t); }

  // Empties everything, and makes room for this many blocks, mostBlocks() at most.
  void start(Commands& commands, uint32_t blocks = 1);
  // Adds to the number of pairs that entered the table.
  void notePairs(uint64_t pairs) {
    pairs_ += pairs;
    last_pairs_ = pairs;
  }
  // Returns whether the table may be more than half full after two more batches like the last.
  bool isCrowded() const { return isSparse() && pairs_ > 0 && pairs_ + 2 * last_pairs_ > capacity_ / 2; }
  // Empties the table into the host's sums and makes it larger, where the device has room for it; nothing is lost.
  // The device must be idle.
  void makeRoom(Commands& commands);
  // Makes the table larger; start() has to follow.
  //   Throws: Error limit where it has too many places; Error memory where the device has no room for them: then
  //   start() makes the table that was.
  void enlarge();
  // Returns all that was counted since start(), of one block.
  PairCounts finish(Commands& commands);
  // Returns the same counts of each block.
  std::vector<PairCounts> finishBlocks(Commands& commands);

 private:
  void allocate();
  uint64_t wordsEach() const { return (isSparse() ? 2 : 1) + (counts_blocked_ ? 1 : 0); }
  void clear(Commands& commands);
  std::vector<PairCounts> read(Commands& commands);
  void takeBlocked(PairCounts& counts) const;

  const Device& device_;
  uint32_t id_count_;
  bool counts_blocked_;
  uint32_t capacity_ = 0;   // of the hash table, a power of 2; 0 where counters are dense
  uint64_t counter_count_;  // of a block, or places in the table
  uint32_t blocks_ = 1;
  uint64_t pairs_ = 0;       // in the table
  uint64_t last_pairs_ = 0;  // of them, from the last batch
  Buffer counters_, read_back_;
  PairCounts drained_;  // from tables before this one; `blocked` holds all lines on which the two face each other
};

}  // namespace viewpeel
