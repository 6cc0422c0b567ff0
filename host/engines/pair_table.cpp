#include "engines/pair_table.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "engines/shared.h"
#include <viewpeel/error.h>
#include "threads.h"

namespace viewpeel {
namespace {

constexpr uint64_t kFirstPlaces = 1024;
constexpr size_t kAdditionsAhead = 8;  // places are fetched from memory this many additions ahead

uint64_t denseWords(uint32_t id_count, bool counts_blocked) {
  return device_data::counterCount(id_count) * (counts_blocked ? 2 : 1);
}

// Returns the counts sorted by key (a counting sort). Counts of one key keep their order.
//   In: keys: keyOf returns numbers below this one
template <class KeyOf>
PairCounts inOrderOf(const PairCounts& counts, size_t keys, KeyOf keyOf) {
  std::vector<uint32_t> places(keys + 1, 0);
  for (const PairCount& count : counts) ++places[keyOf(count) + 1];
  std::partial_sum(places.begin(), places.end(), places.begin());
  PairCounts sorted(counts.size());
  for (const PairCount& count : counts) sorted[places[keyOf(count)]++] = count;
  return sorted;
}

// Sorts the counts of a part by i and j. Where there are many, counting sorts do it: by j, then by i, of which a part
// has few.
void sortPart(PairCounts& counts, uint32_t id_count) {
  if (8 * counts.size() < id_count) return std::sort(counts.begin(), counts.end(), isBefore);
  const auto [first, last] = std::minmax_element(counts.begin(), counts.end(),
                                                 [](const PairCount& a, const PairCount& b) { return a.i < b.i; });
  const uint32_t first_i = first->i, i_count = last->i - first_i + 1;
  counts = inOrderOf(counts, id_count + 2, [&](const PairCount& count) {
    return count.j < kEnvironment ? count.j : id_count + (count.j - kEnvironment);
  });
  counts = inOrderOf(counts, i_count, [&](const PairCount& count) { return count.i - first_i; });
}

}  // namespace

SharedPairs::SharedPairs(uint32_t id_count, bool counts_blocked, uint64_t most_bytes)
    : parts_per_id_((uint64_t(kParts) << 32) / id_count),
      id_count_(id_count),
      stride_(counts_blocked ? 3 : 2),
      most_bytes_(most_bytes),
      parts_(kParts) {}

// Returns the counters of a key, and takes a free place for it where it has none.
uint64_t* SharedPairs::find(Part& part, uint64_t key) const {
  uint64_t place = placeOf(key, part.words.size() / stride_);
  while (part.words[place] != key) {
    if (part.words[place] == 0) {
      part.words[place] = key;
      ++part.used;
      break;
    }
    place = place + stride_ == part.words.size() ? 0 : place + stride_;
  }
  return &part.words[place + 1];
}

// Enlarges a part's table where `more` further pairs would make it more than half full.
void SharedPairs::makeRoom(Part& part, uint64_t more) {
  const uint64_t places = part.words.size() / stride_;
  if (2 * (part.used + more) <= places) return;
  const uint64_t wanted = std::max(2 * places, kFirstPlaces), bytes = (wanted - places) * stride_ * sizeof(uint64_t);
  if ((bytes_ += bytes) > most_bytes_) {
    bytes_ -= bytes;
    throw Error(ErrorCode::limit,
                fmt::format("the tables of facing pairs outgrow {:.0f} MiB of memory; try --by surface",
                            double(most_bytes_) / 1048576.0));
  }
  std::vector<uint64_t> words(wanted * stride_, 0);
  std::swap(words, part.words);
  part.used = 0;
  for (uint64_t place = 0; place < words.size(); place += stride_)
    if (words[place]) std::copy_n(&words[place + 1], stride_ - 1, find(part, words[place]));
}

void SharedPairs::add(uint32_t part_index, const Addition* additions, size_t count) {
  Part& part = parts_[part_index];
  const std::lock_guard lock(part.mutex);
  makeRoom(part, count);
  const uint64_t places = part.words.size() / stride_;
  for (size_t k = 0; k < std::min(kAdditionsAhead, count); ++k)
    __builtin_prefetch(&part.words[placeOf(additions[k].key, places)], 1);
  for (size_t k = 0; k < count; ++k) {
    if (k + kAdditionsAhead < count)
      __builtin_prefetch(&part.words[placeOf(additions[k + kAdditionsAhead].key, places)], 1);
    find(part, additions[k].key)[additions[k].weight & 1] += additions[k].weight >> 1;
  }
}

// Returns the counts of a part in order, and empties it. Parts hold ranges of i, so the counts of all parts, one after
// the other, are in order, too.
PairCounts SharedPairs::take(uint32_t part_index) {
  Part& part = parts_[part_index];
  PairCounts counts;
  counts.reserve(part.used);
  for (uint64_t place = 0; place < part.words.size(); place += stride_) {
    if (part.words[place] == 0) continue;
    const uint64_t pair = ~part.words[place];
    counts.push_back({static_cast<uint32_t>(pair >> 32), static_cast<uint32_t>(pair), part.words[place + 1],
                      stride_ > 2 ? part.words[place + 2] : 0});
  }
  sortPart(counts, id_count_);
  std::fill(part.words.begin(), part.words.end(), 0);
  part.used = 0;
  return counts;
}

PairCounts SharedPairs::takeAll(size_t threads) {
  std::vector<PairCounts> parts(kParts);
  shareOut(threads, kParts, 1, [&](size_t, size_t part) { parts[part] = take(static_cast<uint32_t>(part)); });
  size_t count = 0;
  for (const PairCounts& part : parts) count += part.size();
  PairCounts counts;
  counts.reserve(count);
  for (PairCounts& part : parts) {
    counts.insert(counts.end(), part.begin(), part.end());
    part = {};
  }
  return counts;
}

PairTable::PairTable(uint32_t id_count, bool counts_blocked)
    : id_count_(id_count), stride_(counts_blocked ? 2 : 1), dense_(denseWords(id_count, counts_blocked), 0) {
  for (uint32_t i = 0; i < id_count; ++i) row_starts_.push_back(device_data::counterIndex(i, 0, id_count));
  coming_.fill({dense_.data(), 0});
}

PairTable::PairTable(SharedPairs& shared)
    : shared_(&shared), waiting_(SharedPairs::kParts * kWaiting), counts_(SharedPairs::kParts, 0) {}

uint64_t PairTable::denseBytes(uint32_t id_count, bool counts_blocked) {
  return denseWords(id_count, counts_blocked) * sizeof(uint64_t);
}

// Adds the weights whose counters are still on their way from memory.
void PairTable::settle() {
  for (Coming& coming : coming_) {
    if (coming.weight) *coming.counter += coming.weight;
    coming.weight = 0;
  }
}

PairCounts PairTable::take() {
  settle();
  PairCounts counts;
  const uint64_t* word = dense_.data();
  for (uint32_t i = 0; i < id_count_; ++i)
    for (uint32_t column = i; column < id_count_ + 2; ++column, word += stride_) {
      const uint64_t facing = word[0], blocked = stride_ > 1 ? word[1] : 0;
      if (facing | blocked)
        counts.push_back({i, column < id_count_ ? column : kEnvironment + (column - id_count_), facing, blocked});
    }
  std::fill(dense_.begin(), dense_.end(), 0);
  return counts;
}

void PairTable::moveInto(PairTable& sum) {
  settle();
  for (uint64_t k = 0; k < dense_.size(); ++k) sum.dense_[k] += dense_[k];
  std::fill(dense_.begin(), dense_.end(), 0);
}

void PairTable::clear() {
  settle();
  std::fill(dense_.begin(), dense_.end(), 0);
  std::fill(counts_.begin(), counts_.end(), 0);
}

void PairTable::flush() {
  for (uint32_t part = 0; part < counts_.size(); ++part) flush(part);
}

void PairTable::flush(uint32_t part) {
  const uint32_t count = counts_[part];
  counts_[part] = 0;
  if (count) shared_->add(part, &waiting_[part * kWaiting], count);
}

}  // namespace viewpeel
