// Sets of random directions, every one of them uniform on the sphere by itself.
#pragma once
#include <cstdint>
#include <vector>

#include "directions/direction.h"

namespace viewpeel {

enum class Sampler {
  iid,        // independent: the paper's own (Pellegrini 1997, section 5)
  fibonacci,  // spherical Fibonacci lattice under one random rotation (Marques et al. 2013; rotation: Shoemake 1992)
  jittered,   // independent, one in each of `count` regions of equal area: zones cut into cells (Leopardi 2006); under one random rotation
  sobol,      // the first two dimensions of Sobol's sequence, scrambled (Owen 1995), through the equal-area map of the cylinder; rotated, too
};

// The directions of one replicate, each with a lattice offset uniform in [0, 1)^2 and a lattice rotation uniform about u.
//   In: count > 0; seed, replicate: any    Out: count directions, a function of the arguments only
//   Error: axes orthonormal to 1e-15; uniformity tested in tests/device/directions_test.cpp.
//   Cost: O(count).
std::vector<Direction> sampleDirections(Sampler sampler, uint32_t count, uint64_t seed, uint64_t replicate);

// Independent random lattices, offset and rotation, along one direction.
//   In: u of unit length    Out: count directions that differ in axes and offset only
std::vector<Direction> sampleLattices(const glm::dvec3& u, uint32_t count, uint64_t seed);

}  // namespace viewpeel
