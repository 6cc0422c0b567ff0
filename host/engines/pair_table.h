// The host engine counts pairs of ids in a PairTable a thread: in dense counters, or in hash tables that all threads
// share.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "sums/pair_count.h"

namespace viewpeel {

// SharedPairs are hash tables of the pairs that all threads have counted. The ids are divided into kParts ranges, and
// the pairs (i, j) with i in one range have a table, a part. Threads add many counts to one part at a time, so that its
// table is in the processor's caches.
class SharedPairs {
 public:
  static constexpr uint32_t kParts = 256;

  struct Addition {
    uint64_t key;     // what keyOf returns
    uint64_t weight;  // 2 x weight, plus 1 where the lines are blocked
  };
  // Returns the key of a pair, which is never 0: 0 marks a free place.
  static uint64_t keyOf(uint32_t i, uint32_t j) { return ~(uint64_t(i) << 32 | j); }

  // Makes empty tables, which grow.
  //   In: most_bytes: memory that all tables together may take
  SharedPairs(uint32_t id_count, bool counts_blocked, uint64_t most_bytes);

  uint32_t partOf(uint32_t i) const { return static_cast<uint32_t>(i * parts_per_id_ >> 32); }

  // Adds counts to a part. Any thread may call it.
  //   In: additions[count]    Throws: Error limit where the tables would take more than most_bytes.
  void add(uint32_t part, const Addition* additions, size_t count);

  // Returns all counts in order, and empties the tables.
  PairCounts takeAll(size_t threads);
  uint64_t sizeBytes() const { return bytes_; }

 private:
  struct Part {
    std::mutex mutex;
    // Every place has a key, 0 where it is free, the count of facing lines and, where they are counted, of blocked
    // lines.
    std::vector<uint64_t> words;
    uint64_t used = 0;  // places that are not free
  };
  uint64_t placeOf(uint64_t key, uint64_t places) const {
    return ((key * 0x9E3779B97F4A7C15u) >> 32 & (places - 1)) * stride_;
  }
  uint64_t* find(Part& part, uint64_t key) const;
  void makeRoom(Part& part, uint64_t more);
  PairCounts take(uint32_t part);

  const uint64_t parts_per_id_;       // kParts / id_count, times 2^32
  const uint32_t id_count_, stride_;  // stride_: words of a place
  const uint64_t most_bytes_;
  std::atomic<uint64_t> bytes_ = 0;
  std::vector<Part> parts_;
};

// A PairTable takes the counts of one thread. It has dense counters of its own, or passes counts on to SharedPairs.
class PairTable {
 public:
  // Where the environment is split, lines that leave the scene against the direction are counted here.
  static constexpr uint32_t kBehind = kLeak;

  // Makes a table of dense counters.
  PairTable(uint32_t id_count, bool counts_blocked);
  // Makes a table that passes its counts on.    In: shared: the caller keeps it alive
  explicit PairTable(SharedPairs& shared);

  // Both functions add a weight to the facing, or the blocked, lines of a pair.
  //   In: i <= j; j may be kEnvironment or kLeak    Throws: Error limit, as SharedPairs::add
  void add(uint32_t i, uint32_t j, uint64_t weight) { addTo(i, j, weight, 0); }
  void addBlocked(uint32_t i, uint32_t j, uint64_t weight) { addTo(i, j, weight, 1); }

  // Returns the counts of the dense counters in order, and empties them.
  PairCounts take();
  // Adds this table's dense counters to another table's, and empties its own.
  void moveInto(PairTable& sum);
  // Passes the waiting additions on to the shared tables.    Throws: Error limit, as SharedPairs::add.
  void flush();
  // Empties the dense counters and forgets the waiting additions.
  void clear();

  static uint64_t denseBytes(uint32_t id_count, bool counts_blocked);
  uint64_t sizeBytes() const {
    return dense_.size() * sizeof(uint64_t) + waiting_.size() * sizeof(SharedPairs::Addition);
  }

 private:
  static constexpr uint32_t kWaiting = 512;  // additions of one part that wait to be passed on together
  static constexpr uint32_t kComing = 16;    // dense counters that are on their way from memory at once

  // A Coming is an addition to a dense counter that has been requested from memory.
  struct Coming {
    uint64_t* counter;
    uint64_t weight;
  };

  void addTo(uint32_t i, uint32_t j, uint64_t weight, uint32_t blocked) {
    if (!shared_) {
      uint64_t* counter =
          &dense_[(row_starts_[i] + (j < kEnvironment ? j : id_count_ + (j - kEnvironment))) * stride_ + blocked];
      __builtin_prefetch(counter, 1);
      Coming& earlier = coming_[turn_++ % kComing];
      *earlier.counter += earlier.weight;
      earlier = {counter, weight};
      return;
    }
    const uint32_t part = shared_->partOf(i);
    uint32_t& count = counts_[part];
    waiting_[part * kWaiting + count++] = {SharedPairs::keyOf(i, j), 2 * weight + blocked};
    if (count == kWaiting) flush(part);
  }
  void flush(uint32_t part);
  void settle();

  uint32_t id_count_ = 0, stride_ = 1;
  // dense_ has the facing and, where they are counted, the blocked lines of each counterIndex (shaders/shared.h). Row i
  // begins so that its column j is at row_starts_[i] + j.
  std::vector<uint64_t> row_starts_, dense_;
  std::array<Coming, kComing> coming_{};
  uint32_t turn_ = 0;
  SharedPairs* shared_ = nullptr;
  std::vector<SharedPairs::Addition> waiting_;
  std::vector<uint32_t> counts_;  // number of waiting additions of each part
};

}  // namespace viewpeel
