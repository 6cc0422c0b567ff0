// computeRowBlocks() computes matrices that no process could hold: each holds blocks of rows.
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/compute.h>

namespace viewpeel {

struct RowBlocksRequest {
  // What to count: the whole matrix, by a lattice engine. Windows for small polygons (finest), unoccluded form factors,
  // pair lines, balance and a time limit are refused. The goal is a FixedAmount, a Tolerance or a Relative; a Tolerance
  // is never promised.
  Request request;
  // Rows are divided into this number of blocks of about equal size. Block k belongs to rank k mod (number of ranks). A
  // rank holds one of its blocks in memory; others wait in an unnamed file beside the output.
  uint32_t block_count = 1;
  // Pairs whose form factors are below this both ways are left out of the file, which has their sum for each row. In
  // [0, 1); 0: no pair is.
  double drop_below = 0;
  std::filesystem::path output;                                   // .h5, where all ranks can write
  std::vector<std::pair<std::string, std::string>> parameters{};  // further attributes of the file
};

// RowBlocksSummary says what was written.
struct RowBlocksSummary {
  uint64_t replicates = 0, directions = 0;  // directions of all replicates
  int resolution = 0;                       // lattice spacings across the scene's diameter
  uint64_t entries = 0;                     // form factors between rows in the file: F_ij and F_ji count as two
  double largest_standard_error = 0;        // of all form factors, environment and leak included
  Closure closure;
  double environment_share = 0, leak_share = 0;  // of all emitted radiation
  uint64_t most_entries_of_block = 0;            // entries of the largest block
  uint64_t dropped_pairs = 0;                    // left out by RowBlocksRequest::drop_below
  double most_dropped = 0;                       // largest sum of form factors that a row lost by it,
  std::string most_dropped_row;                  // and the name of this row
  double seconds = 0;
  bool interrupted = false;  // the observer stopped it; nothing is written
};

// Counts form factors and writes them to a .h5, without ever holding the matrix.
//   After each replicate the counts of a block go to the rank that it belongs to. For a Tolerance or Relative a plan
//   chooses directions and resolution, and replicates are added until all blocks reach the goal. At the end each rank
//   writes its blocks into one file.
//   In: scene; request: Request::ranks may be several, whose others call serveRanks(); observer: on_progress and
//     should_stop
//   Out: see RowBlocksSummary. The file has the form factors, standard errors and rows of computeFormFactors() for
//     these directions, replicates and this resolution, to the same bits, for any number of blocks and ranks.
//   Error: as computeFormFactors(). Tests: tests/unit/row_blocks_test.cpp, tests/program/ranks_test.cpp.
//   Throws: as computeFormFactors(); Error bad_usage for a request that is not of this kind; Error output where a file
//     cannot be written.
//   Cost: counting as computeFormFactors(). Memory of a rank: the scene, the counts of its directions of one replicate,
//     24 bytes each, of which a plan makes some 3e7 at most, and the sums of one block, 48 bytes a pair that touches
//     its rows; at the end 40 bytes a pair more, and 40 for each that drop_below keeps. Disk: the file, and 48 bytes a
//     pair that waits.
RowBlocksSummary computeRowBlocks(const Scene& scene, const RowBlocksRequest& request, const Observer& observer = {});

}  // namespace viewpeel
