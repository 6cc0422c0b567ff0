#include "ranks/crew.h"

#include <exception>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "interrupted.h"
#include "ranks/message.h"
#include "ranks/pause.h"
#include "stopwatch.h"

namespace viewpeel {
namespace {

constexpr double kSecondsToStop = 0.5;  // mpirun kills ranks a second after it has told them to end
constexpr double kSecondsToEnd = 10;

[[noreturn]] void rethrow(const std::string& answer, uint32_t rank) {
  MessageReader in(answer, 1);
  const auto code = in.get<ErrorCode>();
  throw Error(code, fmt::format("rank {}: {}", rank, in.getText()));
}

}  // namespace

std::string helloOf(uint64_t scene_hash) {
  return MessageWriter().put(RankWork::hello).put(scene_hash).putAll(std::string(VIEWPEEL_VERSION)).take();
}

Crew::Crew(Ranks& ranks, uint64_t scene_hash, size_t threads, std::function<void()> stop)
    : ranks_(ranks), stop_(std::move(stop)), threads_(ranks.size(), double(threads)) {
  const std::string hello = helloOf(scene_hash);
  const std::vector<std::string> answers = share([&](uint32_t) { return hello; }, [] {});
  for (uint32_t rank = 1; rank < size(); ++rank)
    threads_[rank] = double(MessageReader(answers[rank - 1]).get<uint64_t>());
}

void Crew::tell(const std::string& message) {
  for (uint32_t rank = 1; rank < size(); ++rank) ranks_.send(rank, message);
}

void Crew::stopAll() { tell(MessageWriter().put(RankWork::stop).take()); }

std::vector<std::string> Crew::share(const std::function<std::string(uint32_t)>& question,
                                     const std::function<void()>& work_here) {
  if (is_lost_) throw Interrupted{};
  for (uint32_t rank = 1; rank < size(); ++rank) ranks_.send(rank, question(rank));
  std::exception_ptr failure;
  std::optional<Clock::time_point> stopped;
  const auto attempt = [&](const auto& work) {
    if (failure) return;
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
      stopAll();
      stopped = Clock::now();
    }
  };
  attempt(work_here);
  std::vector<std::string> answers(size() - 1);
  Pause pause;
  for (uint32_t waiting = size() - 1; waiting > 0;) {
    bool has_news = false;
    for (uint32_t rank = 1; rank < size(); ++rank) {
      if (!answers[rank - 1].empty()) continue;
      std::optional<std::string> answer = ranks_.poll(rank);
      if (!answer) continue;
      has_news = true, --waiting;
      answers[rank - 1] = std::move(*answer);
      if (answers[rank - 1][0] == char(RankAnswer::failed)) attempt([&] { rethrow(answers[rank - 1], rank); });
    }
    attempt(stop_);
    if (stopped && secondsSince(*stopped) > kSecondsToStop) {
      is_lost_ = waiting > 0;
      break;
    }
    if (!has_news) pause.wait();
  }
  if (failure) std::rethrow_exception(failure);
  for (std::string& answer : answers) answer.erase(0, 1);
  return answers;
}

std::vector<size_t> Crew::cut(std::span<const double> costs, bool by_threads) const {
  double all = 0, ranks = 0, done = 0, reached = 0;
  for (const double cost : costs) all += cost;
  for (const double threads : threads_) ranks += by_threads ? threads : 1;
  std::vector<size_t> cuts{0};
  size_t at = 0;
  for (uint32_t rank = 0; rank + 1 < size(); ++rank) {
    reached += by_threads ? threads_[rank] : 1;
    // A task goes to the rank whose part of the cost holds the task's middle, so that each cut is the nearest.
    while (at < costs.size() && done + costs[at] / 2 < all * reached / ranks) done += costs[at++];
    cuts.push_back(at);
  }
  cuts.push_back(costs.size());
  return cuts;
}

bool endRanks(Ranks& ranks) {
  const std::string end = MessageWriter().put(RankWork::end).take();
  for (uint32_t rank = 1; rank < ranks.size(); ++rank) ranks.send(rank, end);
  const auto start = Clock::now();
  Pause pause;
  for (uint32_t rank = 1; rank < ranks.size();) {
    // Late answers, which rank 0 no longer awaits, may come before the answer to `end`.
    const std::optional<std::string> answer = ranks.poll(rank);
    if (answer && !answer->empty() && answer->front() == char(RankAnswer::ended)) ++rank;
    else if (secondsSince(start) > kSecondsToEnd) return false;
    else if (!answer) pause.wait();
  }
  return true;
}

}  // namespace viewpeel
