#include "bench/rivals/hemicube.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "engines/lattice.h"
#include "engines/shared.h"
#include "bench/rivals/hemicube_weights.h"
#include "bench/support/points.h"
#include "shaders/hemicube.frag.h"
#include "shaders/hemicube.vert.h"
#include "shaders/hemicube_sum.comp.h"
#include "vulkan/commands.h"
#include "vulkan/image.h"

namespace viewpeel::bench {
namespace {

using namespace device_data;
using glm::vec3;
#include "bench/rivals/hemicube_shared.h"
static_assert(sizeof(HemicubeDraw) <= 128 && sizeof(HemicubeSum) <= 128);

constexpr VkFormat kPixelFormat = VK_FORMAT_R32_UINT, kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr uint64_t kImagePixels = 1u << 20, kSumBytes = 64u << 20;
constexpr uint32_t kGroupSize = 64;    // invocations of a workgroup of hemicube_sum.comp
constexpr double kWeightOne = 0x1p31;  // sum of the weights of a hemicube

struct Eye {
  uint32_t polygon;
  glm::dvec3 at;
  glm::vec3 normal, x, y;
};

// Returns a point of a convex polygon. (s, t) in the unit square chooses one of its two triangles by area, and a point
// in it.
glm::dvec3 pointOn(const Scene& scene, const Polygon& polygon, double s, double t) {
  const glm::dvec3* p = &scene.corners[polygon.first_corner];
  const glm::dvec3 a = p[1] - p[0], b = p[2] - p[0], c = p[polygon.corner_count - 1] - p[0];
  const double share = glm::length(glm::cross(a, b)) / (2 * polygon.area);
  const bool first = s < share || polygon.corner_count == 3;
  const double root = std::sqrt(first ? std::min(1.0, s / share) : (s - share) / (1 - share));
  return p[0] + root * ((1 - t) * (first ? a : b) + t * (first ? b : c));
}

}  // namespace

struct Hemicube::State {
  const Device& device;
  const Scene& scene;
  uint32_t resolution, polygon_count, cell_width, cell_height, cells_per_row, cell_rows, batch;
  SceneBuffers buffers;
  Kernel draw, sum;
  Commands commands;
  Image pixels, depth;
  Buffer pixel_buffer, weights, sums, host_sums;

  State(const Device& the_device, const Scene& the_scene, uint32_t the_resolution)
      : device(the_device),
        scene(the_scene),
        resolution(the_resolution),
        polygon_count(static_cast<uint32_t>(scene.polygons.size())),
        cell_width(3 * resolution),
        cell_height(resolution),
        buffers(device, scene, makeIds(scene, By::polygon, false)),
        draw(device, hemicube_vert, hemicube_frag, kPixelFormat, kDepthFormat, sizeof(HemicubeDraw),
             VK_COMPARE_OP_GREATER),
        sum(device, hemicube_sum_comp, sizeof(HemicubeSum)),
        commands(device) {
    const uint64_t wanted = std::clamp<uint64_t>(
        std::min<uint64_t>(kImagePixels / (uint64_t(cell_width) * cell_height), kSumBytes / (4ull * polygon_count)), 1,
        1024);
    cells_per_row = std::min<uint32_t>(static_cast<uint32_t>(std::ceil(std::sqrt(double(wanted) / 3))),
                                       device.properties().limits.maxImageDimension2D / cell_width);
    cell_rows = std::max<uint32_t>(1, static_cast<uint32_t>(wanted) / cells_per_row);
    batch = cells_per_row * cell_rows;
    const uint32_t width = cells_per_row * cell_width, height = cell_rows * cell_height;
    pixels = Image(device, width, height, kPixelFormat,
                   VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
    depth = Image(device, width, height, kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                  VK_IMAGE_ASPECT_DEPTH_BIT);
    pixel_buffer = Buffer(device, 4ull * width * height, MemoryUse::device);
    const std::vector<double> shares = hemicubeWeights(resolution);
    weights = Buffer(device, 4 * shares.size(), MemoryUse::upload);
    for (size_t k = 0; k < shares.size(); ++k)
      weights.mapped<uint32_t>()[k] = static_cast<uint32_t>(std::lround(shares[k] * kWeightOne));
    sums = Buffer(device, 4ull * batch * polygon_count, MemoryUse::device);
    host_sums = Buffer(device, 4ull * batch * polygon_count, MemoryUse::readback);
    prepareImages();
  }

  void prepareImages() {
    commands.begin();
    for (const Image* image : {&pixels, &depth}) commands.prepare(*image);
    commands.submitAndWait();
  }

  void drawFace(const Eye& eye, uint32_t cell, uint32_t face) {
    const std::array<glm::vec3, 4> around{eye.x, eye.y, -eye.x, -eye.y};
    const glm::vec3 forward = face == 0 ? eye.normal : around[face - 1], right = face == 0 ? eye.x : around[face % 4],
                    up = face == 0 ? eye.y : eye.normal;
    const HemicubeFace place = hemicubeFace(face, resolution);
    const uint32_t x = cell % cells_per_row * cell_width + place.x, y = cell / cells_per_row * cell_height + place.y;
    const VkViewport viewport{float(x), float(y), float(place.width), float(place.height), 0, 1};
    const VkRect2D scissor{{int32_t(x), int32_t(y)}, {place.width, place.height}};
    vkCmdSetViewport(commands.handle(), 0, 1, &viewport);
    vkCmdSetScissor(commands.handle(), 0, 1, &scissor);
    commands.push(draw, HemicubeDraw{buffers.polygons.address(), buffers.corners.address(), eye.at, right, up, forward,
                                     face == 0 ? 1.0f : 2.0f, face == 0 ? 0.0f : 1.0f});
    vkCmdDraw(commands.handle(), 4, polygon_count, 0, 0);
  }

  // Draws the hemicubes of these eyes, and leaves their sums in host_sums.
  void look(std::span<const Eye> eyes) {
    const uint32_t width = cells_per_row * cell_width, height = divideUp(eyes.size(), cells_per_row) * cell_height;
    commands.begin();
    commands.fill(sums, 0);
    VkRenderingAttachmentInfo colour{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    colour.imageView = pixels.view();
    colour.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
    colour.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    colour.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingAttachmentInfo depths = colour;
    depths.imageView = depth.view();
    depths.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea.extent = {width, height};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &colour;
    rendering.pDepthAttachment = &depths;
    vkCmdBeginRendering(commands.handle(), &rendering);
    commands.bind(draw, VK_PIPELINE_BIND_POINT_GRAPHICS);
    for (uint32_t cell = 0; cell < eyes.size(); ++cell)
      for (uint32_t face = 0; face < 5; ++face) drawFace(eyes[cell], cell, face);
    vkCmdEndRendering(commands.handle());
    commands.barrier();
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {width, height, 1};
    vkCmdCopyImageToBuffer(commands.handle(), pixels.handle(), VK_IMAGE_LAYOUT_GENERAL, pixel_buffer.handle(), 1,
                           &region);
    commands.barrier();
    const auto hemicubes = static_cast<uint32_t>(eyes.size());
    commands.dispatch(sum,
                      HemicubeSum{pixel_buffer.address(), weights.address(), sums.address(), polygon_count, cell_width,
                                  cell_height, cells_per_row, width, hemicubes},
                      divideUp(uint64_t(cell_width) * cell_height, kGroupSize), hemicubes);
    commands.barrier();
    commands.copy(sums, host_sums, 4ull * hemicubes * polygon_count);
    commands.submitAndWait();
  }
};

Hemicube::Hemicube(const Device& device, const Scene& scene, uint32_t resolution)
    : state_(std::make_unique<State>(device, scene, resolution)) {}
Hemicube::~Hemicube() = default;

void Hemicube::lookOnce() {
  const Eye eye{0, glm::dvec3(0), {0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  state_->look(std::span(&eye, 1));
}

ExchangeMatrix Hemicube::compute(uint32_t points_per_polygon, uint64_t seed) {
  State& state = *state_;
  const Scene& scene = state.scene;
  ExchangeMatrix exchange(state.polygon_count);
  std::vector<Eye> eyes;
  const auto lookAndAdd = [&] {
    state.look(eyes);
    const std::span<const uint32_t> sums = state.host_sums.mapped<const uint32_t>();
    for (size_t k = 0; k < eyes.size(); ++k) {
      const uint32_t i = eyes[k].polygon;
      const double share = 1 / (kWeightOne * points_per_polygon * std::sqrt(scene.polygons[i].area));
      for (uint32_t j = 0; j < state.polygon_count; ++j)
        if (const uint32_t sum = sums[k * state.polygon_count + j]; sum && j != i) exchange.at(i, j) += sum * share;
    }
    eyes.clear();
  };
  for (uint32_t i = 0; i < state.polygon_count; ++i) {
    const Polygon& polygon = scene.polygons[i];
    const glm::dvec3 normal = (polygon.front_along_plane_normal ? 1.0 : -1.0) * scene.planes[polygon.plane].normal;
    const glm::dvec3 x = glm::normalize(scene.corners[polygon.first_corner + 1] - scene.corners[polygon.first_corner]),
                     y = glm::cross(normal, x);
    PointSource source(Points::sobol, seed, i);
    for (uint32_t k = 0; k < points_per_polygon; ++k) {
      const auto point = source.next();
      glm::dvec3 at(0);
      if (points_per_polygon > 1) at = pointOn(scene, polygon, point[0] * 0x1p-32, point[1] * 0x1p-32);
      else
        for (uint32_t c = 0; c < polygon.corner_count; ++c)
          at += scene.corners[polygon.first_corner + c] / double(polygon.corner_count);
      const double turn_rad = point[2] * 0x1p-32 * 2 * std::numbers::pi;
      const glm::dvec3 turned = std::cos(turn_rad) * x + std::sin(turn_rad) * y;
      eyes.push_back({i, at, normal, turned, glm::cross(normal, turned)});
      if (eyes.size() == state.batch) lookAndAdd();
    }
  }
  if (!eyes.empty()) lookAndAdd();
  for (uint32_t i = 0; i < state.polygon_count; ++i)
    for (uint32_t j = i + 1; j < state.polygon_count; ++j)
      if (double& value = exchange.at(i, j); value > 0)
        value /= std::pow(scene.polygons[i].area, -1.5) + std::pow(scene.polygons[j].area, -1.5);
  return exchange;
}

}  // namespace viewpeel::bench
