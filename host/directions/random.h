// Random numbers and random lattices are the same on every platform.
#pragma once
#include <cstdint>
#include <random>

#include <viewpeel/engine.h>

namespace viewpeel {

// A Random is the stream of one replicate.
class Random {
 public:
  Random(uint64_t seed, uint64_t replicate) {
    std::seed_seq words{uint32_t(seed), uint32_t(seed >> 32), uint32_t(replicate), uint32_t(replicate >> 32)};
    engine_.seed(words);
  }
  // Numbers are uniform in [0, 1), the same on every platform.
  uint64_t word() { return engine_(); }
  double uniform() { return double(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

// Returns the direction along a vector, with a lattice turned uniformly about it and shifted uniformly.    In: not zero
Direction directionAlong(const glm::dvec3& along, Random& random);

}  // namespace viewpeel
