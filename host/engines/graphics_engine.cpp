// Engine `graphics` records these passes, in order, for a batch of directions side by side in one image:
//   project       finds snapped corners, outline and depth over the lattice of every polygon along every direction
//   peel          draws all polygons; the depth test keeps the nearest polygon behind the previous layer
//   (copy)        copies the layer to a buffer that shaders can read
//   accumulate    counts the gaps between layers k-1 and k, and requests layer k+1 where layer k has a polygon
// Passes peel and accumulate repeat until a layer is empty. Several layers are recorded ahead; their draws and
// dispatches are indirect, so that they do nothing once no layer is left.
#include "engines/graphics_engine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "engines/lattice.h"
#include "engines/pair_counters.h"
#include "engines/shared.h"
#include <viewpeel/error.h>
#include "shaders/accumulate.comp.h"
#include "shaders/peel.frag.h"
#include "shaders/peel.vert.h"
#include "shaders/project.comp.h"
#include "vulkan/commands.h"
#include "vulkan/image.h"

namespace viewpeel {
namespace {

using namespace device_data;

constexpr VkFormat kLayerFormat = VK_FORMAT_R32G32_UINT;
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr uint32_t kGroupSize = 64;  // local_size_x of the compute passes
constexpr uint64_t kBatchPixels = 1u << 20;
constexpr uint64_t kBatchPixelsOfAllLayers = 1u << 17;  // pixels of a batch, where all layers are kept
constexpr uint32_t kMostLayers = 1u << 15;    // layers that are kept at most; software devices end loops at 2^16 turns
constexpr uint64_t kLayersRecorded = 4;       // layers of a submission; an unused one still clears and copies an image
constexpr uint64_t kBatchBytes = 256u << 20;  // memory for projected polygons

class GraphicsEngine : public Engine {
 public:
  GraphicsEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options);
  PairCounts count(std::span<const Direction> directions) override;
  double unitArea() const override { return pointArea(options_.resolution); }

 private:
  void planBatch(uint64_t polygon_bytes_per_direction);
  void prepareImages();
  void countBatch(std::span<const Direction> directions);
  void recordLayer(uint32_t k, uint32_t direction_count);
  void makeLayer();
  // Returns the buffer of layer k. Layer -1 lies before everything. Where blocked pairs are counted every layer is
  // kept, else only the last two.
  const Buffer& layerBuffer(uint32_t k_plus_1) const {
    return layers_[options_.count_blocked ? k_plus_1 : k_plus_1 % 2];
  }

  const Device& device_;
  LatticeOptions options_;
  bool two_sided_;
  int fraction_bits_;
  SceneBuffers scene_;
  PairCounters counters_;
  uint32_t cell_size_, cells_per_row_, cell_rows_, batch_size_;

  Kernel project_, peel_, accumulate_;
  Commands commands_;
  Buffer directions_, snapped_corners_, projected_, outlines_;
  std::vector<Buffer> layers_;
  Buffer layer_addresses_;                       // uint64_t[kMostLayers]: addresses of layers 0, 1, ...
  std::array<Buffer, 2> alive_, next_commands_;  // element k % 2 is for layer k
  Buffer status_, batch_status_;
  Image colour_, depth_;
};

GraphicsEngine::GraphicsEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : device_(device),
      options_(options),
      two_sided_(ids.two_sided),
      fraction_bits_(chooseFractionBits(options.resolution)),
      scene_(device, scene, ids),
      counters_(device, ids.count(), options.count_blocked, options.counter_budget_bytes, false),
      project_(device, project_comp, sizeof(ProjectArgs), std::vector<uint32_t>{false, false, true}, 3),
      peel_(device, peel_vert, peel_frag, kLayerFormat, kDepthFormat, sizeof(DrawArgs)),
      accumulate_(device, accumulate_comp, sizeof(AccumulateArgs)),
      commands_(device) {
  if (options.resolution > kMaxResolution)
    throw Error(ErrorCode::bad_usage,
                fmt::format("resolution {} is out of range; choose 1 to {}", options.resolution, kMaxResolution));
  for (const Polygon& polygon : scene.polygons)
    if (polygon.tie_rank != kContactRank && polygon.tie_rank != kSheetRank)
      throw Error(ErrorCode::bad_usage,
                  "three polygons or more coincide, of which --engine graphics can order two only; use --engine "
                  "compute or host");
  cell_size_ = static_cast<uint32_t>(options.resolution) + 4;

  planBatch(uint64_t(scene_.polygon_count) * (sizeof(ProjectedPolygon) + sizeof(Outline) + sizeof(SnappedCorners)));

  directions_ = Buffer(device, batch_size_ * sizeof(DirectionData), MemoryUse::upload, VK_FORMAT_R32G32B32A32_UINT);
  snapped_corners_ =
      Buffer(device, uint64_t(batch_size_) * scene_.polygon_count * sizeof(SnappedCorners), MemoryUse::device);
  projected_ =
      Buffer(device, uint64_t(batch_size_) * scene_.polygon_count * sizeof(ProjectedPolygon), MemoryUse::device);
  outlines_ = Buffer(device, uint64_t(batch_size_) * scene_.polygon_count * sizeof(Outline), MemoryUse::device);
  batch_status_ = Buffer(device, sizeof(BatchStatus), MemoryUse::device);
  if (options.count_blocked) layer_addresses_ = Buffer(device, kMostLayers * sizeof(uint64_t), MemoryUse::upload);
  for (int k = 0; k < 2; ++k) makeLayer();
  for (Buffer& alive : alive_) alive = Buffer(device, batch_size_ * sizeof(uint64_t), MemoryUse::device);
  for (Buffer& next : next_commands_) next = Buffer(device, sizeof(LayerCommands), MemoryUse::device);
  status_ = Buffer(device, sizeof(LayerCommands), MemoryUse::readback);
  prepareImages();
}

// Chooses how many directions a batch has: they must fit side by side in one image, and their projected polygons must
// fit kBatchBytes.
void GraphicsEngine::planBatch(uint64_t polygon_bytes_per_direction) {
  const uint32_t largest_side = device_.properties().limits.maxImageDimension2D;
  const uint64_t cell_pixels = uint64_t(cell_size_) * cell_size_;
  uint64_t wanted =
      options_.batch_directions
          ? options_.batch_directions
          : std::max<uint64_t>(1, (options_.count_blocked ? kBatchPixelsOfAllLayers : kBatchPixels) / cell_pixels);
  if (!options_.batch_directions)
    wanted = std::min(wanted, std::max<uint64_t>(1, kBatchBytes / polygon_bytes_per_direction));
  wanted = std::min<uint64_t>({wanted, uint64_t(largest_side / cell_size_) * (largest_side / cell_size_),
                               device_.properties().limits.maxComputeWorkGroupCount[1],
                               (1ull << 31) / scene_.polygon_count});
  cells_per_row_ =
      std::min<uint32_t>(largest_side / cell_size_, static_cast<uint32_t>(std::ceil(std::sqrt(double(wanted)))));
  cell_rows_ = divideUp(wanted, cells_per_row_);
  batch_size_ = static_cast<uint32_t>(wanted);
}

void GraphicsEngine::makeLayer() {
  if (layers_.size() > kMostLayers)
    throw Error(
        ErrorCode::limit,
        fmt::format(
            "more than {} polygons lie over one lattice point, too many to count blocked pairs; try --engine compute",
            kMostLayers));
  const uint64_t pixels = uint64_t(cells_per_row_) * cell_size_ * cell_rows_ * cell_size_;
  layers_.emplace_back(device_, pixels * sizeof(Layer), MemoryUse::device);
  if (options_.count_blocked && layers_.size() > 1)
    layer_addresses_.mapped<uint64_t>()[layers_.size() - 2] = layers_.back().address();
}

void GraphicsEngine::prepareImages() {
  const uint32_t width = cells_per_row_ * cell_size_, height = cell_rows_ * cell_size_;
  colour_ = Image(device_, width, height, kLayerFormat,
                  VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
  depth_ = Image(device_, width, height, kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                 VK_IMAGE_ASPECT_DEPTH_BIT);
  commands_.begin();
  for (const Image* image : {&colour_, &depth_}) commands_.prepare(*image);
  commands_.submitAndWait();
}

PairCounts GraphicsEngine::count(std::span<const Direction> directions) {
  counters_.start(commands_);
  for (size_t done = 0; done < directions.size();) {
    const size_t count = std::min<size_t>(batch_size_, directions.size() - done);
    countBatch(directions.subspan(done, count));
    done += count;
    if (options_.on_batch) options_.on_batch(done);
  }
  return counters_.finish(commands_);
}

void GraphicsEngine::countBatch(std::span<const Direction> directions) {
  const auto direction_count = static_cast<uint32_t>(directions.size());
  writeDirections(directions, options_.resolution, {}, directions_, 0, directions.size());
  commands_.begin();
  ProjectArgs project{snapped_corners_.address(),
                      projected_.address(),
                      outlines_.address(),
                      scene_.polygon_count,
                      direction_count,
                      options_.resolution,
                      fraction_bits_,
                      0,
                      cell_size_,
                      windowReach(options_.resolution)};
  commands_.bind(project_, VK_PIPELINE_BIND_POINT_COMPUTE);
  commands_.bindTexels(project_, std::array{directions_.texels(), scene_.polygons.texels(), scene_.corners.texels()});
  commands_.dispatch(project_, project, divideUp(scene_.polygon_count, kGroupSize), direction_count);
  // Layer -1 lies before everything: its key is 0, and it has no polygon.
  commands_.fill(layerBuffer(0), 0);
  commands_.fill(alive_[0], 0xFFFFFFFFu);
  const LayerCommands first{4,
                            scene_.polygon_count * direction_count,
                            0,
                            0,
                            divideUp(uint64_t(cell_size_) * cell_size_, kGroupSize),
                            direction_count,
                            1,
                            0};
  vkCmdUpdateBuffer(commands_.handle(), next_commands_[0].handle(), 0, sizeof first, &first);
  commands_.barrier();

  for (uint32_t layer = 0;;) {
    for (uint32_t k = 0; k < kLayersRecorded; ++k) recordLayer(layer++, direction_count);
    commands_.copy(next_commands_[layer % 2], status_, sizeof(LayerCommands));
    commands_.submitAndWait();
    if (status_.mapped<LayerCommands>()[0].draw_instance_count == 0) break;
    commands_.begin();
  }
}

void GraphicsEngine::recordLayer(uint32_t k, uint32_t direction_count) {
  const uint32_t now = k % 2, next = 1 - now;
  while (options_.count_blocked && layers_.size() < k + 2) makeLayer();
  const Buffer &lower = layerBuffer(k), &upper = layerBuffer(k + 1);
  const uint32_t width = cells_per_row_ * cell_size_, height = divideUp(direction_count, cells_per_row_) * cell_size_;
  const VkCommandBuffer commands = commands_.handle();

  // The next layer's commands do nothing until accumulate finds that this layer is not empty.
  const LayerCommands none{4, 0, 0, 0, 0, direction_count, 1, 0};
  vkCmdUpdateBuffer(commands, next_commands_[next].handle(), 0, sizeof none, &none);
  commands_.fill(alive_[next], 0);

  VkRenderingAttachmentInfo colour{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  colour.imageView = colour_.view();
  colour.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
  colour.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
  colour.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  colour.clearValue.color.uint32[0] = kKeyPastEverything;
  VkRenderingAttachmentInfo depth = colour;
  depth.imageView = depth_.view();
  depth.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  depth.clearValue.depthStencil = {1, 0};
  VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
  rendering.renderArea.extent = {width, height};
  rendering.layerCount = 1;
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachments = &colour;
  rendering.pDepthAttachment = &depth;
  const VkViewport viewport{0, 0, float(width), float(height), 0, 1};
  const VkRect2D scissor{{0, 0}, {width, height}};
  const DrawArgs peel{scene_.polygons.address(),
                      snapped_corners_.address(),
                      projected_.address(),
                      outlines_.address(),
                      lower.address(),
                      alive_[now].address(),
                      scene_.polygon_count,
                      cell_size_,
                      cells_per_row_,
                      width,
                      height,
                      fraction_bits_};
  vkCmdBeginRendering(commands, &rendering);
  commands_.bind(peel_, VK_PIPELINE_BIND_POINT_GRAPHICS);
  commands_.push(peel_, peel);
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
  vkCmdDrawIndirect(commands, next_commands_[now].handle(), 0, 1, 0);
  vkCmdEndRendering(commands);
  commands_.barrier();

  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {width, height, 1};
  vkCmdCopyImageToBuffer(commands, colour_.handle(), VK_IMAGE_LAYOUT_GENERAL, upper.handle(), 1, &region);
  commands_.barrier();

  const AccumulateArgs accumulate{scene_.polygons.address(),
                                  lower.address(),
                                  upper.address(),
                                  counters_.address(),
                                  batch_status_.address(),
                                  alive_[next].address(),
                                  next_commands_[next].address(),
                                  counters_.idCount(),
                                  cell_size_,
                                  cells_per_row_,
                                  width,
                                  direction_count,
                                  two_sided_ ? 1u : 0u,
                                  scene_.polygon_count * direction_count,
                                  divideUp(uint64_t(cell_size_) * cell_size_, kGroupSize),
                                  k,
                                  options_.count_blocked ? layer_addresses_.address() : 0};
  commands_.dispatchIndirect(accumulate_, accumulate, next_commands_[now], offsetof(LayerCommands, group_count_x));
  commands_.barrier();
}

}  // namespace

std::unique_ptr<Engine> makeGraphicsEngine(const Device& device, const Scene& scene, const Ids& ids,
                                           const LatticeOptions& options) {
  return std::make_unique<GraphicsEngine>(device, scene, ids, options);
}

}  // namespace viewpeel
