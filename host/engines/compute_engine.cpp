// Engine `compute` plans batches of directions and keeps two in flight where memory allows. A batch is one submission
// of the passes in record_passes.h. Where lists, fragments or the hash table overflow, the batch's status says so. The
// engine then makes room and repeats the batch, or counts everything again with smaller batches.
#include "engines/compute_engine.h"

#include <algorithm>

#include <fmt/format.h>

#include "engines/batch_plan.h"
#include "engines/lattice.h"
#include "engines/pair_counters.h"
#include "engines/record_passes.h"
#include "engines/shared.h"
#include "engines/tuning.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using namespace device_data;

constexpr uint32_t kFragmentCapacity = 8;  // fragments of a lattice point in the first batches

class ComputeEngine : public Engine {
 public:
  ComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options);
  ~ComputeEngine() override;
  PairCounts count(std::span<const Direction> directions) override;
  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override;
  double unitArea() const override { return pointArea(options_.resolution) / double(1 << settings_.column_bits); }
  const Work* work() const override { return options_.measure_work ? &work_ : nullptr; }
  std::string describePlan() const override;

 private:
  void rebuild();
  void makeBatches();
  void shrink(const Error& error);
  void retune(const BatchStatus& found);
  void countInto(std::span<const Direction> directions, size_t block_directions);
  void startCounters(uint32_t blocks);
  bool countAll(std::span<const Direction> directions);
  void submit(Batch& batch);
  BatchStatus waitFor(Batch& batch);
  bool finish(Batch& batch);
  bool makeRoom(Batch& batch, const BatchStatus& found);
  bool isSound(const BatchStatus& found);
  BatchStatus peelUnfinished(Batch& batch, BatchStatus found);
  void addWork(const Batch& batch, const BatchStatus& found);
  uint64_t sceneBytes() const { return scene_.polygons.sizeBytes() + scene_.corners.sizeBytes(); }
  uint64_t memoryBytes() const;

  const Device& device_;
  LatticeOptions options_;
  Tuning tuning_;
  SceneBuffers scene_;
  PairCounters counters_;
  PassSettings settings_;
  PassKernels kernels_;
  BatchPlan plan_;
  uint32_t fragment_capacity_;  // most fragments of a lattice point, in batches that are planned next
  std::vector<Batch> batches_;
  Commands commands_;              // commands for work on the counters, between batches
  bool must_grow_ = false;         // the hash table has to be enlarged before counting goes on
  bool must_refit_ = false;        // batches have to be planned again: for more fragments, or with less memory
  bool tuned_ = false;             // whether the first batch's figures have been used to choose the tuning
  uint64_t counted_ = 0;           // directions that this call has counted
  uint64_t block_directions_ = 1;  // directions of each block with counters of its own
  BatchStatus first_found_{};      // status of the first batch
  Work work_;
};

ComputeEngine::ComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : device_(device),
      options_(options),
      tuning_(tune(device, options)),
      scene_(device, scene, ids),
      counters_(device, ids.count(), options.count_blocked, counterBudget(options), true, options.table_capacity),
      settings_{options_,
                tuning_,
                scene_,
                counters_,
                IdRules(ids),
                chooseFractionBits(options.resolution, options.window),
                options.sampling == Sampling::scanline ? kScanlineBits : 0},
      fragment_capacity_(options.fragment_capacity ? options.fragment_capacity : kFragmentCapacity),
      commands_(device) {
  if (settings_.fraction_bits < settings_.column_bits)
    throw Error(ErrorCode::bad_usage, "scanlines cannot be this fine; use --sampling lattice");
  if (ids.count() > kIdMask)
    throw Error(ErrorCode::limit, fmt::format("{} polygons are more than {}; try --by surface", ids.count(), kIdMask));
  if (!options_.few_points) options_.few_points = chooseFewPoints(scene, options.resolution);
  rebuild();
}

// Waits for the device, because after an error a batch may still use the buffers that are freed here.
ComputeEngine::~ComputeEngine() {
  for (Batch& batch : batches_)
    if (batch.in_flight) vkDeviceWaitIdle(device_.handle());
}

void ComputeEngine::rebuild() {
  do {
    batches_.clear();  // frees their memory for the new ones
    must_refit_ = false;
    plan_ = planBatches(
        device_, options_, tuning_,
        {scene_.polygon_count, settings_.ids.all_count, fragment_capacity_, counters_.sizeBytes() + sceneBytes()});
    kernels_ = makeKernels(device_, settings_, plan_.shape);
    try {
      makeBatches();
    } catch (const Error& error) {
      shrink(error);
    }
  } while (must_refit_);
}

void ComputeEngine::makeBatches() {
  for (uint32_t k = 0; k < plan_.in_flight; ++k) {
    Batch batch{.commands = Commands(device_), .shape = plan_.shape};
    if (options_.measure_work) batch.timestamps = Timestamps(device_, kMostPasses + 1);
    fitBuffers(device_, batch.shape, batch.buffers);
    batches_.push_back(std::move(batch));
  }
}

// Makes the next batches smaller, after the device had no memory for these or lists were too long.
//   In: error: what was thrown    Throws: the same error where its code is not memory; Error memory where batches
//     cannot be smaller.
void ComputeEngine::shrink(const Error& error) {
  if (error.code() != ErrorCode::memory) throw error;
  must_refit_ = true;
  if (!planSmaller(plan_, options_))
    throw Error(ErrorCode::memory, fmt::format("one direction at a time does not fit: {}", error.what()));
}

// Chooses the tuning that options left open by the status of the first batch, and plans batches again where it differs.
// No tuning changes a result.
void ComputeEngine::retune(const BatchStatus& found) {
  tuned_ = true;
  if (found.active_tiles == 0) return;
  const Tuning before = tuning_;
  adaptOptions(found, options_);
  tuning_ = tune(device_, options_);
  tuning_.most_blocks = before.most_blocks;
  if (tuning_.tile_rows == before.tile_rows && tuning_.sorts == before.sorts &&
      tuning_.layers_kept == before.layers_kept)
    return;
  options_.list_capacity = 0;
  rebuild();
}

PairCounts ComputeEngine::count(std::span<const Direction> directions) {
  countInto(directions, std::max<size_t>(directions.size(), 1));
  return counters_.finish(commands_);
}

std::vector<PairCounts> ComputeEngine::countBlocks(std::span<const Direction> directions, size_t block_directions) {
  const size_t at_once = counters_.mostBlocks() * block_directions;
  if (at_once == block_directions) return Engine::countBlocks(directions, block_directions);
  std::vector<PairCounts> blocks;
  for (size_t first = 0; first < directions.size(); first += at_once) {
    countInto(directions.subspan(first, std::min(at_once, directions.size() - first)), block_directions);
    std::ranges::move(counters_.finishBlocks(commands_), std::back_inserter(blocks));
  }
  return blocks;
}

// Counts all directions, each block of block_directions of them into counters of its own.
void ComputeEngine::countInto(std::span<const Direction> directions, size_t block_directions) {
  block_directions_ = block_directions;
  const uint32_t blocks = std::max(divideUp(directions.size(), block_directions), 1u);
  for (Batch& batch : batches_) {  // an earlier call that ended in an error may have left batches running
    if (batch.in_flight) batch.commands.wait();
    batch.in_flight = false;
  }
  if (must_refit_) rebuild();
  startCounters(blocks);
  const Work work_before = work_;
  while (!countAll(directions)) {
    const uint64_t repeats = work_.repeats;
    work_ = work_before;
    work_.repeats = repeats;
    if (must_refit_) rebuild();
    startCounters(blocks);
  }
}

// Makes empty counters for this many blocks, with a larger hash table where must_grow_ says so. Where the device has no
// memory for them, batches are planned smaller.
void ComputeEngine::startCounters(uint32_t blocks) {
  for (;;) {
    try {
      if (must_grow_) counters_.enlarge();
      must_grow_ = false;
      return counters_.start(commands_, blocks);
    } catch (const Error& error) {
      shrink(error);
      rebuild();
    }
  }
}

// Counts all directions, batch by batch. Returns false where counts were lost, so that everything has to be counted
// again: the hash table was too small, loops were cut, or batches have to be planned again.
bool ComputeEngine::countAll(std::span<const Direction> directions) {
  bool complete = true;
  size_t done = 0;
  counted_ = 0;
  for (uint32_t turn = 0; complete && (done < directions.size() || batches_[turn % batches_.size()].in_flight);
       ++turn) {
    Batch& batch = batches_[turn % batches_.size()];
    if (batch.in_flight) complete = finish(batch);
    if (complete && counters_.isCrowded()) {
      for (Batch& other : batches_) complete = complete && (!other.in_flight || finish(other));
      if (complete) counters_.makeRoom(commands_);
    }
    if (!complete || done == directions.size()) continue;
    batch.directions = directions.subspan(
        done, std::min<size_t>(tuned_ ? plan_.shape.directions : std::min(plan_.shape.directions, kTrialDirections),
                               directions.size() - done));
    batch.first_direction = done;
    done += batch.directions.size();
    submit(batch);
    if (tuned_) continue;
    complete = finish(batch);
    if (complete) retune(first_found_);
  }
  for (Batch& batch : batches_)
    if (batch.in_flight) complete = finish(batch) && complete;
  return complete;
}

void ComputeEngine::submit(Batch& batch) {
  writeDirections(batch.directions, options_.resolution, options_.window, batch.buffers.directions,
                  batch.first_direction, block_directions_);
  recordPasses(settings_, kernels_, batch);
  batch.commands.submit();
  batch.in_flight = true;
}

BatchStatus ComputeEngine::waitFor(Batch& batch) {
  batch.commands.wait();
  batch.in_flight = false;
  return batch.buffers.status_read.mapped<BatchStatus>()[0];
}

// Waits for a batch; where its lists or fragments overflowed, makes room and repeats it. Returns false where counts
// were lost, so that everything has to be counted again.
bool ComputeEngine::finish(Batch& batch) {
  BatchStatus found = waitFor(batch);
  while (found.active_tiles & kListsOverflowed) {
    ++work_.repeats;
    if (!must_refit_ && (found.active_tiles & kListsUncountable)) shrink(listsTooLong(device_));
    if (must_refit_ || !makeRoom(batch, found)) return false;
    submit(batch);
    found = waitFor(batch);
  }
  if (!found.overflows && found.unfinished) found = peelUnfinished(batch, found);
  if (!isSound(found)) {
    ++work_.repeats;
    return false;
  }
  if (!tuned_) first_found_ = found;
  counted_ += batch.directions.size();
  if (options_.on_batch) options_.on_batch(counted_);
  addWork(batch, found);
  counters_.notePairs(found.pairs);
  return true;
}

// Makes longer lists, or room for more fragments, for a batch that overflowed. Returns false where batches have to be
// planned again, smaller or without fragments.
bool ComputeEngine::makeRoom(Batch& batch, const BatchStatus& found) {
  if (found.most_fragments > batch.shape.fragment_capacity) {
    fragment_capacity_ = std::max(fragment_capacity_, found.most_fragments + found.most_fragments / 4);
    const uint64_t bytes =
        uint64_t(plan_.shape.directions) * plan_.shape.pointsPerDirection() * fragment_capacity_ * sizeof(uint64_t);
    must_refit_ = bytes > largestBuffer(device_) || bytes > kMemoryBudget / 4;
    batch.shape.fragment_capacity = fragment_capacity_;
  }
  if (found.list_length > batch.shape.list_capacity)
    batch.shape.list_capacity = uint64_t(found.list_length) + found.list_length / 4;
  if (must_refit_) return false;
  try {
    fitBuffers(device_, batch.shape, batch.buffers);
  } catch (const Error& error) {
    shrink(error);
  }
  return !must_refit_;
}

// Returns whether a batch has counted all its gaps. If it has not, everything has to be counted again, and this
// prepares for it: the hash table will grow, or invocations of peel go through fewer blocks of polygons.
//   Throws: Error limit or device where neither would help.
bool ComputeEngine::isSound(const BatchStatus& found) {
  if (found.overflows & kOtherSubgroups)
    throw Error(ErrorCode::device, fmt::format("{}: subgroups are not of {} as it says; use --engine graphics",
                                               device_.description().name, tuning_.subgroup_size));
  if (found.overflows & kTooManySpans)
    throw Error(ErrorCode::limit,
                fmt::format("more than {} polygons cross one row of a tile; try a larger --resolution", kMostSpans));
  must_grow_ = must_grow_ || (found.overflows & kCountersOverflowed);
  if ((found.overflows & kLoopCut) &&
      !(found.overflows & kCountersOverflowed)) {  // a full table by itself makes loops long
    if (tuning_.most_blocks < 2)
      throw Error(ErrorCode::limit,
                  "more polygons lie over one row than this device's loops can take; try --engine graphics");
    tuning_.most_blocks /= 2;
  }
  return found.overflows == 0;
}

// Dispatches peel again for unfinished tiles until there are none. Returns the last status.
BatchStatus ComputeEngine::peelUnfinished(Batch& batch, BatchStatus found) {
  while (found.unfinished && !found.overflows) {
    std::swap(batch.buffers.unfinished, batch.buffers.unfinished_next);
    std::swap(batch.buffers.reached, batch.buffers.reached_next);
    recordResume(settings_, kernels_, batch, found.unfinished);
    batch.commands.submit();
    found = waitFor(batch);
    ++work_.resumed;
  }
  return found;
}

void ComputeEngine::addWork(const Batch& batch, const BatchStatus& found) {
  if (!options_.measure_work) return;
  work_.directions += batch.directions.size();
  work_.tiles += batch.directions.size() * plan_.shape.tilesPerDirection();
  work_.active_tiles += found.active_tiles;
  work_.lattice_points +=
      tuning_.tile_width *
      (options_.sampling == Sampling::scanline ? found.rows : uint64_t(found.active_tiles) * tuning_.tile_rows);
  work_.list_entries += found.list_length;
  work_.rows += found.rows;
  work_.spans += found.spans;
  work_.samples += found.samples;
  work_.rounds += found.rounds;
  work_.tests += found.tests;
  work_.fragments += found.fragments;
  work_.gaps += found.gaps;
  work_.memory_bytes = memoryBytes();
  const std::vector<double> seconds = batch.timestamps.seconds();
  work_.pass_seconds.resize(seconds.size());
  for (size_t k = 0; k < seconds.size(); ++k)
    work_.pass_seconds[k] = {batch.pass_names[k], work_.pass_seconds[k].second + seconds[k]};
}

uint64_t ComputeEngine::memoryBytes() const {
  uint64_t bytes = counters_.sizeBytes() + sceneBytes();
  for (const Batch& batch : batches_) bytes += sizeBytes(batch.buffers);
  return bytes;
}

std::string ComputeEngine::describePlan() const {
  const auto mib = [](uint64_t bytes) { return double(bytes) / 1048576.0; };
  const auto mibOf = [&](BufferUse use) {
    uint64_t bytes = 0;
    for (const Batch& batch : batches_) bytes += sizeBytes(batch.buffers, use);
    return mib(bytes);
  };
  return fmt::format(
      "plan       {} x {} directions in flight; {} x {} tiles of {} x {}; subgroups of {}, {} layers a round{}\n"
      "memory     {:.1f} MiB on the device: {} counters {:.1f}, scene {:.1f}, projections {:.1f}, tile lists {:.1f}, "
      "fragments {:.1f}, lines to go on with {:.1f}\n",
      batches_.size(), plan_.shape.directions, plan_.shape.tiles_wide, plan_.shape.tiles_high, tuning_.tile_width,
      tuning_.tile_rows, tuning_.subgroup_size, tuning_.layers_kept, tuning_.sorts ? ", lists sorted by depth" : "",
      mib(memoryBytes()), counters_.isSparse() ? "hashed" : "dense", mib(counters_.sizeBytes()), mib(sceneBytes()),
      mibOf(BufferUse::projections), mibOf(BufferUse::lists), mibOf(BufferUse::fragments),
      mibOf(BufferUse::unfinished));
}

}  // namespace

std::unique_ptr<Engine> makeComputeEngine(const Device& device, const Scene& scene, const Ids& ids,
                                          const LatticeOptions& options) {
  return std::make_unique<ComputeEngine>(device, scene, ids, options);
}

}  // namespace viewpeel
