#include "engines/host_engine.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "engines/lattice.h"
#include "engines/pair_table.h"
#include "engines/sweep.h"
#include "engines/work.h"
#include "scene/interpenetration.h"
#include <viewpeel/error.h>
#include "threads.h"

namespace viewpeel {
namespace {

// A thread's dense counters have at most this number of bytes. Larger ones are seldom in the processor's caches, and
// take long to clear.
constexpr uint64_t kDenseBudget = 16u << 20;
constexpr uint64_t kMostChunk = 64;  // directions that a thread takes at once

uint64_t memoryOfMachine() {
  return static_cast<uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

class HostEngine : public Engine {
 public:
  HostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);
  PairCounts count(std::span<const Direction> directions) override;
  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override;
  double unitArea() const override {
    return pointArea(options_.resolution) /
           (options_.sampling == Sampling::scanline ? double(1 << kScanlineBits) : 1.0);
  }
  const Work* work() const override;
  std::string describePlan() const override;

 private:
  struct Worker {
    Worker(const SweepScene& scene, const LatticeOptions& options, PairTable counters)
        : sweep(scene, options), table(std::move(counters)) {}
    Sweep sweep;
    PairTable table;
  };
  void clear();
  uint64_t memoryBytes() const;

  SweepScene scene_;
  LatticeOptions options_;
  uint32_t id_count_;
  std::optional<SharedPairs> shared_;
  std::vector<std::unique_ptr<Worker>> workers_;
  uint64_t directions_ = 0;
  bool is_clear_ = true;  // whether all counters are empty; they are not after a call that ended in an error
  mutable Work work_;
};

HostEngine::HostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : scene_(scene, ids), options_(options), id_count_(ids.count()) {
  const uint64_t available = options.available_bytes ? options.available_bytes : memoryOfMachine();
  const uint64_t sweep_bytes = Sweep(scene_, options).memoryBytes();
  const uint64_t dense_bytes = PairTable::denseBytes(id_count_, options.count_blocked);
  if (dense_bytes > (options.counter_budget_bytes ? options.counter_budget_bytes : kDenseBudget))
    shared_.emplace(id_count_, options.count_blocked, available / 2);
  // A sweep's spans grow to as much memory again as it has at first.
  const uint64_t each = 2 * sweep_bytes + (shared_ ? 0 : dense_bytes);
  if (each > available / 2)
    throw Error(ErrorCode::limit,
                fmt::format("{} polygons need {:.0f} MiB to sweep, half of the memory there is is {:.0f} MiB; try a "
                            "smaller scene, or --by surface",
                            scene.polygons.size(), double(each) / 1048576.0, double(available) / 2 / 1048576.0));
  const uint64_t threads = options.thread_count ? options.thread_count : threadCount();
  for (uint64_t k = 0; k < std::min(threads, available / 2 / each); ++k)
    workers_.push_back(std::make_unique<Worker>(
        scene_, options, shared_ ? PairTable(*shared_) : PairTable(id_count_, options.count_blocked)));
}

void HostEngine::clear() {
  if (!is_clear_) {
    for (const auto& worker : workers_) worker->table.clear();
    if (shared_) shared_->takeAll(workers_.size());
  }
  is_clear_ = false;
}

PairCounts HostEngine::count(std::span<const Direction> directions) {
  clear();
  const size_t chunk = std::clamp<size_t>(directions.size() / (8 * workers_.size()), 1, kMostChunk);
  shareOut(
      workers_.size(), directions.size(), chunk,
      [&](size_t worker, size_t k) { workers_[worker]->sweep.count(directions[k], workers_[worker]->table); },
      options_.on_batch);
  directions_ += directions.size();
  is_clear_ = true;
  if (shared_) {
    for (const auto& worker : workers_) worker->table.flush();
    return shared_->takeAll(workers_.size());
  }
  for (size_t k = 1; k < workers_.size(); ++k) workers_[k]->table.moveInto(workers_[0]->table);
  return workers_[0]->table.take();
}

// Counts each block of directions on one thread, in the dense counters of this thread.
std::vector<PairCounts> HostEngine::countBlocks(std::span<const Direction> directions, size_t block_directions) {
  if (shared_) return Engine::countBlocks(directions, block_directions);
  clear();
  std::vector<PairCounts> blocks(directions.size() / block_directions);
  const auto countBlock = [&](size_t thread, size_t k) {
    Worker& worker = *workers_[thread];
    for (const Direction& direction : directions.subspan(k * block_directions, block_directions))
      worker.sweep.count(direction, worker.table);
    blocks[k] = worker.table.take();
  };
  const auto report = [&](size_t done) {
    if (options_.on_batch) options_.on_batch(done * block_directions);
  };
  shareOut(workers_.size(), blocks.size(), 1, countBlock, report);
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
  return fmt::format("host       {} thread{}, counters {}, {:.1f} MiB\n", workers_.size(),
                     workers_.size() == 1 ? "" : "s", shared_ ? "in a hash table" : "dense, each its own",
                     double(memoryBytes()) / 1048576.0);
}

// Scanlines reach an rms error of 1e-4 in half the time of lattice points in the office (576 polygons), and take twice
// their time in a room of 9,984 polygons. This number of polygons lies between the two.
constexpr size_t kScanlinePolygons = 2400;
// With a prior, scanlines are still better in the office refined to 9,280 polygons. After the same time their rms error
// is smaller by 5 to 25 %, and their largest error is a quarter of lattice points' largest error.
constexpr size_t kScanlinePolygonsWithPrior = 10'000;
// Scanlines in windows hit a row often enough if its area is above this, in unit-ball units squared
// (estimator/plan.cpp).
constexpr double kScanlineArea = 1e-10;
constexpr int kLeastResolution = 64;

}  // namespace

Sampling chooseSampling(const Scene& scene, const Ids& ids, bool has_prior) {
  const double least_area = *std::min_element(ids.areas.begin(), ids.areas.end()) / (scene.scale * scene.scale);
  const bool are_few = scene.polygons.size() <= (has_prior ? kScanlinePolygonsWithPrior : kScanlinePolygons);
  return are_few && least_area > kScanlineArea && findInterpenetrations(scene, kCrossingDepth).empty()
             ? Sampling::scanline
             : Sampling::lattice;
}

int chooseResolution(const Scene& scene, double spacings_per_side, int finest) {
  std::vector<double> areas;
  areas.reserve(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons) areas.push_back(polygon.area);
  const auto middle = areas.begin() + static_cast<ptrdiff_t>(areas.size() / 2);
  std::nth_element(areas.begin(), middle, areas.end());
  return static_cast<int>(std::clamp<double>(2 * spacings_per_side / std::sqrt(*middle), kLeastResolution, finest));
}

std::unique_ptr<Engine> makeHostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  return std::make_unique<HostEngine>(scene, ids, options);
}

}  // namespace viewpeel
