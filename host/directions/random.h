// Random draws the random numbers of a replicate, and directionAlong random lattices. Both have the same bits on every
// platform.
#pragma once
#include <cstdint>
#include <random>

#include <viewpeel/engine.h>

namespace viewpeel {

// A Random is the stream of random numbers of one replicate.
class Random {
 public:
  Random(uint64_t seed, uint64_t replicate) {
    std::seed_seq words{uint32_t(seed), uint32_t(seed >> 32), uint32_t(replicate), uint32_t(replicate >> 32)};
    engine_.seed(words);
  }
  // Returns the next 64 random bits.
  uint64_t word() { return engine_(); }
  // Returns the next number, uniform in [0, 1).
  double uniform() { return double(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

// Returns the direction along a vector, with a lattice whose rotation about it and offset are uniform.
//   In: along: a vector of any length above 0
Direction directionAlong(const glm::dvec3& along, Random& random);

}  // namespace viewpeel
