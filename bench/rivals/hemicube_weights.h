// The pixels of a hemicube have delta form factors as weights: the part of a point's radiation that passes each pixel,
// integrated over the pixel (M. F. Cohen & D. P. Greenberg, The hemi-cube, SIGGRAPH 1985).
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace viewpeel::bench {

// The faces of a hemicube of resolution R lie in a cell of 3 R x R pixels. The top has R x R pixels. Beside it the four
// sides lie in two rows, R x R / 2 each, with the horizon at the lower y.
struct HemicubeFace {
  uint32_t x, y, width, height;
};
inline HemicubeFace hemicubeFace(uint32_t face, uint32_t resolution) {
  if (face == 0) return {0, 0, resolution, resolution};
  return {resolution * (1 + (face - 1) % 2), (face - 1) / 2 * (resolution / 2), resolution, resolution / 2};
}

// Returns the weights of the pixels of a cell; they sum to 1.    In: resolution: even
inline std::vector<double> hemicubeWeights(uint32_t resolution) {
  // The integrands are 1 / (pi (1 + x^2 + y^2)^2) over the top and z / (pi (1 + y^2 + z^2)^2) over a side.
  const auto top = [](double x, double y) {
    const double p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
    return (x / p * std::atan(y / p) + y / q * std::atan(x / q)) / (2 * std::numbers::pi);
  };
  const auto side = [](double y, double z) {
    return -std::atan(y / std::sqrt(1 + z * z)) / std::sqrt(1 + z * z) / (2 * std::numbers::pi);
  };
  std::vector<double> weights(3 * uint64_t(resolution) * resolution, 0);
  for (uint32_t face = 0; face < 5; ++face) {
    const HemicubeFace place = hemicubeFace(face, resolution);
    const auto integral = [&](double x, double y) { return face == 0 ? top(x, y) : side(x, y); };
    const double pixel = 2.0 / resolution, left = -1, low = face == 0 ? -1 : 0;
    for (uint32_t y = 0; y < place.height; ++y)
      for (uint32_t x = 0; x < place.width; ++x) {
        const double x0 = left + x * pixel, x1 = left + (x + 1) * pixel, y0 = low + y * pixel,
                     y1 = low + (y + 1) * pixel;
        weights[uint64_t(place.y + y) * 3 * resolution + place.x + x] =
            integral(x1, y1) - integral(x0, y1) - integral(x1, y0) + integral(x0, y0);
      }
  }
  return weights;
}

}  // namespace viewpeel::bench
