#include "run/row_blocks.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "io/hdf5_frame.h"
#include "sums/add_pairs.h"
#include <viewpeel/drop_below.h>

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
  out.putAll(entry_counts).putAll(outside).putAll(row_sums).put(largest_standard_error).put(largest_relative_error);
  out.putAll(dropped).put(dropped_pairs);
}

BlockReport BlockReport::get(MessageReader& in) {
  BlockReport report;
  report.entry_counts = in.getAll<uint64_t>();
  report.outside = in.getAll<FormFactors::Entry>();
  report.row_sums = in.getAll<Measured>();
  report.largest_standard_error = in.get<double>(), report.largest_relative_error = in.get<double>();
  report.dropped = in.getAll<Measured>(), report.dropped_pairs = in.get<uint64_t>();
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

RowBlocks::RowBlocks(Ids ids, uint32_t block_count, uint32_t rank, uint32_t ranks, const std::filesystem::path& beside)
    : ids_(std::move(ids)), block_count_(block_count), rank_(rank), ranks_(ranks) {
  if (rank + ranks < block_count) file_.emplace(beside);
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

// Brings a block of this rank into memory, and the block in use into the file.
RowBlocks::Sums& RowBlocks::use(uint32_t number) {
  if (sums_ && sums_->number == number) return *sums_;
  if (sums_ && file_) {
    Waiting& waiting = waiting_[sums_->number];
    waiting.replicates = sums_->replicates;
    file_->write(waiting.pairs, sums_->pairs), file_->write(waiting.rows, sums_->rows);
  }
  sums_ = std::make_unique<Sums>();  // first frees the memory of the other
  sums_->number = number;
  sums_->block = rowBlock(ids_.count(), number, block_count_);
  if (const auto at = waiting_.find(number); at != waiting_.end()) {
    sums_->replicates = at->second.replicates;
    sums_->pairs = file_->read<PairSum>(at->second.pairs), sums_->rows = file_->read<Sum>(at->second.rows);
  }
  sums_->rows.resize(sums_->block.end - sums_->block.first);
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

// Makes form factors of the pairs that touch a block, of which only rows in the block are whole.
FormFactors RowBlocks::formFactors(uint32_t number, const BlockUnits& units) {
  Sums& sums = use(number);
  std::vector<Sum> rows(ids_.count());
  std::ranges::copy(sums.rows, rows.begin() + sums.block.first);
  ReplicateSums measured(ids_, sums.replicates, {}, std::move(rows));
  std::vector<double> steps;
  for (const double area : ids_.areas)
    steps.push_back(lineStep(units.line, units.is_scanline, area / ids_.sides(), units.count_area));
  measured.setLineSteps(std::move(steps));
  std::vector<FormFactors::Entry> entries;
  entries.reserve(sums.pairs.size());
  for (const PairSum& pair : sums.pairs)
    entries.push_back({pair.i, pair.j, measured.exchangeArea(pair, units.measure_area, units.count_area)});
  return {ids_, std::move(entries), measured.measureRows(units.measure_area)};
}

BlockReport RowBlocks::measure(uint32_t number, const BlockUnits& units) {
  const FormFactors all = formFactors(number, units);
  const RowBlock block = rowBlock(ids_.count(), number, block_count_);
  BlockReport report;
  for (const FormFactors::Entry& entry : all.entries()) {
    const auto [value, error] = entry.exchange_area;
    const double area = ids_.smallerArea(entry.i, entry.j);
    report.largest_standard_error = std::max(report.largest_standard_error, error / area);
    if (value / area >= units.relative_floor)
      report.largest_relative_error = std::max(report.largest_relative_error, error / value);
    if (entry.j >= kEnvironment) report.outside.push_back(entry);
    else report.dropped_pairs += block.has(entry.i);
  }
  std::optional<DroppedBelow> below;
  if (units.drop_below > 0) {
    below = dropBelow(all, units.drop_below);
    report.dropped.assign(below->dropped.sums.begin() + block.first, below->dropped.sums.begin() + block.end);
  }
  report.entry_counts.resize(block.end - block.first);
  for (const FormFactors::Entry& entry : below ? below->kept.entries() : all.entries()) {
    if (entry.j >= kEnvironment) continue;
    report.dropped_pairs -= block.has(entry.i);
    if (block.has(entry.i)) ++report.entry_counts[entry.i - block.first];
    if (entry.j != entry.i && block.has(entry.j)) ++report.entry_counts[entry.j - block.first];
  }
  report.row_sums.assign(all.rowSums().begin() + block.first, all.rowSums().begin() + block.end);
  return report;
}

void RowBlocks::write(uint32_t number, const BlockUnits& units, const std::vector<int64_t>& starts,
                      const std::map<std::string, uint64_t>& places, const std::string& file) {
  FormFactors found = formFactors(number, units);
  if (units.drop_below > 0) found = dropBelow(found, units.drop_below).kept;
  const RowBlock block = rowBlock(ids_.count(), number, block_count_);
  Ids ids = ids_;
  ids.requested.assign(ids.count(), false);
  std::fill(ids.requested.begin() + block.first, ids.requested.begin() + block.end, true);
  writeHdf5Block({std::move(ids), std::move(found).entries(), {}}, starts, places, file);
}

}  // namespace viewpeel
