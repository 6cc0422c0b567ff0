// RowBlocks are the blocks of rows that one rank holds: include/viewpeel/row_blocks.h.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>
#include "io/scratch_file.h"
#include "ranks/message.h"
#include "sums/replicate_sums.h"

namespace viewpeel {

// A RowBlock has the rows `first` to end - 1. Its pairs are all that touch one of them.
struct RowBlock {
  uint32_t first = 0, end = 0;

  bool has(uint32_t id) const { return id >= first && id < end; }
};
// Returns block k of n blocks of count rows.
RowBlock rowBlock(uint32_t count, uint32_t k, uint32_t n);

// BlockUnits turn counts into form factors, and say which relative errors count.
struct BlockUnits {
  double measure_area = 0, count_area = 0;  // as in ReplicateSums
  double line = 1;                          // as lineStep() takes it, as the next is
  bool is_scanline = false;
  double relative_floor = 0.01;
  double drop_below = 0;  // pairs whose form factors are smaller both ways are left out of the file
};

// A BlockReport is what rank 0 learns of a block at the end.
struct BlockReport {
  std::vector<uint64_t> entry_counts;       // of each row of the block: entries between rows
  std::vector<FormFactors::Entry> outside;  // environment and leak of its rows
  std::vector<Measured> row_sums;           // of each row of the block
  double largest_standard_error = 0;
  double largest_relative_error = 0;  // over form factors of at least BlockUnits::relative_floor
  std::vector<Measured> dropped;      // with BlockUnits::drop_below, of each row of the block: the sum left out
  uint64_t dropped_pairs = 0;         // pairs left out whose first row is in the block

  void put(MessageWriter& out) const;
  static BlockReport get(MessageReader& in);
};

// RowBlocks add up the counts of some blocks of rows over replicates.
class RowBlocks {
 public:
  //   In: ids: of all rows; block_count: of all ranks; rank, ranks: this rank has the blocks rank, rank + ranks, ...;
  //     beside: blocks that are not in use wait in an unnamed file in the folder of this file
  //   Throws: Error output where this rank has several blocks, and the folder cannot be written to.
  RowBlocks(Ids ids, uint32_t block_count, uint32_t rank, uint32_t ranks, const std::filesystem::path& beside);
  ~RowBlocks();

  uint32_t count() const { return block_count_; }
  uint32_t rank() const { return rank_; }
  uint32_t ownerOf(uint32_t block) const { return block % ranks_; }

  // Takes the counts that this rank has made of one replicate, until the next call.
  void take(PairCounts counts) { counts_ = std::move(counts); }
  // Returns the part of the taken counts that touches a block of any rank, sorted.
  PairCounts partOf(uint32_t block) const;
  // Adds a replicate to a block of this rank.    In: counts: of all ranks
  void add(uint32_t block, const PairCounts& counts);

  // Makes form factors of the sums of a block of this rank, and reports on them.
  BlockReport measure(uint32_t block, const BlockUnits& units);
  // Makes the form factors of a block again, and writes them by writeHdf5Block(). Keeping them since measure() would
  // take the memory of all blocks.
  void write(uint32_t block, const BlockUnits& units, const std::vector<int64_t>& starts,
             const std::map<std::string, uint64_t>& places, const std::string& file);

 private:
  struct Sums;
  // A Waiting block is in the file.
  struct Waiting {
    uint64_t replicates = 0;
    ScratchFile::Place pairs, rows;
  };
  Sums& use(uint32_t block);
  FormFactors formFactors(uint32_t block, const BlockUnits& units);

  Ids ids_;
  uint32_t block_count_, rank_, ranks_;
  PairCounts counts_;
  std::unique_ptr<Sums> sums_;           // of the block in use
  std::optional<ScratchFile> file_;      // where this rank has several blocks
  std::map<uint32_t, Waiting> waiting_;  // by number, blocks that are in the file
};

}  // namespace viewpeel
