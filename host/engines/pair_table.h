// PairTable has counters of pairs of ids on the host: dense ones of each thread, or hash tables that all threads share.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "sums/pair_count.h"

namespace viewpeel {

// SharedPairs are hash tables of the pairs that any thread has counted, one for each part of the ids i. Additions come
// a part's worth at a time, and then its table is in the processor's caches.
class SharedPairs {
 public:
  static constexpr uint32_t kParts = 256;

  struct Addition {
    uint64_t key;     // keyOf
    uint64_t weight;  // twice the weight, and one more for blocked lines
  };
  static uint64_t keyOf(uint32_t i, uint32_t j) { return ~(uint64_t(i) << 32 | j); }  // not 0

  // Makes the tables, which grow.
  //   In: most_bytes: of the tables' memory
  SharedPairs(uint32_t id_count, bool counts_blocked, uint64_t most_bytes);

  uint32_t partOf(uint32_t i) const { return static_cast<uint32_t>(i * parts_per_id_ >> 32); }

  // Adds counts; any thread may call it.    Throws: Error limit.
  void add(uint32_t part, const Addition* additions, size_t count);

  // Returns all counts, in order, and empties the table.
  PairCounts takeAll(size_t threads);
  uint64_t sizeBytes() const { return bytes_; }

 private:
  struct Part {
    std::mutex mutex;
    std::vector<uint64_t> words;  // of every place: key, 0 where it is free; facing; blocked where that is counted
    uint64_t used = 0;
  };
  uint64_t placeOf(uint64_t key, uint64_t places) const {
    return ((key * 0x9E3779B97F4A7C15u) >> 32 & (places - 1)) * stride_;
  }
  uint64_t* find(Part& part, uint64_t key) const;
  void makeRoom(Part& part, uint64_t more);
  PairCounts take(uint32_t part);

  const uint64_t parts_per_id_;  // x 2^32
  const uint32_t id_count_, stride_;
  const uint64_t most_bytes_;
  std::atomic<uint64_t> bytes_ = 0;
  std::vector<Part> parts_;
};

// A PairTable holds the counts of one thread.
class PairTable {
 public:
  // Makes a dense table.
  PairTable(uint32_t id_count, bool counts_blocked);
  explicit PairTable(SharedPairs& shared);

  // i <= j; j may be kEnvironment or kLeak.    Throws: Error limit.
  void add(uint32_t i, uint32_t j, uint64_t weight) { addTo(i, j, weight, 0); }
  void addBlocked(uint32_t i, uint32_t j, uint64_t weight) { addTo(i, j, weight, 1); }

  // Returns all counts of dense counters, in order, and empties them.
  PairCounts take();
  // Adds dense counters: it adds them to others, and empties them.
  void moveInto(PairTable& sum);
  // Gives the waiting additions to the shared tables.    Throws: Error limit.
  void flush();
  // Forgets all counts since the last take.
  void clear();

  static uint64_t denseBytes(uint32_t id_count, bool counts_blocked);
  uint64_t sizeBytes() const {
    return dense_.size() * sizeof(uint64_t) + waiting_.size() * sizeof(SharedPairs::Addition);
  }

 private:
  static constexpr uint32_t kWaiting = 512;  // additions, of each part
  static constexpr uint32_t kComing = 16;    // additions to dense counters that are on their way from memory

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
  std::vector<uint64_t> row_starts_, dense_;  // by counterIndex (shaders/shared.h), facing and blocked of each
  std::array<Coming, kComing> coming_{};
  uint32_t turn_ = 0;
  SharedPairs* shared_ = nullptr;
  std::vector<SharedPairs::Addition> waiting_;
  std::vector<uint32_t> counts_;  // of the waiting additions, by part
};

}  // namespace viewpeel
