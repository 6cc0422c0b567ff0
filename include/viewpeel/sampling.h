// Which directions lines have, and where in a projection they lie.
#pragma once
#include <array>
#include <string>
#include <utility>

namespace viewpeel {

// Sets of directions of a replicate, each direction uniform on the sphere by itself.
enum class Sampler {
  iid,        // independent: the paper's own (Pellegrini 1997, section 5)
  fibonacci,  // spherical Fibonacci lattice under one random rotation (Marques et al. 2013; rotation: Shoemake 1992)
  jittered,   // independent, one in each of `count` regions of equal area: zones cut into cells (Leopardi 2006); under
              // one random rotation
  sobol,      // the first two dimensions of Sobol's sequence, scrambled (Owen 1995), through the equal-area map of the
              // cylinder; rotated, too
};

// Their names, as the program has them.
inline constexpr std::array<std::pair<const char*, Sampler>, 4> kSamplerNames = {{{"fibonacci", Sampler::fibonacci},
                                                                                  {"jittered", Sampler::jittered},
                                                                                  {"sobol", Sampler::sobol},
                                                                                  {"iid", Sampler::iid}}};
// "fibonacci" and so on.    Cost: O(1).
std::string nameOf(Sampler sampler);

// Samples of a direction.
enum class Sampling {
  lattice,   // points, each of weight one
  scanline,  // the intervals of lattice rows between two ends of polygons, cut every 32 columns, with their lengths as
             // weights
};

// The finest lattice of a whole scene. One of 2043 x 2043 points is the largest whose groups of 64 every device can
// dispatch in one row (65,535).
constexpr int kMaxResolution = 2039;

// The finest lattice of a window: corners across the whole scene still have 4 bits after the point.
constexpr int kMaxWindowResolution = 1 << 20;
constexpr int kMostWindowPoints = 8192;  // across a window
constexpr int kMaxScanlineResolution =
    1 << 14;  // of scanlines in windows: corners keep the 10 bits that ends of intervals have

// The finest that windows can be: lattice spacings across the scene's diameter, at most.
constexpr int maxWindowResolution(Sampling sampling) {
  return sampling == Sampling::scanline ? kMaxScanlineResolution : kMaxWindowResolution;
}

}  // namespace viewpeel
