// Sets of random directions, every one of them uniform on the sphere by itself.
#pragma once
#include <vector>

#include <viewpeel/engine.h>
#include <viewpeel/sampling.h>

namespace viewpeel {

// Draws the directions of one replicate, each with a lattice offset uniform in [0, 1)^2 and a lattice rotation uniform
// about u.
//   In: count > 0; seed, replicate: any    Out: count directions, a function of the arguments only
//   Error: axes orthonormal to 1e-15; uniformity tested in tests/unit/directions_test.cpp.
//   Cost: O(count).
std::vector<Direction> sampleDirections(Sampler sampler, uint32_t count, uint64_t seed, uint64_t replicate);

// Draws independent random lattices, offset and rotation, along one direction.
//   In: u of unit length    Out: count directions that differ in axes and offset only
std::vector<Direction> sampleLattices(const glm::dvec3& u, uint32_t count, uint64_t seed);

}  // namespace viewpeel
