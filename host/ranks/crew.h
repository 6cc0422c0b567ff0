// A Crew is all ranks as rank 0 sees them: it hands out work, does its own part, and collects the answers.
//
// One call is one exchange: a question to every other rank, and an answer from each. Only rank 0 decides anything, so
// ranks never have to agree. If a rank fails, or rank 0 has to stop, all ranks stop. The exchange still ends with an
// answer from each rank, so that the next exchange begins afresh.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <viewpeel/ranks.h>

namespace viewpeel {

// RankWork is the first byte of a question, and says what the rank is to do. `close_engine` and `stop` have no
// answer; the answer to `end` is RankAnswer::ended.
enum class RankWork : uint8_t {
  hello,          // version and fingerprint of the scene -> threads of the rank
  open_engine,    // number, kind, lattice, ids -> nothing
  count,          // number, directions -> counts
  count_blocks,   // number, directions, directions of a block -> counts of each block
  find_pairs,     // ids, seed, ... -> hash of the pairs
  plan_lines,     // a range of pairs, goals -> plans of their lines
  take_pairs,     // plans of all pairs -> hash of the pairs' parts, after they are cut
  count_lines,    // replicate, a range of pairs -> counts
  draw_uniform,   // tasks -> the same, done
  draw_strata,    // tasks -> the same, done
  open_rows,      // ids, number of blocks, output -> nothing
  count_rows,     // number of an engine, directions -> nothing; the rank keeps the counts
  take_rows,      // block -> the part of the kept counts that touches it
  add_rows,       // block of this rank, or none; counts of all ranks -> nothing
  measure_rows,   // block of this rank, or none; units -> BlockReport
  write_rows,     // units, starts, places, file -> nothing, after all blocks of the rank are written
  open_products,  // lattice, ids, materials -> nothing
  sum_products,   // directions, factors -> sums of products
  close_engine,
  stop,
  end,
};

// RankAnswer is the first byte of an answer.
enum class RankAnswer : uint8_t { done, stopped, failed, ended };

class Crew {
 public:
  // Greets the other ranks.
  //   In: ranks: referred to; scene_hash: fingerprint of the scene; threads: of this rank; stop: called while others
  //   work, may throw
  //   Throws: Error bad_usage where a rank has another scene or another version; errors of other ranks.
  Crew(Ranks& ranks, uint64_t scene_hash, size_t threads, std::function<void()> stop);

  uint32_t size() const { return ranks_.size(); }
  // Returns a number for an engine that ranks keep.
  uint64_t newNumber() { return next_number_++; }

  // Has all ranks work at the same time.
  //   In: question: what rank r > 0 is asked; work_here: does the part of rank 0
  //   Out: answers of ranks 1, 2, ..., without their first byte
  //   Throws: what `work_here` or `stop` throws; errors of other ranks, with their number.
  std::vector<std::string> share(const std::function<std::string(uint32_t rank)>& question,
                                 const std::function<void()>& work_here);
  // Sends the same words, which have no answer, to all other ranks.
  void tell(const std::string& message);

  // Cuts tasks 0 to n - 1 into a range for each rank, of about equal cost for each of its threads.
  //   In: costs: double[n]; by_threads: false: of about equal cost for each rank
  //   Out: size() + 1 ascending indices: rank r has the tasks from [r] to [r + 1] - 1
  std::vector<size_t> cut(std::span<const double> costs, bool by_threads = true) const;
  // Cuts tasks of equal cost.
  std::vector<size_t> cutEvenly(size_t count, bool by_threads = true) const {
    return cut(std::vector<double>(count, 1.0), by_threads);
  }

 private:
  void stopAll();

  Ranks& ranks_;
  std::function<void()> stop_;
  std::vector<double> threads_;  // of each rank
  uint64_t next_number_ = 0;
  bool is_lost_ = false;  // some rank did not stop in time: its answers are no longer awaited
};

// Writes what rank 0 and the others must have in common.
std::string helloOf(uint64_t scene_hash);

}  // namespace viewpeel
