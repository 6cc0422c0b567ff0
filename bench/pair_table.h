// One thread's counts of pairs, for rivals of the engines: dense where all pairs fit, else a hash that grows.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

namespace viewpeel::bench {

class PairTable {
 public:
  // Columns beyond the ids are the environment and the leak.
  explicit PairTable(uint32_t id_count) : id_count_(id_count), dense_(uint64_t(id_count) * (id_count + 3) / 2 <= kMostDense) { clear(); }

  void clear() {
    used_ = 0;
    if (dense_) counters_.assign(uint64_t(id_count_) * (id_count_ + 3) / 2 + id_count_, 0);
    else slots_.assign(1u << 16, {kEmpty, 0});
  }

  //   In: i < ids, j < ids + 2, in any order
  void add(uint32_t i, uint32_t j) {
    if (i > j) std::swap(i, j);
    if (dense_) {
      ++counters_[uint64_t(i) * (id_count_ + 2) - uint64_t(i) * (i + 1) / 2 + j];
      return;
    }
    const uint64_t key = uint64_t(i) << 32 | j;
    Slot& slot = find(key);
    if (slot.key == kEmpty) {
      slot.key = key;
      slot.count = 1;
      if (++used_ * 2 > slots_.size()) grow();
    } else {
      ++slot.count;
    }
  }

  // Calls use(i, j, count) for all nonzero counts, sorted where dense.
  template <class Use>
  void forEach(Use use) const {
    if (dense_) {
      for (uint32_t i = 0; i < id_count_; ++i) {
        const uint32_t* row = &counters_[uint64_t(i) * (id_count_ + 2) - uint64_t(i) * (i + 1) / 2];
        for (uint32_t j = i; j < id_count_ + 2; ++j)
          if (row[j]) use(i, j, uint64_t(row[j]));
      }
    } else {
      for (const Slot& slot : slots_)
        if (slot.key != kEmpty) use(uint32_t(slot.key >> 32), uint32_t(slot.key), slot.count);
    }
  }

 private:
  struct Slot {
    uint64_t key, count;
  };
  static constexpr uint64_t kMostDense = 1ull << 27;  // counters of 4 bytes
  static constexpr uint64_t kEmpty = UINT64_MAX;

  Slot& find(uint64_t key) {
    const uint64_t mask = slots_.size() - 1;
    uint64_t at = (key * 0x9E3779B97F4A7C15ull) >> 20 & mask;
    while (slots_[at].key != key && slots_[at].key != kEmpty) at = (at + 1) & mask;
    return slots_[at];
  }

  void grow() {
    std::vector<Slot> old(2 * slots_.size(), {kEmpty, 0});
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.key != kEmpty) find(slot.key) = slot;
  }

  uint32_t id_count_;
  bool dense_;
  std::vector<uint32_t> counters_;
  std::vector<Slot> slots_;
  uint64_t used_ = 0;
};

}  // namespace viewpeel::bench
