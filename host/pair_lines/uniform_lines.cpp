#include "pair_lines/uniform_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "hash.h"
#include "pair_lines/lanes.h"

namespace viewpeel {
namespace {

using glm::dvec3;

// Rounding moves places by less than this number of units in the last place of the largest coordinate. The 2^-24 or
// 2^-53 of random numbers are included: docs/method.md, section 14.
constexpr double kPlaceUlps = 64;
constexpr double kUlp[] = {0x1p-24, 0x1p-53};
// Below this square of the cosine, sqrt(1 - x^2 - y^2) loses more than kPlaceUlps.
constexpr double kLeastCosine2[] = {1.0 / 64, 1e-8};
constexpr float kLeastSlope = 1e-18f;  // least slope that is divided by, so that nothing overflows
// More candidates than this multiple of their expected number show that the exchange area is wrong.
constexpr double kMostCandidates = 64;
constexpr uint64_t kFreeCandidates = 1 << 10;

// Generators are sixteen generators xoshiro128++ side by side (D. Blackman, S. Vigna, Scrambled linear pseudorandom
// number generators, ACM Trans. Math. Softw. 47, 2021).
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

constexpr int kNumbers = 5;  // random numbers that a candidate takes

// Candidates are sixteen candidates for lines, or one, with bounds that say how surely they are lines of the pair.
template <class Lanes>
struct Candidates {
  LaneVector<Lanes> p, d, q;     // each runs from p along d and arrives at q
  Lanes arrival, arrival_error;  // q = p + arrival d
  // A candidate is surely a line of the pair where `inside` is above 0, and surely none where `outside` is below 0.
  Lanes inside, outside;
};

template <class Lanes>
VIEWPEEL_INLINE void require(Candidates<Lanes>& lines, const Lanes& above_0, const Lanes& error) {
  lines.inside = least(lines.inside, above_0 - error), lines.outside = least(lines.outside, above_0 + error);
}

VIEWPEEL_INLINE Floats filled(float x, const Floats&) { return all(x); }
VIEWPEEL_INLINE double filled(double x, double) { return x; }
VIEWPEEL_INLINE Floats sizeOf(const Floats& x) { return x < 0.0f ? -x : x; }
VIEWPEEL_INLINE double sizeOf(double x) { return x < 0 ? -x : x; }
VIEWPEEL_INLINE Floats rootOf(Floats x) {
  for (int lane = 0; lane < kLineLanes; ++lane) x[lane] = __builtin_sqrtf(x[lane]);
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
  lines.arrival = filled(1, u[0]), lines.arrival_error = filled(0, u[0]);
  const Lanes out = dot(of.first.normal, lines.d), in = -dot(of.second.normal, lines.d), square = dot(lines.d, lines.d),
              weight = (out * in) / (square * square) * (density_p * density_q) * of.scale;
  lines.inside = lines.outside = filled(1, u[0]);
  require(lines, out, filled(of.place_error, u[0]));
  require(lines, in, filled(of.place_error, u[0]));
  require(lines, weight - u[4], filled(of.weight_error, u[0]));
  return lines;
}

template <class Geometry, class Lanes>
VIEWPEEL_INLINE Candidates<Lanes> drawDirections(const Geometry& of, const Lanes* u) {
  Candidates<Lanes> lines;
  Lanes density;
  lines.p = pointOn(of.first, u[0], u[1], density);
  // The direction is uniform in the disk below the hemisphere, by W. Nusselt's projection (1928).
  const Lanes x = 2.0f * u[2] - 1.0f, y = 2.0f * u[3] - 1.0f, cosine2 = 1.0f - x * x - y * y,
              z = rootOf(greatest(cosine2, filled(of.least_cosine2, x)));
  const auto along = [&](int axis) __attribute__((always_inline)) {
    return x * of.axes[0][axis] + y * of.axes[1][axis] + z * of.axes[2][axis];
  };
  lines.d = {along(0), along(1), along(2)};
  const Lanes height = dot(of.second.normal, lines.p) - of.second.offset, slope = -dot(of.second.normal, lines.d),
              inverse = 1.0f / greatest(slope, filled(kLeastSlope, x));
  lines.arrival = height * inverse;
  lines.arrival_error = of.place_error * (1.0f + sizeOf(lines.arrival)) * inverse;
  lines.q = {lines.p.x + lines.arrival * lines.d.x, lines.p.y + lines.arrival * lines.d.y,
             lines.p.z + lines.arrival * lines.d.z};
  lines.inside = lines.outside = filled(1, x);
  require(lines, height, filled(of.place_error, x));
  require(lines, slope, filled(of.place_error, x));
  require(lines, density * of.scale - u[4], filled(of.weight_error, x));
  require(lines, -beyond(of.second.edges, of.second.edge_count, lines.q),
          of.place_error + of.reach * lines.arrival_error);
  // Near the disk's rim z is not accurate, so the candidate is undecided.
  lines.inside = cosine2 > of.least_cosine2 ? lines.inside : filled(-1, x);
  lines.outside = cosine2 > of.least_cosine2 ? lines.outside : cosine2 + of.least_cosine2;
  return lines;
}

template <class Geometry, class Lanes>
VIEWPEEL_INLINE Candidates<Lanes> drawContacts(const Geometry& of, const Lanes* u) {
  Candidates<Lanes> lines;
  Lanes density;
  lines.p = lines.q = pointOn(of.first, u[0], u[1], density);
  lines.d = LaneVector<Lanes>{};
  lines.arrival = lines.arrival_error = filled(0, u[0]);
  lines.inside = lines.outside = filled(1, u[0]);
  require(lines, density * of.scale - u[4], filled(of.weight_error, u[0]));
  require(lines, -beyond(of.second.edges, of.second.edge_count, lines.p), filled(of.place_error, u[0]));
  return lines;
}

// Returns how far lines pass beyond a blocker.    Out: above `error` where a line surely passes; below -error where it
// surely does not
template <class Number, class Geometry, class Lanes>
VIEWPEEL_INLINE Lanes passing(const Obstacle<Number>& by, const Geometry& of, const Candidates<Lanes>& lines,
                              Lanes& error) {
  if (by.place != BlockerPlace::between) {
    error = of.place_error + of.reach * lines.arrival_error;
    return beyond(by.edges, by.edge_count, by.place == BlockerPlace::over_first ? lines.p : lines.q);
  }
  const Lanes at_p = dot(by.plane, lines.p) + by.plane[3], tilt = dot(by.plane, lines.d),
              tiny = filled(kLeastSlope, tilt), slope = sizeOf(tilt) < tiny ? tiny : tilt, inverse = 1.0f / slope,
              t = -at_p * inverse;
  const LaneVector<Lanes> x{lines.p.x + t * lines.d.x, lines.p.y + t * lines.d.y, lines.p.z + t * lines.d.z};
  error = of.place_error * (1.0f + of.reach * (1.0f + sizeOf(t)) * sizeOf(inverse)) + of.reach * lines.arrival_error;
  return greatest(of.reach * greatest(-t, t - lines.arrival), beyond(by.edges, by.edge_count, x));
}

dvec3 anyAcross(const dvec3& n) {
  const dvec3 size = glm::abs(n);
  const dvec3 axis = size.x <= size.y && size.x <= size.z ? dvec3(1, 0, 0)
                     : size.y <= size.z                   ? dvec3(0, 1, 0)
                                                          : dvec3(0, 0, 1);
  return glm::normalize(glm::cross(n, axis));
}

// Returns the largest height of the patch's corners in front of the other patch.
double mostInFront(const Patch& patch, const Patch& of) {
  double most = 0;
  for (uint32_t k = 0; k < patch.corner_count; ++k)
    most = std::max(most, glm::dot(of.normal, patch.corners[k]) - of.offset);
  return most;
}

template <class End>
double mostDensity(const End& end) {
  const auto [a, b, c] = std::tuple(double(end.density[0]), double(end.density[1]), double(end.density[2]));
  return end.is_folded ? a : std::max({a, a + b, a + c, a + b + c});
}

}  // namespace

// The gap between the patches along any direction is a lower bound on their distance. The patches' normals and the
// directions of Gilbert's algorithm are tried (E. Gilbert, An iterative procedure for computing the minimum of a
// quadratic form on a convex set, 1966).
double leastDistance(const Patch& a, const Patch& b) {
  constexpr int kSteps = 16;
  constexpr double kSharp = 1e-3;
  dvec3 z = b.middle - a.middle;  // a difference of a point of b and a point of a
  double best = 0;
  dvec3 nearest(0);
  const auto tryDirection = [&](const dvec3& direction) {
    double gap = INFINITY;
    for (uint32_t k = 0; k < a.corner_count; ++k)
      for (uint32_t m = 0; m < b.corner_count; ++m) {
        const dvec3 difference = b.corners[m] - a.corners[k];
        if (const double along = glm::dot(difference, direction); along < gap) gap = along, nearest = difference;
      }
    best = std::max(best, gap);
  };
  for (const Patch* patch : {&a, &b}) tryDirection(glm::dot(patch->normal, z) < 0 ? -patch->normal : patch->normal);
  for (int step = 0; step < kSteps; ++step) {
    const double length = glm::length(z);
    if (length - best <= kSharp * length) break;
    tryDirection(z / length);
    const dvec3 step_to = nearest - z;
    const double square = glm::dot(step_to, step_to);
    if (!(square > 0)) break;
    z += std::clamp(-glm::dot(z, step_to) / square, 0.0, 1.0) * step_to;
  }
  return best;
}

UniformLines::UniformLines(const Patch& a, const Patch& b, double exchange, const std::vector<Blocker>& blockers,
                           std::span<const PlacedBlocker> between) {
  const bool is_swapped = b.area < a.area;
  const Patch &small = is_swapped ? b : a, &large = is_swapped ? a : b;
  chooseWay(small, large, exchange);
  fast_ = makeGeometry<float>(small, large, blockers, between, is_swapped);
  accurate_ = makeGeometry<double>(small, large, blockers, between, is_swapped);
}

// Chooses the way that wastes the fewest candidates, and sets most_ and efficiency_.
void UniformLines::chooseWay(const Patch& small, const Patch& large, double exchange) {
  const double density = mostDensity(makeLineEnd<double>(small, small.middle, true));
  if (small.plane == large.plane) {
    way_ = Way::contact, most_ = density, efficiency_ = exchange / density;
    return;
  }
  way_ = Way::directions, most_ = density, efficiency_ = std::numbers::pi / 4 * exchange / density;
  const double r = leastDistance(small, large), out = mostInFront(large, small) / r, in = mostInFront(small, large) / r,
               most = std::min(1.0, out) * std::min(1.0, in) / (r * r) * density *
                      mostDensity(makeLineEnd<double>(large, small.middle, true));
  if (const double efficiency = std::numbers::pi * exchange / most; r > 0 && efficiency > efficiency_)
    way_ = Way::points, most_ = most, efficiency_ = efficiency;
}

template <class Number>
UniformLines::Geometry<Number> UniformLines::makeGeometry(const Patch& small, const Patch& large,
                                                          const std::vector<Blocker>& blockers,
                                                          std::span<const PlacedBlocker> between,
                                                          bool is_swapped) const {
  constexpr bool kIsDouble = std::is_same_v<Number, double>;
  const dvec3 origin = small.middle;
  Geometry<Number> of{};
  of.first = makeLineEnd<Number>(small, origin, true), of.second = makeLineEnd<Number>(large, origin, true);
  of.obstacles = makeObstacles<Number>(blockers, between, origin, is_swapped);
  double farthest = 0;
  for (const Patch* patch : {&small, &large})
    for (const dvec3& corner : patch->corners) farthest = std::max(farthest, glm::length(corner - origin));
  const double ulp = kUlp[kIsDouble], reach = way_ == Way::points ? 2 * farthest : farthest,
               place_error = kPlaceUlps * ulp * farthest;
  of.reach = static_cast<Number>(reach);
  of.scale = static_cast<Number>(1 / most_);
  of.place_error = static_cast<Number>(place_error);
  of.weight_error = static_cast<Number>(kPlaceUlps * ulp);
  of.least_cosine2 = static_cast<Number>(kLeastCosine2[kIsDouble]);
  if (way_ == Way::points) {
    // An error of place_error in cosines and distance changes a weight by this share of the largest weight.
    const double r = leastDistance(small, large), densities = mostDensity(of.first) * mostDensity(of.second);
    of.weight_error += static_cast<Number>(6 * place_error / (r * r * r) * densities / most_);
  }
  const dvec3 across = anyAcross(small.normal), axes[3] = {across, glm::cross(small.normal, across), small.normal};
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) of.axes[k][axis] = static_cast<Number>(reach * axes[k][axis]);
  return of;
}

UniformLineCount UniformLines::draw(uint64_t stream, uint64_t lines, Vectors vectors) const {
  UniformLineCount count;
  runVectorised(
      vectors, [&]() __attribute__((always_inline)) { count = drawAll(stream, lines); });
  return count;
}

// Decides about one candidate in double precision, with more digits of its random numbers.
UniformLineCount UniformLines::decide(const uint32_t* words) const {
  double u[kNumbers];
  for (int d = 0; d < kNumbers; ++d) {
    Hash hash;
    for (int k = 0; k < kNumbers; ++k) hash.add(words[(d + k) % kNumbers]);
    u[d] = (words[d] + double(hash.value() >> 11) * 0x1p-53) * 0x1p-32;
  }
  const Candidates<double> line = way_ == Way::points       ? drawPoints(accurate_, u)
                                  : way_ == Way::directions ? drawDirections(accurate_, u)
                                                            : drawContacts(accurate_, u);
  UniformLineCount count;
  if (!(line.inside > 0)) return count;  // undecided candidates are dropped, too: 1e-8 of all
  count.lines = 1;
  bool is_open = false;
  for (const Obstacle<double>& obstacle : accurate_.obstacles) {
    double error;
    const double passed = passing(obstacle, accurate_, line, error);
    if (passed < -error) return count;
    is_open |= !(passed > error);
  }
  ++(is_open ? count.open : count.facing);
  return count;
}

// Waiting lines are candidates that may be lines of the pair. Sixteen are tested at a time, for most candidates fail.
struct UniformLines::Waiting {
  static constexpr int kMost = 2 * kLineLanes;
  static constexpr int kFigures = 12;  // p, d, q, arrival, arrival_error, inside
  float figures[kFigures][kMost] = {};
  uint32_t words[kNumbers][kMost] = {};
  int count = 0;

  VIEWPEEL_INLINE void add(const Candidates<Floats>& lines, const Words* of, int lane) {
    const Floats* const from[] = {&lines.p.x, &lines.p.y,     &lines.p.z,           &lines.d.x,
                                  &lines.d.y, &lines.d.z,     &lines.q.x,           &lines.q.y,
                                  &lines.q.z, &lines.arrival, &lines.arrival_error, &lines.inside};
    for (int k = 0; k < kFigures; ++k) figures[k][count] = (*from[k])[lane];
    for (int d = 0; d < kNumbers; ++d) words[d][count] = of[d][lane];
    ++count;
  }
  VIEWPEEL_INLINE Candidates<Floats> first() const {
    const auto at = [&](int k) __attribute__((always_inline)) { return load<Floats>(figures[k]); };
    return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}, {at(6), at(7), at(8)}, at(9), at(10), at(11), Floats{}};
  }
  VIEWPEEL_INLINE void removeFirst(int removed) {
    for (auto& figure : figures) std::copy(figure + removed, figure + count, figure);
    for (auto& word : words) std::copy(word + removed, word + count, word);
    count -= removed;
  }
};

// Tests the first waiting lines, sixteen at most, against all obstacles and adds up to `lines` of them to the sum.
[[gnu::always_inline]] inline void UniformLines::test(const Waiting& waiting, uint64_t lines,
                                                      UniformLineCount& sum) const {
  const Candidates<Floats> line = waiting.first();
  const int here = std::min(waiting.count, kLineLanes);
  const Floats one = all(1.0f), none{};
  // A line is blocked where one obstacle surely blocks it, and facing where it surely passes all.
  Floats passed = one, blocked = one;
  for (size_t k = 0; k < fast_.obstacles.size(); ++k) {
    Floats error;
    const Floats x = passing(fast_.obstacles[k], fast_, line, error);
    passed = least(passed, x - error), blocked = least(blocked, x + error);
    if (k % 4 == 3 && !isAny(blocked < 0.0f ? none : one)) break;
  }
  const Floats is_line = line.inside > 0.0f ? one : none, is_facing = passed > 0.0f ? is_line : none,
               is_decided = blocked < 0.0f ? is_line : is_facing;
  if (here == kLineLanes && !isAny(one - is_decided) && sum.lines + kLineLanes <= lines) {
    sum.lines += kLineLanes, sum.facing += static_cast<uint64_t>(sumOf(is_facing));
    return;
  }
  for (int lane = 0; lane < here && sum.lines < lines; ++lane) {
    if (is_decided[lane] > 0) {
      ++sum.lines, sum.facing += is_facing[lane] > 0;
      continue;
    }
    uint32_t words[kNumbers];
    for (int d = 0; d < kNumbers; ++d) words[d] = waiting.words[d][lane];
    sum += decide(words);
  }
}

[[gnu::always_inline]] inline UniformLineCount UniformLines::drawAll(uint64_t stream, uint64_t lines) const {
  Generators generators(stream);
  UniformLineCount sum;
  Waiting waiting;
  const auto most_candidates =
      static_cast<uint64_t>(kMostCandidates * double(lines) / std::max(efficiency_, 1e-15)) + kFreeCandidates;
  while (sum.lines < lines) {
    while (waiting.count < kLineLanes && sum.lines + uint64_t(waiting.count) < lines &&
           sum.candidates < most_candidates) {
      sum.candidates += kLineLanes;
      Words words[kNumbers];
      Floats u[kNumbers];
      for (int d = 0; d < kNumbers; ++d) {
        words[d] = generators.next();
        u[d] = __builtin_convertvector((Integers)(words[d] >> 8), Floats) * 0x1p-24f;
      }
      const Candidates<Floats> candidates = way_ == Way::points       ? drawPoints(fast_, u)
                                            : way_ == Way::directions ? drawDirections(fast_, u)
                                                                      : drawContacts(fast_, u);
      for (int lane = 0; lane < kLineLanes; ++lane)
        if (!(candidates.outside[lane] < 0)) waiting.add(candidates, words, lane);
    }
    if (waiting.count == 0) break;
    test(waiting, lines, sum);
    waiting.removeFirst(std::min(waiting.count, kLineLanes));
  }
  sum.open += lines - sum.lines, sum.lines = lines;
  return sum;
}

}  // namespace viewpeel
