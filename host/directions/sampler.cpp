#include "directions/sampler.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "directions/random.h"

namespace viewpeel {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

// Returns a rotation uniform over SO(3), from a uniform unit quaternion (Shoemake 1992).
glm::dmat3 randomRotation(Random& random) {
  const double a = random.uniform(), b = kTwoPi * random.uniform(), c = kTwoPi * random.uniform();
  const double x = std::sqrt(1 - a) * std::sin(b), y = std::sqrt(1 - a) * std::cos(b);
  const double z = std::sqrt(a) * std::sin(c), w = std::sqrt(a) * std::cos(c);
  return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
          2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
          2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
}

glm::dvec3 fromHeightAndAzimuth(double z, double azimuth_rad) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), z};
}

// Appends one direction in each of `count` cells of equal area. The sphere is cut into zones about as high as their
// cells are wide, and each zone at equal azimuths into cells.
void addJittered(uint32_t count, const glm::dmat3& rotation, Random& random, std::vector<Direction>& directions) {
  const double side_rad = std::sqrt(4 * std::numbers::pi / count);
  const auto zones = std::max<uint32_t>(1, static_cast<uint32_t>(std::lround(std::numbers::pi / side_rad)));
  for (uint32_t zone = 0, done = 0; zone < zones; ++zone) {
    // The zones up to this one have the whole number of cells that is nearest to their share of the sphere.
    const double share = (1 - std::cos(std::numbers::pi * (zone + 1) / zones)) / 2;
    const auto end =
        zone + 1 == zones ? count : std::max<uint32_t>(done, static_cast<uint32_t>(std::lround(share * count)));
    const uint32_t cells = end - done;
    for (uint32_t cell = 0; cell < cells; ++cell) {
      const double z = 1 - 2 * (done + cells * random.uniform()) / count;
      directions.push_back(
          directionAlong(rotation * fromHeightAndAzimuth(z, kTwoPi * (cell + random.uniform()) / cells), random));
    }
    done = end;
  }
}

// Returns a bit that depends on all bits of the key.
uint32_t randomBit(uint64_t key) {
  key = (key ^ key >> 31) * 0x7FB5D329728EA185ull;
  key = (key ^ key >> 27) * 0x81DADEF4BC2DD44Dull;
  return static_cast<uint32_t>(key >> 63);
}

// Returns a number in [0, 1) from 32 binary digits that are scrambled as Owen does. Each digit is flipped or not by a
// random bit that depends on the digits before it.
double scramble(uint32_t bits, uint64_t seed) {
  uint32_t scrambled = 0;
  for (uint32_t level = 0; level < 32; ++level) {
    const uint64_t before = level == 0 ? 0 : bits >> (32 - level);
    scrambled |=
        ((bits >> (31 - level) & 1) ^ randomBit(seed + 0x9E3779B97F4A7C15ull * (before + (uint64_t(1) << level))))
        << (31 - level);
  }
  return (scrambled + 0.5) * 0x1p-32;
}

uint32_t reverseBits(uint32_t x) {
  uint32_t reversed = 0;
  for (int k = 0; k < 32; ++k) reversed = reversed << 1 | (x >> k & 1);
  return reversed;
}

// Returns the second coordinate of a point of Sobol's sequence, times 2^32. Its direction numbers follow from the
// polynomial x + 1.
uint32_t sobolSecond(uint32_t index) {
  uint32_t x = 0;
  for (uint32_t direction = 1u << 31; index; index >>= 1, direction ^= direction >> 1)
    if (index & 1) x ^= direction;
  return x;
}

}  // namespace

std::string nameOf(Sampler sampler) {
  for (const auto& [name, value] : kSamplerNames)
    if (value == sampler) return name;
  return {};
}

std::vector<Direction> sampleDirections(Sampler sampler, uint32_t count, uint64_t seed, uint64_t replicate) {
  Random random(seed, replicate);
  std::vector<Direction> directions;
  directions.reserve(count);
  if (sampler == Sampler::fibonacci) {
    const double golden_angle_rad = std::numbers::pi * (3 - std::sqrt(5.0));
    const glm::dmat3 rotation = randomRotation(random);
    for (uint32_t k = 0; k < count; ++k)
      directions.push_back(
          directionAlong(rotation * fromHeightAndAzimuth(1 - (2.0 * k + 1) / count, golden_angle_rad * k), random));
  } else if (sampler == Sampler::jittered) {
    const glm::dmat3 rotation = randomRotation(random);
    addJittered(count, rotation, random, directions);
  } else if (sampler == Sampler::sobol) {
    const glm::dmat3 rotation = randomRotation(random);
    const uint64_t first = random.word(), second = random.word();
    for (uint32_t k = 0; k < count; ++k)
      directions.push_back(directionAlong(rotation * fromHeightAndAzimuth(1 - 2 * scramble(reverseBits(k), first),
                                                                          kTwoPi * scramble(sobolSecond(k), second)),
                                          random));
  } else {
    for (uint32_t k = 0; k < count; ++k) {
      const double z = 2 * random.uniform() - 1;
      directions.push_back(directionAlong(fromHeightAndAzimuth(z, kTwoPi * random.uniform()), random));
    }
  }
  return directions;
}

std::vector<Direction> sampleReplicates(Sampler sampler, uint32_t count, uint64_t seed, uint64_t first,
                                        uint64_t replicates) {
  std::vector<Direction> directions;
  for (uint64_t replicate = first; replicate < first + replicates; ++replicate)
    std::ranges::copy(sampleDirections(sampler, count, seed, replicate), std::back_inserter(directions));
  return directions;
}

std::vector<Direction> sampleLattices(const glm::dvec3& u, uint32_t count, uint64_t seed) {
  Random random(seed, 0);
  std::vector<Direction> directions;
  for (uint32_t k = 0; k < count; ++k) directions.push_back(directionAlong(u, random));
  return directions;
}

}  // namespace viewpeel
