// This header names the ways to draw directions and to sample along one, and their limits.
#pragma once
#include <array>
#include <string>
#include <utility>

namespace viewpeel {

// A Sampler draws the directions of a replicate. By itself, each direction is uniform on the sphere.
enum class Sampler {
  iid,        // independent, as in the paper (Pellegrini 1997, section 5)
  fibonacci,  // spherical Fibonacci lattice under one random rotation (Marques et al. 2013; rotation: Shoemake 1992)
  // The sphere is cut into as many regions of equal area as there are directions: zones, cut into cells (Leopardi
  // 2006). Each region gets one independent direction. One random rotation turns all of them.
  jittered,
  // The first two dimensions of Sobol's sequence, scrambled (Owen 1995), go through the equal-area map from the
  // cylinder to the sphere. One random rotation turns all directions.
  sobol,
};

// The program's options use these names.
inline constexpr std::array<std::pair<const char*, Sampler>, 4> kSamplerNames = {{{"fibonacci", Sampler::fibonacci},
                                                                                  {"jittered", Sampler::jittered},
                                                                                  {"sobol", Sampler::sobol},
                                                                                  {"iid", Sampler::iid}}};
// Returns the name of a sampler: "fibonacci" and so on.    Cost: O(1).
std::string nameOf(Sampler sampler);

// Sampling is one of two ways to sample a projection along a direction.
enum class Sampling {
  lattice,  // samples are lattice points, each of weight 1
  // Samples are intervals of lattice rows, weighted by their length. An interval ends where a polygon begins or ends,
  // and every 32 columns.
  scanline,
};

// The finest lattice of a whole scene has this resolution: the number of spacings across the unit ball's diameter.
// Every device can dispatch 65,535 workgroups in one row. With 64 points each that is enough for up to 2043 x 2043
// points.
constexpr int kMaxResolution = 2039;

// A window may have a lattice of up to this resolution. The snapped corners of the whole scene then keep 4 bits for
// fractions of a spacing.
constexpr int kMaxWindowResolution = 1 << 20;
constexpr int kMostWindowPoints = 8192;  // lattice points across a window
// With scanlines the limit is lower, because the ends of intervals need 10 bits for fractions of a spacing.
constexpr int kMaxScanlineResolution = 1 << 14;

// Returns the finest resolution that a window may have.
constexpr int maxWindowResolution(Sampling sampling) {
  return sampling == Sampling::scanline ? kMaxScanlineResolution : kMaxWindowResolution;
}

}  // namespace viewpeel
