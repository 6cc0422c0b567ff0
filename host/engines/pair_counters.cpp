#include "engines/pair_counters.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "engines/shared.h"
#include <viewpeel/error.h>
#include "threads.h"

namespace viewpeel {
namespace {

constexpr uint32_t kFirstCapacity = 1u << 20, kMostCapacity = 1u << 31;
constexpr uint64_t kReadBytes = 32u << 20;  // bytes of counters that are read from the device at a time
constexpr uint64_t kPart = 1 << 15;         // counters that a thread looks through at a time
constexpr uint64_t kMostBlocks = 1024;

}  // namespace

PairCounters::PairCounters(const Device& device, uint32_t id_count, bool counts_blocked, uint64_t budget_bytes,
                           bool may_be_sparse, uint32_t table_capacity)
    : device_(device),
      id_count_(id_count),
      counts_blocked_(counts_blocked),
      counter_count_(device_data::counterCount(id_count)) {
  const uint64_t bytes = counter_count_ * wordsEach() * sizeof(uint64_t);
  const uint64_t budget = std::min<uint64_t>(budget_bytes ? budget_bytes : 1ull << 30, device.maxAllocationBytes());
  if (bytes > budget) {
    if (!may_be_sparse)
      throw Error(
          ErrorCode::limit,
          fmt::format("dense counters of all pairs of {} ids need {:.1f} MiB, more than the {:.1f} MiB allowed; "
                      "try --by surface or --engine compute",
                      id_count, double(bytes) / 1048576.0, double(budget) / 1048576.0));
    capacity_ = std::bit_ceil(table_capacity ? table_capacity : std::max(kFirstCapacity, 32 * id_count));
  }
  allocate();
  read_back_ = Buffer(device, kReadBytes, MemoryUse::readback);
}

uint64_t PairCounters::sizeBytes() const { return counters_.sizeBytes() + kReadBytes; }

void PairCounters::allocate() {
  if (isSparse()) counter_count_ = capacity_;
  counters_ = Buffer();  // frees the old counters before the new ones are made
  counters_ = Buffer(device_, blocks_ * blockBytes(), MemoryUse::device);
}

uint32_t PairCounters::mostBlocks() const {
  return isSparse() ? 1
                    : static_cast<uint32_t>(std::clamp<uint64_t>(
                          std::min(kReadBytes, device_.maxAllocationBytes()) / blockBytes(), 1, kMostBlocks));
}

void PairCounters::start(Commands& commands, uint32_t blocks) {
  drained_.clear();
  blocks_ = blocks;
  if (blocks * blockBytes() > counters_.sizeBytes()) allocate();
  clear(commands);
}

void PairCounters::makeRoom(Commands& commands) {
  drained_ = addCounts(drained_, read(commands)[0]);
  try {
    enlarge();
  } catch (const Error&) {
    allocate();  // makes counters of the old size
  }
  clear(commands);
}

void PairCounters::enlarge() {
  if (capacity_ > kMostCapacity / 4)
    throw Error(ErrorCode::limit,
                fmt::format("the table of facing pairs outgrows {} places; try --by surface", capacity_));
  const uint32_t before = capacity_;
  capacity_ *= 4;
  try {
    allocate();
  } catch (const Error&) {
    capacity_ = before;
    throw;
  }
}

PairCounts PairCounters::finish(Commands& commands) {
  PairCounts counts = std::move(read(commands)[0]);
  if (!drained_.empty()) counts = addCounts(drained_, counts);
  takeBlocked(counts);
  return counts;
}

std::vector<PairCounts> PairCounters::finishBlocks(Commands& commands) {
  std::vector<PairCounts> blocks = read(commands);
  for (PairCounts& counts : blocks) takeBlocked(counts);
  return blocks;
}

// Makes `blocked` the number of blocked lines. The device has counted all lines on which two fronts look at each other,
// blocked or not, so the facing lines are subtracted here.
void PairCounters::takeBlocked(PairCounts& counts) const {
  for (PairCount& count : counts)
    if (counts_blocked_ && count.j < kEnvironment) count.blocked -= count.count;
}

void PairCounters::clear(Commands& commands) {
  commands.begin();
  commands.fill(counters_, 0, blocks_ * blockBytes());
  commands.submitAndWait();
  pairs_ = 0;
}

// Reads the counters piece by piece. Each piece is divided into parts, and threads share the parts.
std::vector<PairCounts> PairCounters::read(Commands& commands) {
  const uint64_t bytes_each = wordsEach() * sizeof(uint64_t), at_once = kReadBytes / bytes_each,
                 all = blocks_ * counter_count_;
  std::vector<PairCounts> blocks(blocks_), in_no_order;
  for (uint64_t first = 0; first < all; first += at_once) {
    const uint64_t count = std::min(at_once, all - first);
    commands.begin();
    commands.copy(counters_, read_back_, count * bytes_each, first * bytes_each, 0);
    commands.submitAndWait();
    std::vector<std::vector<PairCounts>> parts((count + kPart - 1) / kPart);
    shareOut(threadsFor(count), parts.size(), 1, [&](size_t, size_t part) {
      const uint64_t begin = part * kPart, end = std::min(count, begin + kPart);
      if (isSparse()) parts[part] = {readPlaces(begin, end)};
      else parts[part] = readDense(first, begin, end);
    });
    for (size_t part = 0; part < parts.size(); ++part)
      for (size_t k = 0; k < parts[part].size(); ++k) {
        if (isSparse()) {
          in_no_order.push_back(std::move(parts[part][k]));
        } else {
          PairCounts& block = blocks[(first + part * kPart) / counter_count_ + k];
          block.insert(block.end(), parts[part][k].begin(), parts[part][k].end());
        }
      }
  }
  if (isSparse()) blocks[0] = sortAndJoin(in_no_order, id_count_);
  return blocks;
}

// Returns the counts of the places begin to end - 1 of a piece of the hash table.
PairCounts PairCounters::readPlaces(uint64_t begin, uint64_t end) const {
  const std::span<const uint64_t> words = read_back_.mapped<uint64_t>();
  PairCounts counts;
  for (uint64_t k = begin; k < end; ++k) {
    const uint64_t* record = &words[k * wordsEach()];
    if (!record[0]) continue;
    const uint64_t pair = ~record[0];
    counts.push_back(
        {static_cast<uint32_t>(pair >> 32), static_cast<uint32_t>(pair), record[1], counts_blocked_ ? record[2] : 0});
  }
  return counts;
}

// Returns the counts of the dense counters begin to end - 1 of a piece, a list for each block that they are of.
//   In: first: index of the piece's first counter
std::vector<PairCounts> PairCounters::readDense(uint64_t first, uint64_t begin, uint64_t end) const {
  const std::span<const uint64_t> words = read_back_.mapped<uint64_t>();
  const auto rowStart = [&](uint32_t row) { return device_data::counterIndex(row, row, id_count_); };
  const uint64_t in_block = (first + begin) % counter_count_;
  uint32_t i = 0;  // the last row that starts at or before the first counter
  for (uint32_t step = std::bit_floor(id_count_); step > 0; step /= 2)
    if (i + step < id_count_ && rowStart(i + step) <= in_block) i += step;
  auto column = static_cast<uint32_t>(i + (in_block - rowStart(i)));
  std::vector<PairCounts> blocks(1);
  for (uint64_t k = begin; k < end; ++k) {
    const uint64_t* numbers = &words[k * wordsEach()];
    const uint64_t in_all = counts_blocked_ ? numbers[1] : 0;
    if (numbers[0] || in_all)
      blocks.back().push_back(
          {i, column < id_count_ ? column : kEnvironment + (column - id_count_), numbers[0], in_all});
    if (++column < id_count_ + 2) continue;
    column = ++i;
    if (i == id_count_ && k + 1 < end) {
      i = column = 0;
      blocks.emplace_back();
    }
  }
  return blocks;
}

}  // namespace viewpeel
