// This file serves rank 0: the other ranks count and draw lines as it asks (include/viewpeel/ranks.h).

#include <atomic>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/ranks.h>

#include "engines/engine_factory.h"
#include "engines/ranked_engine.h"
#include "interrupted.h"
#include "pair_lines/ranked_lines.h"
#include "ranks/crew.h"
#include "ranks/pause.h"
#include "ranks/put_ids.h"
#include "run/ranked_rows.h"
#include "solve/ranked_products.h"
#include "threads.h"

namespace viewpeel {
namespace {

std::string waitForQuestion(Ranks& ranks) {
  for (Pause pause;; pause.wait())
    if (std::optional<std::string> question = ranks.poll(0)) return std::move(*question);
}

std::string answerOf(const Error& error) {
  return MessageWriter().put(RankAnswer::failed).put(error.code()).putAll(std::string(error.what())).take();
}

// Answers questions until rank 0 ends them.
void answerAll(Ranks& ranks, const std::function<std::string(RankWork work, MessageReader& in)>& answer) {
  for (;;) {
    const std::string question = waitForQuestion(ranks);
    MessageReader in(question);
    const auto work = in.get<RankWork>();
    if (work == RankWork::stop) continue;  // rank 0 sent it before it had the answer to its last question
    if (work == RankWork::end) return ranks.send(0, MessageWriter().put(RankAnswer::ended).take());
    std::string reply;
    try {
      reply = MessageWriter().put(RankAnswer::done).take();
      reply.append(answer(work, in));
    } catch (const Interrupted&) {
      reply = MessageWriter().put(RankAnswer::stopped).take();
    } catch (const Error& error) {
      reply = answerOf(error);
    } catch (const std::exception& error) {
      reply = answerOf(Error(ErrorCode::memory, error.what()));
    }
    if (work != RankWork::close_engine) ranks.send(0, reply);
  }
}

// A Serving holds everything that a rank above 0 keeps from one question to the next.
class Serving {
 public:
  Serving(Ranks& ranks, const Scene& scene, const Request& request)
      : ranks_(ranks),
        scene_(scene),
        request_(request),
        lines_(
            scene, request.threads, [this] { stopOnRequest(); }, [this] { return device(); }),
        products_(scene, request.threads, [this] { stopOnRequest(); }) {}

  std::string answer(RankWork work, MessageReader& in) {
    is_stopped_ = false;
    switch (work) {
      case RankWork::hello:
        return greet(in);
      case RankWork::open_engine:
        return openEngine(in);
      case RankWork::close_engine:
        return engines_.erase(in.get<uint64_t>()), std::string();
      case RankWork::count:
        return count(in);
      case RankWork::count_blocks:
        return countBlocks(in);
      case RankWork::open_rows:
      case RankWork::count_rows:
      case RankWork::take_rows:
      case RankWork::add_rows:
      case RankWork::measure_rows:
      case RankWork::write_rows:
        return answerRows(work, in);
      case RankWork::open_products:
      case RankWork::sum_products:
        return products_.answer(work, in);
      default:
        return lines_.answer(work, in);
    }
  }

 private:
  struct Open {
    std::unique_ptr<const Ids> ids;
    std::unique_ptr<Engine> engine;
  };

  // While a question is being answered rank 0 sends nothing but the word to stop.
  void stopOnRequest() {
    if (std::this_thread::get_id() == thread_ && ranks_.poll(0)) is_stopped_ = true;
    if (is_stopped_) throw Interrupted{};
  }

  std::string greet(MessageReader& in) {
    const auto hash = in.get<uint64_t>();
    if (in.getText() != VIEWPEEL_VERSION)
      throw Error(ErrorCode::bad_usage, "has another version of viewpeel than rank 0; install the same everywhere");
    if (hash != fingerprint(scene_))
      throw Error(ErrorCode::bad_usage,
                  "has read another scene than rank 0; put the same file in the same place of every machine");
    return MessageWriter().put(uint64_t(request_.threads ? request_.threads : threadCount())).take();
  }

  std::string openEngine(MessageReader& in) {
    const auto number = in.get<uint64_t>();
    const auto kind = in.get<EngineKind>();
    LatticeOptions options = getLattice(in);
    options.thread_count = request_.threads;
    options.stop = [this] { stopOnRequest(); };
    options.on_batch = [this](uint64_t) { stopOnRequest(); };
    Open open{std::make_unique<const Ids>(getIds(in)), nullptr};
    const bool needs_device = kind == EngineKind::compute || kind == EngineKind::graphics;
    const EngineFactory make =
        kind == EngineKind::exact ? request_.exact_engine : latticeEngines(kind, needs_device ? device() : nullptr);
    open.engine = make(scene_, *open.ids, options);
    engines_[number] = std::move(open);
    return {};
  }

  std::string count(MessageReader& in) {
    Engine& engine = *engines_.at(in.get<uint64_t>()).engine;
    const std::vector<Direction> directions = in.getAll<Direction>();
    return MessageWriter().putAll(directions.empty() ? PairCounts{} : engine.count(directions)).take();
  }

  std::string countBlocks(MessageReader& in) {
    Engine& engine = *engines_.at(in.get<uint64_t>()).engine;
    const auto block_directions = in.get<uint64_t>();
    const std::vector<Direction> directions = in.getAll<Direction>();
    std::vector<PairCounts> blocks;
    if (!directions.empty()) blocks = engine.countBlocks(directions, block_directions);
    MessageWriter out;
    out.put(uint64_t(blocks.size()));
    for (const PairCounts& block : blocks) out.putAll(block);
    return out.take();
  }

  std::string answerRows(RankWork work, MessageReader& in) {
    if (work == RankWork::open_rows) {
      rows_ = openRows(in, ranks_);
    } else if (!rows_) {
      throw Error(ErrorCode::limit, "rank 0 asked for rows that were not opened");
    } else if (work == RankWork::count_rows) {
      Engine& engine = *engines_.at(in.get<uint64_t>()).engine;
      const std::vector<Direction> directions = in.getAll<Direction>();
      rows_->take(directions.empty() ? PairCounts{} : engine.count(directions));
    } else {
      return answerOfRows(*rows_, work, in);
    }
    return {};
  }

  const Device* device() {
    if (!device_) device_.emplace(request_.device);
    return &*device_;
  }

  Ranks& ranks_;
  const Scene& scene_;
  const Request& request_;
  std::thread::id thread_ = std::this_thread::get_id();
  std::atomic<bool> is_stopped_ = false;
  std::optional<Device> device_;
  std::map<uint64_t, Open> engines_;  // by the numbers that rank 0 gave them
  std::unique_ptr<RowBlocks> rows_;
  LineServer lines_;
  ProductServer products_;
};

}  // namespace

void serveRanks(Ranks& ranks, const Scene& scene, const Request& request) {
  Serving serving(ranks, scene, request);
  answerAll(ranks, [&](RankWork work, MessageReader& in) { return serving.answer(work, in); });
}

void serveRanks(Ranks& ranks, const Error& failure) {
  answerAll(ranks, [&](RankWork, MessageReader&) -> std::string { throw failure; });
}

}  // namespace viewpeel
