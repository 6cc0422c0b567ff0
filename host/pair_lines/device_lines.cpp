#include "pair_lines/device_lines.h"

#include <algorithm>
#include <utility>

#include "pair_lines/shared.h"
#include "pair_lines/sobol_points.h"
#include "shaders/pair_lines_draw.comp.h"
#include "shaders/pair_lines_place.comp.h"
#include "shaders/pair_lines_prepare.comp.h"
#include <viewpeel/error.h>
#include "vulkan/commands.h"

namespace viewpeel {
namespace {

using namespace pair_lines_data;

constexpr uint64_t kMostTests = 1 << 26, kMostTestsInSoftware = 1 << 21;
constexpr uint64_t kLeastBatchBytes = 1 << 16;
constexpr size_t kTriedTasks = 48;

static_assert(uint32_t(LineWay::points) == kByPoints && uint32_t(LineWay::angles) == kByAngles &&
              uint32_t(LineWay::contact) == kByContact);
static_assert(uint32_t(BlockerPlace::between) == kBetween && uint32_t(BlockerPlace::over_first) == kOverFirst &&
              uint32_t(BlockerPlace::over_second) == kOverSecond);
static_assert(kMostBlockerCorners == kMostObstacleEdges);

PatchData dataOf(const Patch& patch) {
  PatchData data{};
  for (uint32_t k = 0; k < 4; ++k) {
    data.corners[k] = patch.corners[k];
    data.edge_normals[k] = patch.edge_normals[k];
    data.edge_offsets[k] = patch.edge_offsets[k];
  }
  data.normal = patch.normal, data.offset = patch.offset, data.middle = patch.middle;
  data.across = acrossOf(patch);
  data.corner_count = patch.corner_count;
  return data;
}

BlockerData dataOf(const Blocker& blocker) {
  BlockerData data{};
  data.normal = blocker.normal, data.offset = blocker.offset;
  for (uint32_t k = 0; k < kMostBlockerCorners; ++k) {
    data.edge_normals[k] = blocker.edge_normals[k];
    data.edge_offsets[k] = blocker.edge_offsets[k];
  }
  data.corner_count = blocker.corner_count;
  return data;
}

constexpr uint32_t groupsFor(size_t invocations, uint32_t of_group) {
  return static_cast<uint32_t>((invocations + of_group - 1) / of_group);
}

// A Place says which task comes next, and at which of its blocks the next portion begins.
struct Place {
  size_t task = 0;
  uint32_t block = 0;  // counted from the task's first block
};

// A Batch holds portions of consecutive tasks. The portions of one task may be in several batches.
struct Batch {
  std::vector<LineTaskData> tasks;
  std::vector<LinePortionData> portions;
  std::vector<PlacedData> placed;
  size_t first_task = 0;

  uint64_t bytes() const {
    return tasks.size() * (sizeof(LineTaskData) + sizeof(LinePairData)) +
           placed.size() * (sizeof(PlacedData) + sizeof(ObstacleData)) +
           portions.size() * (sizeof(LinePortionData) + sizeof(LinePortionSums));
  }
};

// A Slot holds the buffers of one batch in flight. They grow as batches need.
struct Slot {
  explicit Slot(const Device& device) : commands(device) {}

  Commands commands;
  Buffer tasks_written, portions_written, placed_written, tasks, portions, placed, pairs, obstacles, sums, sums_read;
  Batch batch;
  bool is_busy = false;
};

}  // namespace

DrawnLines drawOnHost(const LineTask& task, std::span<const Patch> patches, const std::vector<Blocker>& blockers,
                      Vectors vectors) {
  const LineDrawer drawer(patches[task.a], patches[task.b], task.way, task.exchange, blockers, task.between);
  return drawer.draw(task.scrambles, task.first, task.end, vectors);
}

struct DeviceLines::State {
  State(const Device& device, std::span<const Patch> patches, std::span<const Blocker> blockers,
        const DeviceLinesOptions& options);
  template <class T>
  Buffer uploaded(const std::vector<T>& values);
  void fill(Batch& batch, std::span<const LineTask> tasks, Place& next) const;
  void addTask(Batch& batch, const LineTask& task) const;
  void fit(Slot& slot) const;
  void submit(Slot& slot) const;
  void collect(Slot& slot, std::vector<DrawnLines>& found) const;

  const Device& device;
  std::span<const Patch> patches;
  DeviceLinesOptions options;
  Kernel prepare, place, draw;
  std::array<Slot, 2> slots;
  Buffer patch_data, blocker_data, sobol;
};

DeviceLines::State::State(const Device& on, std::span<const Patch> all_patches, std::span<const Blocker> blockers,
                          const DeviceLinesOptions& requested)
    : device(on),
      patches(all_patches),
      options(requested),
      prepare(on, pair_lines_prepare_comp, sizeof(PrepareArgs)),
      place(on, pair_lines_place_comp, sizeof(PlaceArgs)),
      draw(on, pair_lines_draw_comp, sizeof(DrawLinesArgs)),
      slots{Slot(on), Slot(on)} {
  if (options.most_tests == 0)
    options.most_tests = device.description().kind == "cpu" ? kMostTestsInSoftware : kMostTests;
  options.most_bytes = std::min({options.most_bytes, device.memoryBytes() / 8, uint64_t(device.maxAllocationBytes())});
  std::vector<PatchData> patch_values;
  for (const Patch& patch : patches) patch_values.push_back(dataOf(patch));
  std::vector<BlockerData> blocker_values;
  for (const Blocker& blocker : blockers) blocker_values.push_back(dataOf(blocker));
  patch_data = uploaded(patch_values), blocker_data = uploaded(blocker_values);
  sobol = uploaded(std::vector<uint32_t>(kSobol.numbers().begin(), kSobol.numbers().end()));
}

template <class T>
Buffer DeviceLines::State::uploaded(const std::vector<T>& values) {
  const uint64_t size_bytes = values.size() * sizeof(T);
  Buffer buffer(device, size_bytes, MemoryUse::device), staging(device, size_bytes, MemoryUse::upload);
  if (values.empty()) return buffer;
  staging.write(std::span<const T>(values));
  Commands& commands = slots[0].commands;
  commands.begin();
  commands.copy(staging, buffer, size_bytes);
  commands.submitAndWait();
  return buffer;
}

// Adds a task and its obstacles to a batch, without portions of lines.
void DeviceLines::State::addTask(Batch& batch, const LineTask& task) const {
  const bool is_swapped = patches[task.b].area < patches[task.a].area;
  const auto index = static_cast<uint32_t>(batch.tasks.size());
  LineTaskData& data = batch.tasks.emplace_back();
  data.small = is_swapped ? task.b : task.a, data.large = is_swapped ? task.a : task.b;
  data.way = static_cast<uint32_t>(task.way);
  data.unit = unitOfWeights(task.way, task.exchange);
  std::copy(task.scrambles.begin(), task.scrambles.end(), data.scrambles);
  data.first_obstacle = static_cast<uint32_t>(batch.placed.size());
  data.obstacle_count = static_cast<uint32_t>(task.between.size());
  for (const PlacedBlocker& placed : task.between)
    batch.placed.push_back({index, placed.blocker, static_cast<uint32_t>(placeFrom(placed.place, is_swapped))});
}

// Fills a batch with at least one portion, starting where the last batch ended.
void DeviceLines::State::fill(Batch& batch, std::span<const LineTask> tasks, Place& next) const {
  batch.tasks.clear(), batch.portions.clear(), batch.placed.clear();
  batch.first_task = next.task;
  const uint64_t most_portions = uint64_t(device.properties().limits.maxComputeWorkGroupCount[0]) * kTeams;
  uint64_t tests = 0;
  for (; next.task < tasks.size(); ++next.task, next.block = 0) {
    const LineTask& task = tasks[next.task];
    addTask(batch, task);
    while (task.first + next.block < task.end) {
      if (!batch.portions.empty() && (tests >= options.most_tests || batch.bytes() >= options.most_bytes ||
                                      batch.portions.size() >= most_portions))
        return;
      const uint32_t first = task.first + next.block,
                     end = std::min((first / kPortionBlocks + 1) * kPortionBlocks, task.end);
      batch.portions.push_back({static_cast<uint32_t>(batch.tasks.size() - 1), first, end});
      tests += uint64_t(end - first) * kBlockLanes * (task.between.size() + 4);
      next.block = end - task.first;
    }
  }
}

// Makes buffers large enough.    Throws: Error memory.
void DeviceLines::State::fit(Slot& slot) const {
  const auto grow = [&](Buffer& buffer, uint64_t size_bytes, MemoryUse use) {
    if (buffer.sizeBytes() >= size_bytes && buffer.handle()) return;
    buffer = {};
    buffer = Buffer(device, size_bytes + size_bytes / 4, use);
  };
  const Batch& batch = slot.batch;
  const auto growBoth = [&](Buffer& written, Buffer& read, uint64_t size_bytes) {
    grow(written, size_bytes, MemoryUse::upload);
    grow(read, size_bytes, MemoryUse::device);
  };
  growBoth(slot.tasks_written, slot.tasks, batch.tasks.size() * sizeof(LineTaskData));
  growBoth(slot.portions_written, slot.portions, batch.portions.size() * sizeof(LinePortionData));
  growBoth(slot.placed_written, slot.placed, batch.placed.size() * sizeof(PlacedData));
  grow(slot.pairs, batch.tasks.size() * sizeof(LinePairData), MemoryUse::device);
  grow(slot.obstacles, batch.placed.size() * sizeof(ObstacleData), MemoryUse::device);
  grow(slot.sums, batch.portions.size() * sizeof(LinePortionSums), MemoryUse::device);
  grow(slot.sums_read, batch.portions.size() * sizeof(LinePortionSums), MemoryUse::readback);
}

void DeviceLines::State::submit(Slot& slot) const {
  const Batch& batch = slot.batch;
  const auto task_count = static_cast<uint32_t>(batch.tasks.size()),
             portion_count = static_cast<uint32_t>(batch.portions.size()),
             placed_count = static_cast<uint32_t>(batch.placed.size());
  Commands& commands = slot.commands;
  commands.begin();
  const auto send = [&](const auto& values, Buffer& written, const Buffer& read) {
    if (values.empty()) return;
    written.write(std::span(values));
    commands.copy(written, read, std::span(values).size_bytes());
  };
  send(batch.tasks, slot.tasks_written, slot.tasks);
  send(batch.portions, slot.portions_written, slot.portions);
  send(batch.placed, slot.placed_written, slot.placed);
  commands.barrier();
  commands.dispatch(prepare, PrepareArgs{slot.tasks.address(), patch_data.address(), slot.pairs.address(), task_count},
                    groupsFor(task_count, kPairLinesGroup), 1);
  if (placed_count)
    commands.dispatch(place,
                      PlaceArgs{slot.placed.address(), slot.tasks.address(), patch_data.address(),
                                blocker_data.address(), slot.obstacles.address(), placed_count},
                      groupsFor(placed_count, kPairLinesGroup), 1);
  commands.barrier();
  commands.dispatch(draw,
                    DrawLinesArgs{slot.portions.address(), slot.tasks.address(), slot.pairs.address(),
                                  slot.obstacles.address(), sobol.address(), slot.sums.address(), portion_count},
                    groupsFor(portion_count, kTeams), 1);
  commands.barrier();
  commands.copy(slot.sums, slot.sums_read, portion_count * sizeof(LinePortionSums));
  commands.submit();
  slot.is_busy = true;
}

// Adds the sums of a batch, portion by portion in their order.
void DeviceLines::State::collect(Slot& slot, std::vector<DrawnLines>& found) const {
  if (!slot.is_busy) return;
  slot.is_busy = false;
  slot.commands.wait();
  const std::span<const LinePortionSums> sums = slot.sums_read.mapped<LinePortionSums>();
  for (size_t k = 0; k < slot.batch.portions.size(); ++k) {
    const LinePortionData& portion = slot.batch.portions[k];
    DrawnLines& of = found[slot.batch.first_task + portion.task];
    of.facing += double(sums[k].facing), of.all += double(sums[k].all), of.squares += double(sums[k].squares);
    of.lines += uint64_t(LineDrawer::kBlockLines) * (portion.end - portion.first);
  }
}

DeviceLines::DeviceLines(const Device& device, std::span<const Patch> patches, std::span<const Blocker> blockers,
                         const DeviceLinesOptions& options)
    : state_(std::make_unique<State>(device, patches, blockers, options)) {}
DeviceLines::~DeviceLines() = default;
DeviceLines::DeviceLines(DeviceLines&&) noexcept = default;
DeviceLines& DeviceLines::operator=(DeviceLines&&) noexcept = default;

std::vector<DrawnLines> DeviceLines::draw(std::span<const LineTask> tasks, const std::function<void()>& stop) {
  State& state = *state_;
  std::vector<DrawnLines> found(tasks.size());
  // However this function ends, no batch is in flight afterwards.
  struct Waiting {
    State& of;
    ~Waiting() {
      for (Slot& slot : of.slots) {
        if (!std::exchange(slot.is_busy, false)) continue;
        try {
          slot.commands.wait();
        } catch (const Error&) {  // the device is lost; the exception that is being thrown says so
        }
      }
    }
  } waiting{state};
  Place next;
  size_t turn = 0;
  for (; next.task < tasks.size(); ++turn) {
    if (stop) stop();
    Slot& slot = state.slots[turn % 2];
    state.collect(slot, found);
    const Place begun = next;
    state.fill(slot.batch, tasks, next);
    if (slot.batch.portions.empty()) break;
    try {
      state.fit(slot);
    } catch (const Error& error) {
      // Smaller batches may fit once the other batch in flight has ended.
      if (error.code() != ErrorCode::memory || state.options.most_bytes <= kLeastBatchBytes) throw;
      state.options.most_bytes = std::min(state.options.most_bytes, slot.batch.bytes()) / 2;
      next = begun;
      continue;
    }
    state.submit(slot);
  }
  state.collect(state.slots[turn % 2], found);  // the batch that was sent first
  state.collect(state.slots[(turn + 1) % 2], found);
  return found;
}

bool agree(DeviceLines& device_lines, std::span<const LineTask> tasks, std::span<const Patch> patches,
           const std::vector<Blocker>& blockers) {
  std::vector<LineTask> tried;
  for (size_t k = 0; k < tasks.size(); k += tasks.size() / kTriedTasks + 1) {
    if (!DeviceLines::takes(tasks[k])) continue;
    tried.push_back(tasks[k]);
    tried.back().end = std::min(tried.back().end, tried.back().first + kPortionBlocks);
  }
  const std::vector<DrawnLines> found = device_lines.draw(tried);
  const Vectors vectors = widestVectors();
  for (size_t k = 0; k < tried.size(); ++k)
    if (found[k] != drawOnHost(tried[k], patches, blockers, vectors)) return false;
  return true;
}

}  // namespace viewpeel
