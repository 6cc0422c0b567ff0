// The engines that count on a lattice share these functions.
#pragma once
#include <span>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "vulkan/buffer.h"

namespace viewpeel {

// SceneBuffers hold the scene on the device, as the shaders read it.
struct SceneBuffers {
  Buffer polygons;  // PolygonData[polygon_count]
  Buffer corners;   // CornerData[corner_count]
  uint32_t polygon_count;

  SceneBuffers(const Device& device, const Scene& scene, const Ids& ids);
};

// Returns the number of binary digits after the point of snapped coordinates. Lattice coordinates are at most
// resolution / 2 (1 + |window.centre|) + 1 in size, and kSnapBits bits hold them with their fraction.
//   Throws: Error bad_usage where the resolution is out of range.
int chooseFractionBits(int resolution, const Window& window = {});

// With scanlines, columns are in units of 2^-10 spacings: the ends of spans are rounded to them.
constexpr int kScanlineBits = 10;

// Returns the number n such that a window, wherever the lattice's offset puts it, lies between the lattice points -n
// and n - 1 in x and y.
int windowReach(int resolution, const Window& window = {});

// Returns the area that one lattice point stands for, h^2 with h = 2 / resolution, in unit-ball units squared.
inline double pointArea(int resolution) { return 4.0 / (double(resolution) * resolution); }

// Returns the average number of lattice points, or scanlines, of one direction that meet an id. The id's mean
// projection is taken for a square.
//   In: area: of the id, unit-ball units squared; h: spacing, unit-ball units
double expectedPoints(Sampling sampling, double area, double h);

// Returns the offset of lattice coordinates, in spacings: the direction's offset, moved by whole spacings so that the
// window's centre is within a spacing of lattice point (0, 0). All windows of one resolution thus have the same
// lattice.
glm::dvec2 latticeOrigin(const Direction& direction, int resolution, const Window& window);

// Returns a . b with the same bits as dotInOrder in projection.glsl, by the same operations in the same order.
[[gnu::always_inline]] inline double dotInOrder(double ax, double ay, double az, const glm::dvec3& b) {
  return ax * b.x + ay * b.y + az * b.z;
}

// Writes DirectionData[directions.size()] into an upload buffer.
//   In: first: number, within the call, of the first direction; block_directions: directions in each block
void writeDirections(std::span<const Direction> directions, int resolution, const Window& window, Buffer& buffer,
                     uint64_t first, uint64_t block_directions);

constexpr uint32_t divideUp(uint64_t value, uint64_t by) { return static_cast<uint32_t>((value + by - 1) / by); }

}  // namespace viewpeel
