// Exact areas of a scene with coincident faces equal the areas of the same scene with small gaps between the faces. The
// test peel_test.cpp compares the engines with the exact path and with the CPU twin.
#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "scenes/coincident_scenes.h"
#include "directions/sampler.h"
#include "engines/host_engine.h"
#include <viewpeel/error.h>
#include "reference/exact/exact_pair_areas.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

using Areas = std::map<std::pair<uint32_t, uint32_t>, double>;  // input units squared, over all directions

Areas areasOf(const Scene& scene, const std::vector<glm::dvec3>& directions) {
  Areas areas;
  // Faces that rounding has moved may pass through their neighbours by this depth.
  for (const auto& found : reference::computeExactPairAreas(scene, directions, {.touching_depth = 1e-5}))
    for (const auto& pair : found.pairs)
      areas[{scene.polygons[pair.a].face, pair.b < kEnvironment ? scene.polygons[pair.b].face : pair.b}] +=
          pair.area * scene.scale * scene.scale;
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
    for (size_t k = 0; k < face.corners.size(); ++k)
      sum += glm::length(face.corners[(k + 1) % face.corners.size()] - face.corners[k]);
  return sum;
}

// Returns an empty string where no pair's area differs by more than `allowed`, else the first pair that does.
std::string firstDifference(const InputScene& input, const Areas& areas, const Areas& meant, double allowed) {
  const auto nameOf = [&](uint32_t face) -> std::string {
    return face == kEnvironment ? "environment"
           : face == kLeak      ? "leak"
                                : input.surface_names[input.faces[face].surface];
  };
  Areas both = areas;
  both.insert(meant.begin(), meant.end());
  for (const auto& entry : both) {
    const auto valueIn = [&](const Areas& all) { return all.count(entry.first) ? all.at(entry.first) : 0; };
    const double found = valueIn(areas), wanted = valueIn(meant);
    if (std::abs(found - wanted) > allowed)
      return nameOf(entry.first.first) + " to " + nameOf(entry.first.second) + ": " + std::to_string(found) +
             " in place of " + std::to_string(wanted);
  }
  return "";
}

constexpr double kMeantGap = 1e-5;

// A gap of g moves every face by at most 2 g, and so every edge of the projection. A pair's area changes by at most 2 g
// times all perimeters, in either of the scenes compared.
double allowedDifference(const InputScene& input, double gap, size_t directions) {
  return 2 * (kMeantGap + gap) * perimeters(input) * double(directions);
}

class Coincident : public testing::TestWithParam<ts::CoincidentScene> {
 protected:
  void compare(const InputScene& input, const InputScene& meant, double gap) {
    const auto directions = someDirections();
    const Scene scene = buildScene(input);
    EXPECT_EQ(firstDifference(input, areasOf(scene, directions), areasOf(buildScene(meant), directions),
                              allowedDifference(input, gap, directions.size())),
              "")
        << GetParam().name;
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
  }
};

TEST_P(Coincident, IsWhatAGapWouldMean) {
  const InputScene meant = GetParam().make(kMeantGap);
  compare(GetParam().make(0), meant, 0);
  compare(ts::turnedAndMoved(GetParam().make(0)), ts::turnedAndMoved(meant), 0);
}

// Rounding may turn a gap of 0 into a negative one: the faces have passed through each other.
TEST_P(Coincident, AtGapsOfRounding) {
  for (double gap : {1e-12, 1e-9, 1e-8, 1e-7, 1e-6})
    for (double sign : {1.0, -1.0}) {
      if (GetParam().needs_gap && sign < 0) continue;
      SCOPED_TRACE(sign * gap);
      compare(GetParam().make(sign * gap), GetParam().make(kMeantGap), gap);
    }
}

TEST_P(Coincident, InSinglePrecision) {
  const double rounding = 0x1p-22;  // largest rounding of coordinates below 4
  for (double gap : {0.0, 1e-7}) {
    SCOPED_TRACE(gap);
    compare(ts::roundedToSingle(ts::turnedAndMoved(GetParam().make(gap))),
            ts::turnedAndMoved(GetParam().make(kMeantGap)), gap + rounding);
  }
}

// Negative control: with reversed ranks the areas differ.
TEST_P(Coincident, TheOtherOrderIsNoticed) {
  Scene scene = buildScene(GetParam().make(0));
  const auto directions = someDirections();
  const Areas meant = areasOf(scene, directions);
  for (Polygon& polygon : scene.polygons) polygon.tie_rank = kTieRanks - 1 - polygon.tie_rank;
  EXPECT_NE(firstDifference(GetParam().make(0), areasOf(scene, directions), meant,
                            allowedDifference(GetParam().make(0), 0, directions.size())),
            "")
      << GetParam().name;
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

// Boxes holds random boxes with whole corners, and the union of them as a grid of unit cubes. Faces are named by their
// plane and by the way they look, so that both forms of the solid have the same surfaces.
struct Boxes {
  static constexpr int kWidth = 24;
  std::vector<std::pair<glm::ivec3, glm::ivec3>> boxes;
  std::vector<bool> is_solid = std::vector<bool>(kWidth * kWidth * kWidth, false);

  static bool isWithin(int x) { return x >= 0 && x < kWidth; }
  bool at(glm::ivec3 c) const {
    return isWithin(c.x) && isWithin(c.y) && isWithin(c.z) &&
           is_solid[static_cast<size_t>((c.x * kWidth + c.y) * kWidth + c.z)];
  }

  Boxes(size_t count, bool disjoint, uint32_t seed) {
    std::mt19937 random(seed);
    const auto below = [&](int most) { return static_cast<int>(random() % static_cast<uint32_t>(most)); };
    // Adds boxes at two opposite corners, so that the ball around the scene does not depend on the other boxes.
    const auto add = [&](glm::ivec3 low, glm::ivec3 high) {
      boxes.emplace_back(low, high);
      forEachCube(low, high,
                  [&](glm::ivec3 c) { is_solid[static_cast<size_t>((c.x * kWidth + c.y) * kWidth + c.z)] = true; });
    };
    add(glm::ivec3(0), glm::ivec3(1));
    add(glm::ivec3(kWidth - 1), glm::ivec3(kWidth));
    for (size_t tries = 0; boxes.size() < count && tries < 100 * count; ++tries) {
      glm::ivec3 low(below(kWidth), below(kWidth), below(kWidth)), size(1 + below(5), 1 + below(5), 1 + below(5));
      const glm::ivec3 high = glm::min(low + size, glm::ivec3(kWidth));
      bool is_free = true;
      forEachCube(low, high, [&](glm::ivec3 c) { is_free = is_free && !at(c); });
      if (!disjoint || is_free) add(low, high);
    }
  }

  template <class Use>
  static void forEachCube(glm::ivec3 low, glm::ivec3 high, Use use) {
    for (int x = low.x; x < high.x; ++x)
      for (int y = low.y; y < high.y; ++y)
        for (int z = low.z; z < high.z; ++z) use(glm::ivec3(x, y, z));
  }

  // Returns a scene without faces that has the names of all possible surfaces, in a fixed order.
  static InputScene empty(const char* file) {
    InputScene scene{file, {}, {}};
    for (int axis = 0; axis < 3; ++axis)
      for (int upper = 0; upper < 2; ++upper)
        for (int plane = 0; plane <= kWidth; ++plane)
          scene.surface_names.push_back(std::string(1, "xyz"[axis]) + "-+"[upper] + std::to_string(plane));
    return scene;
  }
  static void addOutside(InputScene& scene, glm::ivec3 low, glm::ivec3 high, int axis, int upper) {
    InputScene one{"", {}, {}};
    ts::addBox(one, "box", low, high, false, true);
    InputFace face = one.faces[static_cast<size_t>(2 * axis + upper)];
    face.surface = static_cast<uint32_t>((axis * 2 + upper) * (kWidth + 1) + (upper ? high : low)[axis]);
    scene.faces.push_back(face);
  }
  InputScene asBoxes() const {
    InputScene scene = empty("boxes");
    for (const auto& [low, high] : boxes)
      for (int side = 0; side < 6; ++side) addOutside(scene, low, high, side / 2, side % 2);
    return scene;
  }
  InputScene cut() const {
    InputScene scene = empty("cut boxes");
    forEachCube(glm::ivec3(0), glm::ivec3(kWidth), [&](glm::ivec3 c) {
      if (!at(c)) return;
      for (int side = 0; side < 6; ++side) {
        glm::ivec3 next = c;
        next[side / 2] += side % 2 ? 1 : -1;
        if (!at(next)) addOutside(scene, c, c + 1, side / 2, side % 2);
      }
    });
    return scene;
  }
};

// Counts are keyed by name, for a surface may exist in one of the scenes only.
using CountsByName = std::map<std::pair<std::string, std::string>, uint64_t>;
CountsByName countsByName(const InputScene& input) {
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::surface, false);
  CountsByName counts;
  for (const PairCount& pair :
       makeHostEngine(scene, ids, {.resolution = 96})->count(sampleDirections(Sampler::fibonacci, 24, 3, 0))) {
    std::string a = ids.names[pair.i], b = pair.j == kEnvironment ? "environment"
                                           : pair.j == kLeak      ? "leak"
                                                                  : ids.names[pair.j];
    if (pair.j < kEnvironment && b < a) std::swap(a, b);
    counts[{a, b}] = pair.count;
  }
  return counts;
}

// Returns the sum of all differences between the counts of two scenes.
uint64_t differenceOf(const CountsByName& a, const CountsByName& b) {
  CountsByName all = a;
  all.insert(b.begin(), b.end());
  uint64_t difference = 0;
  for (const auto& entry : all) {
    const auto countIn = [&](const CountsByName& counts) {
      return counts.count(entry.first) ? counts.at(entry.first) : 0;
    };
    difference += std::max(countIn(a), countIn(b)) - std::min(countIn(a), countIn(b));
  }
  return difference;
}
uint64_t sumOf(const CountsByName& counts) {
  uint64_t sum = 0;
  for (const auto& entry : counts) sum += entry.second;
  return sum;
}

// Lines that rounding moves across an edge may count for another pair. Corners are snapped to 2^-18 of a spacing, and
// the edges of 1,000 boxes are some 8e4 spacings long. So 0.3 of the 25,000 lattice points of a direction are that near
// to an edge.
constexpr double kGrazing = 2e-5;

// The boxes together and their union give the same counts, for they are one solid on one lattice. Only the contacts of
// touching boxes count in addition, and are taken out.
TEST(CoincidentPairs, TouchingBoxesAreTheirUnion) {
  for (uint32_t seed : {1u, 2u}) {
    const Boxes boxes(1000, true, seed);
    auto counted = countsByName(boxes.asBoxes());
    const auto meant = countsByName(boxes.cut());
    std::erase_if(counted, [&](const auto& entry) {  // x+5 and x-5 face each other in contacts only
      const auto& [a, b] = entry.first;
      return b != "environment" && b != "leak" && a[0] == b[0] && a.substr(2) == b.substr(2);
    });
    EXPECT_LE(double(differenceOf(counted, meant)), kGrazing * double(sumOf(meant))) << "seed " << seed;
    EXPECT_GT(differenceOf(counted, countsByName(boxes.asBoxes())),
              0.1 * double(sumOf(meant)));  // negative control: with the contacts counts differ
    EXPECT_GT(boxes.boxes.size(), 500u);
  }
}

// Boxes overlap, are nested, or have coplanar faces. The radiation to the environment equals that of their union. Parts
// inside the union count as leak and are not compared.
TEST(CoincidentPairs, OverlappingBoxesShowTheirUnion) {
  const Boxes boxes(1000, false, 3);
  auto counted = countsByName(boxes.asBoxes());
  auto meant = countsByName(boxes.cut());
  const auto isInside = [](const auto& entry) { return entry.first.second != "environment"; };
  std::erase_if(counted, isInside);
  std::erase_if(meant, isInside);
  EXPECT_LE(double(differenceOf(counted, meant)), kGrazing * double(sumOf(meant)));
  EXPECT_GT(meant.size(), 50u);
}

// The scene decides by default that the two faces are a sheet. The options `sheets` and `solids` overrule it, and
// contradictions are refused.
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

TEST(CoincidentPairs, ContradictionsAreReported) {
  InputScene input{"half", {}, {}};
  ts::addRoom(input, "room", {-2, -2, -2}, {2, 2, 2});
  ts::addSheet(input, "wall", {-1.5, -1.5, 0}, {3, 0, 0}, {0, 3, 0}, 0);
  ts::addRoom(input, "shell", {-1.6, -1.6, -0.1}, {1.6, 1.6, 0.5});  // turned below
  for (InputFace& face : input.faces)
    if (input.surface_names[face.surface].starts_with("shell")) std::reverse(face.corners.begin(), face.corners.end());
  const Scene scene = buildScene(input);  // both sides of the wall see only backs, so it lies inside a solid
  EXPECT_EQ(scene.coincidences.contacts, 1u);
  // Now one side of the wall is free and the other lies in a solid, which is warned of.
  input.faces.erase(
      std::remove_if(input.faces.begin(), input.faces.end(),
                     [&](const InputFace& face) { return input.surface_names[face.surface] == "shellz0"; }),
      input.faces.end());
  for (InputFace& face : input.faces)
    if (input.surface_names[face.surface].starts_with("shell"))
      for (glm::dvec3& corner : face.corners) corner.z = std::max(corner.z, 0.0);
  const Scene half = buildScene(input);
  ASSERT_EQ(half.warnings.size(), 1u);
  EXPECT_NE(half.warnings[0].find("free space on one side and the inside of a solid on the other"), std::string::npos)
      << half.warnings[0];
}

}  // namespace
}  // namespace viewpeel
