// The exact path: sums that close as rational numbers, and other ways to the same areas.
#include "reference/exact_pair_areas.h"

#include <cmath>
#include <map>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "compare.h"
#include "error.h"
#include "facing.h"
#include "reference/closed_forms.h"
#include "reference/exact_engine.h"
#include "scenes.h"

namespace viewpeel::reference {
namespace {

namespace ts = test_scenes;

std::vector<glm::dvec3> directionsToTry() {
  std::vector<glm::dvec3> directions = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1},          // along axes: edge-on walls, ties
                                        {1, 1, 0}, {0, 1, -1}, {1, 1, 1}, {-1, 0.5, 0},        // in planes, along diagonals of faces
                                        {4, 0.5, 0}, {1e-9, 1, 0}, {1, 2e-17, 0}, {3, 2, -1}};  // all but parallel to edges and faces
  for (const Direction& d : sampleDirections(Sampler::iid, 6, 17, 0)) directions.push_back(d.u);
  return directions;
}

std::vector<InputScene> scenesToTry() {
  InputScene neighbours{"coplanar neighbours, T-junctions", {}, {}};
  ts::addFace(neighbours, "floor", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 2, 0}));
  ts::addFace(neighbours, "floor", ts::parallelogram({1, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(neighbours, "floor", ts::parallelogram({1, 1, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(neighbours, "lid", ts::parallelogram({0, 0, 1}, {0, 2, 0}, {2, 0, 0}));
  return {ts::parallelSquares(),          ts::perpendicularSquares(), ts::insideOfCube(),      ts::cubeInCube(0.4), ts::roomWithTouchingBoxes(),
          ts::stackOfSheets({0, 0, 0, 0.5, 0.5, 1}),  // coincident duplicates and touching sheets
          ts::triangleSoup(40, 0.3, 5),  neighbours};
}

TEST(ExactPairAreas, SumsCloseAsRationals) {
  for (const InputScene& input : scenesToTry())
    for (const glm::dvec3& u : directionsToTry())
      for (bool two_sided : {false, true}) {
        const PairAreas areas = computePairAreas(buildScene(input), u, {.two_sided = two_sided, .check_sums = true});
        EXPECT_EQ(areas.largest_sum_defect, 0) << input.file << ", u = " << u.x << " " << u.y << " " << u.z << (two_sided ? ", two-sided" : "");
      }
}

// The sums of the doubles, per polygon, against projected areas found here: |normal . u| area, for one front each.
TEST(ExactPairAreas, RowsAreProjectedAreas) {
  for (const InputScene& input : scenesToTry())
    for (const Direction& d : sampleDirections(Sampler::iid, 4, 3, 0)) {
      const Scene scene = buildScene(input);
      std::vector<double> rows(scene.polygons.size(), 0.0);
      for (const PairArea& pair : computePairAreas(scene, 3.0 * d.u).pairs) {
        rows[pair.a] += pair.area;
        if (pair.b < kEnvironment) rows[pair.b] += pair.area;
      }
      for (size_t p = 0; p < rows.size(); ++p) {
        const Polygon& polygon = scene.polygons[p];
        // A face's area is rounded at 1e-16 for each of its corners; no polygon here is cut into more than 1000.
        EXPECT_NEAR(rows[p], polygon.area * std::abs(glm::dot(scene.planes[polygon.plane].normal, d.u)), 1e-12) << input.file;
      }
    }
}

// In a convex room every pair sees itself whole: A'_ij is the intersection of two projections.
TEST(ExactPairAreas, ConvexRoomGivesIntersectionsOfProjections) {
  const Scene scene = buildScene(ts::insideOfCube());
  for (const Direction& d : sampleDirections(Sampler::iid, 20, 4, 0)) {
    std::map<std::pair<uint32_t, uint32_t>, double> areas;
    for (const PairArea& pair : computePairAreas(scene, d.u).pairs) areas[{pair.a, pair.b}] = pair.area;
    for (uint32_t a = 0; a < 6; ++a)
      for (uint32_t b = a + 1; b < 6; ++b) {
        const auto frontUp = [&](uint32_t p) {
          const Polygon& polygon = scene.polygons[p];
          return (glm::dot(scene.planes[polygon.plane].normal, d.u) > 0) == polygon.front_along_plane_normal;
        };
        Loop common;
        for (int k = 0; k < 4; ++k) {
          const glm::dvec3 p = scene.corners[scene.polygons[a].first_corner + k];
          common.push_back(p - glm::dot(p, d.u) * d.u);
        }
        for (int k = 0; k < 4 && !common.empty(); ++k) {
          const glm::dvec3 p = scene.corners[scene.polygons[b].first_corner + k], q = scene.corners[scene.polygons[b].first_corner + (k + 1) % 4];
          const glm::dvec3 inward = glm::cross(d.u, q - p) * (frontUp(b) ? 1.0 : -1.0);
          common = clip(common, inward, glm::dot(inward, p));
        }
        const double expected = frontUp(a) == frontUp(b) || common.empty() ? 0 : areaOf(common);
        EXPECT_NEAR(areas[std::pair(a, b)], expected, 1e-13);
      }
  }
}

// Lines at random points, all polygons sorted by brute force: hits per pair are binomial. 5.5 standard deviations over at most 2000 pairs:
// false-alarm rate 8e-5.
TEST(ExactPairAreas, AgreeWithRandomLines) {
  int wrong_seen = 0;
  for (const InputScene& input : {ts::roomWithTouchingBoxes(), ts::cubeInCube(0.4), ts::triangleSoup(12, 0.2, 8)}) {
    const Scene scene = buildScene(input);
    ASSERT_TRUE(findInterpenetrations(scene).empty()) << input.file;
    for (const Direction& d : sampleDirections(Sampler::iid, 3, 23, 0)) {
      const PairAreas exact = computePairAreas(scene, d.u);
      std::map<std::pair<uint32_t, uint32_t>, double> hits;
      std::mt19937_64 random(1);
      std::uniform_real_distribution<double> uniform(-1, 1);
      const int lines = 20000;
      for (int n = 0; n < lines; ++n) {
        const glm::dvec3 p = uniform(random) * d.x_axis + uniform(random) * d.y_axis;
        std::vector<std::tuple<double, bool, uint32_t>> layers;  // height, front down, polygon
        for (uint32_t q = 0; q < scene.polygons.size(); ++q) {
          const Polygon& polygon = scene.polygons[q];
          const Plane& plane = scene.planes[polygon.plane];
          const double nu = glm::dot(plane.normal, d.u);
          const bool front_up = (nu > 0) == polygon.front_along_plane_normal;
          bool inside = true;
          for (uint32_t k = 0; k < polygon.corner_count && inside; ++k) {
            const glm::dvec3 a = scene.corners[polygon.first_corner + k], b = scene.corners[polygon.first_corner + (k + 1) % polygon.corner_count];
            inside = glm::dot(glm::cross(b - a, p - a), d.u) * (front_up ? 1 : -1) > 0;
          }
          if (inside) layers.emplace_back((plane.offset - glm::dot(plane.normal, p)) / nu, !front_up, q);
        }
        std::sort(layers.begin(), layers.end());
        for (size_t k = 0; k <= layers.size() && !layers.empty(); ++k) {
          const bool lower = k > 0, upper = k < layers.size();
          const uint32_t a = lower ? std::get<2>(layers[k - 1]) : 0, b = upper ? std::get<2>(layers[k]) : 0;
          const uint gap = classifyGap(lower ? sideTowardsGap(!std::get<1>(layers[k - 1]), false, true) : kSideNone,
                                       upper ? sideTowardsGap(!std::get<1>(layers[k]), false, false) : kSideNone);
          if (gap == kGapFacingPair) ++hits[{std::min(a, b), std::max(a, b)}];
          else if (gap == kGapLowerEnvironment) ++hits[{a, kEnvironment}];
          else if (gap == kGapUpperEnvironment) ++hits[{b, kEnvironment}];
          else if (gap == kGapLowerLeak) ++hits[{a, kLeak}];
          else if (gap == kGapUpperLeak) ++hits[{b, kLeak}];
        }
      }
      for (const PairArea& pair : exact.pairs) {
        const double p = pair.area / 4, expected = p * lines, deviation = std::sqrt(lines * p * (1 - p));
        const double found = hits[{pair.a, pair.b}];
        hits.erase({pair.a, pair.b});
        EXPECT_LE(std::abs(found - expected), 5.5 * deviation + 8) << input.file << " " << pair.a << " " << pair.b;  // + 8: Poisson tail of rare pairs
        wrong_seen += std::abs(found - 1.2 * expected) > 5.5 * deviation + 8;
      }
      for (const auto& [key, found] : hits) EXPECT_LE(found, 8) << input.file << " " << key.first << " " << key.second;
    }
  }
  EXPECT_GT(wrong_seen, 10);  // 20 % more would be seen
}

TEST(ExactPairAreas, TouchingSolidsFaceEachOther) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  for (const PairArea& pair : computePairAreas(scene, {0.2, -0.3, 1}).pairs) {
    EXPECT_NE(pair.b, kLeak);
    EXPECT_NE(pair.b, kEnvironment);
  }
}

// A unit square in the middle of a plane hides its own perimeter: the regions' perimeters are those of the shapes.
TEST(ExactPairAreas, PerimetersAreThoseOfTheRegions) {
  const Scene scene = buildScene(ts::parallelSquares());
  const double side = 1 / scene.scale;
  for (const PairArea& pair : computePairAreas(scene, {0, 0, 1}).pairs) {
    EXPECT_EQ(pair.a, 0u);
    EXPECT_EQ(pair.b, 1u);
    EXPECT_NEAR(pair.perimeter, 4 * side, 1e-14);
    EXPECT_NEAR(pair.area, side * side, 1e-14);
  }
}

TEST(Interpenetration, CrossingPolygonsAreNamedWithTheirPlace) {
  InputScene input{"crossing", {}, {}};
  ts::addFace(input, "table", ts::parallelogram({0, 0, 0}, {2, 0, 0}, {0, 2, 0}));
  ts::addFace(input, "blade", ts::parallelogram({1, 0.5, -1}, {0, 1, 0}, {0, 0, 3}));
  const Scene scene = buildScene(input);
  const auto found = findInterpenetrations(scene);
  ASSERT_EQ(found.size(), 1u);
  const glm::dvec3 place = scene.centre + scene.scale * found[0].place;
  EXPECT_LT(glm::length(place - glm::dvec3(1, 1, 0)), 1e-12);
  EXPECT_EQ(describe(scene, found[0]).find("crossing: polygons table and blade pass through each other at (1, 1, "), 0u) << describe(scene, found[0]);
  EXPECT_THROW(makeExactEngine(scene, makeIds(scene, By::polygon, false)), Error);
}

TEST(Interpenetration, TouchingIsNone) {
  for (const InputScene& input : {ts::roomWithTouchingBoxes(), ts::perpendicularSquares(), ts::stackOfSheets({0, 0, 0.1})})
    EXPECT_TRUE(findInterpenetrations(buildScene(input)).empty()) << input.file;
  InputScene standing{"blade stands on the table", {}, {}};
  ts::addFace(standing, "table", ts::parallelogram({0, 0, 0}, {2, 0, 0}, {0, 2, 0}));
  ts::addFace(standing, "blade", ts::parallelogram({1, 0.5, 0}, {0, 1, 0}, {0, 0, 3}));
  EXPECT_TRUE(findInterpenetrations(buildScene(standing)).empty());
}

TEST(ExactEngine, EstimatesAreThoseOfTheClosedForm) {
  const Scene scene = buildScene(ts::perpendicularSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeExactEngine(scene, ids);
  const Estimate e = estimateFormFactors(*engine, scene, ids, {.directions = 200, .replicates = 16});
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 1), perpendicularRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}), e.replicates, 1e-11));
  EXPECT_LT(e.largest_standard_error, 1e-3);
}

// A polygon past a convex blocker, by the estimator and by quadrature.
TEST(ExactEngine, SeesPastABlocker) {
  InputScene input = ts::parallelSquares();
  const Loop blocker{{0.2, 0.3, 0.4}, {0.9, 0.4, 0.6}, {0.3, 0.8, 0.5}};
  ts::addFace(input, "blocker", blocker);
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const Estimate e = estimateFormFactors(*makeExactEngine(scene, ids), scene, ids, {.directions = 200, .replicates = 16});
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 1), polygonPastBlocker(input.faces[0].corners, input.faces[1].corners, blocker), e.replicates, 1e-7));
  EXPECT_GT(e.form_factors.formFactor(1, 2).value + e.form_factors.formFactor(1, kLeak).value, 0.01);  // it is in the way
}

TEST(ExactEngine, ThreadsNeverChangeTheCounts) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::surface, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 20, 1, 0);
  const PairCounts one = makeExactEngine(scene, ids, 1)->count(directions), three = makeExactEngine(scene, ids, 3)->count(directions);
  ASSERT_EQ(one.size(), three.size());
  for (size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k].count, three[k].count);
}

}  // namespace
}  // namespace viewpeel::reference
