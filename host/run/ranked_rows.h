// Ranks share the work on blocks of rows: what rank 0 asks, and how others answer.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <viewpeel/engine.h>
#include <viewpeel/ranks.h>
#include "ranks/crew.h"
#include "ranks/message.h"
#include "run/row_blocks.h"

namespace viewpeel {

// RankedRows are the blocks of all ranks, as rank 0 sees them.
class RankedRows {
 public:
  //   In: crew: the other ranks; nullptr: there are none; engine: of this rank; others open one like it; all are kept
  //     by reference. ids: with names; kind, lattice: of the engines; beside: as in RowBlocks
  RankedRows(Crew* crew, Engine& engine, const Ids& ids, EngineKind kind, const LatticeOptions& lattice,
             uint32_t block_count, const std::filesystem::path& beside);
  ~RankedRows();
  RankedRows(const RankedRows&) = delete;

  // Counts one replicate on all ranks, and adds it to the blocks of all ranks.
  void add(std::span<const Direction> directions);
  // Returns the reports of the block `first` and the blocks after it, one of each rank.    In: first: a block of rank 0
  std::vector<BlockReport> measure(uint32_t first, const BlockUnits& units);
  // Has all ranks write their blocks into a frame: writeHdf5Block.
  void write(const BlockUnits& units, const std::vector<int64_t>& starts, const std::map<std::string, uint64_t>& places,
             const std::string& file);

 private:
  Crew* crew_;
  Engine& engine_;
  uint64_t number_ = 0;  // of the others' engines
  RowBlocks blocks_;     // of this rank
};

// Opens the blocks of a rank above 0.
std::unique_ptr<RowBlocks> openRows(MessageReader& in, const Ranks& ranks);
// Answers take_rows, add_rows, measure_rows and write_rows.
std::string answerOfRows(RowBlocks& blocks, RankWork work, MessageReader& in);

}  // namespace viewpeel
