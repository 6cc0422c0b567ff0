#include "pair_lines/uniform_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "pair_lines/line_candidates.h"

namespace viewpeel {
namespace {

using glm::dvec3;

// Rounding moves places by less than this number of units in the last place of the largest coordinate. The error of
// random numbers, 2^-24 or 2^-53, is included: docs/method.md, eq. (56).
constexpr double kPlaceUlps = 64;
constexpr double kUlp[] = {0x1p-24, 0x1p-53};
// Where the square of a direction's cosine is below this, sqrt(1 - x^2 - y^2) errs by more than kPlaceUlps.
constexpr double kLeastCosine2[] = {1.0 / 64, 1e-8};
// Where more candidates are drawn than this multiple of their expected number, the given exchange area is wrong.
// The first kFreeCandidates do not count, for few candidates vary much.
constexpr double kMostCandidates = 64;
constexpr uint64_t kFreeCandidates = 1 << 10;

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

// The gap between two patches along any direction is a lower bound on their distance. The patches' normals and the
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
  setLengths(small, large);
  fast_ = makeGeometry<float>(small, large, blockers, between, is_swapped);
  accurate_ = makeGeometry<double>(small, large, blockers, between, is_swapped);
}

// Chooses the way that wastes the fewest candidates, and sets most_ and efficiency_.
void UniformLines::chooseWay(const Patch& small, const Patch& large, double exchange) {
  const double density = mostDensity(makeLineEnd<double>(small, small.middle, true));
  if (small.plane == large.plane) {
    way_ = UniformWay::contact, most_ = density, efficiency_ = exchange / density;
    return;
  }
  const double r = leastDistance(small, large);
  frameDisk(small, large, r);
  const double framed = (double(disk_.high[0]) - double(disk_.low[0])) * (double(disk_.high[1]) - double(disk_.low[1]));
  way_ = UniformWay::directions, most_ = density, efficiency_ = std::numbers::pi * exchange / (framed * density);
  const double out = mostInFront(large, small) / r, in = mostInFront(small, large) / r,
               most = std::min(1.0, out) * std::min(1.0, in) / (r * r) * density *
                      mostDensity(makeLineEnd<double>(large, small.middle, true));
  if (const double efficiency = std::numbers::pi * exchange / most; r > 0 && efficiency > efficiency_)
    way_ = UniformWay::points, most_ = most, efficiency_ = efficiency;
}

// Sets the rectangle that directions are drawn in. Directions of Lambert's law are uniform in the unit disk onto which
// the hemisphere is projected; the rectangle holds all from the smaller patch to the larger. One axis runs along the
// line in which the two planes meet, so that a wall beside a floor takes at most half of the disk.
void UniformLines::frameDisk(const Patch& small, const Patch& large, double least_distance) {
  constexpr double kParallel = 1e-3, kMargin = 1e-6;
  const dvec3 fold = glm::cross(small.normal, large.normal);
  const double sine = glm::length(fold);
  disk_.axes[0] =
      sine > kParallel ? glm::normalize(fold - glm::dot(fold, small.normal) * small.normal) : anyAcross(small.normal);
  disk_.axes[1] = glm::cross(small.normal, disk_.axes[0]);
  for (int axis = 0; axis < 2; ++axis) {
    double low = INFINITY, high = -INFINITY;
    for (uint32_t k = 0; k < small.corner_count; ++k)
      for (uint32_t m = 0; m < large.corner_count; ++m) {
        const double along = glm::dot(large.corners[m] - small.corners[k], disk_.axes[axis]);
        low = std::min(low, along), high = std::max(high, along);
      }
    // A line that moves by `along` on the axis is no shorter than `along`, nor than the least distance. So the
    // component of its direction on the axis is at most this.
    const auto partOf = [&](double along) { return along / std::max(least_distance, std::abs(along)); };
    disk_.low[axis] = static_cast<float>(std::max(-1.0, std::min(0.0, partOf(low)) - kMargin));
    disk_.high[axis] = static_cast<float>(std::min(1.0, std::max(0.0, partOf(high)) + kMargin));
  }
}

// Sets the distances over which the four numbers of a candidate move a line, for strata.
void UniformLines::setLengths(const Patch& small, const Patch& large) {
  const LineEnd<double> first = makeLineEnd<double>(small, small.middle, true),
                        second = makeLineEnd<double>(large, small.middle, true);
  const auto lengthOf = [](const double* side) { return std::hypot(side[0], side[1], side[2]); };
  lengths_[0] = lengthOf(first.side_a), lengths_[1] = lengthOf(first.side_b);
  if (way_ == UniformWay::contact) return;
  // Directions that differ end farther apart on longer lines.
  const double height = std::abs(glm::dot(large.normal, small.middle) - large.offset),
               reach = std::min(2 * height, std::max(glm::length(large.middle - small.middle), std::sqrt(large.area)));
  const auto acrossDisk = [&](int axis) { return reach * double(disk_.high[axis] - disk_.low[axis]); };
  lengths_[2] = way_ == UniformWay::points ? lengthOf(second.side_a) : acrossDisk(0);
  lengths_[3] = way_ == UniformWay::points ? lengthOf(second.side_b) : acrossDisk(1);
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
  const double ulp = kUlp[kIsDouble], reach = way_ == UniformWay::points ? 2 * farthest : farthest,
               place_error = kPlaceUlps * ulp * farthest;
  of.reach = static_cast<Number>(reach);
  of.scale = static_cast<Number>(1 / most_);
  of.place_error = static_cast<Number>(place_error);
  of.weight_error = static_cast<Number>(kPlaceUlps * ulp);
  of.least_cosine2 = static_cast<Number>(kLeastCosine2[kIsDouble]);
  if (way_ == UniformWay::points) {
    // An error of place_error in cosines and distance changes a weight by this share of the largest weight.
    const double r = leastDistance(small, large), densities = mostDensity(of.first) * mostDensity(of.second);
    of.weight_error += static_cast<Number>(6 * place_error / (r * r * r) * densities / most_);
  }
  for (int axis = 0; axis < 2; ++axis) {
    of.disk_low[axis] = disk_.low[axis];
    of.disk_size[axis] = static_cast<Number>(double(disk_.high[axis]) - double(disk_.low[axis]));
  }
  const dvec3 axes[3] = {disk_.axes[0], disk_.axes[1], small.normal};
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) of.axes[k][axis] = static_cast<Number>(reach * axes[k][axis]);
  return of;
}

UniformLineCount UniformLines::draw(uint64_t stream, uint64_t lines, Vectors vectors) const {
  UniformLineCount count;
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) { count = drawAll<Types>(stream, lines); });
  return count;
}

// Decides one candidate in double precision, with more digits of its random numbers.
UniformLineCount UniformLines::decide(const uint32_t* words) const {
  double u[kNumbers];
  for (int d = 0; d < kNumbers; ++d) u[d] = withFurtherDigits(words, d);
  Candidates<double> line = drawCandidate(way_, accurate_, u);
  require(line, line.weight - u[kNumbers - 1], accurate_.weight_error);
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

  template <class Floats, class Words>
  VIEWPEEL_INLINE void add(const Candidates<Floats>& lines, const Words* of, int lane) {
    const Floats* const from[] = {&lines.p.x, &lines.p.y,     &lines.p.z,           &lines.d.x,
                                  &lines.d.y, &lines.d.z,     &lines.q.x,           &lines.q.y,
                                  &lines.q.z, &lines.arrival, &lines.arrival_error, &lines.inside};
    for (int k = 0; k < kFigures; ++k) figures[k][count] = (*from[k])[lane];
    for (int d = 0; d < kNumbers; ++d) words[d][count] = of[d][lane];
    ++count;
  }
  template <class Floats>
  VIEWPEEL_INLINE Candidates<Floats> first() const {
    const auto at = [&](int k) __attribute__((always_inline)) { return load<Floats>(figures[k]); };
    return {
        {at(0), at(1), at(2)}, {at(3), at(4), at(5)}, {at(6), at(7), at(8)}, at(9), at(10), at(11), Floats{}, Floats{}};
  }
  VIEWPEEL_INLINE void removeFirst(int removed) {
    for (auto& figure : figures) std::copy(figure + removed, figure + count, figure);
    for (auto& word : words) std::copy(word + removed, word + count, word);
    count -= removed;
  }
};

// Tests the first waiting lines, sixteen at most, against all obstacles and adds up to `lines` of them to the sum.
template <class Floats>
[[gnu::always_inline]] inline void UniformLines::test(const Waiting& waiting, uint64_t lines,
                                                      UniformLineCount& sum) const {
  const Candidates<Floats> line = waiting.first<Floats>();
  const int here = std::min(waiting.count, kLineLanes);
  const Floats one = 1.0f, none{};
  // A line is blocked where one obstacle surely blocks it, and facing where it surely passes all.
  Floats passed = one, blocked = one;
  for (size_t k = 0; k < fast_.obstacles.size(); ++k) {
    Floats error;
    const Floats x = passing(fast_.obstacles[k], fast_, line, error);
    passed = least(passed, x - error), blocked = least(blocked, x + error);
    if (k % 4 == 3 && !isAnyAtMost(none, blocked)) break;
  }
  const Floats is_line = ifBelow(none, line.inside, one, none), is_facing = ifBelow(none, passed, is_line, none),
               is_decided = ifBelow(blocked, none, is_line, is_facing);
  if (here == kLineLanes && !isAnyBelow(is_decided, one) && sum.lines + kLineLanes <= lines) {
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

template <class Types>
[[gnu::always_inline]] inline UniformLineCount UniformLines::drawAll(uint64_t stream, uint64_t lines) const {
  using Floats = typename Types::Floats;
  using Words = typename Types::Words;
  Generators<Words> generators(stream);
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
        u[d] = unitNumber(words[d]);
      }
      Candidates<Floats> candidates = drawCandidate(way_, fast_, u);
      require(candidates, candidates.weight - u[kNumbers - 1], Floats(fast_.weight_error));
      for (int lane = 0; lane < kLineLanes; ++lane)
        if (!(candidates.outside[lane] < 0)) waiting.add(candidates, words, lane);
    }
    if (waiting.count == 0) break;
    test<Floats>(waiting, lines, sum);
    waiting.removeFirst(std::min(waiting.count, kLineLanes));
  }
  sum.open += lines - sum.lines, sum.lines = lines;
  return sum;
}

}  // namespace viewpeel
