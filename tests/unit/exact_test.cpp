// These tests compare exact areas with slabs in rational numbers, with clipping, and with random lines. They also check
// that areas add up without any error.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "tests/support/exact_oracle.h"
#include "scenes/exact_scenes.h"
#include "reference/exact/exact_pair_areas.h"
#include "reference/exact/pair_sums.h"

namespace viewpeel::tests {
namespace {

using namespace reference;

struct NamedScene {
  const char* name;
  Scene scene;
};

const std::vector<NamedScene>& smallScenes() {
  static const std::vector<NamedScene> scenes = {{"room", makeRoom()},
                                                 {"cube in cube", makeCubeInCube()},
                                                 {"two plates", makeTwoPlates()},
                                                 {"staircase", makeStaircase()},
                                                 {"stack", makeStack()},
                                                 {"tiles", makeTiles()},
                                                 {"duplicates", makeDuplicates()},
                                                 {"creases", makeCreases()},
                                                 {"soup", makeSoup(12, 5)}};
  return scenes;
}

// Returns a uniform random rotation, from a quaternion of four normal numbers.
glm::dmat3 randomRotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  const double s = 2 / (w * w + x * x + y * y + z * z);
  return {1 - s * (y * y + z * z), s * (x * y + w * z),     s * (x * z - w * y),
          s * (x * y - w * z),     1 - s * (x * x + z * z), s * (y * z + w * x),
          s * (x * z + w * y),     s * (y * z - w * x),     1 - s * (x * x + y * y)};
}

// Returns directions along axes, in planes of faces, along edges and diagonals, at grazing angles, and three at random.
std::vector<glm::dvec3> hardDirections(const Scene& scene) {
  std::vector<glm::dvec3> directions = {{0, 0, 1},  {0, -1, 0},  {1, 0, 0},     {1, 1, 0},       {0, 0.25, -1},
                                        {-1, 1, 1}, {1, 0, 0.5}, {1e-9, 0, -1}, {0.3, 1e-16, 1}, {0.4, 0.7, 0.59}};
  const auto& corners = scene.corners;
  directions.push_back(corners[1] - corners[0]);
  directions.push_back(corners[2] - corners[0]);
  directions.push_back(corners.back() - corners[1]);
  std::mt19937 random(11);
  for (int k = 0; k < 3; ++k) directions.push_back(randomRotation(random) * glm::dvec3(0, 0, 1));
  return directions;
}

// Returns an empty string where both agree within `bound` in every pair, else the first difference.
std::string disagreement(const std::vector<PairArea>& found, const AreaMap& expected, double bound) {
  AreaMap rest = expected;
  for (const PairArea& pair : found) rest[{pair.a, pair.b}] -= pair.area;
  for (const auto& [key, difference] : rest) {
    if (std::abs(difference) <= bound) continue;
    const auto value = expected.find(key);
    return "pair (" + std::to_string(key.first) + ", " + std::to_string(key.second) + ") expected " +
           std::to_string(value == expected.end() ? 0 : value->second) + ", off by " + std::to_string(difference);
  }
  return "";
}

std::string text(const glm::dvec3& u) {
  return "u = (" + std::to_string(u.x) + ", " + std::to_string(u.y) + ", " + std::to_string(u.z) + ")";
}

// The slabs round once for each trapezoid. A pair has fewer than 1e4 trapezoids, each rounded by 1e-16.
constexpr double kSlabBound = 1e-12;

void expectExact(const Scene& scene, const glm::dvec3& u, bool two_sided) {
  ExactOptions options;
  options.two_sided = two_sided;
  options.blocked = true;
  const ExactPairAreas bounded = computeExactPairAreas(scene, u, options);
  options.arithmetic = Arithmetic::exact;
  const ExactPairAreas exact = computeExactPairAreas(scene, u, options);
  const SlabAreas slabs = cutIntoSlabs(scene, u, two_sided);

  EXPECT_TRUE(exact.open_polygons.empty());
  EXPECT_TRUE(exact.open_pairs.empty());
  const auto compare = [](const std::vector<PairArea>& in_double, const std::vector<PairArea>& in_rationals,
                          const AreaMap& expected) {
    AreaMap exact_areas;
    for (const PairArea& pair : in_rationals) {
      EXPECT_GT(pair.area, 0);
      EXPECT_LT(pair.a, pair.b);
      exact_areas[{pair.a, pair.b}] = pair.area;
    }
    EXPECT_EQ(disagreement(in_rationals, expected, kSlabBound), "");
    for (const PairArea& pair : in_double) {
      EXPECT_LE(std::abs(pair.area - exact_areas[{pair.a, pair.b}]), pair.error * (1 + 1e-12));
      EXPECT_LT(pair.error, 1e-12);
    }
    EXPECT_EQ(disagreement(in_double, exact_areas, 1e-12), "");
  };
  compare(bounded.pairs, exact.pairs, slabs.pairs);
  compare(bounded.blocked, exact.blocked, slabs.blocked);
}

TEST(ExactPairAreas, SlabsAgreeAndSumsCloseOnExactCorners) {
  for (const NamedScene& named : smallScenes())
    for (const glm::dvec3& u : hardDirections(named.scene)) {
      SCOPED_TRACE(std::string(named.name) + ", " + text(u));
      expectExact(named.scene, u, false);
    }
}

TEST(ExactPairAreas, SlabsAgreeAndSumsCloseTwoSided) {
  for (const NamedScene& named : smallScenes())
    for (const glm::dvec3& u : {glm::dvec3(0, 0, 1), glm::dvec3(0.3, -0.5, 0.4)}) {
      SCOPED_TRACE(std::string(named.name) + ", " + text(u));
      expectExact(named.scene, u, true);
    }
}

TEST(ExactPairAreas, SlabsAgreeAndSumsCloseOnRoundedCorners) {
  std::mt19937 random(3);
  for (const NamedScene& named : smallScenes()) {
    const glm::dmat3 rotation = randomRotation(random);
    const Scene turned = turn(named.scene, rotation);
    for (const glm::dvec3& u : hardDirections(named.scene)) {
      SCOPED_TRACE(std::string(named.name) + " turned, " + text(u));
      expectExact(turned, rotation * u, false);
    }
  }
}

// The sides and legs of a desk share planes and touch. Edges coincide up to rounding, beside faces of width 1e-17.
TEST(ExactPairAreas, SlabsAgreeAndSumsCloseInAnOffice) {
  std::mt19937 random(77);
  const Scene office = makeOffice(1, 1);
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 u = randomRotation(random) * glm::dvec3(0, 0, 1);
    SCOPED_TRACE(text(u));
    expectExact(office, u, false);
  }
}

// Directions are half a degree off a plane, or less by powers of ten. They make slivers of every width down to
// rounding.
TEST(ExactPairAreas, SlabsAgreeAndSumsCloseAtGrazingAngles) {
  std::mt19937 random(13);
  for (const Scene& scene : {makeCubeInCube(), makeCreases()}) {
    const glm::dmat3 rotation = randomRotation(random);
    const Scene turned = turn(scene, rotation);
    for (int power = 2; power <= 17; ++power) {
      const glm::dvec3 u(0.3, std::pow(10.0, -power), 1);
      SCOPED_TRACE(text(u) + ", 1e-" + std::to_string(power));
      expectExact(scene, u, false);
      expectExact(turned, rotation * u, false);
    }
  }
}

TEST(ExactPairAreas, SlabComparatorSeesWrongAnswers) {
  const Scene scene = makeCubeInCube();
  const glm::dvec3 u(0.3, -0.5, 0.4);
  ExactOptions options;
  options.blocked = true;
  const ExactPairAreas found = computeExactPairAreas(scene, u, options);
  const SlabAreas right = cutIntoSlabs(scene, u);
  EXPECT_EQ(disagreement(found.pairs, right.pairs, kSlabBound), "");
  EXPECT_EQ(disagreement(found.blocked, right.blocked, kSlabBound), "");
  for (const SlabAreas& wrong : {cutIntoSlabs(scene, u + glm::dvec3(1e-9, 0, 0)), cutIntoSlabs(flip(scene, 7), u),
                                 cutIntoSlabs(scene, u, true)}) {
    EXPECT_NE(disagreement(found.pairs, wrong.pairs, kSlabBound), "");
    EXPECT_NE(disagreement(found.blocked, wrong.blocked, kSlabBound), "");
  }
}

// Facing and blocked area of a pair together are the common part of two projections. Clipping computes this part
// without regard to other polygons. A clipped corner is off by some 1e-16 along its edge, and heights by as much. These
// directions avoid planes within 1e-3 of u, where the error would be larger.
TEST(ExactPairAreas, FacingAndBlockedTogetherAreTheCommonPartOfTwoProjections) {
  constexpr double kBound = 1e-12;
  const auto compare = [&](const Scene& scene, const glm::dvec3& u, const ExactPairAreas& areas, bool two_sided) {
    std::vector<PairArea> together = areas.pairs;
    std::erase_if(together, [](const PairArea& pair) { return pair.b >= kEnvironment; });
    together.insert(together.end(), areas.blocked.begin(), areas.blocked.end());
    const auto isUp = [&](uint32_t p) {
      const Polygon& polygon = scene.polygons[p];
      return (glm::dot(scene.planes[polygon.plane].normal, u) > 0) == polygon.front_along_plane_normal;
    };
    AreaMap expected;
    for (uint32_t a = 0; a < scene.polygons.size(); ++a)
      for (uint32_t b = 0; b < scene.polygons.size(); ++b) {
        const Overlap common = overlap(scene, u, a, b);
        if (two_sided ? a < b : isUp(a) && !isUp(b) && common.height > -1e-12)
          expected[{std::min(a, b), std::max(a, b)}] += common.area;
      }
    return disagreement(together, expected, kBound);
  };
  std::mt19937 random(5);
  size_t directions_with_blocked = 0;
  for (const Scene& scene : {makeCubeInCube(), makeStack(), makeStaircase(), makeSoup(300, 5), makeOffice(1, 1)})
    for (int trial = 0; trial < 10; ++trial)
      for (bool two_sided : {false, true}) {
        ExactOptions options;
        options.two_sided = two_sided;
        options.blocked = true;
        options.arithmetic = Arithmetic::exact;
        const glm::dvec3 u = randomRotation(random) * glm::dvec3(0, 0, 1);
        SCOPED_TRACE(text(u));
        ExactPairAreas areas = computeExactPairAreas(scene, u, options);
        EXPECT_EQ(compare(scene, u, areas, two_sided), "");
        if (areas.blocked.empty()) continue;
        areas.blocked.front().area += 2 * kBound;
        EXPECT_NE(compare(scene, u, areas, two_sided), "");
        ++directions_with_blocked;
      }
  EXPECT_GT(directions_with_blocked, 50u);  // at least half of the directions
}

TEST(ExactPairAreas, ConvexRoomIsIntersectionOfProjections) {
  const Scene room = makeRoom();
  std::mt19937 random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const glm::dvec3 u = randomRotation(random) * glm::dvec3(0, 0, 1);
    AreaMap expected;
    for (uint32_t a = 0; a < 6; ++a)
      for (uint32_t b = a + 1; b < 6; ++b) {
        // Both fronts face the gap: one looks along +u, the other along -u.
        const auto facing = [&](uint32_t p) {
          const Polygon& polygon = room.polygons[p];
          return (glm::dot(room.planes[polygon.plane].normal, u) > 0) == polygon.front_along_plane_normal;
        };
        if (facing(a) != facing(b)) expected[{a, b}] = overlap(room, u, a, b).area;
      }
    SCOPED_TRACE(text(u));
    EXPECT_EQ(disagreement(computeExactPairAreas(room, u).pairs, expected, 1e-12), "");
    expected.begin()->second += 2e-12;
    EXPECT_NE(disagreement(computeExactPairAreas(room, u).pairs, expected, 1e-12), "");
  }
}

// Returns the largest deviation of a pair's area from the sampled one, in standard deviations of the sample.
double worstDeviation(const ExactPairAreas& found, const Samples& samples, uint32_t sample_count) {
  AreaMap areas;
  for (const PairArea& pair : found.pairs) areas[{pair.a, pair.b}] = pair.area;
  for (const auto& [key, area] : samples.areas) areas.try_emplace(key, 0);
  double worst = 0;
  for (const auto& [key, area] : areas) {
    const auto sampled = samples.areas.find(key);
    const double difference = (sampled == samples.areas.end() ? 0 : sampled->second) - area;
    // The added term keeps one extra sample from counting as a deviation where less than one is expected.
    const double variance = samples.square * (area + samples.square / sample_count) / sample_count;
    worst = std::max(worst, std::abs(difference) / std::sqrt(variance));
  }
  return worst;
}

// There are some 2e3 pairs. A count of mean m differs from m by more than 9 (m + 1)^1/2 with probability below 3e-10.
// This is Chernoff's bound exp(k - m - k log(k / m)) at k = m +- 9 (m + 1)^1/2. The false-alarm rate is below 1e-6.
TEST(ExactPairAreas, RandomLinesAgree) {
  constexpr uint32_t kSampleCount = 100'000;
  const Scene soup = makeSoup(150, 1), office = makeOffice(2, 1);
  std::mt19937 random(23);
  for (int trial = 0; trial < 3; ++trial)
    for (const Scene* scene : {&soup, &office}) {
      const glm::dvec3 u = randomRotation(random) * glm::dvec3(0, 0, 1);
      const Samples samples = sampleLines(*scene, u, kSampleCount, 100 + trial);
      SCOPED_TRACE(text(u) + ", seed " + std::to_string(100 + trial));
      const ExactPairAreas found = computeExactPairAreas(*scene, u);
      EXPECT_LT(worstDeviation(found, samples, kSampleCount), 9);
      EXPECT_GT(worstDeviation(computeExactPairAreas(*scene, u + glm::dvec3(0.1)), samples, kSampleCount), 9);
    }
}

TEST(ExactPairAreas, LargerScenesCloseExactly) {
  ExactOptions options;
  options.arithmetic = Arithmetic::exact;
  for (const Scene& scene : {makeOffice(2, 1), makeSoup(100, 2)})
    for (const glm::dvec3& u : {glm::dvec3(0, 0, 1), glm::dvec3(1, 1, 0.25), glm::dvec3(0.2, 0.5, -0.7)}) {
      SCOPED_TRACE(text(u));
      const ExactPairAreas areas = computeExactPairAreas(scene, u, options);
      EXPECT_TRUE(areas.open_polygons.empty());
      EXPECT_TRUE(areas.open_pairs.empty());
    }
}

// The boundary of a plate closes exactly. If 2^-300 of its area is missing the polygon is reported as open, and if as
// much of its boundary is missing the pair is.
TEST(ExactPairAreas, ClosureSeesMissingPieces) {
  SceneBuilder builder;
  builder.addPolygon("plate", {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.5, 0}, {0, 0.5, 0}});
  ExactOptions options;
  options.arithmetic = Arithmetic::exact;
  const Projection projection(builder.scene, IntegerCorners(builder.scene), {0, 0, 1});
  const mpz_class twice_area = 2 * projection.exactCross(0, 1, 2);
  const auto finish = [&](const mpq_class& area, const mpq_class& dx) {
    PairSums sums(projection, options);
    Piece piece;
    piece.exact = Piece::Exact{area, dx, 0};
    sums.addGap(0, kNoOutline, piece);
    return sums.finish();
  };
  const ExactPairAreas whole = finish(twice_area, 0);
  EXPECT_TRUE(whole.open_polygons.empty() && whole.open_pairs.empty());
  const mpq_class tiny = mpq_class(1) / (mpz_class(1) << 300);
  EXPECT_EQ(finish(twice_area - tiny, 0).open_polygons.size(), 1u);
  EXPECT_EQ(finish(twice_area, tiny).open_pairs.size(), 1u);
}

TEST(ExactPairAreas, EdgeOnPolygonsContributeNothing) {
  const ExactPairAreas areas = computeExactPairAreas(makeRoom(), {0, 0, 1});
  ASSERT_EQ(areas.pairs.size(), 1u);  // floor and ceiling
  EXPECT_EQ(areas.pairs[0].a, 0u);
  EXPECT_EQ(areas.pairs[0].b, 1u);
  EXPECT_NEAR(areas.pairs[0].area, 1, areas.pairs[0].error);
}

TEST(ExactPairAreas, TouchingSolidsFaceEachOther) {
  // The boxes `bottom` and `middle` touch over 0.3 x 0.4 in the plane z = -0.2.
  const ExactPairAreas areas = computeExactPairAreas(makeStack(), {0, 0, 1});
  const uint32_t top_of_bottom = 7, bottom_of_middle = 12;
  double area = 0;
  for (const PairArea& pair : areas.pairs) {
    EXPECT_NE(pair.b, kLeak);
    if (pair.a == top_of_bottom && pair.b == bottom_of_middle) area = pair.area;
  }
  EXPECT_NEAR(area, 0.3 * 0.4, 1e-15);
}

TEST(ExactPairAreas, LengthAndSignOfDirectionDoNotMatter) {
  const Scene scene = makeStaircase();
  const glm::dvec3 u(0.3, -0.5, 0.4);
  const ExactPairAreas one = computeExactPairAreas(scene, u);
  for (const double factor : {1024.0, -1.0, 0x1p-600}) {
    const ExactPairAreas other = computeExactPairAreas(scene, factor * u);
    ASSERT_EQ(one.pairs.size(), other.pairs.size());
    for (size_t k = 0; k < one.pairs.size(); ++k)
      EXPECT_NEAR(one.pairs[k].area, other.pairs[k].area, one.pairs[k].error + other.pairs[k].error);
  }
}

TEST(ExactPairAreas, ThreadsDoNotChangeBits) {
  const Scene scene = makeOffice(2, 1);
  std::mt19937 random(31);
  std::vector<glm::dvec3> directions;
  for (int k = 0; k < 12; ++k) directions.push_back(randomRotation(random) * glm::dvec3(0, 0, 1));
  ExactOptions options;
  options.thread_count = 4;
  const std::vector<ExactPairAreas> together = computeExactPairAreas(scene, directions, options);
  for (size_t k = 0; k < directions.size(); ++k) {
    const ExactPairAreas alone = computeExactPairAreas(scene, directions[k]);
    ASSERT_EQ(alone.pairs.size(), together[k].pairs.size());
    for (size_t p = 0; p < alone.pairs.size(); ++p) EXPECT_EQ(alone.pairs[p].area, together[k].pairs[p].area);
  }
}

TEST(ExactPairAreas, UselessDirectionsAreRefused) {
  EXPECT_THROW(computeExactPairAreas(makeRoom(), {0, 0, 0}), Error);
  EXPECT_THROW(computeExactPairAreas(makeRoom(), {0, NAN, 1}), Error);
}

}  // namespace
}  // namespace viewpeel::tests
