// These tests check which faces belong to one shell, and which faces are turned the wrong way.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include <viewpeel/form_factors.h>
#include "result/leak_warnings.h"
#include "scene/exposed_backs.h"
#include "scene/leaks.h"
#include "scene/shells.h"
#include "scenes/coincident_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

InputScene emptyScene(const char* name) { return {name, {}, {}}; }

void turn(InputScene& input, size_t face) {
  std::reverse(input.faces[face].corners.begin(), input.faces[face].corners.end());
}

std::set<uint32_t> flippedIn(const InputScene& input) {
  const Scene scene = buildScene(input);
  Sight sight(scene);
  const std::vector<uint32_t> faces = findFlipped(scene, findShells(scene), sight);
  return {faces.begin(), faces.end()};
}

// Solids and rooms that touch are separate shells, even if they share corners, parts of edges or whole faces.
TEST(Shells, TouchingSolidsAreSeparateShells) {
  const Scene room = buildScene(ts::roomWithTouchingBoxes());
  const std::vector<Shell> shells = findShells(room);
  ASSERT_EQ(shells.size(), 4u);
  for (const Shell& shell : shells) {
    EXPECT_TRUE(shell.is_closed);
    EXPECT_FALSE(shell.is_twisted);
    EXPECT_EQ(std::count(shell.is_against.begin(), shell.is_against.end(), true), 0);
  }
  InputScene stacked = emptyScene("stacked");
  ts::addSolid(stacked, "lower", {0, 0, 0}, {1, 1, 1});
  ts::addSolid(stacked, "upper", {0, 0, 1}, {1, 1, 2});
  EXPECT_EQ(findShells(buildScene(stacked)).size(), 2u);
  InputScene rooms = emptyScene("rooms");
  ts::addRoom(rooms, "left", {0, 0, 0}, {1, 1, 1});
  ts::addRoom(rooms, "right", {1, 0, 0}, {2, 1, 1});
  EXPECT_EQ(findShells(buildScene(rooms)).size(), 2u);
}

TEST(Shells, AMoebiusStripCannotBeTurned) {
  InputScene strip = emptyScene("strip");
  const int count = 12;
  const auto at = [&](int k, double side) {
    const double a = 2 * 3.14159265358979 * k / count, half = a / 2, r = 2 + side * std::cos(half);
    return glm::dvec3(r * std::cos(a), r * std::sin(a), side * std::sin(half));
  };
  for (int k = 0; k < count; ++k) {
    const bool last = k + 1 == count;  // the corners of the first, upside down
    const glm::dvec3 p = last ? at(0, 0.5) : at(k + 1, -0.5), q = last ? at(0, -0.5) : at(k + 1, 0.5);
    ts::addFace(strip, "strip", {at(k, -0.5), p, at(k, 0.5)});
    ts::addFace(strip, "strip", {p, q, at(k, 0.5)});
  }
  const std::vector<Shell> shells = findShells(buildScene(strip));
  ASSERT_EQ(shells.size(), 1u);
  EXPECT_TRUE(shells[0].is_twisted);
}

// No face is turned in correct scenes: rooms, solids, sheets and contacts, also moved and in single precision.
// Returns the names of the surfaces of which all backs are exposed. No surface has both kinds.
std::set<std::string> exposedIn(const InputScene& input) {
  const Scene scene = buildScene(input);
  const std::vector<bool> is_exposed = findExposedBacks(scene);
  std::set<std::string> exposed, hidden;
  for (size_t k = 0; k < scene.faces.size(); ++k)
    (is_exposed[k] ? exposed : hidden).insert(scene.surfaces[scene.faces[k].surface].name);
  for (const std::string& name : exposed) EXPECT_FALSE(hidden.contains(name)) << name;
  return exposed;
}

// Adds the sides and the top of a house that stands on the ground, z = 0, without a floor.
void addHouse(InputScene& input, const char* name, glm::dvec3 low, glm::dvec3 high) {
  InputScene solid = emptyScene(name);
  ts::addSolid(solid, name, low, high);
  for (const InputFace& face : solid.faces)
    if (std::ranges::any_of(face.corners, [&](const glm::dvec3& corner) { return corner.z > low.z; }))
      ts::addFace(input, name, face.corners);
}

TEST(ExposedBacks, AreOfOpenShells) {
  using Names = std::set<std::string>;
  EXPECT_EQ(exposedIn(ts::roomWithTouchingBoxes()), Names());
  InputScene town = emptyScene("town");
  ts::addFace(town, "ground", ts::parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}));
  addHouse(town, "house", {0, 0, 0}, {1, 1, 2});
  addHouse(town, "tower", {3, 0, 0}, {4, 1, 6});
  EXPECT_EQ(exposedIn(town), Names());
  ts::addFace(town, "sunshade", ts::parallelogram({0, -1, 1}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(exposedIn(town), Names{"sunshade"});
  // One pixel above the ground its rim is within the scene.
  addHouse(town, "hovering", {-3, 0, 1e-9}, {-2, 1, 1});
  EXPECT_EQ(exposedIn(town), (Names{"sunshade", "hovering"}));

  // Of two tiles that look up the back of the upper one is seen, although its edges are on a side of the bounding box.
  InputScene tiles = emptyScene("tiles");
  ts::addFace(tiles, "lower", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(tiles, "upper", ts::parallelogram({0, 0, 1}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(exposedIn(tiles), Names{"upper"});
  turn(tiles, 0), turn(tiles, 1);
  EXPECT_EQ(exposedIn(tiles), Names{"lower"});
  turn(tiles, 0);
  EXPECT_EQ(exposedIn(tiles), Names());

  // The backs of a room's walls are hidden from what stands in the room, with a lid or without one. What stands beside
  // the room sees them.
  InputScene room = emptyScene("room");
  ts::addRoom(room, "room", {0, 0, 0}, {3, 3, 3});
  InputScene open = emptyScene("open");
  for (const InputFace& face : room.faces)
    if (std::ranges::any_of(face.corners, [](const glm::dvec3& corner) { return corner.z < 3; }))
      ts::addFace(open, "room", face.corners);
  for (InputScene* input : {&room, &open}) {
    ts::addSolid(*input, "table", {1, 1, 0}, {2, 2, 1});
    EXPECT_EQ(exposedIn(*input), Names());
    ts::addSolid(*input, "tree", {5, 1, 0}, {6, 2, 1});
    EXPECT_EQ(exposedIn(*input).contains("table"), false);
    EXPECT_EQ(exposedIn(*input).contains("tree"), false);
    EXPECT_GE(exposedIn(*input).size(), 1u);
  }
  InputScene turned = ts::roomWithTouchingBoxes();
  turn(turned, 7);
  EXPECT_FALSE(exposedIn(turned).empty());
}

TEST(Shells, WhatIsRightStays) {
  for (const ts::CoincidentScene& of : ts::coincidentScenes())
    for (const InputScene& input : {of.make(0), of.make(1e-3), ts::roundedToSingle(ts::turnedAndMoved(of.make(0)))})
      EXPECT_TRUE(flippedIn(input).empty()) << of.name;
  for (const InputScene& input :
       {ts::insideOfCube(), ts::cubeInCube(0.3), ts::roomWithTouchingBoxes(), ts::parallelSquares()})
    EXPECT_TRUE(flippedIn(input).empty()) << input.file;
}

// Exactly the faces or shells that were turned over in a clean scene are found.
TEST(Shells, WhatWasTurnedIsFound) {
  const InputScene clean = ts::cubeInCube(0.3);  // faces 0 to 5 are the outer cube, 6 to 11 the inner one
  const std::vector<std::set<uint32_t>> cases = {
      {0}, {7}, {2, 9}, {0, 1}, {6, 7, 8, 9, 10, 11}, {0, 1, 2, 3, 4, 5}, {0, 1, 2, 3, 4, 5, 8}};
  for (const std::set<uint32_t>& turned : cases) {
    InputScene input = clean;
    for (uint32_t face : turned) turn(input, face);
    EXPECT_EQ(flippedIn(input), turned) << *turned.begin() << " and " << turned.size() - 1 << " more";
    EXPECT_EQ(flippedIn(ts::roundedToSingle(ts::turnedAndMoved(input))), turned);
    const Scene fixed = buildScene(input, {.fix_normals = true}), expected = buildScene(clean);
    for (size_t k = 0; k < expected.polygons.size(); ++k)
      EXPECT_NEAR(glm::dot(frontNormal(fixed, fixed.polygons[k]), frontNormal(expected, expected.polygons[k])), 1,
                  1e-12);
  }
  // A single box whose fronts look outward counts as a room that CAD drew inside out. With a ground to see it counts as
  // a solid.
  InputScene box = emptyScene("box");
  ts::addSolid(box, "box", {0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(flippedIn(box).size(), 6u);
  ts::addFace(box, "ground", ts::parallelogram({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}));
  EXPECT_TRUE(flippedIn(box).empty());
}

TEST(Leaks, HiddenAreaIsMeasured) {
  InputScene input = emptyScene("no bottom");
  ts::addRoom(input, "room", {0, 0, 0}, {1, 1, 1});
  ts::addBox(input, "box", {0.2, 0.2, 0}, {0.6, 0.6, 0.5}, false);
  input.faces.erase(input.faces.begin() + 6 + 4);
  const Scene scene = buildScene(input);
  const FrontRays found = followFronts(scene);
  ASSERT_EQ(found.leaks.size(), 1u);
  EXPECT_EQ(found.leaks[0].cause, LeakCause::no_bottom);
  EXPECT_EQ(scene.surfaces[found.leaks[0].from].name, "roomz0");
  // The hidden area is 0.16 of 6.8, so that 386 +- 19 of 16,384 rays hit it. Four of these standard deviations are
  // allowed.
  EXPECT_NEAR(found.leaks[0].hidden_area, 0.16, 0.16 * 4 / std::sqrt(386));
  EXPECT_EQ(followFronts(buildScene(ts::roomWithTouchingBoxes())).backs, 0u);
  EXPECT_EQ(describeClosedness(scene).find("closed, but leaking"), 0u);
  EXPECT_EQ(describeClosedness(buildScene(ts::roomWithTouchingBoxes())), "closed");
  EXPECT_EQ(describeClosedness(buildScene(ts::parallelSquares())), "open");
  for (const ts::CoincidentScene& of : ts::coincidentScenes()) {
    if (!of.is_closed) continue;
    const std::string word = describeClosedness(buildScene(ts::roundedToSingle(ts::turnedAndMoved(of.make(0)))));
    EXPECT_TRUE(word == "closed" || word == "closed but for edges that meet no other") << of.name << ": " << word;
  }
}

// A sheet stands in a room, so that rays from walls and floor end on its back. A surface's share is of the radiation
// that ends on backs, however many rays its polygons get. Surfaces with larger shares get more rays here, and no share
// changes. Of 16,384 rays 2,000 end on backs, so shares are known to 1 / sqrt(2,000) = 0.022. The test allows four
// times this, and more for rays that stand for ten times the area of others.
TEST(Leaks, SharesAreOfRadiation) {
  InputScene input = emptyScene("sheet");
  ts::addRoom(input, "room", {0, 0, 0}, {1, 1, 1});
  ts::addFace(input, "sheet", ts::parallelogram({0.2, 0.5, 0.2}, {0.6, 0, 0}, {0, 0, 0.6}));
  const Scene scene = buildScene(input);
  const auto sharesOf = [&](const std::vector<double>& weights) {
    std::map<std::string, double> shares;
    for (const Leak& leak : followFronts(scene, weights).leaks) shares[scene.surfaces[leak.from].name] += leak.share;
    return shares;
  };
  const auto even = sharesOf({});
  std::vector<double> weights;
  for (const Polygon& polygon : scene.polygons) {
    const std::string& name = scene.surfaces[scene.faces[polygon.face].surface].name;
    weights.push_back(polygon.area * (even.contains(name) ? even.at(name) : 0));
  }
  const auto weighted = sharesOf(weights);
  ASSERT_GE(even.size(), 3u);
  double largest = 0, by_count = 0, squares = 0;
  for (const auto& [name, share] : even) squares += share * share;
  for (const auto& [name, share] : even) {
    EXPECT_NEAR(weighted.at(name), share, 0.1) << name;
    largest = std::max(largest, share), by_count = std::max(by_count, share * share / squares);
  }
  // Negative control: if weights counted twice, the largest share would be off by more.
  EXPECT_GT(by_count, largest + 0.1);
}

// A leak is warned of from a millionth of the radiation on where all edges meet another, elsewhere from a thousandth
// on.
TEST(Leaks, WarningsBeginAtTheirShares) {
  InputScene open = emptyScene("open");
  ts::addRoom(open, "room", {0, 0, 0}, {1, 1, 1});
  open.faces.pop_back();
  InputScene closed = emptyScene("closed");
  ts::addRoom(closed, "room", {0, 0, 0}, {1, 1, 1});
  const auto warns = [](const InputScene& input, double share) {
    const Scene scene = buildScene(input);
    Ids ids = makeIds(scene, By::polygon, false);
    const double area = std::accumulate(ids.areas.begin(), ids.areas.end(), 0.0);
    const size_t rows = ids.count();
    return !warnOfLeaks(
                scene, FormFactors(ids, {{0, 1, {0.2, 0}}, {0, kLeak, {share * area, 0}}}, std::vector<Measured>(rows)))
                .empty();
  };
  // A row that loses more than the goal allows it to err is warned of, whatever the share of all radiation.
  const auto warnsOfRow = [&](double goal) {
    const Scene scene = buildScene(open);
    const Ids ids = makeIds(scene, By::polygon, false);
    return !warnOfLeaks(scene, {ids, {{0, kLeak, {2e-3 * ids.areas[0], 0}}}, std::vector<Measured>(ids.count())}, goal)
                .empty();
  };
  EXPECT_TRUE(warnsOfRow(1.9e-3));
  EXPECT_FALSE(warnsOfRow(2.1e-3));
  EXPECT_FALSE(warns(closed, 0.99e-6));
  EXPECT_TRUE(warns(closed, 1.01e-6));
  EXPECT_FALSE(warns(open, 0.99e-3));
  EXPECT_TRUE(warns(open, 1.01e-3));
}

}  // namespace
}  // namespace viewpeel
