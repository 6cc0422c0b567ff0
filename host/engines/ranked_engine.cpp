#include "engines/ranked_engine.h"

#include <utility>

#include "ranks/put_ids.h"
#include "sums/pair_count.h"

namespace viewpeel {
namespace {

class RankedEngine final : public Engine {
 public:
  RankedEngine(Crew& crew, const EngineFactory& make_engine, EngineKind kind, const Scene& scene, const Ids& ids,
               LatticeOptions options)
      : crew_(crew), by_threads_(kind == EngineKind::host || kind == EngineKind::exact), number_(crew.newNumber()) {
    if (options.on_batch)
      // Progress is shown as if the other ranks counted as fast as this one.
      options.on_batch = [this, on_batch = std::move(options.on_batch)](uint64_t done) {
        on_batch(here_ ? done * all_ / here_ : all_);
      };
    const std::string message = openingOf(number_, kind, options, ids);
    try {
      crew_.share([&](uint32_t) { return message; }, [&] { engine_ = make_engine(scene, ids, options); });
    } catch (...) {
      close();  // closes the engines of ranks that could make theirs
      throw;
    }
  }
  ~RankedEngine() override { close(); }

  PairCounts count(std::span<const Direction> directions) override {
    std::vector<PairCounts> parts(1);
    const std::vector<size_t> cuts = cutEvenly(directions.size());
    const auto partOf = [&](size_t rank) { return directions.subspan(cuts[rank], cuts[rank + 1] - cuts[rank]); };
    const std::vector<std::string> answers = crew_.share(
        [&](uint32_t rank) { return MessageWriter().put(RankWork::count).put(number_).putAll(partOf(rank)).take(); },
        [&] {
          here_ = partOf(0).size(), all_ = directions.size();
          if (here_) parts[0] = engine_->count(partOf(0));
        });
    for (const std::string& answer : answers) parts.push_back(MessageReader(answer).getAll<PairCount>());
    // Sums of two at a time take n log(ranks) additions.
    for (; parts.size() > 1; parts.resize((parts.size() + 1) / 2))
      for (size_t k = 0; k < parts.size(); k += 2)
        parts[k / 2] = k + 1 < parts.size() ? addCounts(parts[k], parts[k + 1]) : std::move(parts[k]);
    return std::move(parts[0]);
  }

  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override {
    const std::vector<size_t> cuts = cutEvenly(directions.size() / block_directions);
    const auto partOf = [&](size_t rank) {
      return directions.subspan(cuts[rank] * block_directions, (cuts[rank + 1] - cuts[rank]) * block_directions);
    };
    std::vector<PairCounts> blocks;
    const std::vector<std::string> answers = crew_.share(
        [&](uint32_t rank) {
          return MessageWriter()
              .put(RankWork::count_blocks)
              .put(number_)
              .put(uint64_t(block_directions))
              .putAll(partOf(rank))
              .take();
        },
        [&] {
          here_ = partOf(0).size(), all_ = directions.size();
          if (here_) blocks = engine_->countBlocks(partOf(0), block_directions);
        });
    for (const std::string& answer : answers) {
      MessageReader in(answer);
      for (auto count = in.get<uint64_t>(); count > 0; --count) blocks.push_back(in.getAll<PairCount>());
    }
    return blocks;
  }

  double unitArea() const override { return engine_->unitArea(); }
  std::string describePlan() const override { return engine_->describePlan(); }

 private:
  void close() { crew_.tell(closingOf(number_)); }
  std::vector<size_t> cutEvenly(size_t count) const { return crew_.cutEvenly(count, by_threads_); }

  Crew& crew_;
  bool by_threads_;
  uint64_t number_;
  uint64_t here_ = 0, all_ = 0;  // directions of the present call
  std::unique_ptr<Engine> engine_;
};

}  // namespace

EngineFactory rankedEngines(Crew& crew, EngineFactory make_engine, EngineKind kind) {
  return [&crew, make_engine = std::move(make_engine), kind](const Scene& scene, const Ids& ids,
                                                             const LatticeOptions& options) {
    return std::make_unique<RankedEngine>(crew, make_engine, kind, scene, ids, options);
  };
}

std::string openingOf(uint64_t number, EngineKind kind, const LatticeOptions& options, const Ids& ids) {
  MessageWriter out;
  out.put(RankWork::open_engine).put(number).put(kind);
  putLattice(out, options);
  putIds(out, ids);
  return out.take();
}

std::string closingOf(uint64_t number) { return MessageWriter().put(RankWork::close_engine).put(number).take(); }

void putLattice(MessageWriter& out, const LatticeOptions& options) {
  out.put(options.resolution).put(options.sampling).put(options.window).put(options.count_blocked);
  out.put(options.split_environment).put(options.batch_directions);
}

LatticeOptions getLattice(MessageReader& in) {
  LatticeOptions options;
  options.resolution = in.get<int>(), options.sampling = in.get<Sampling>(), options.window = in.get<Window>();
  options.count_blocked = in.get<bool>(), options.split_environment = in.get<bool>();
  options.batch_directions = in.get<uint32_t>();
  return options;
}

}  // namespace viewpeel
