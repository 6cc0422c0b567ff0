// sampleDirections draws sets of random directions, each of which is uniform on the sphere by itself.
#pragma once
#include <vector>

#include <viewpeel/engine.h>
#include <viewpeel/sampling.h>

namespace viewpeel {

// Draws the directions of one replicate, each with a lattice offset uniform in [0, 1)^2 and a lattice rotation uniform
// about u.
//   In: count: number of directions, above 0; seed, replicate: any
//   Out: count directions. The same arguments give the same bits.
//   Error: axes are orthonormal to 1e-15; tests/unit/directions_test.cpp tests uniformity.
//   Cost: O(count).
std::vector<Direction> sampleDirections(Sampler sampler, uint32_t count, uint64_t seed, uint64_t replicate);

// Draws the directions of several replicates, one after another, as Engine::countBlocks() takes them.
//   In: first: the first replicate; others as sampleDirections()    Out: replicates x count directions
std::vector<Direction> sampleReplicates(Sampler sampler, uint32_t count, uint64_t seed, uint64_t first,
                                        uint64_t replicates);

// Draws lattices of independent random offset and rotation along one direction.
//   In: u: a unit vector; count: number of lattices    Out: count directions that differ only in axes and offset
std::vector<Direction> sampleLattices(const glm::dvec3& u, uint32_t count, uint64_t seed);

}  // namespace viewpeel
