// City models keep the promises of scenes/triangulated_city.h: edges match, corners are in single precision, and counts
// and areas are as requested.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "scene/interpenetration.h"
#include "scene/leaks.h"
#include "scenes/triangulated_city.h"
#include "scenes/write_scene.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kBeyondSingle = (1u << (52 - 23)) - 1;  // bits of a double's fraction that a float lacks

struct Case {
  uint32_t n;
  uint64_t seed;
};

// Returns the edges that do not have exactly one opposite edge. In a city without a hole they are the edges of
// the rim.
using Edge = std::array<double, 6>;
std::vector<Edge> findOpenEdges(const InputScene& scene) {
  const auto edgeOf = [](glm::dvec3 a, glm::dvec3 b) { return Edge{a.x, a.y, a.z, b.x, b.y, b.z}; };
  std::map<Edge, int> times;
  for (const InputFace& face : scene.faces)
    for (size_t k = 0; k < 3; ++k) ++times[edgeOf(face.corners[k], face.corners[(k + 1) % 3])];
  std::vector<Edge> open;
  for (const auto& [edge, count] : times) {
    const auto opposite = times.find({edge[3], edge[4], edge[5], edge[0], edge[1], edge[2]});
    if (count != 1 || opposite == times.end() || opposite->second != 1) open.push_back(edge);
  }
  return open;
}

double areaOfFace(const InputFace& face) {
  return glm::length(glm::cross(face.corners[1] - face.corners[0], face.corners[2] - face.corners[0])) / 2;
}

// Returns the area of a face projected on the ground, positive where the face looks up.
double shadowOf(const InputFace& face) {
  return glm::cross(face.corners[1] - face.corners[0], face.corners[2] - face.corners[0]).z / 2;
}

double footprintAreaOf(const CityPlot& plot) {
  return std::accumulate(plot.footprints.begin(), plot.footprints.end(), 0.0,
                         [](double sum, const PlanPolygon& polygon) { return sum + areaOf(polygon); });
}

class TriangulatedCity : public testing::TestWithParam<Case> {
 protected:
  const bench::TriangulatedCity city_ = triangulatedCity(GetParam().n, GetParam().seed);
  const std::string where_ =
      "city of " + std::to_string(GetParam().n) + ", seed " + std::to_string(GetParam().seed) + ": ";
};

TEST_P(TriangulatedCity, HasTheCountRequested) {
  EXPECT_LE(std::abs(double(city_.scene.faces.size()) - GetParam().n), 0.02 * GetParam().n) << where_;
}

TEST_P(TriangulatedCity, AreasAndHeightsAreAsPromised) {
  double least = INFINITY, largest = 0, largest_ground = 0;
  for (const InputFace& face : city_.scene.faces) {
    ASSERT_EQ(face.corners.size(), 3u);
    double& most = face.surface == 0 ? largest_ground : largest;
    most = std::max(most, areaOfFace(face));
    least = std::min(least, areaOfFace(face));
  }
  EXPECT_GE(least, kLeastCityArea) << where_;
  EXPECT_LE(least, 4 * kLeastCityArea) << where_;
  EXPECT_LE(largest, kMostCityArea * (1 + 1e-5)) << where_;  // faces are divided before new corners are rounded
  EXPECT_GE(largest, kMostCityArea / 2) << where_;
  EXPECT_GE(largest_ground, kMostCityArea * 0.9) << where_;
  const auto [lowest, highest] = std::minmax_element(city_.heights.begin(), city_.heights.end());
  EXPECT_EQ(*lowest, 3) << where_;
  EXPECT_GE(*highest, 40) << where_;
  EXPECT_LE(*highest, 80) << where_;
}

TEST_P(TriangulatedCity, MeetsEdgeToEdge) {
  const std::vector<Edge> open = findOpenEdges(city_.scene);
  EXPECT_EQ(open.size(), city_.rim.size()) << where_;
  for (const Edge& edge : open) EXPECT_TRUE(edge[2] == 0 && edge[5] == 0) << where_ << "not on the rim";
}

TEST_P(TriangulatedCity, GroundAndFootprintsFillThePlot) {
  const double whole = areaOf(city_.rim), sums = 1e-12 * whole;  // corners are shared, so only sums round
  double ground = 0, outlines = 0, all = 0;
  for (const InputFace& face : city_.scene.faces) all += shadowOf(face);
  std::map<std::string, double> of_surface;
  for (const InputFace& face : city_.scene.faces) of_surface[city_.scene.surface_names[face.surface]] += shadowOf(face);
  ground = of_surface.at("ground");
  for (size_t k = 0; k < city_.plots.size(); ++k) {
    const CityPlot& plot = city_.plots[k];
    const double outline = areaOf(plot.outline);
    outlines += outline;
    EXPECT_NEAR(of_surface.at("plot_" + std::to_string(k + 1)) + footprintAreaOf(plot), outline, sums) << where_;
  }
  EXPECT_NEAR(ground + outlines, whole, sums) << where_;
  EXPECT_NEAR(all, whole, sums) << where_ << "roofs and crowns";
}

TEST_P(TriangulatedCity, ComesBackFromSinglePrecision) {
  for (const InputFace& face : city_.scene.faces)
    for (const glm::dvec3 p : face.corners)
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_EQ(std::bit_cast<uint64_t>(p[axis]) & kBeyondSingle, 0u) << where_ << p[axis];
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() /
      ("viewpeel_city_" + std::to_string(GetParam().n) + "_" + std::to_string(GetParam().seed) + ".stl");
  writeStl(city_.scene, file.string());
  const Scene kept = buildScene(city_.scene), read = loadScene(file);
  std::filesystem::remove(file);
  ASSERT_EQ(read.polygons.size(), city_.scene.faces.size()) << where_;
  EXPECT_EQ(read.corners, kept.corners) << where_;
}

TEST_P(TriangulatedCity, NothingLeaksAndNothingCrosses) {
  const Scene scene = buildScene(city_.scene);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{}) << where_;
  EXPECT_EQ(warnOfBacks(scene), std::vector<std::string>{}) << where_;
  EXPECT_EQ(followFronts(scene).backs, 0u) << where_;
  EXPECT_EQ(findInterpenetrations(scene).size(), 0u) << where_;
}

INSTANTIATE_TEST_SUITE_P(Sizes, TriangulatedCity,
                         testing::Values(Case{1000, 1}, Case{2900, 1}, Case{4200, 1}, Case{6600, 1}, Case{1000, 2},
                                         Case{2900, 3}, Case{20000, 4}),
                         [](const auto& tested) {
                           return std::to_string(tested.param.n) + "_" + std::to_string(tested.param.seed);
                         });

TEST(TriangulatedCityEdges, OneTriangleLessIsNoticed) {
  bench::TriangulatedCity city = triangulatedCity(1000);
  city.scene.faces.pop_back();
  EXPECT_EQ(findOpenEdges(city.scene).size(), city.rim.size() + 3);
}

TEST(TriangulatedCitySeeds, SameSeedSameCity) {
  const InputScene a = triangulatedCity(1000, 5).scene, b = triangulatedCity(1000, 5).scene,
                   other = triangulatedCity(1000, 6).scene;
  ASSERT_EQ(a.faces.size(), b.faces.size());
  for (size_t k = 0; k < a.faces.size(); ++k) ASSERT_EQ(a.faces[k].corners, b.faces[k].corners) << k;
  EXPECT_NE(a.faces[0].corners, other.faces[0].corners);
}

TEST(WriteStl, RefusesQuadrilaterals) {
  const InputScene scene{"square", {"square"}, {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0, 0}}};
  try {
    writeStl(scene, "square.stl");
    FAIL() << "written";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
  }
}

}  // namespace
}  // namespace viewpeel::bench
