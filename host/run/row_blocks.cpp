#include "run/row_blocks.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "io/hdf5_frame.h"
#include "sums/add_pairs.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Sum = ReplicateSums::Sum;
using PairSum = ReplicateSums::PairSum;

}  // namespace

RowBlock rowBlock(uint32_t count, uint32_t k, uint32_t n) {
  const auto cut = [&](uint64_t at) { return static_cast<uint32_t>(count * at / n); };
  return {cut(k), cut(uint64_t(k) + 1)};
}

void BlockReport::put(MessageWriter& out) const {
  out.putAll(entry_counts).putAll(outside).putAll(row_sums).put(largest_standard_error);
}

BlockReport BlockReport::get(MessageReader& in) {
  BlockReport report;
  report.entry_counts = in.getAll<uint64_t>();
  report.outside = in.getAll<FormFactors::Entry>();
  report.row_sums = in.getAll<Measured>();
  report.largest_standard_error = in.get<double>();
  return report;
}

// Sums are of one block: pairs that touch its rows, and the sums of these rows.
struct RowBlocks::Sums {
  uint32_t number = 0;
  RowBlock block;
  uint64_t replicates = 0;
  std::vector<PairSum> pairs;  // sorted by (i, j)
  std::vector<Sum> rows;       // of each row of the block
};

// A Waiting block is in an unnamed file while another is in use.
struct RowBlocks::Waiting {
  Waiting(const std::filesystem::path& beside, bool has_file) {
    if (!has_file) return;
    folder_ = beside.has_parent_path() ? beside.parent_path().string() : std::string(".");
    std::string name = folder_ + "/viewpeel.XXXXXX";
    file_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (file_ < 0) fail("write");
    ::unlink(name.c_str());  // so that the file ends with the process
  }
  ~Waiting() {
    if (file_ >= 0) ::close(file_);
  }
  Waiting(const Waiting&) = delete;

  void keep(const Sums& sums) {
    replicates_ = sums.replicates, pair_count_ = sums.pairs.size(), row_count_ = sums.rows.size();
    move(sums.pairs.data(), pair_count_ * sizeof(PairSum), 0, ::pwrite, "write");
    move(sums.rows.data(), row_count_ * sizeof(Sum), pair_count_ * sizeof(PairSum), ::pwrite, "write");
  }
  void restore(Sums& sums) const {
    sums.replicates = replicates_;
    sums.pairs.resize(pair_count_), sums.rows.resize(row_count_);
    move(sums.pairs.data(), pair_count_ * sizeof(PairSum), 0, ::pread, "read");
    move(sums.rows.data(), row_count_ * sizeof(Sum), pair_count_ * sizeof(PairSum), ::pread, "read");
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw Error(ErrorCode::output,
                fmt::format("{}: cannot {} an unnamed file for a block of rows: {}; write the output "
                            "to another folder, or give fewer --row-blocks",
                            folder_, what, std::strerror(errno ? errno : ENOSPC)));
  }
  template <class Bytes>
  void move(Bytes* values, size_t size, size_t place, auto system_call, const char* what) const {
    auto* bytes = const_cast<char*>(reinterpret_cast<const char*>(values));
    for (size_t done = 0; done < size;) {
      errno = 0;
      const ssize_t moved = system_call(file_, bytes + done, size - done, static_cast<off_t>(place + done));
      if (moved <= 0 && errno != EINTR) fail(what);
      if (moved > 0) done += static_cast<size_t>(moved);
    }
  }

  std::string folder_;
  int file_ = -1;
  uint64_t replicates_ = 0;
  size_t pair_count_ = 0, row_count_ = 0;
};

RowBlocks::RowBlocks(Ids ids, uint32_t block_count, uint32_t rank, uint32_t ranks, const std::filesystem::path& beside)
    : ids_(std::move(ids)), block_count_(block_count), rank_(rank), ranks_(ranks) {
  const bool has_files = rank + ranks < block_count;
  for (uint32_t block = rank; block < block_count; block += ranks)
    waiting_[block] = std::make_unique<Waiting>(beside, has_files);
}

RowBlocks::~RowBlocks() = default;

PairCounts RowBlocks::partOf(uint32_t number) const {
  const RowBlock block = rowBlock(ids_.count(), number, block_count_);
  PairCounts part;
  std::ranges::copy_if(counts_, std::back_inserter(part), [&](const PairCount& count) {
    return count.count > 0 && (block.has(count.i) || (count.j < kEnvironment && block.has(count.j)));
  });
  return part;
}

void RowBlocks::letWait() {
  if (sums_ && waiting_.size() > 1) waiting_.at(sums_->number)->keep(*sums_);
}

// Brings a block of this rank into memory, and lets the other wait.
RowBlocks::Sums& RowBlocks::use(uint32_t number) {
  if (sums_ && sums_->number == number) return *sums_;
  letWait();
  auto sums = std::make_unique<Sums>();
  sums_.reset();  // before the other needs memory
  sums->number = number;
  sums->block = rowBlock(ids_.count(), number, block_count_);
  if (waiting_.size() > 1) waiting_.at(number)->restore(*sums);
  sums->rows.resize(sums->block.end - sums->block.first);
  sums_ = std::move(sums);
  return *sums_;
}

void RowBlocks::add(uint32_t number, const PairCounts& counts) {
  Sums& sums = use(number);
  ++sums.replicates;
  std::vector<uint64_t> rows(sums.rows.size(), 0);
  for (const PairCount& count : counts) {
    if (sums.block.has(count.i)) rows[count.i - sums.block.first] += count.count;
    if (count.j < kEnvironment && sums.block.has(count.j)) rows[count.j - sums.block.first] += count.count;
  }
  for (size_t k = 0; k < rows.size(); ++k) sums.rows[k].add(rows[k]);
  addPairs(sums.pairs, counts, [](PairSum& sum, const PairCount& count) { sum.sum.add(count.count); });
}

// Makes form factors of a block, whose rows are the requested ones.
FormFactors RowBlocks::formFactors(uint32_t number, double measure_area, double count_area) {
  Sums& sums = use(number);
  std::vector<Sum> rows(ids_.count());
  std::ranges::copy(sums.rows, rows.begin() + sums.block.first);
  const ReplicateSums measured(ids_, sums.replicates, {}, std::move(rows));
  std::vector<FormFactors::Entry> entries;
  entries.reserve(sums.pairs.size());
  for (const PairSum& pair : sums.pairs)
    entries.push_back({pair.i, pair.j, measured.exchangeArea(pair, measure_area, count_area)});
  Ids ids = ids_;
  ids.requested.assign(ids.count(), false);
  std::fill(ids.requested.begin() + sums.block.first, ids.requested.begin() + sums.block.end, true);
  return {std::move(ids), std::move(entries), measured.measureRows(measure_area)};
}

BlockReport RowBlocks::finish(uint32_t number, double measure_area, double count_area) {
  const FormFactors found = formFactors(number, measure_area, count_area);
  const RowBlock block = rowBlock(ids_.count(), number, block_count_);
  BlockReport report;
  report.entry_counts.resize(block.end - block.first);
  for (const FormFactors::Entry& entry : found.entries()) {
    report.largest_standard_error = std::max(report.largest_standard_error,
                                             entry.exchange_area.standard_error / ids_.smallerArea(entry.i, entry.j));
    if (entry.j >= kEnvironment) {
      report.outside.push_back(entry);
      continue;
    }
    if (block.has(entry.i)) ++report.entry_counts[entry.i - block.first];
    if (entry.j != entry.i && block.has(entry.j)) ++report.entry_counts[entry.j - block.first];
  }
  report.row_sums.assign(found.rowSums().begin() + block.first, found.rowSums().begin() + block.end);
  return report;
}

void RowBlocks::write(uint32_t number, double measure_area, double count_area, const std::vector<int64_t>& starts,
                      const std::map<std::string, uint64_t>& places, const std::string& file) {
  writeHdf5Block(formFactors(number, measure_area, count_area), starts, places, file);
}

}  // namespace viewpeel
