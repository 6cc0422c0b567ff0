#include "run/ranked_rows.h"

#include <utility>

#include "engines/ranked_engine.h"
#include "ranks/put_ids.h"
#include "sums/pair_count.h"

namespace viewpeel {
namespace {

constexpr uint32_t kNoBlock = 0xFFFFFFFFu;

void putPlaces(MessageWriter& out, const std::map<std::string, uint64_t>& places) {
  out.put(uint64_t(places.size()));
  for (const auto& [name, place] : places) out.putAll(name).put(place);
}
std::map<std::string, uint64_t> getPlaces(MessageReader& in) {
  std::map<std::string, uint64_t> places;
  for (auto count = in.get<uint64_t>(); count > 0; --count) {
    const std::string name = in.getText();
    places[name] = in.get<uint64_t>();
  }
  return places;
}

// Writes all blocks of a rank.
void writeBlocks(RowBlocks& blocks, uint32_t rank, const BlockUnits& units, const std::vector<int64_t>& starts,
                 const std::map<std::string, uint64_t>& places, const std::string& file) {
  for (uint32_t block = 0; block < blocks.count(); ++block)
    if (blocks.ownerOf(block) == rank) blocks.write(block, units, starts, places, file);
}

}  // namespace

RankedRows::RankedRows(Crew* crew, Engine& engine, const Ids& ids, EngineKind kind, const LatticeOptions& lattice,
                       uint32_t block_count, const std::filesystem::path& beside)
    : crew_(crew), engine_(engine), blocks_(ids, block_count, 0, crew ? crew->size() : 1, beside) {
  if (!crew_) return;
  number_ = crew_->newNumber();
  MessageWriter rows;
  rows.put(RankWork::open_rows).put(block_count).putAll(std::filesystem::absolute(beside).string());
  putIds(rows, ids);
  for (const std::string& question : {openingOf(number_, kind, lattice, ids), rows.take()})
    crew_->share([&](uint32_t) { return question; }, [] {});
}

RankedRows::~RankedRows() {
  if (crew_) crew_->tell(closingOf(number_));
}

void RankedRows::add(std::span<const Direction> directions) {
  const std::vector<size_t> cuts =
      crew_ ? crew_->cutEvenly(directions.size()) : std::vector<size_t>{0, directions.size()};
  const auto partOf = [&](size_t rank) { return directions.subspan(cuts[rank], cuts[rank + 1] - cuts[rank]); };
  const auto countHere = [&] { blocks_.take(partOf(0).empty() ? PairCounts{} : engine_.count(partOf(0))); };
  if (!crew_) {
    countHere();
    for (uint32_t block = 0; block < blocks_.count(); ++block) blocks_.add(block, blocks_.partOf(block));
    return;
  }
  crew_->share(
      [&](uint32_t rank) { return MessageWriter().put(RankWork::count_rows).put(number_).putAll(partOf(rank)).take(); },
      countHere);
  for (uint32_t block = 0; block < blocks_.count(); ++block) {
    PairCounts counts;
    const std::string question = MessageWriter().put(RankWork::take_rows).put(block).take();
    for (const std::string& answer :
         crew_->share([&](uint32_t) { return question; }, [&] { counts = blocks_.partOf(block); }))
      counts = addCounts(counts, MessageReader(answer).getAll<PairCount>());
    const uint32_t owner = blocks_.ownerOf(block);
    crew_->share(
        [&](uint32_t rank) {
          return MessageWriter()
              .put(RankWork::add_rows)
              .put(rank == owner ? block : kNoBlock)
              .putAll(rank == owner ? counts : PairCounts{})
              .take();
        },
        [&] {
          if (owner == 0) blocks_.add(block, counts);
        });
  }
}

std::vector<BlockReport> RankedRows::measure(uint32_t first, const BlockUnits& units) {
  const auto blockOf = [&](uint32_t rank) { return first + rank < blocks_.count() ? first + rank : kNoBlock; };
  std::vector<BlockReport> reports(1);
  const auto measureHere = [&] { reports[0] = blocks_.measure(first, units); };
  if (!crew_) {
    measureHere();
    return reports;
  }
  const std::vector<std::string> answers = crew_->share(
      [&](uint32_t rank) { return MessageWriter().put(RankWork::measure_rows).put(blockOf(rank)).put(units).take(); },
      measureHere);
  for (uint32_t rank = 1; rank < crew_->size() && blockOf(rank) != kNoBlock; ++rank) {
    MessageReader in(answers[rank - 1]);
    reports.push_back(BlockReport::get(in));
  }
  return reports;
}

void RankedRows::write(const BlockUnits& units, const std::vector<int64_t>& starts,
                       const std::map<std::string, uint64_t>& places, const std::string& file) {
  const auto writeHere = [&] { writeBlocks(blocks_, 0, units, starts, places, file); };
  if (!crew_) return writeHere();
  MessageWriter out;
  out.put(RankWork::write_rows).put(units).putAll(starts);
  putPlaces(out, places);
  const std::string question = out.putAll(std::filesystem::absolute(file).string()).take();
  crew_->share([&](uint32_t) { return question; }, writeHere);
}

std::unique_ptr<RowBlocks> openRows(MessageReader& in, const Ranks& ranks) {
  const auto block_count = in.get<uint32_t>();
  const std::string beside = in.getText();
  return std::make_unique<RowBlocks>(getIds(in), block_count, ranks.rank(), ranks.size(), beside);
}

std::string answerOfRows(RowBlocks& blocks, RankWork work, MessageReader& in) {
  if (work == RankWork::take_rows) return MessageWriter().putAll(blocks.partOf(in.get<uint32_t>())).take();
  if (work == RankWork::add_rows) {
    const auto block = in.get<uint32_t>();
    if (block != kNoBlock) blocks.add(block, in.getAll<PairCount>());
    return {};
  }
  if (work == RankWork::measure_rows) {
    const auto block = in.get<uint32_t>();
    const auto units = in.get<BlockUnits>();
    MessageWriter out;
    if (block != kNoBlock) blocks.measure(block, units).put(out);
    return out.take();
  }
  const auto units = in.get<BlockUnits>();
  const std::vector<int64_t> starts = in.getAll<int64_t>();
  const std::map<std::string, uint64_t> places = getPlaces(in);
  writeBlocks(blocks, blocks.rank(), units, starts, places, in.getText());
  return {};
}

}  // namespace viewpeel
