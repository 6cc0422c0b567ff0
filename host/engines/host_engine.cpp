#include "engines/host_engine.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "engines/lattice.h"
#include "engines/sweep.h"
#include "error.h"

namespace viewpeel {
namespace {

constexpr uint64_t kDenseBudget = 64u << 20;  // of a thread: beyond it counters are seldom in the processor's caches anyway, and clearing them takes long
constexpr uint64_t kMostChunk = 64;           // directions that a thread takes at once

uint64_t memoryOfMachine() { return static_cast<uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE)); }

class HostEngine : public Engine {
 public:
  HostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);
  PairCounts count(std::span<const Direction> directions) override;
  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override;
  double unitArea() const override { return pointArea(options_.resolution) / (options_.sampling == Sampling::scanline ? double(1 << kScanlineBits) : 1.0); }
  const Work* work() const override;
  std::string describePlan() const override;

 private:
  struct Worker {
    Sweep sweep;
    PairTable table;
  };
  // Shares out `tasks` by number, `chunk` at a time, and tells of directions done, where tasks have any.
  void shareOut(size_t tasks, size_t chunk, const std::function<void(Worker&, size_t)>& doTask, size_t directions_each = 0);
  void clear();
  PairCounts takeShared();
  uint64_t memoryBytes() const;

  SweepScene scene_;
  LatticeOptions options_;
  uint32_t id_count_;
  std::optional<SharedPairs> shared_;
  std::vector<std::unique_ptr<Worker>> workers_;
  uint64_t directions_ = 0;
  bool is_clear_ = true;  // nothing is left of a call that ended in an error
  mutable Work work_;
};

HostEngine::HostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options) : scene_(scene, ids), options_(options), id_count_(ids.count()) {
  const uint64_t available = options.available_bytes ? options.available_bytes : memoryOfMachine();
  const uint64_t sweep_bytes = Sweep(scene_, options).memoryBytes();
  const uint64_t dense_bytes = PairTable::denseBytes(id_count_, options.count_blocked);
  if (dense_bytes > (options.counter_budget_bytes ? options.counter_budget_bytes : kDenseBudget)) shared_.emplace(id_count_, options.count_blocked, available / 2);
  // Spans take up to as much again.
  const uint64_t each = 2 * sweep_bytes + (shared_ ? 0 : dense_bytes);
  if (each > available / 2)
    throw Error(ErrorCode::limit, fmt::format("{} polygons need {:.0f} MiB to sweep, half of the memory there is is {:.0f} MiB; try a smaller scene, or --by surface", scene.polygons.size(),
                                              double(each) / 1048576.0, double(available / 2) / 1048576.0));
  const uint64_t threads = options.thread_count ? options.thread_count : std::max(1u, std::thread::hardware_concurrency());
  for (uint64_t k = 0; k < std::min(threads, available / 2 / each); ++k)
    workers_.push_back(std::make_unique<Worker>(Sweep(scene_, options), shared_ ? PairTable(*shared_) : PairTable(id_count_, options.count_blocked)));
}

void HostEngine::shareOut(size_t tasks, size_t chunk, const std::function<void(Worker&, size_t)>& doTask, size_t directions_each) {
  const bool tells = options_.on_batch && directions_each;
  std::atomic<size_t> next = 0, done = 0;
  std::atomic<bool> stopped = false;
  std::exception_ptr failure;
  std::mutex failing;
  const auto fail = [&] {
    const std::lock_guard lock(failing);
    if (!failure) failure = std::current_exception();
    stopped = true;
  };
  const auto work = [&](Worker& worker) {
    try {
      for (size_t first = next.fetch_add(chunk); first < tasks && !stopped; first = next.fetch_add(chunk)) {
        const size_t end = std::min(first + chunk, tasks);
        for (size_t k = first; k < end && !stopped; ++k) doTask(worker, k);
        done += end - first;
        if (tells && &worker == workers_[0].get()) options_.on_batch(done * directions_each);
      }
    } catch (...) {
      fail();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (size_t k = 1; k < std::min(workers_.size(), (tasks + chunk - 1) / chunk); ++k) threads.emplace_back([&, k] { work(*workers_[k]); });
    work(*workers_[0]);
  }
  if (failure) std::rethrow_exception(failure);
  if (tells) options_.on_batch(tasks * directions_each);
}

void HostEngine::clear() {
  if (!is_clear_) {
    for (const auto& worker : workers_) worker->table.clear();
    for (uint32_t part = 0; shared_ && part < SharedPairs::kParts; ++part) shared_->take(part);
  }
  is_clear_ = false;
}

PairCounts HostEngine::count(std::span<const Direction> directions) {
  clear();
  const size_t chunk = std::clamp<size_t>(directions.size() / (8 * workers_.size()), 1, kMostChunk);
  shareOut(directions.size(), chunk, [&](Worker& worker, size_t k) { worker.sweep.count(directions[k], worker.table); }, 1);
  directions_ += directions.size();
  is_clear_ = true;
  if (shared_) {
    for (const auto& worker : workers_) worker->table.flush();
    return takeShared();
  }
  for (size_t k = 1; k < workers_.size(); ++k) workers_[k]->table.moveInto(workers_[0]->table);
  return workers_[0]->table.take();
}

PairCounts HostEngine::takeShared() {
  std::vector<PairCounts> parts(SharedPairs::kParts);
  shareOut(parts.size(), 1, [&](Worker&, size_t part) { parts[part] = shared_->take(static_cast<uint32_t>(part)); });
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

// Every block by one thread, in dense counters of its own.
std::vector<PairCounts> HostEngine::countBlocks(std::span<const Direction> directions, size_t block_directions) {
  if (shared_) return Engine::countBlocks(directions, block_directions);
  clear();
  std::vector<PairCounts> blocks(directions.size() / block_directions);
  const auto countBlock = [&](Worker& worker, size_t k) {
    for (const Direction& direction : directions.subspan(k * block_directions, block_directions)) worker.sweep.count(direction, worker.table);
    blocks[k] = worker.table.take();
  };
  shareOut(blocks.size(), 1, countBlock, block_directions);
  directions_ += directions.size();
  is_clear_ = true;
  return blocks;
}

uint64_t HostEngine::memoryBytes() const {
  uint64_t bytes = shared_ ? shared_->sizeBytes() : 0;
  for (const auto& worker : workers_) bytes += worker->sweep.memoryBytes() + worker->table.sizeBytes();
  return bytes;
}

const Work* HostEngine::work() const {
  if (!options_.measure_work) return nullptr;
  work_ = {};
  for (const auto& worker : workers_) addWork(worker->sweep.work(), work_);
  work_.directions = directions_;
  work_.memory_bytes = memoryBytes();
  return &work_;
}

std::string HostEngine::describePlan() const {
  return fmt::format("host       {} thread{}, counters {}, {:.1f} MiB\n", workers_.size(), workers_.size() == 1 ? "" : "s", shared_ ? "in a hash table" : "dense, each its own",
                     double(memoryBytes()) / 1048576.0);
}

}  // namespace

std::unique_ptr<Engine> makeHostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options) { return std::make_unique<HostEngine>(scene, ids, options); }

}  // namespace viewpeel
