// The passes, in order, for a batch of directions:
//   enter      where all count: polygons over few lattice points enter themselves there, the others are listed
//   project    every polygon along every direction, or every listed one: snapped corners, box and depth over the lattice
//   bin        where only some polygons count: the tiles that those reach that emit, and their span in each row
//   bin        those that the others reach that receive
//   bin        count the polygons that reach each tile
//   allocate   give every tile its list, list the active tiles
//   bin        fill the lists
//   sort       where lines meet many polygons: the lists by depth
//   peel       every row of every active tile: spans of its polygons, samples, layers in order, facing rules, counters
//   cover      where blocked pairs are counted: the lattice points of every active tile that each of its polygons covers
//   meet       of every two of those that may face each other, how many they share
// A batch is one submission, and two are in flight where memory allows. What overflows says so in the batch's status: the host makes room and repeats,
// with smaller batches where the device has no memory for that.
#include "engines/compute_engine.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "engines/batch_plan.h"
#include "engines/lattice.h"
#include "engines/pair_counters.h"
#include "engines/shared.h"
#include "engines/tuning.h"
#include "error.h"
#include "shaders/allocate.comp.h"
#include "shaders/bin.comp.h"
#include "shaders/cover.comp.h"
#include "shaders/enter.comp.h"
#include "shaders/meet.comp.h"
#include "shaders/peel.comp.h"
#include "shaders/peel_blocked.comp.h"
#include "shaders/project.comp.h"
#include "shaders/sort.comp.h"
#include "vulkan/commands.h"
#include "vulkan/timestamps.h"

namespace viewpeel {
namespace {

using namespace device_data;

constexpr uint32_t kLongList = 48;            // polygons over a tile, on the average, from which on smaller tiles are faster
constexpr double kManyRounds = 1.5;           // a tile, from which on more layers are kept
constexpr uint32_t kSortedList = 16;          // polygons over such a tile, on the average, from which on lists are sorted
constexpr uint32_t kDeepList = 16;            // polygons over a tile of scanlines, on the average, from which on more layers are kept
constexpr uint32_t kFragmentCapacity = 8;     // of a lattice point at first
constexpr uint32_t kWideRow = 64;  // tiles, from which on allocate takes rows where there are spans of emitters
constexpr uint32_t kTexelBuffers = 5;
const std::array<const char*, 11> kPasses = {"enter",     "project",  "bin emitters", "bin receivers",
                                             "bin count", "allocate", "bin scatter",  "sort",
                                             "peel",      "cover",    "meet"};

// What one batch of directions is done with.
struct Batch {
  Commands commands;
  Timestamps timestamps;
  Buffer directions, listed, snapped_corners, projected, fragments, fragment_counts, tile_roles, emitter_spans,
      tile_counts, tile_starts, active_tiles, entries, lists, covers, cover_polygons, meetings;
  Buffer status, status_read;
  std::array<Buffer, 2> unfinished, reached;
  uint32_t list_capacity = 0, fragment_capacity = 0;
  std::span<const Direction> asked;
  uint64_t first = 0;  // of them, in the call
  bool in_flight = false;
};

class ComputeEngine : public Engine {
 public:
  ComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options);
  ~ComputeEngine() override;
  PairCounts count(std::span<const Direction> directions) override;
  std::vector<PairCounts> countBlocks(std::span<const Direction> directions, size_t block_directions) override;
  double unitArea() const override { return pointArea(options_.resolution) / double(1 << column_bits_); }
  const Work* work() const override { return options_.measure_work ? &work_ : nullptr; }
  std::string describePlan() const override;

 private:
  void rebuild();
  void makeKernels();
  void plan();
  void shrink(const Error& error);
  void retune(const BatchStatus& found);
  void makeBatches();
  void makeLists(Batch& batch, uint64_t capacity);
  void makeFragments(Batch& batch, uint32_t capacity);
  void countInto(std::span<const Direction> directions, size_t block_directions);
  bool countAll(std::span<const Direction> directions);
  void submit(Batch& batch);
  bool finish(Batch& batch);
  BatchStatus peelUnfinished(Batch& batch, BatchStatus found);
  void addWork(const Batch& batch, const BatchStatus& found);
  PeelArgs peelArgs(const Batch& batch) const;
  void bindTexels(Batch& batch, const Kernel& kernel, const Buffer& lists);
  uint64_t memoryBytes() const;
  bool makeRoom(Batch& batch, const BatchStatus& found);
  void startCounters(uint32_t blocks);
  uint64_t listEntryBytes() const;
  // Entries that lists of a batch can have.
  uint64_t mostListed() const { return std::min<uint64_t>(device_.properties().limits.maxTexelBufferElements, 0x7FFFFFFF); }
  Error listsTooLong() const;
  // Whether polygons enter themselves where they cover few lattice points.
  bool enters() const { return plan_.enters; }
  uint32_t pointsPerDirection() const { return tiles_wide_ * tiles_high_ * tuning_.tile_width * tuning_.tile_rows; }
  // Whether blocked pairs are counted by passes of their own.
  bool meets() const { return options_.count_blocked && options_.sampling == Sampling::lattice; }
  bool allocatesRows() const { return needed_roles_ && tiles_wide_ >= kWideRow; }
  // Of a tile: those that peel may take one by one.
  uint32_t mostParts() const { return options_.sampling == Sampling::scanline ? tuning_.tile_rows : 1; }

  const Device& device_;
  LatticeOptions options_;
  Tuning tuning_;
  bool two_sided_, all_count_, counts_environment_, ids_are_indices_;
  int fraction_bits_, column_bits_;
  SceneBuffers scene_;
  PairCounters counters_;
  uint32_t tiles_wide_ = 0, tiles_high_ = 0, needed_roles_ = 0, fragment_capacity_ = 0;
  BatchPlan plan_;
  uint64_t list_capacity_ = 0;
  Kernel enter_, project_, bin_emitters_, bin_receivers_, bin_count_, bin_scatter_, allocate_, sort_, peel_, cover_,
      meet_;
  std::vector<Batch> batches_;
  Commands commands_;       // of what is done between batches
  bool must_grow_ = false;   // the hash table
  bool must_refit_ = false;  // the batches, to more fragments or less memory
  bool tuned_ = false;
  uint64_t counted_ = 0;  // directions of this call
  uint64_t block_directions_ = 1;
  BatchStatus first_found_{};
  Work work_;
};

ComputeEngine::ComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : device_(device),
      options_(options),
      tuning_(tune(device, options)),
      two_sided_(ids.two_sided),
      all_count_(ids.roles.empty()),
      counts_environment_(ids.counts_environment),
      ids_are_indices_(ids.roles.empty() && ids.of_polygon.size() == ids.count()),
      fraction_bits_(chooseFractionBits(options.resolution, options.window)),
      column_bits_(options.sampling == Sampling::scanline ? kScanlineBits : 0),
      scene_(device, scene, ids),
      counters_(device, ids.count(), options.count_blocked, counterBudget(options), true, options.table_capacity),
      commands_(device) {
  if (fraction_bits_ < column_bits_) throw Error(ErrorCode::bad_usage, "scanlines cannot be this fine; use --sampling lattice");
  for (uint32_t k = 0; ids_are_indices_ && k < ids.of_polygon.size(); ++k) ids_are_indices_ = ids.of_polygon[k] == k;
  if (ids.count() > kIdMask) throw Error(ErrorCode::limit, fmt::format("{} polygons are more than {}; try --by surface", ids.count(), kIdMask));
  if (!all_count_) needed_roles_ = counts_environment_ ? viewpeel::kEmits : viewpeel::kEmits | viewpeel::kReceives;
  if (!options_.few_points) options_.few_points = chooseFewPoints(scene, options.resolution);
  rebuild();
}

// After an error a batch may still be running on what is about to go.
ComputeEngine::~ComputeEngine() {
  for (Batch& batch : batches_)
    if (batch.in_flight) vkDeviceWaitIdle(device_.handle());
}

void ComputeEngine::rebuild() {
  do {
    batches_.clear();  // room for the next
    must_refit_ = false;
    plan();
    makeKernels();
    try {
      makeBatches();
    } catch (const Error& error) {
      shrink(error);
    }
  } while (must_refit_);
}

// Where the device had no memory, or lists were too long: the next batches, once rebuilt, are smaller.
//   Throws: the error, where they cannot be or it was another.
void ComputeEngine::shrink(const Error& error) {
  if (error.code() != ErrorCode::memory) throw error;
  must_refit_ = true;
  if (!planSmaller(plan_, options_)) throw Error(ErrorCode::memory, fmt::format("one direction at a time does not fit: {}", error.what()));
}

void ComputeEngine::makeKernels() {
  const uint32_t scanlines = options_.sampling == Sampling::scanline, cut_bits = static_cast<uint32_t>(fraction_bits_ - column_bits_);
  if (enters()) enter_ = Kernel(device_, enter_comp, sizeof(ProjectArgs), {tuning_.tile_width, tuning_.tile_rows}, 3);
  project_ = Kernel(device_, project_comp, sizeof(ProjectArgs), {enters(), !enters(), false}, 3);
  const auto makeBin = [&](uint32_t mode) { return Kernel(device_, bin_comp, sizeof(BinArgs), {mode, needed_roles_ != 0, tuning_.sorts, tuning_.tile_width, tuning_.tile_rows, static_cast<uint32_t>(column_bits_), cut_bits}, kTexelBuffers); };
  if (needed_roles_) bin_emitters_ = makeBin(kBinEmitters);
  if (needed_roles_) bin_receivers_ = makeBin(kBinReceivers);
  bin_count_ = makeBin(kBinCount);
  bin_scatter_ = makeBin(kBinScatter);
  allocate_ = Kernel(device_, allocate_comp, sizeof(BinArgs),
                     {enters(), tuning_.tile_width, tuning_.tile_rows, scanlines, allocatesRows()});
  if (tuning_.sorts) sort_ = Kernel(device_, sort_comp, sizeof(SortArgs), {tuning_.subgroup_size}, kTexelBuffers);
  const bool meets_spans = scanlines && options_.count_blocked;
  peel_ = Kernel(device_, meets_spans ? std::span<const uint32_t>(peel_blocked_comp) : peel_comp, sizeof(PeelArgs),
                 {tuning_.subgroup_size, tuning_.layers_kept, scanlines, counters_.isSparse(), all_count_, options_.aggregate, options_.measure_work,
                  tuning_.steps, ids_are_indices_, tuning_.tile_width, tuning_.sorts, two_sided_, options_.count_blocked, enters(), tuning_.tile_rows,
                  static_cast<uint32_t>(column_bits_), cut_bits},
                 kTexelBuffers + 2);
  if (!meets()) return;
  cover_ = Kernel(device_, cover_comp, sizeof(MeetArgs), {tuning_.subgroup_size, tuning_.tile_width, all_count_, two_sided_, tuning_.tile_rows, cut_bits}, kTexelBuffers);
  meet_ = Kernel(device_, meet_comp, sizeof(MeetArgs),
                 {tuning_.subgroup_size, tuning_.tile_width, all_count_, two_sided_, counters_.isSparse(), ids_are_indices_}, kTexelBuffers + 1);
}

// Chooses the rest by what the first batch met: it changes no result.
void ComputeEngine::retune(const BatchStatus& found) {
  tuned_ = true;
  if (found.active_tiles == 0) return;
  const Tuning before = tuning_;
  const uint32_t list_length = found.list_length / found.active_tiles;
  if (options_.sampling == Sampling::scanline) {
    if (!options_.layers_kept && list_length >= kDeepList) options_.layers_kept = 6;
  } else {
    if (!options_.tile_rows && list_length >= kLongList) options_.tile_rows = 4;
    if (!options_.layers_kept && found.rounds > kManyRounds * found.active_tiles) {
      options_.sort = list_length >= kSortedList;
      options_.layers_kept = 8;
    }
  }
  tuning_ = tune(device_, options_);
  tuning_.most_blocks = before.most_blocks;
  if (tuning_.tile_rows == before.tile_rows && tuning_.sorts == before.sorts && tuning_.layers_kept == before.layers_kept) return;
  options_.list_capacity = 0;
  rebuild();
}

// The window holds its ball with the lattice's offset; a direction's tiles form a grid that is symmetric about the lattice's origin.
void ComputeEngine::plan() {
  const auto reach = static_cast<uint64_t>(windowReach(options_.resolution, options_.window));
  tiles_wide_ = 2 * divideUp(reach, tuning_.tile_width);
  tiles_high_ = 2 * divideUp(reach, tuning_.tile_rows);
  const uint64_t tiles = uint64_t(tiles_wide_) * tiles_high_, parts = tiles * mostParts();
  const uint64_t lists = 4 * uint64_t(scene_.polygon_count) + tiles;  // of a direction
  const uint64_t bytes = scene_.polygon_count * (sizeof(uint32_t) + sizeof(ProjectedPolygon) + sizeof(SnappedCorners)) + tiles * 12 + parts * sizeof(ActiveTile) +
                         parts * 2 * (sizeof(UnfinishedTile) + sizeof(uint64_t) * tuning_.subgroup_size * tuning_.steps) + lists * listEntryBytes() + (meets() ? tiles * sizeof(Meeting) : 0);
  const uint64_t largest = std::max<uint64_t>(scene_.polygon_count * sizeof(ProjectedPolygon), lists * (meets() ? sizeof(Cover) : 2 * sizeof(uint32_t)));
  fragment_capacity_ = std::max(fragment_capacity_, options_.fragment_capacity ? options_.fragment_capacity : kFragmentCapacity);
  const bool may_enter = *options_.few_points && options_.sampling == Sampling::lattice && all_count_ && !options_.count_blocked;
  const uint64_t fragment_bytes = may_enter ? uint64_t(pointsPerDirection()) * (sizeof(uint32_t) + fragment_capacity_ * sizeof(uint64_t)) : 0;
  plan_ = planBatches(device_, options_, {scene_.polygon_count, tiles, parts, bytes, largest, fragment_bytes},
                      counters_.sizeBytes() + scene_.polygons.sizeBytes() + scene_.corners.sizeBytes());
  list_capacity_ = options_.list_capacity ? options_.list_capacity : plan_.directions * lists;
}

void ComputeEngine::makeBatches() {
  const uint64_t tiles = uint64_t(plan_.directions) * tiles_wide_ * tiles_high_, parts = tiles * mostParts();
  const auto texels = VK_FORMAT_R32G32B32A32_UINT;
  for (uint32_t k = 0; k < plan_.in_flight; ++k) {
    Batch batch{Commands(device_)};
    if (options_.measure_work) batch.timestamps = Timestamps(device_, kPasses.size() + 1);
    batch.directions = Buffer(device_, plan_.directions * sizeof(DirectionData), MemoryUse::upload, texels);
    batch.listed = Buffer(device_, uint64_t(plan_.directions) * scene_.polygon_count * sizeof(uint32_t), MemoryUse::device);
    batch.snapped_corners = Buffer(device_, uint64_t(plan_.directions) * scene_.polygon_count * sizeof(SnappedCorners), MemoryUse::device, texels);
    batch.projected = Buffer(device_, uint64_t(plan_.directions) * scene_.polygon_count * sizeof(ProjectedPolygon), MemoryUse::device, texels);
    batch.tile_roles = Buffer(device_, needed_roles_ ? tiles * sizeof(uint32_t) : 0, MemoryUse::device);
    batch.emitter_spans =
        Buffer(device_, needed_roles_ ? uint64_t(plan_.directions) * tiles_high_ * 2 * sizeof(uint32_t) : 0,
               MemoryUse::device);
    batch.tile_counts = Buffer(device_, tiles * sizeof(uint32_t), MemoryUse::device);
    batch.tile_starts = Buffer(device_, tiles * sizeof(uint32_t), MemoryUse::device);
    batch.active_tiles = Buffer(device_, parts * sizeof(ActiveTile), MemoryUse::device, texels);
    for (Buffer& unfinished : batch.unfinished) unfinished = Buffer(device_, parts * sizeof(UnfinishedTile), MemoryUse::device);
    for (Buffer& reached : batch.reached) reached = Buffer(device_, parts * tuning_.subgroup_size * tuning_.steps * sizeof(uint64_t), MemoryUse::device);
    batch.status = Buffer(device_, sizeof(BatchStatus), MemoryUse::device);
    batch.status_read = Buffer(device_, sizeof(BatchStatus), MemoryUse::readback);
    makeLists(batch, list_capacity_);
    if (enters()) {
      batch.fragment_counts = Buffer(device_, uint64_t(plan_.directions) * pointsPerDirection() * sizeof(uint32_t), MemoryUse::device, VK_FORMAT_R32_UINT);
      makeFragments(batch, fragment_capacity_);
    }
    batches_.push_back(std::move(batch));
  }
}

// Smaller batches have shorter ones: as where memory is short.
Error ComputeEngine::listsTooLong() const {
  return Error(ErrorCode::memory, fmt::format("polygons reach more than {} tiles, which is as many as {} can address; try a smaller --resolution", mostListed(), device_.description().name));
}

void ComputeEngine::makeLists(Batch& batch, uint64_t capacity) {
  if (capacity > mostListed()) throw listsTooLong();
  for (Buffer* buffer : {&batch.lists, &batch.entries, &batch.covers, &batch.cover_polygons, &batch.meetings}) *buffer = Buffer();  // room for the next
  batch.list_capacity = static_cast<uint32_t>(capacity);
  if (tuning_.sorts) batch.entries = Buffer(device_, capacity * sizeof(ListEntry), MemoryUse::device, VK_FORMAT_R32G32_UINT);
  batch.lists = Buffer(device_, capacity * sizeof(uint32_t), MemoryUse::device, VK_FORMAT_R32_UINT);
  if (!meets()) return;
  batch.covers = Buffer(device_, capacity * sizeof(Cover), MemoryUse::device, VK_FORMAT_R32G32B32A32_UINT);
  batch.cover_polygons = Buffer(device_, capacity * sizeof(uint32_t), MemoryUse::device, VK_FORMAT_R32_UINT);
  // Every tile has as many as subgroups hold its polygons, the last not full.
  const uint64_t meetings = uint64_t(plan_.directions) * tiles_wide_ * tiles_high_ + capacity / tuning_.subgroup_size;
  batch.meetings = Buffer(device_, meetings * sizeof(Meeting), MemoryUse::device);
}

void ComputeEngine::makeFragments(Batch& batch, uint32_t capacity) {
  batch.fragments = Buffer();
  batch.fragment_capacity = capacity;
  batch.fragments = Buffer(device_, uint64_t(plan_.directions) * pointsPerDirection() * capacity * sizeof(uint64_t), MemoryUse::device, VK_FORMAT_R32G32_UINT);
}

// False where that takes smaller batches, or lists instead of fragments.
bool ComputeEngine::makeRoom(Batch& batch, const BatchStatus& found) {
  try {
    if (found.most_fragments > batch.fragment_capacity) {
      fragment_capacity_ = std::max(fragment_capacity_, found.most_fragments + found.most_fragments / 4);
      const uint64_t bytes = uint64_t(plan_.directions) * pointsPerDirection() * fragment_capacity_ * sizeof(uint64_t);
      must_refit_ = bytes > largestBuffer(device_) || bytes > kMemoryBudget / 4;
      if (!must_refit_) makeFragments(batch, fragment_capacity_);
    }
    if (!must_refit_ && found.list_length > batch.list_capacity) makeLists(batch, uint64_t(found.list_length) + found.list_length / 4);
  } catch (const Error& error) {
    shrink(error);
  }
  return !must_refit_;
}

// Empty and as large as they have to be, before batches where memory is short.
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

uint64_t ComputeEngine::listEntryBytes() const {
  const uint64_t sorted = tuning_.sorts ? sizeof(ListEntry) : 0;
  return sizeof(uint32_t) + sorted + (meets() ? sizeof(Cover) + sizeof(uint32_t) + sizeof(Meeting) / tuning_.subgroup_size : 0);
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

// Counts every block into counters of its own.
void ComputeEngine::countInto(std::span<const Direction> directions, size_t block_directions) {
  block_directions_ = block_directions;
  const uint32_t blocks = std::max(divideUp(directions.size(), block_directions), 1u);
  for (Batch& batch : batches_) {  // what a call that ended in an error left running
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

// False where what was counted is lost, because the hash table or peel's work had to be given more room.
bool ComputeEngine::countAll(std::span<const Direction> directions) {
  bool complete = true;
  size_t done = 0;
  counted_ = 0;
  for (uint32_t turn = 0; complete && (done < directions.size() || batches_[turn % batches_.size()].in_flight); ++turn) {
    Batch& batch = batches_[turn % batches_.size()];
    if (batch.in_flight) complete = finish(batch);
    if (complete && counters_.isCrowded()) {
      for (Batch& other : batches_) complete = complete && (!other.in_flight || finish(other));
      if (complete) counters_.makeRoom(commands_);
    }
    if (!complete || done == directions.size()) continue;
    batch.asked = directions.subspan(done, std::min<size_t>(tuned_ ? plan_.directions : std::min(plan_.directions, kTrialDirections), directions.size() - done));
    batch.first = done;
    done += batch.asked.size();
    submit(batch);
    if (tuned_) continue;
    complete = finish(batch);
    if (complete) retune(first_found_);
  }
  for (Batch& batch : batches_)
    if (batch.in_flight) complete = finish(batch) && complete;
  return complete;
}

void ComputeEngine::bindTexels(Batch& batch, const Kernel& kernel, const Buffer& lists) {
  std::vector<VkBufferView> views = {batch.snapped_corners.texels(), batch.projected.texels(), scene_.polygons.texels(), lists.texels(), batch.active_tiles.texels()};
  if (&kernel == &peel_)  // without fragments it reads none
    for (const Buffer* buffer : {&batch.fragments, &batch.fragment_counts}) views.push_back((enters() ? buffer : &batch.snapped_corners)->texels());
  batch.commands.bindTexels(kernel, views);
}

PeelArgs ComputeEngine::peelArgs(const Batch& batch) const {
  return {batch.unfinished[1].address(), batch.reached[1].address(), batch.unfinished[0].address(), batch.reached[0].address(), batch.status.address(),
          counters_.address(), scene_.polygon_count, counters_.idCount(), counters_.mask(),
          counts_environment_ ? 1u : 0u, tuning_.most_blocks, static_cast<uint32_t>(batch.asked.size()) * pointsPerDirection(), 0, counters_.blockBytes()};
}

void ComputeEngine::submit(Batch& batch) {
  const auto direction_count = static_cast<uint32_t>(batch.asked.size());
  const uint32_t tile_count = direction_count * tiles_wide_ * tiles_high_;
  Commands& commands = batch.commands;
  writeDirections(batch.asked, options_.resolution, options_.window, batch.directions, batch.first, block_directions_);

  commands.begin();
  batch.timestamps.reset(commands.handle());
  const auto endPass = [&] {
    commands.barrier();
    batch.timestamps.mark(commands.handle());
  };
  const uint32_t rows_per_invocation = std::max(1u, kMostTilesPerInvocation / tiles_wide_);
  BatchStatus none{};
  none.project_groups = {0, 1, 1};
  none.bin_groups = {0, 1, divideUp(tiles_high_, rows_per_invocation)};
  none.peel_groups = {0, 1, 1};
  vkCmdUpdateBuffer(commands.handle(), batch.status.handle(), 0, sizeof none, &none);
  commands.fill(batch.tile_counts, 0, tile_count * sizeof(uint32_t));
  if (enters()) commands.fill(batch.fragment_counts, 0, direction_count * pointsPerDirection() * sizeof(uint32_t));
  if (needed_roles_) commands.fill(batch.tile_roles, 0, tile_count * sizeof(uint32_t));
  if (needed_roles_) commands.fill(batch.emitter_spans, 0, direction_count * tiles_high_ * 2 * sizeof(uint32_t));
  endPass();
  const ProjectArgs project{batch.snapped_corners.address(),
                            batch.projected.address(), 0, scene_.polygon_count, direction_count, options_.resolution,
                            fraction_bits_, column_bits_, 0, windowReach(options_.resolution, options_.window), batch.listed.address(), batch.status.address(),
                            batch.fragments.address(), batch.fragment_counts.address(), batch.fragment_capacity, direction_count * pointsPerDirection(), *options_.few_points,
                            tiles_wide_, tiles_high_};
  const uint32_t polygon_groups = divideUp(scene_.polygon_count, kGroupSize);
  const std::array scene_texels{batch.directions.texels(), scene_.polygons.texels(), scene_.corners.texels()};
  if (enters()) {
    commands.bindTexels(enter_, scene_texels);
    commands.dispatch(enter_, project, polygon_groups, direction_count);
  }
  endPass();
  commands.bindTexels(project_, scene_texels);
  if (enters()) commands.dispatchIndirect(project_, project, batch.status, offsetof(BatchStatus, project_groups));
  else commands.dispatch(project_, project, polygon_groups, direction_count);
  endPass();

  const BinArgs bin{batch.tile_roles.address(),
                    batch.emitter_spans.address(),
                    batch.tile_counts.address(),
                    batch.tile_starts.address(),
                    (tuning_.sorts ? batch.entries : batch.lists).address(),
                    batch.active_tiles.address(),
                    batch.directions.address(),
                    batch.status.address(),
                    batch.listed.address(),
                    batch.fragment_counts.address(),
                    batch.fragment_capacity,
                    scene_.polygon_count,
                    tiles_wide_,
                    tiles_high_,
                    tile_count,
                    batch.list_capacity,
                    rows_per_invocation,
                    needed_roles_};
  const auto runBin = [&](const Kernel& kernel) {
    commands.bind(kernel, VK_PIPELINE_BIND_POINT_COMPUTE);
    bindTexels(batch, kernel, batch.lists);
    commands.dispatchIndirect(kernel, bin, batch.status, offsetof(BatchStatus, bin_groups));
    endPass();
  };
  for (const Kernel* roles : {&bin_emitters_, &bin_receivers_})
    if (needed_roles_) runBin(*roles);
    else endPass();
  runBin(bin_count_);
  commands.dispatch(allocate_, bin, allocatesRows() ? direction_count * tiles_high_ : divideUp(tile_count, kGroupSize),
                    1);
  endPass();
  runBin(bin_scatter_);

  if (tuning_.sorts) {
    const SortArgs sort{batch.lists.address(), batch.active_tiles.address(), batch.status.address()};
    commands.bind(sort_, VK_PIPELINE_BIND_POINT_COMPUTE);
    bindTexels(batch, sort_, batch.entries);
    commands.dispatchIndirect(sort_, sort, batch.status, offsetof(BatchStatus, peel_groups));
  }
  endPass();
  commands.bind(peel_, VK_PIPELINE_BIND_POINT_COMPUTE);
  bindTexels(batch, peel_, batch.lists);
  commands.dispatchIndirect(peel_, peelArgs(batch), batch.status, offsetof(BatchStatus, peel_groups));
  endPass();
  if (meets()) {
    const MeetArgs meet{batch.covers.address(), batch.cover_polygons.address(), batch.meetings.address(), batch.status.address(), counters_.address(),
                        scene_.polygon_count, counters_.idCount(), counters_.mask(), counters_.blockBytes()};
    commands.bind(cover_, VK_PIPELINE_BIND_POINT_COMPUTE);
    bindTexels(batch, cover_, batch.lists);
    commands.dispatchIndirect(cover_, meet, batch.status, offsetof(BatchStatus, peel_groups));
    endPass();
    commands.bind(meet_, VK_PIPELINE_BIND_POINT_COMPUTE);
    commands.bindTexels(meet_, std::array{batch.snapped_corners.texels(), batch.projected.texels(), scene_.polygons.texels(), batch.cover_polygons.texels(),
                                          batch.active_tiles.texels(), batch.covers.texels()});
    commands.dispatchIndirect(meet_, meet, batch.status, offsetof(BatchStatus, meet_groups));
    endPass();
  }
  commands.copy(batch.status, batch.status_read, sizeof(BatchStatus));
  commands.submit();
  batch.in_flight = true;
}

// Waits, makes room where the batch lacked it and does it again. False where the counters have lost something.
bool ComputeEngine::finish(Batch& batch) {
  batch.commands.wait();
  batch.in_flight = false;
  BatchStatus found = batch.status_read.mapped<BatchStatus>()[0];
  while (found.active_tiles & kListsOverflowed) {
    ++work_.repeats;
    if (!must_refit_ && (found.active_tiles & kListsUncountable)) shrink(listsTooLong());
    if (must_refit_ || !makeRoom(batch, found)) return false;
    submit(batch);
    batch.commands.wait();
    batch.in_flight = false;
    found = batch.status_read.mapped<BatchStatus>()[0];
  }
  if (found.overflows & kOtherSubgroups)
    throw Error(ErrorCode::device, fmt::format("{}: subgroups are not of {} as it says; use --engine graphics", device_.description().name, tuning_.subgroup_size));
  if (found.overflows & kTooManySpans)
    throw Error(ErrorCode::limit, fmt::format("more than {} polygons cross one row of a tile; try a larger --resolution", kMostSpans));
  if (!found.overflows && found.unfinished) found = peelUnfinished(batch, found);
  must_grow_ = must_grow_ || (found.overflows & kCountersOverflowed);
  if ((found.overflows & kLoopCut) && !(found.overflows & kCountersOverflowed)) {  // a full table alone makes loops long
    if (tuning_.most_blocks < 2) throw Error(ErrorCode::limit, "more polygons lie over one row than this device's loops can take; try --engine graphics");
    tuning_.most_blocks /= 2;
  }
  if (found.overflows) {
    ++work_.repeats;
    return false;
  }
  if (!tuned_) first_found_ = found;
  counted_ += batch.asked.size();
  if (options_.on_batch) options_.on_batch(counted_);
  addWork(batch, found);
  counters_.notePairs(found.pairs);
  return true;
}

// Rows whose layers one invocation could not get through go on where they had got to.
BatchStatus ComputeEngine::peelUnfinished(Batch& batch, BatchStatus found) {
  Commands& commands = batch.commands;
  for (uint32_t from = 0; found.unfinished && !found.overflows; from = 1 - from) {
    PeelArgs peel = peelArgs(batch);
    peel.tiles = batch.unfinished[from].address();
    peel.reached = batch.reached[from].address();
    peel.reached_next = batch.reached[1 - from].address();
    peel.unfinished = batch.unfinished[1 - from].address();
    peel.resumes = found.unfinished;
    const uint32_t none = 0;
    commands.begin();
    vkCmdUpdateBuffer(commands.handle(), batch.status.handle(), offsetof(BatchStatus, unfinished), sizeof none, &none);
    commands.barrier();
    commands.bind(peel_, VK_PIPELINE_BIND_POINT_COMPUTE);
    bindTexels(batch, peel_, batch.lists);
    commands.dispatch(peel_, peel, std::min(found.unfinished, kGroupsPerRow), divideUp(found.unfinished, kGroupsPerRow));
    commands.barrier();
    commands.copy(batch.status, batch.status_read, sizeof(BatchStatus));
    commands.submitAndWait();
    found = batch.status_read.mapped<BatchStatus>()[0];
    ++work_.resumed;
  }
  return found;
}

void ComputeEngine::addWork(const Batch& batch, const BatchStatus& found) {
  if (!options_.measure_work) return;
  work_.directions += batch.asked.size();
  work_.tiles += batch.asked.size() * tiles_wide_ * tiles_high_;
  work_.active_tiles += found.active_tiles;
  work_.lattice_points += tuning_.tile_width * (options_.sampling == Sampling::scanline ? found.rows : uint64_t(found.active_tiles) * tuning_.tile_rows);
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
  for (size_t k = 0; k < seconds.size(); ++k) work_.pass_seconds[k] = {kPasses[k], work_.pass_seconds[k].second + seconds[k]};
}

uint64_t ComputeEngine::memoryBytes() const {
  uint64_t bytes = counters_.sizeBytes() + scene_.polygons.sizeBytes() + scene_.corners.sizeBytes();
  for (const Batch& batch : batches_) {
    for (const Buffer* buffer :
         {&batch.directions,  &batch.listed,          &batch.snapped_corners, &batch.projected,
          &batch.fragments,   &batch.fragment_counts, &batch.tile_roles,      &batch.emitter_spans,
          &batch.tile_counts, &batch.tile_starts,     &batch.active_tiles,    &batch.entries,
          &batch.lists,       &batch.covers,          &batch.cover_polygons,  &batch.meetings,
          &batch.status,      &batch.status_read,     &batch.unfinished[0],   &batch.unfinished[1],
          &batch.reached[0],  &batch.reached[1]})
      bytes += buffer->sizeBytes();
  }
  return bytes;
}

std::string ComputeEngine::describePlan() const {
  const auto mib = [](uint64_t bytes) { return double(bytes) / 1048576.0; };
  uint64_t lists = 0, projected = 0, unfinished = 0, fragments = 0;
  for (const Batch& batch : batches_) {
    fragments += batch.fragments.sizeBytes() + batch.fragment_counts.sizeBytes();
    unfinished += batch.unfinished[0].sizeBytes() + batch.unfinished[1].sizeBytes() + batch.reached[0].sizeBytes() + batch.reached[1].sizeBytes();
    for (const Buffer* buffer : {&batch.covers, &batch.cover_polygons, &batch.meetings}) lists += buffer->sizeBytes();
    lists += batch.entries.sizeBytes() + batch.lists.sizeBytes() + batch.tile_counts.sizeBytes() + batch.tile_starts.sizeBytes() + batch.active_tiles.sizeBytes();
    projected += batch.snapped_corners.sizeBytes() + batch.projected.sizeBytes();
  }
  return fmt::format(
      "plan       {} x {} directions in flight; {} x {} tiles of {} x {}; subgroups of {}, {} layers a round{}\n"
      "memory     {:.1f} MiB on the device: {} counters {:.1f}, scene {:.1f}, projections {:.1f}, tile lists {:.1f}, fragments {:.1f}, lines to go on with {:.1f}\n",
      batches_.size(), plan_.directions, tiles_wide_, tiles_high_, tuning_.tile_width, tuning_.tile_rows, tuning_.subgroup_size, tuning_.layers_kept,
      tuning_.sorts ? ", lists sorted by depth" : "", mib(memoryBytes()), counters_.isSparse() ? "hashed" : "dense", mib(counters_.sizeBytes()),
      mib(scene_.polygons.sizeBytes() + scene_.corners.sizeBytes()), mib(projected), mib(lists), mib(fragments), mib(unfinished));
}

}  // namespace

std::unique_ptr<Engine> makeComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  return std::make_unique<ComputeEngine>(device, scene, ids, options);
}

}  // namespace viewpeel
