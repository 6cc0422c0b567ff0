// Coincident faces mean what the same scene with gaps means, in the exact path; that engines agree with it, to the bit
// with the CPU twin, is tested in peel_test.cpp.
#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "coincident_scenes.h"
#include "directions/sampler.h"
#include "error.h"
#include "reference/exact_pair_areas.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

using Areas = std::map<std::pair<uint32_t, uint32_t>, double>;  // input units squared, summed over directions

Areas areasOf(const Scene& scene, const std::vector<glm::dvec3>& directions) {
  Areas areas;
  // Faces moved by rounding pass through their neighbours by as little.
  for (const auto& found : reference::computeExactPairAreas(scene, directions, {.touching_depth = 1e-5}))
    for (const auto& pair : found.pairs) areas[{scene.polygons[pair.a].face, pair.b < kEnvironment ? scene.polygons[pair.b].face : pair.b}] += pair.area * scene.scale * scene.scale;
  return areas;
}

std::vector<glm::dvec3> someDirections() {
  std::vector<glm::dvec3> directions;
  for (const Direction& direction : sampleDirections(Sampler::fibonacci, 12, 5, 0)) directions.push_back(direction.u);
  return directions;
}

double perimeters(const InputScene& scene) {
  double sum = 0;
  for (const InputFace& face : scene.faces)
    for (size_t k = 0; k < face.corners.size(); ++k) sum += glm::length(face.corners[(k + 1) % face.corners.size()] - face.corners[k]);
  return sum;
}

// Empty where no pair's area differs by more than `allowed`.
std::string firstDifference(const InputScene& input, const Areas& areas, const Areas& meant, double allowed) {
  const auto nameOf = [&](uint32_t face) -> std::string {
    return face == kEnvironment ? "environment" : face == kLeak ? "leak" : input.surface_names[input.faces[face].surface];
  };
  Areas both = areas;
  both.insert(meant.begin(), meant.end());
  for (const auto& entry : both) {
    const auto valueIn = [&](const Areas& all) { return all.count(entry.first) ? all.at(entry.first) : 0; };
    const double found = valueIn(areas), wanted = valueIn(meant);
    if (std::abs(found - wanted) > allowed)
      return nameOf(entry.first.first) + " to " + nameOf(entry.first.second) + ": " + std::to_string(found) + " in place of " + std::to_string(wanted);
  }
  return "";
}

constexpr double kMeantGap = 1e-5;

// A gap of g moves every face by at most 2 g, so every edge of the projection, and a pair's area by at most 2 g times
// all perimeters, in either of the scenes compared.
double allowedDifference(const InputScene& input, double gap, size_t directions) { return 2 * (kMeantGap + gap) * perimeters(input) * double(directions); }

class Coincident : public testing::TestWithParam<ts::CoincidentScene> {
 protected:
  void compare(const InputScene& input, const InputScene& meant, double gap) {
    const auto directions = someDirections();
    const Scene scene = buildScene(input);
    EXPECT_EQ(firstDifference(input, areasOf(scene, directions), areasOf(buildScene(meant), directions), allowedDifference(input, gap, directions.size())), "") << GetParam().name;
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
  }
};

TEST_P(Coincident, IsWhatAGapWouldMean) {
  const InputScene meant = GetParam().make(kMeantGap);
  compare(GetParam().make(0), meant, 0);
  compare(ts::turnedAndMoved(GetParam().make(0)), ts::turnedAndMoved(meant), 0);
}

// A negative gap is what rounding makes of none: faces that have passed through each other.
TEST_P(Coincident, AtGapsOfRounding) {
  for (double gap : {1e-12, 1e-9, 1e-8, 1e-7, 1e-6})
    for (double sign : {1.0, -1.0}) {
      if (GetParam().needs_gap && sign < 0) continue;
      SCOPED_TRACE(sign * gap);
      compare(GetParam().make(sign * gap), GetParam().make(kMeantGap), gap);
    }
}

TEST_P(Coincident, InSinglePrecision) {
  const double rounding = 0x1p-22;  // of coordinates below 4
  for (double gap : {0.0, 1e-7}) {
    SCOPED_TRACE(gap);
    compare(ts::roundedToSingle(ts::turnedAndMoved(GetParam().make(gap))), ts::turnedAndMoved(GetParam().make(kMeantGap)), gap + rounding);
  }
}

// The comparison sees the wrong order.
TEST_P(Coincident, TheOtherOrderIsNoticed) {
  Scene scene = buildScene(GetParam().make(0));
  const auto directions = someDirections();
  const Areas meant = areasOf(scene, directions);
  for (Polygon& polygon : scene.polygons) polygon.tie_rank = kTieRanks - 1 - polygon.tie_rank;
  EXPECT_NE(firstDifference(GetParam().make(0), areasOf(scene, directions), meant, allowedDifference(GetParam().make(0), 0, directions.size())), "") << GetParam().name;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Coincident, testing::ValuesIn(ts::coincidentScenes()), [](const auto& scene) {
  std::string name = scene.param.name;
  std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
  return name;
});

TEST(CoincidentPairs, AreCounted) {
  const auto countsOf = [](const char* name) {
    for (const ts::CoincidentScene& scene : ts::coincidentScenes())
      if (scene.name == name) return buildScene(scene.make(0)).coincidences;
    return Coincidences{};
  };
  EXPECT_EQ(countsOf("pane in a hole").sheets, 5u);
  EXPECT_EQ(countsOf("pane in a hole").contacts, 0u);
  EXPECT_EQ(countsOf("stacked boxes").contacts, 2u);
  EXPECT_EQ(countsOf("box against a partition").sheets, 1u);
  EXPECT_EQ(countsOf("box against a partition").contacts, 1u);
  EXPECT_EQ(countsOf("sheet alone").in_doubt, 0u);
  EXPECT_EQ(countsOf("three rooms in a row").in_doubt, 0u);
}

// A floor whose lower side is free, and whose upper side is the inside of a solid, is told; options decide.
TEST(CoincidentPairs, OptionsDecide) {
  InputScene input{"flipped", {}, {}};
  ts::addRoom(input, "room", {-2, -2, -2}, {2, 2, 2});
  ts::addSheet(input, "sheet", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0);
  const auto sheets = [&](const SceneOptions& options) { return buildScene(input, options).coincidences.sheets; };
  EXPECT_EQ(sheets({}), 1u);
  EXPECT_EQ(sheets({.solids = {"sheet+"}}), 0u);
  EXPECT_EQ(sheets({.sheets = {"sheet-"}}), 1u);
  EXPECT_THROW(sheets({.sheets = {"shet"}}), Error);
  EXPECT_THROW(sheets({.sheets = {"sheet+"}, .solids = {"sheet+"}}), Error);
}

TEST(CoincidentPairs, ContradictionsAreSaid) {
  InputScene input{"half", {}, {}};
  ts::addRoom(input, "room", {-2, -2, -2}, {2, 2, 2});
  ts::addSheet(input, "wall", {-1.5, -1.5, 0}, {3, 0, 0}, {0, 3, 0}, 0);
  ts::addRoom(input, "shell", {-1.6, -1.6, -0.1}, {1.6, 1.6, 0.5});  // its fronts see the sheet's upper side
  for (InputFace& face : input.faces)
    if (input.surface_names[face.surface].starts_with("shell")) std::reverse(face.corners.begin(), face.corners.end());
  const Scene scene = buildScene(input);  // turned: all that the sheet sees is backs
  EXPECT_EQ(scene.coincidences.contacts, 1u);
  // One side free, the other solid.
  input.faces.erase(std::remove_if(input.faces.begin(), input.faces.end(), [&](const InputFace& face) { return input.surface_names[face.surface] == "shellz0"; }), input.faces.end());
  for (InputFace& face : input.faces)
    if (input.surface_names[face.surface].starts_with("shell"))
      for (glm::dvec3& corner : face.corners) corner.z = std::max(corner.z, 0.0);
  const Scene half = buildScene(input);
  ASSERT_EQ(half.warnings.size(), 1u);
  EXPECT_NE(half.warnings[0].find("free space on one side and the inside of a solid on the other"), std::string::npos) << half.warnings[0];
}

}  // namespace
}  // namespace viewpeel
