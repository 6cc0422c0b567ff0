// These functions draw candidates for lines between two patches. They bound rounding errors, so that it is known which
// candidates surely are lines of the pair, and which lines surely pass a blocker. Uniform lines keep some candidates by
// chance (uniform_lines.cpp); lines in strata keep all with their weights (strata_lines.cpp). Sixteen candidates in
// single precision and one in double have the same formulas.
#pragma once
#include <cstdint>

#include "hash.h"
#include "lanes.h"
#include "pair_lines/uniform_lines.h"

namespace viewpeel {

constexpr float kLeastSlope = 1e-18f;  // least slope that is divided by, so that nothing overflows

// Generators are sixteen generators xoshiro128++ side by side (D. Blackman, S. Vigna, Scrambled linear pseudorandom
// number generators, ACM Trans. Math. Softw. 47, 2021).
template <class Words>
struct Generators {
  Words state[4];

  explicit Generators(uint64_t stream) {
    uint32_t words[4][kLineLanes];
    for (int lane = 0; lane < kLineLanes; ++lane)
      for (int half = 0; half < 2; ++half) {
        Hash hash;
        hash.add(stream);
        hash.add(uint64_t(2 * lane + half));
        for (int round = 0; round < 3; ++round) hash.add(uint64_t(round));
        words[2 * half][lane] = static_cast<uint32_t>(hash.value() >> 32);
        words[2 * half + 1][lane] = static_cast<uint32_t>(hash.value()) | 1u;  // the state must not be 0
      }
    for (int k = 0; k < 4; ++k) state[k] = load<Words>(words[k]);
  }

  VIEWPEEL_INLINE static Words rotate(const Words& x, int by) { return (x << by) | (x >> (32 - by)); }

  VIEWPEEL_INLINE Words next() {
    const Words result = rotate(state[0] + state[3], 7) + state[0], shifted = state[1] << 9;
    state[2] ^= state[0], state[3] ^= state[1], state[1] ^= state[2], state[0] ^= state[3];
    state[2] ^= shifted;
    state[3] = rotate(state[3], 11);
    return result;
  }
};

constexpr int kNumbers = 5;  // random numbers that a candidate takes; the last one decides whether it is kept

// Returns numbers in [0, 1) of 24 random bits.
template <class Words>
VIEWPEEL_INLINE typename Words::Floats unitNumber(const Words& words) {
  return floatsOf(words >> 8) * 0x1p-24f;
}

// Returns a random number in [0, 1) of 53 bits, which begin with the bits of words[d].    In: words: kNumbers
inline double withFurtherDigits(const uint32_t* words, int d) {
  Hash hash;
  for (int k = 0; k < kNumbers; ++k) hash.add(words[(d + k) % kNumbers]);
  return (words[d] + double(hash.value() >> 11) * 0x1p-53) * 0x1p-32;
}

// Candidates are sixteen candidates for lines, or one, with bounds that say how surely they are lines of the pair.
template <class Lanes>
struct Candidates {
  LaneVector<Lanes> p, d, q;     // each runs from p along d and arrives at q
  Lanes arrival, arrival_error;  // q = p + arrival d
  // A candidate is surely a line of the pair where `inside` is above 0, and surely none where `outside` is below 0.
  Lanes inside, outside;
  Lanes weight;  // as a share of the largest weight
};

template <class Lanes>
VIEWPEEL_INLINE void require(Candidates<Lanes>& lines, const Lanes& above_0, const Lanes& error) {
  lines.inside = least(lines.inside, above_0 - error), lines.outside = least(lines.outside, above_0 + error);
}

template <class Floats>
VIEWPEEL_INLINE Floats rootOf(Floats x) {
  for (int lane = 0; lane < kLineLanes; ++lane) x.set(lane, __builtin_sqrtf(x[lane]));
  return x;
}
VIEWPEEL_INLINE double rootOf(double x) { return __builtin_sqrt(x); }

template <class Geometry, class Lanes>
VIEWPEEL_INLINE Candidates<Lanes> drawPoints(const Geometry& of, const Lanes* u) {
  Candidates<Lanes> lines;
  Lanes density_p, density_q;
  lines.p = pointOn(of.first, u[0], u[1], density_p);
  lines.q = pointOn(of.second, u[2], u[3], density_q);
  lines.d = {lines.q.x - lines.p.x, lines.q.y - lines.p.y, lines.q.z - lines.p.z};
  lines.arrival = Lanes(1), lines.arrival_error = Lanes(0);
  const Lanes out = dot(of.first.normal, lines.d), in = -dot(of.second.normal, lines.d), square = dot(lines.d, lines.d);
  lines.weight = (out * in) / (square * square) * (density_p * density_q) * of.scale;
  lines.inside = lines.outside = Lanes(1);
  require(lines, out, Lanes(of.place_error));
  require(lines, in, Lanes(of.place_error));
  return lines;
}

template <class Geometry, class Lanes>
VIEWPEEL_INLINE Candidates<Lanes> drawDirections(const Geometry& of, const Lanes* u) {
  Candidates<Lanes> lines;
  Lanes density;
  lines.p = pointOn(of.first, u[0], u[1], density);
  // The direction is uniform in a part of the disk below the hemisphere, by W. Nusselt's projection (1928).
  const Lanes x = of.disk_low[0] + of.disk_size[0] * u[2], y = of.disk_low[1] + of.disk_size[1] * u[3],
              cosine2 = 1.0f - x * x - y * y, z = rootOf(greatest(cosine2, Lanes(of.least_cosine2)));
  const auto along = [&](int axis) __attribute__((always_inline)) {
    return x * of.axes[0][axis] + y * of.axes[1][axis] + z * of.axes[2][axis];
  };
  lines.d = {along(0), along(1), along(2)};
  const Lanes height = dot(of.second.normal, lines.p) - of.second.offset, slope = -dot(of.second.normal, lines.d),
              inverse = 1.0f / greatest(slope, Lanes(kLeastSlope));
  lines.arrival = height * inverse;
  lines.arrival_error = of.place_error * (1.0f + sizeOf(lines.arrival)) * inverse;
  lines.q = {lines.p.x + lines.arrival * lines.d.x, lines.p.y + lines.arrival * lines.d.y,
             lines.p.z + lines.arrival * lines.d.z};
  lines.inside = lines.outside = Lanes(1);
  require(lines, height, Lanes(of.place_error));
  require(lines, slope, Lanes(of.place_error));
  lines.weight = density * of.scale;
  require(lines, -beyond(of.second.edges, of.second.edge_count, lines.q),
          of.place_error + of.reach * lines.arrival_error);
  // Near the disk's rim z = sqrt(1 - x^2 - y^2) is not accurate, so the candidate is undecided.
  lines.inside = ifBelow(of.least_cosine2, cosine2, lines.inside, Lanes(-1));
  lines.outside = ifBelow(of.least_cosine2, cosine2, lines.outside, cosine2 + of.least_cosine2);
  return lines;
}

template <class Geometry, class Lanes>
VIEWPEEL_INLINE Candidates<Lanes> drawContacts(const Geometry& of, const Lanes* u) {
  Candidates<Lanes> lines;
  Lanes density;
  lines.p = lines.q = pointOn(of.first, u[0], u[1], density);
  lines.d = LaneVector<Lanes>{};
  lines.arrival = lines.arrival_error = Lanes(0);
  lines.inside = lines.outside = Lanes(1);
  lines.weight = density * of.scale;
  require(lines, -beyond(of.second.edges, of.second.edge_count, lines.p), Lanes(of.place_error));
  return lines;
}

template <class Geometry, class Lanes>
VIEWPEEL_INLINE Candidates<Lanes> drawCandidate(UniformWay way, const Geometry& of, const Lanes* u) {
  return way == UniformWay::points       ? drawPoints(of, u)
         : way == UniformWay::directions ? drawDirections(of, u)
                                         : drawContacts(of, u);
}

// Returns by how much lines miss a blocker. Out: above `error` where a line surely misses it; below -error where a line
// surely meets it
template <class Number, class Geometry, class Lanes>
VIEWPEEL_INLINE Lanes passing(const Obstacle<Number>& by, const Geometry& of, const Candidates<Lanes>& lines,
                              Lanes& error) {
  if (by.place != BlockerPlace::between) {
    error = of.place_error + of.reach * lines.arrival_error;
    return beyond(by.edges, by.edge_count, by.place == BlockerPlace::over_first ? lines.p : lines.q);
  }
  const Lanes at_p = dot(by.plane, lines.p) + by.plane[3], tilt = dot(by.plane, lines.d), tiny = Lanes(kLeastSlope),
              slope = ifBelow(sizeOf(tilt), tiny, tiny, tilt), inverse = 1.0f / slope, t = -at_p * inverse;
  const LaneVector<Lanes> x{lines.p.x + t * lines.d.x, lines.p.y + t * lines.d.y, lines.p.z + t * lines.d.z};
  error = of.place_error * (1.0f + of.reach * (1.0f + sizeOf(t)) * sizeOf(inverse)) + of.reach * lines.arrival_error;
  return greatest(of.reach * greatest(-t, t - lines.arrival), beyond(by.edges, by.edge_count, x));
}

}  // namespace viewpeel
