// Directions and samples have these kinds and limits.
#pragma once
#include <array>
#include <string>
#include <utility>

namespace viewpeel {

// A Sampler draws the set of directions of a replicate, each direction uniform on the sphere by itself.
enum class Sampler {
  iid,        // independent: the paper's own (Pellegrini 1997, section 5)
  fibonacci,  // spherical Fibonacci lattice under one random rotation (Marques et al. 2013; rotation: Shoemake 1992)
  // It draws independent directions, one in each of `count` regions of equal area under one random rotation: zones cut
  // into cells (Leopardi 2006).
  jittered,
  // It takes the first two dimensions of Sobol's sequence, scrambled (Owen 1995), through the equal-area map of the
  // cylinder; rotated, too.
  sobol,
};

// The program has these names for them.
inline constexpr std::array<std::pair<const char*, Sampler>, 4> kSamplerNames = {{{"fibonacci", Sampler::fibonacci},
                                                                                  {"jittered", Sampler::jittered},
                                                                                  {"sobol", Sampler::sobol},
                                                                                  {"iid", Sampler::iid}}};
// Returns the name of a sampler: "fibonacci" and so on.    Cost: O(1).
std::string nameOf(Sampler sampler);

// A direction is sampled in one of two ways.
enum class Sampling {
  lattice,  // points, each of weight one
  // Samples are the intervals of lattice rows between two ends of polygons, cut every 32 columns, with their lengths as
  // weights.
  scanline,
};

// The finest lattice of a whole scene has this resolution. One of 2043 x 2043 points is the largest whose groups of 64
// every device can dispatch in one row (65,535).
constexpr int kMaxResolution = 2039;

// The finest lattice of a window leaves corners across the whole scene 4 bits after the point.
constexpr int kMaxWindowResolution = 1 << 20;
constexpr int kMostWindowPoints = 8192;  // across a window
// Scanlines in windows are coarser: corners keep the 10 bits that ends of intervals have.
constexpr int kMaxScanlineResolution = 1 << 14;

// Returns the finest resolution of windows: lattice spacings across the scene's diameter, at most.
constexpr int maxWindowResolution(Sampling sampling) {
  return sampling == Sampling::scanline ? kMaxScanlineResolution : kMaxWindowResolution;
}

}  // namespace viewpeel
