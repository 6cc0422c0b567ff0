// ThreadRanks are the ranks of one process, each on a thread. They exchange messages as an MPI job does, without MPI.
#pragma once
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <viewpeel/ranks.h>

namespace viewpeel::test {

class Mailbox {
 public:
  void put(uint32_t from, uint32_t to, std::string message) {
    const std::lock_guard lock(mutex_);
    messages_[{from, to}].push_back(std::move(message));
    bytes_ += messages_[{from, to}].back().size(), ++count_;
  }
  std::optional<std::string> take(uint32_t from, uint32_t to) {
    const std::lock_guard lock(mutex_);
    std::deque<std::string>& waiting = messages_[{from, to}];
    if (waiting.empty()) return std::nullopt;
    std::string message = std::move(waiting.front());
    waiting.pop_front();
    return message;
  }
  uint64_t count() const { return count_; }
  uint64_t bytes() const { return bytes_; }

 private:
  std::mutex mutex_;
  std::map<std::pair<uint32_t, uint32_t>, std::deque<std::string>> messages_;
  uint64_t count_ = 0, bytes_ = 0;
};

class ThreadRanks final : public Ranks {
 public:
  ThreadRanks(Mailbox& mailbox, uint32_t size, uint32_t rank) : mailbox_(mailbox), size_(size), rank_(rank) {}
  uint32_t size() const override { return size_; }
  uint32_t rank() const override { return rank_; }
  void send(uint32_t to, const std::string& message) override { mailbox_.put(rank_, to, message); }
  std::optional<std::string> poll(uint32_t from) override { return mailbox_.take(from, rank_); }

 private:
  Mailbox& mailbox_;
  uint32_t size_, rank_;
};

// Runs `serve` on a thread of its own for each rank above 0, and `work` as rank 0.
//   Out: the messages that were sent, and their bytes
inline std::pair<uint64_t, uint64_t> withRanks(uint32_t size, const std::function<void(Ranks& ranks)>& serve,
                                               const std::function<void(Ranks& ranks)>& work) {
  Mailbox mailbox;
  {
    std::vector<std::jthread> others;
    for (uint32_t rank = 1; rank < size; ++rank)
      others.emplace_back([&, rank] {
        ThreadRanks ranks(mailbox, size, rank);
        serve(ranks);
      });
    ThreadRanks ranks(mailbox, size, 0);
    // The threads end, whatever `work` throws.
    struct End {
      ThreadRanks& ranks;
      ~End() { endRanks(ranks); }
    } end{ranks};
    work(ranks);
  }
  return {mailbox.count(), mailbox.bytes()};
}

}  // namespace viewpeel::test
