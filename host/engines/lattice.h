// The engines that count lattice points share these functions.
#pragma once
#include <span>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "vulkan/buffer.h"

namespace viewpeel {

// SceneBuffers hold the scene as the shaders read it.
struct SceneBuffers {
  Buffer polygons;  // PolygonData[polygon_count], as texels too
  Buffer corners;   // CornerData[corner_count], as texels only
  uint32_t polygon_count;

  SceneBuffers(const Device& device, const Scene& scene, const Ids& ids);
};

// Returns the fraction bits of snapped coordinates: lattice coordinates stay within resolution / 2 (1 +
// |window.centre|) + 1, and kSnapBits hold them.
//   Throws: Error bad_usage where the resolution is out of range.
int chooseFractionBits(int resolution, const Window& window = {});

// This is the number of fraction bits of a column coordinate with scanlines: an interval's ends are rounded to 2^-10 of
// a spacing.
constexpr int kScanlineBits = 10;

// Returns the number of lattice points from the middle of a window to its border.
int windowReach(int resolution, const Window& window = {});

// Returns the area of a lattice point, unit-ball units squared.
inline double pointArea(int resolution) { return 4.0 / (double(resolution) * resolution); }

// Returns the place of the lattice's origin in P(u), in spacings: in the middle of the window, within a spacing. The
// lattice itself is the direction's, the same in all windows of a resolution.
glm::dvec2 latticeOrigin(const Direction& direction, int resolution, const Window& window);

// Returns the same bits as the shaders' (projection.glsl): the same operations in the same order.
[[gnu::always_inline]] inline double dotInOrder(double ax, double ay, double az, const glm::dvec3& b) {
  return ax * b.x + ay * b.y + az * b.z;
}

// Writes DirectionData[directions.size()] into an upload buffer.
//   In: first: the number of directions before the first one; block_directions: of each block
void writeDirections(std::span<const Direction> directions, int resolution, const Window& window, Buffer& buffer,
                     uint64_t first, uint64_t block_directions);

constexpr uint32_t divideUp(uint64_t value, uint64_t by) { return static_cast<uint32_t>((value + by - 1) / by); }

}  // namespace viewpeel
