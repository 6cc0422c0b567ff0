#include "engines/record_passes.h"

#include <algorithm>
#include <optional>
#include <variant>

#include "engines/batch_plan.h"
#include "engines/shared.h"
#include "shaders/allocate.comp.h"
#include "shaders/bin.comp.h"
#include "shaders/cover.comp.h"
#include "shaders/enter.comp.h"
#include "shaders/meet.comp.h"
#include "shaders/peel.comp.h"
#include "shaders/peel_blocked.comp.h"
#include "shaders/project.comp.h"
#include "shaders/sort.comp.h"

namespace viewpeel {

using namespace device_data;

namespace {

constexpr uint32_t kSceneTexels = 3, kTileTexels = 5;  // texel buffers of passes over the scene, and over tiles

// PassGroups are the workgroups of a dispatch: x by y, or as many as earlier passes have written into BatchStatus.
struct PassGroups {
  uint32_t x = 0, y = 1;
  std::optional<size_t> in_status = std::nullopt;  // offset in BatchStatus, in bytes
};

struct Pass {
  const char* name;
  const Kernel& kernel;  // a pass whose kernel was not made is left out
  std::variant<ProjectArgs, BinArgs, SortArgs, PeelArgs, MeetArgs> args;
  std::vector<VkBufferView> texels;  // the buffers at bindings 0, 1, ...
  PassGroups groups;
};

uint32_t directionCount(const Batch& batch) { return static_cast<uint32_t>(batch.directions.size()); }
uint32_t tileCount(const Batch& batch) { return directionCount(batch) * batch.shape.tilesPerDirection(); }
uint32_t tileRowCount(const Batch& batch) { return directionCount(batch) * batch.shape.tiles_high; }
uint32_t pointCount(const Batch& batch) { return directionCount(batch) * batch.shape.pointsPerDirection(); }
uint32_t tileRowsPerInvocation(const BatchShape& shape) {
  return std::max(1u, kMostTilesPerInvocation / shape.tiles_wide);
}

ProjectArgs projectArgs(const PassSettings& settings, const Batch& batch) {
  return {
      .snapped_corners = batch.buffers.snapped_corners.address(),
      .projected = batch.buffers.projected.address(),
      .outlines = 0,
      .polygon_count = settings.scene.polygon_count,
      .direction_count = directionCount(batch),
      .resolution = settings.options.resolution,
      .fraction_bits = settings.fraction_bits,
      .column_bits = settings.column_bits,
      .cell_size = 0,
      .window = windowReach(settings.options.resolution, settings.options.window),
      .listed = batch.buffers.listed.address(),
      .status = batch.buffers.status.address(),
      .fragments = batch.buffers.fragments.address(),
      .fragment_counts = batch.buffers.fragment_counts.address(),
      .fragment_capacity = batch.shape.fragment_capacity,
      .point_count = pointCount(batch),
      .few_points = *settings.options.few_points,
      .tiles_wide = batch.shape.tiles_wide,
      .tiles_high = batch.shape.tiles_high,
  };
}

BinArgs binArgs(const PassSettings& settings, const Batch& batch) {
  return {
      .tile_roles = batch.buffers.tile_roles.address(),
      .emitter_spans = batch.buffers.emitter_spans.address(),
      .tile_counts = batch.buffers.tile_counts.address(),
      .tile_starts = batch.buffers.tile_starts.address(),
      .lists = (batch.shape.sorts ? batch.buffers.entries : batch.buffers.lists).address(),
      .active_tiles = batch.buffers.active_tiles.address(),
      .directions = batch.buffers.directions.address(),
      .status = batch.buffers.status.address(),
      .listed = batch.buffers.listed.address(),
      .fragment_counts = batch.buffers.fragment_counts.address(),
      .fragment_capacity = batch.shape.fragment_capacity,
      .polygon_count = settings.scene.polygon_count,
      .tiles_wide = batch.shape.tiles_wide,
      .tiles_high = batch.shape.tiles_high,
      .tile_count = tileCount(batch),
      .list_capacity = static_cast<uint32_t>(batch.shape.list_capacity),
      .rows_per_invocation = tileRowsPerInvocation(batch.shape),
      .needed_roles = settings.ids.needed_roles,
  };
}

PeelArgs peelArgs(const PassSettings& settings, const Batch& batch, uint32_t resumes) {
  return {
      .tiles = batch.buffers.unfinished.address(),
      .reached = batch.buffers.reached.address(),
      .unfinished = batch.buffers.unfinished_next.address(),
      .reached_next = batch.buffers.reached_next.address(),
      .status = batch.buffers.status.address(),
      .counters = settings.counters.address(),
      .polygon_count = settings.scene.polygon_count,
      .id_count = settings.counters.idCount(),
      .counter_mask = settings.counters.mask(),
      .counts_environment = settings.ids.counts_environment,
      .most_blocks = settings.tuning.most_blocks,
      .point_count = pointCount(batch),
      .resumes = resumes,
      .block_bytes = settings.counters.blockBytes(),
  };
}

MeetArgs meetArgs(const PassSettings& settings, const Batch& batch) {
  return {
      .covers = batch.buffers.covers.address(),
      .cover_polygons = batch.buffers.cover_polygons.address(),
      .meetings = batch.buffers.meetings.address(),
      .status = batch.buffers.status.address(),
      .counters = settings.counters.address(),
      .polygon_count = settings.scene.polygon_count,
      .id_count = settings.counters.idCount(),
      .counter_mask = settings.counters.mask(),
      .block_bytes = settings.counters.blockBytes(),
  };
}

// Returns the texel buffers at bindings 0 to 4 of every pass over tiles (shaders/texels.glsl).
std::vector<VkBufferView> tileTexels(const PassSettings& settings, const BatchBuffers& buffers, const Buffer& lists) {
  return {buffers.snapped_corners.texels(), buffers.projected.texels(), settings.scene.polygons.texels(),
          lists.texels(), buffers.active_tiles.texels()};
}

std::vector<VkBufferView> peelTexels(const PassSettings& settings, const Batch& batch) {
  const BatchBuffers& buffers = batch.buffers;
  std::vector<VkBufferView> texels = tileTexels(settings, buffers, buffers.lists);
  const bool has = batch.shape.enters;  // without fragments any buffer will do: the shader reads none of it
  texels.push_back((has ? buffers.fragments : buffers.snapped_corners).texels());
  texels.push_back((has ? buffers.fragment_counts : buffers.snapped_corners).texels());
  return texels;
}

void runPass(Commands& commands, const Buffer& status, const Pass& pass) {
  if (!pass.texels.empty()) commands.bindTexels(pass.kernel, pass.texels);
  const auto dispatch = [&](const auto& args) {
    if (pass.groups.in_status) commands.dispatchIndirect(pass.kernel, args, status, *pass.groups.in_status);
    else commands.dispatch(pass.kernel, args, pass.groups.x, pass.groups.y);
  };
  std::visit(dispatch, pass.args);
}

// Records commands that reset the status and set to 0 the buffers in which passes count.
void recordClearing(Batch& batch) {
  BatchStatus none{};
  none.project_groups = {0, 1, 1};
  none.bin_groups = {0, 1, divideUp(batch.shape.tiles_high, tileRowsPerInvocation(batch.shape))};
  none.peel_groups = {0, 1, 1};
  vkCmdUpdateBuffer(batch.commands.handle(), batch.buffers.status.handle(), 0, sizeof none, &none);
  batch.commands.fill(batch.buffers.tile_counts, 0, tileCount(batch) * sizeof(uint32_t));
  if (batch.shape.enters) batch.commands.fill(batch.buffers.fragment_counts, 0, pointCount(batch) * sizeof(uint32_t));
  if (!batch.shape.has_roles) return;
  batch.commands.fill(batch.buffers.tile_roles, 0, tileCount(batch) * sizeof(uint32_t));
  batch.commands.fill(batch.buffers.emitter_spans, 0, tileRowCount(batch) * 2 * sizeof(uint32_t));
}

}  // namespace

IdRules::IdRules(const Ids& ids)
    : two_sided(ids.two_sided),
      counts_environment(ids.counts_environment),
      all_count(ids.roles.empty()),
      are_indices(ids.roles.empty() && ids.of_polygon.size() == ids.count()),
      needed_roles(all_count            ? 0
                   : counts_environment ? viewpeel::kEmits
                                        : viewpeel::kEmits | viewpeel::kReceives) {
  for (uint32_t k = 0; are_indices && k < ids.of_polygon.size(); ++k) are_indices = ids.of_polygon[k] == k;
}

PassKernels makeKernels(const Device& device, const PassSettings& settings, const BatchShape& shape) {
  const Tuning& tuning = settings.tuning;
  const IdRules& ids = settings.ids;
  const bool counts_blocked = settings.options.count_blocked, is_sparse = settings.counters.isSparse();
  const auto column_bits = static_cast<uint32_t>(settings.column_bits),
             cut_bits = static_cast<uint32_t>(settings.fraction_bits - settings.column_bits);
  const auto makeBin = [&](uint32_t mode) {
    return Kernel(device, bin_comp, sizeof(BinArgs),
                  {mode, shape.has_roles, tuning.sorts, tuning.tile_width, tuning.tile_rows, column_bits, cut_bits},
                  kTileTexels);
  };
  PassKernels kernels;
  if (shape.enters)
    kernels.enter =
        Kernel(device, enter_comp, sizeof(ProjectArgs), {tuning.tile_width, tuning.tile_rows}, kSceneTexels);
  kernels.project =
      Kernel(device, project_comp, sizeof(ProjectArgs), {shape.enters, !shape.enters, false}, kSceneTexels);
  if (shape.has_roles) kernels.bin_emitters = makeBin(kBinEmitters);
  if (shape.has_roles) kernels.bin_receivers = makeBin(kBinReceivers);
  kernels.bin_count = makeBin(kBinCount);
  kernels.bin_scatter = makeBin(kBinScatter);
  kernels.allocate =
      Kernel(device, allocate_comp, sizeof(BinArgs),
             {shape.enters, tuning.tile_width, tuning.tile_rows, settings.isScanline(), shape.allocatesRows()});
  if (tuning.sorts) kernels.sort = Kernel(device, sort_comp, sizeof(SortArgs), {tuning.subgroup_size}, kTileTexels);
  const std::span<const uint32_t> peel =
      settings.isScanline() && counts_blocked ? std::span<const uint32_t>(peel_blocked_comp) : peel_comp;
  kernels.peel = Kernel(
      device, peel, sizeof(PeelArgs),
      {tuning.subgroup_size, tuning.layers_kept, settings.isScanline(), is_sparse, ids.all_count,
       settings.options.aggregate, settings.options.measure_work, tuning.steps, ids.are_indices, tuning.tile_width,
       tuning.sorts, ids.two_sided, counts_blocked, shape.enters, tuning.tile_rows, column_bits, cut_bits},
      kTileTexels + 2);
  if (!shape.meets) return kernels;
  kernels.cover = Kernel(
      device, cover_comp, sizeof(MeetArgs),
      {tuning.subgroup_size, tuning.tile_width, ids.all_count, ids.two_sided, tuning.tile_rows, cut_bits}, kTileTexels);
  kernels.meet =
      Kernel(device, meet_comp, sizeof(MeetArgs),
             {tuning.subgroup_size, tuning.tile_width, ids.all_count, ids.two_sided, is_sparse, ids.are_indices},
             kTileTexels + 1);
  return kernels;
}

void recordPasses(const PassSettings& settings, const PassKernels& kernels, Batch& batch) {
  const BatchBuffers& buffers = batch.buffers;
  const std::vector<VkBufferView> scene_texels = {buffers.directions.texels(), settings.scene.polygons.texels(),
                                                  settings.scene.corners.texels()};
  const std::vector<VkBufferView> tile_texels = tileTexels(settings, buffers, buffers.lists);
  std::vector<VkBufferView> meet_texels = tileTexels(settings, buffers, buffers.cover_polygons);
  meet_texels.push_back(buffers.covers.texels());
  const ProjectArgs project = projectArgs(settings, batch);
  const BinArgs bin = binArgs(settings, batch);
  const SortArgs sort{.sorted_lists = buffers.lists.address(),
                      .active_tiles = buffers.active_tiles.address(),
                      .status = buffers.status.address()};
  const MeetArgs meet = meetArgs(settings, batch);
  const PassGroups by_polygon{.x = divideUp(settings.scene.polygon_count, kGroupSize), .y = directionCount(batch)};
  const PassGroups by_tile{.x = batch.shape.allocatesRows() ? tileRowCount(batch)
                                                            : divideUp(tileCount(batch), kGroupSize)};
  const PassGroups listed_projections{.in_status = offsetof(BatchStatus, project_groups)},
      by_listed{.in_status = offsetof(BatchStatus, bin_groups)};
  const PassGroups by_active_tile{.in_status = offsetof(BatchStatus, peel_groups)},
      by_meeting{.in_status = offsetof(BatchStatus, meet_groups)};
  const Pass passes[] = {
      {"enter", kernels.enter, project, scene_texels, by_polygon},
      {"project", kernels.project, project, scene_texels, batch.shape.enters ? listed_projections : by_polygon},
      {"bin emitters", kernels.bin_emitters, bin, tile_texels, by_listed},
      {"bin receivers", kernels.bin_receivers, bin, tile_texels, by_listed},
      {"bin count", kernels.bin_count, bin, tile_texels, by_listed},
      {"allocate", kernels.allocate, bin, {}, by_tile},
      {"bin scatter", kernels.bin_scatter, bin, tile_texels, by_listed},
      {"sort", kernels.sort, sort, tileTexels(settings, buffers, buffers.entries), by_active_tile},
      {"peel", kernels.peel, peelArgs(settings, batch, 0), peelTexels(settings, batch), by_active_tile},
      {"cover", kernels.cover, meet, tile_texels, by_active_tile},
      {"meet", kernels.meet, meet, meet_texels, by_meeting},
  };
  static_assert(std::size(passes) == kMostPasses);
  const size_t pass_count = batch.shape.meets ? kMostPasses : kMostPasses - 2;  // the last two are cover and meet

  batch.commands.begin();
  batch.timestamps.reset(batch.commands.handle());
  batch.pass_names.clear();
  recordClearing(batch);
  batch.commands.barrier();
  batch.timestamps.mark(batch.commands.handle());
  for (const Pass& pass : std::span(passes).first(pass_count)) {
    if (pass.kernel.pipeline()) runPass(batch.commands, buffers.status, pass);
    batch.commands.barrier();
    batch.timestamps.mark(batch.commands.handle());
    batch.pass_names.push_back(pass.name);
  }
  batch.commands.copy(buffers.status, buffers.status_read, sizeof(BatchStatus));
}

void recordResume(const PassSettings& settings, const PassKernels& kernels, Batch& batch, uint32_t unfinished_count) {
  const PassGroups groups{.x = std::min(unfinished_count, kGroupsPerRow),
                          .y = divideUp(unfinished_count, kGroupsPerRow)};
  const Pass resume{"peel", kernels.peel, peelArgs(settings, batch, unfinished_count), peelTexels(settings, batch),
                    groups};
  const uint32_t none = 0;
  batch.commands.begin();
  vkCmdUpdateBuffer(batch.commands.handle(), batch.buffers.status.handle(), offsetof(BatchStatus, unfinished),
                    sizeof none, &none);
  batch.commands.barrier();
  runPass(batch.commands, batch.buffers.status, resume);
  batch.commands.barrier();
  batch.commands.copy(batch.buffers.status, batch.buffers.status_read, sizeof(BatchStatus));
}

}  // namespace viewpeel
