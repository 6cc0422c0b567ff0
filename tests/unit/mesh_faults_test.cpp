// These meshes have the faults that users' meshes have: faces that occur twice, overlap or have no area, and names that
// collide.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/ids.h>
#include "scene/face_names.h"
#include "scenes/coincident_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

InputScene named(const char* name) { return {name, {}, {}}; }

size_t countWith(const Scene& scene, const std::string& part) {
  return static_cast<size_t>(std::count_if(scene.warnings.begin(), scene.warnings.end(), [&](const std::string& line) {
    return line.find(part) != std::string::npos;
  }));
}

std::string all(const Scene& scene) {
  std::string text;
  for (const std::string& line : scene.warnings) text += line + "\n";
  return text;
}

std::string messageOf(const InputScene& input, const SceneOptions& options = {}) {
  try {
    buildScene(input, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MeshFaults, AFaceThatIsThereTwiceCountsOnceAndKeepsItsRow) {
  InputScene input = ts::parallelSquares();
  // Adds the same square again, starting at another corner and with one corner twice.
  ts::addFace(input, "again", {{1, 1, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}});
  ts::addFace(input, "last", {{3, 0, 0}, {4, 0, 0}, {4, 1, 0}});
  const Scene scene = buildScene(input);
  ASSERT_EQ(scene.faces.size(), 3u);
  EXPECT_EQ(scene.faces[2].row, 3u);
  EXPECT_EQ(scene.empty_faces, (std::vector<EmptyRow>{{2, "again"}}));
  EXPECT_EQ(scene.empty_surfaces, (std::vector<EmptyRow>{{2, "again"}}));
  ASSERT_EQ(scene.warnings.size(), 1u) << all(scene);
  EXPECT_NE(
      scene.warnings[0].find(
          "1 face is there already, facing alike: again (face 3 of the file) is lower (face 1 of the file) again"),
      std::string::npos)
      << scene.warnings[0];
  for (By by : {By::polygon, By::surface}) {
    const Ids ids = makeIds(scene, by, false);
    EXPECT_EQ(ids.rows(), (std::vector<uint32_t>{0, 1, 3}));
    EXPECT_EQ(ids.rowCount(), 4u);
  }
}

// A mesh contains all its faces three times. Each counts once, also after a turn and in single precision.
TEST(MeshFaults, AMeshThatIsThereThreeTimesCountsOnce) {
  InputScene input = ts::cubeInCube(0.3);
  const std::vector<InputFace> once = input.faces;
  for (int copy = 0; copy < 2; ++copy) input.faces.insert(input.faces.end(), once.begin(), once.end());
  for (const InputScene& each : {input, ts::turnedAndMoved(input), ts::roundedToSingle(ts::turnedAndMoved(input))}) {
    const Scene scene = buildScene(each);
    EXPECT_EQ(scene.faces.size(), once.size());
    EXPECT_EQ(scene.empty_faces.size(), 2 * once.size());
    EXPECT_EQ(scene.warnings.size(), 1u) << all(scene);
    EXPECT_EQ(faceName(scene, 0), "outer[1]");
    EXPECT_EQ(scene.empty_faces.front().name, "outer[7]");
  }
}

TEST(MeshFaults, TilesThatOverlapAreNamedWithTheirArea) {
  InputScene input = named("tiles");
  ts::addFace(input, "left", ts::parallelogram({0, 0, 0}, {0.6, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "right", ts::parallelogram({0.4, 0, 0}, {0.6, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "lid", ts::parallelogram({0, 0, 1}, {0, 1, 0}, {1, 0, 0}));
  const Scene scene = buildScene(input);
  EXPECT_EQ(scene.faces.size(), 3u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find(
                "1 pair of faces overlaps in one plane and faces the same way: left and right, 0.2 of area"),
            std::string::npos)
      << scene.warnings[0];
  // A square and its two triangles cover the same area twice, but no two faces are equal.
  InputScene halves = named("halves");
  ts::addFace(halves, "whole", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(halves, "half", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  ts::addFace(halves, "half", {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  EXPECT_EQ(countWith(buildScene(halves), "2 pairs of faces overlap"), 1u) << all(buildScene(halves));
  EXPECT_EQ(countWith(buildScene(halves), "1 in all"), 1u) << all(buildScene(halves));
}

// Intended shapes give no warnings: tiles that share edges, T-junctions, sheets, touching solids, sheets on sheets.
TEST(MeshFaults, CleanScenesWarnOfNothing) {
  for (const ts::CoincidentScene& of : ts::coincidentScenes())
    for (const InputScene& input : {of.make(0), ts::turnedAndMoved(of.make(0)),
                                    ts::roundedToSingle(ts::turnedAndMoved(of.make(0))), of.make(1e-3)}) {
      const Scene scene = buildScene(input);
      EXPECT_EQ(countWith(scene, "same way"), 0u) << of.name << "\n" << all(scene);
      EXPECT_TRUE(scene.empty_faces.empty()) << of.name << "\n" << all(scene);
    }
  for (const InputScene& input : {ts::roomWithTouchingBoxes(), ts::squaresInParts(20, 0.05, 1),
                                  ts::roundedToSingle(ts::turnedAndMoved(ts::squaresInParts(20, 0.05, 1)))})
    EXPECT_TRUE(buildScene(input).warnings.empty()) << all(buildScene(input));
  InputScene stack = named("two sheets on each other");
  ts::addSheet(stack, "lower", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0);
  ts::addSheet(stack, "upper", {0.25, 0.25, 0}, {0.5, 0, 0}, {0, 0.5, 0}, 0);
  ts::addFace(stack, "sun", ts::parallelogram({0, 0, 1}, {0, 1, 0}, {1, 0, 0}));
  EXPECT_EQ(countWith(buildScene(stack), "same way"), 0u) << all(buildScene(stack));
}

// In single precision, coordinates 4,500 km from the origin come in steps of half a metre, which is warned of.
TEST(MeshFaults, CoarseCoordinatesAreReported) {
  InputScene city = named("city");
  for (int k = 0; k < 20; ++k) ts::addBox(city, "box", {3.1 * k, 0.7, 0}, {3.1 * k + 2.3, 3.4, 5.2}, false);
  const auto moved = [&](double offset, double size) {
    return ts::transformed(city, glm::dmat3(1), size, glm::dvec3(offset));
  };
  EXPECT_EQ(countWith(buildScene(ts::roundedToSingle(moved(4.5e6, 1))), "come in steps of 0.5"), 1u)
      << all(buildScene(ts::roundedToSingle(moved(4.5e6, 1))));
  for (const InputScene& fine : {city, moved(4.5e6, 1), ts::roundedToSingle(city), ts::roundedToSingle(moved(1e3, 1)),
                                 ts::roundedToSingle(moved(4.5e6, 100))})
    EXPECT_EQ(countWith(buildScene(fine), "come in steps of"), 0u) << all(buildScene(fine));
  // Text gives single precision nine digits. With eight digits more, as in double precision, nothing is warned of.
  InputScene text = ts::roundedToSingle(moved(642857, 0.1)), all_digits = moved(642857, 0.1);
  for (InputScene* input : {&text, &all_digits})
    for (InputFace& face : input->faces)
      for (glm::dvec3& corner : face.corners)
        for (int axis = 0; axis < 3; ++axis)
          corner[axis] = std::stod(fmt::format("{:.{}g}", corner[axis], input == &text ? 9 : 17));
  const auto isExact = [](const InputFace& face) {
    return std::ranges::all_of(face.corners, [](const glm::dvec3& p) { return glm::dvec3(glm::vec3(p)) == p; });
  };
  EXPECT_FALSE(std::ranges::all_of(text.faces, isExact));
  EXPECT_EQ(countWith(buildScene(text), "come in steps of 0.062"), 1u) << all(buildScene(text));
  EXPECT_EQ(countWith(buildScene(all_digits), "come in steps of"), 0u);
  InputScene whole = named("whole metres");  // whole numbers are exact in single precision
  for (int k = 0; k < 20; ++k)
    ts::addBox(whole, "box", {4.5e6 + 4 * k, 5.1e5, 0}, {4.5e6 + 4 * k + 2, 5.1e5 + 3, 5}, false);
  EXPECT_EQ(countWith(buildScene(whole), "come in steps of"), 0u);
}

// The two triangles of each facet of a dish lie in one plane up to rounding. No warning is given.
TEST(MeshFaults, FacetsOfADishAreNoNarrowGaps) {
  InputScene dish = named("dish");
  const int across = 20, around = 48;
  const auto at = [&](int ring, int turn) {
    const double r = 0.5 * ring / across, a = 2 * 3.14159265358979 * turn / around;
    return glm::dvec3(r * std::cos(a), r * std::sin(a), r * r);
  };
  for (int ring = 1; ring < across; ++ring)
    for (int turn = 0; turn < around; ++turn) {
      const glm::dvec3 p = at(ring, turn), q = at(ring + 1, turn), r = at(ring + 1, turn + 1), s = at(ring, turn + 1);
      ts::addFace(dish, "dish", {p, q, r});
      ts::addFace(dish, "dish", {p, r, s});
    }
  for (const InputScene& input : {dish, ts::roundedToSingle(dish), ts::roundedToSingle(ts::turnedAndMoved(dish))})
    EXPECT_TRUE(buildScene(input).warnings.empty()) << all(buildScene(input));
  // A real overlap is still warned of: the same dish 1e-9 above itself.
  InputScene twice = dish;
  for (InputFace face : dish.faces) {
    for (glm::dvec3& corner : face.corners) corner.z += 1e-9;
    twice.faces.push_back(face);
  }
  EXPECT_EQ(countWith(buildScene(twice), "face the same way"), 1u) << all(buildScene(twice));
}

TEST(MeshFaults, FacesWithoutAreaKeepTheirNumbers) {
  InputScene input = named("degenerate");
  ts::addFace(input, "gone", {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}});
  ts::addFace(input, "a", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  ts::addFace(input, "a", {{0, 0, 0}, {0, 0, 0}, {1, 1, 0}});
  ts::addFace(input, "a", {{0, 0, 1}, {1, 1, 1}, {1, 0, 1}});
  const Scene scene = buildScene(input);
  ASSERT_EQ(scene.faces.size(), 2u);
  EXPECT_EQ(faceName(scene, 0), "a[1]");
  EXPECT_EQ(faceName(scene, 1), "a[3]");
  EXPECT_EQ(scene.empty_faces, (std::vector<EmptyRow>{{0, "gone"}, {2, "a[2]"}}));
  EXPECT_EQ(scene.empty_surfaces, (std::vector<EmptyRow>{{0, "gone"}}));
  EXPECT_EQ(makeIds(scene, By::polygon, false).rows(), (std::vector<uint32_t>{1, 3}));
  EXPECT_EQ(makeIds(scene, By::surface, false).rows(), (std::vector<uint32_t>{1}));
  EXPECT_EQ(countWith(scene, "its row stays, empty, and later numbers do not shift"), 2u) << all(scene);
  EXPECT_EQ(findPolygons(scene, "a[3]"), (std::vector<uint32_t>{1}));
  EXPECT_THROW(findPolygons(scene, "a[2]"), Error);  // the face has no area and so no polygon
  Scene shifted = scene;
  shifted.empty_faces[1].row = 1;
  EXPECT_NE(fingerprint(shifted), fingerprint(scene));
}

// Three squares share an edge, and a sliver has a width of 1e-6. Form factors equal closed forms, and no warning is
// given.
TEST(MeshFaults, EdgesOfThreeFacesAndSliversAreQuiet) {
  InputScene input = named("edge of three");
  ts::addFace(input, "floor", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  ts::addFace(input, "wall", {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}});
  ts::addFace(input, "skirt", {{1, 0, 0}, {0, 0, 0}, {0, 0, -1}, {1, 0, -1}});
  ts::addFace(input, "sliver", {{0, 0.5, 1}, {0, 0.500001, 1}, {1, 0.500001, 1}, {1, 0.5, 1}});
  const Scene scene = buildScene(input);
  EXPECT_TRUE(scene.warnings.empty());
  const Result result = computeFormFactors(scene);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_NEAR(result.form_factors.formFactor(0, 1).value, 0.2000437761, 1e-6);
  EXPECT_EQ(result.form_factors.formFactor(1, 2).value, 0);
  // The sliver lies over the middle of the unit square, at a distance of 1. Its form factor is the mean along it of the
  // form factor from an element to four rectangles (Howell, B-3).
  double truth = 0;
  constexpr int kParts = 2000;
  for (int k = 0; k < kParts; ++k) {
    const double x = (k + 0.5) / kParts;
    for (const double a : {x, 1 - x}) {
      const double b = 0.5, of_a = std::sqrt(1 + a * a), of_b = std::sqrt(1 + b * b);
      truth += 2 * (a / of_a * std::atan(b / of_a) + b / of_b * std::atan(a / of_b)) / (2 * std::numbers::pi) / kParts;
    }
  }
  EXPECT_NEAR(result.form_factors.formFactor(3, 0).value, truth, 2e-6);
}

TEST(MeshFaults, NamesThatCollideAreRefused) {
  InputScene input = named("names");
  ts::addFace(input, "a[2]", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  ts::addFace(input, "a", {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}});
  EXPECT_EQ(messageOf(input), "accepted");  // surface a has only one face
  ts::addFace(input, "a", {{0, 0, 2}, {1, 0, 2}, {1, 1, 2}});
  EXPECT_EQ(messageOf(input),
            "names: a surface is called 'a[2]', as face 2 of surface 'a' is in the results; rename one of the two");
  for (const char* other : {"a[02]", "a[x]", "a[]", "[2]", "a[2", "b[2]", "a[3]"}) {
    input.surface_names[0] = other;
    EXPECT_EQ(messageOf(input), "accepted") << other;
  }
}

class ObjNames : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("viewpeel_obj_names_" + std::to_string(::getpid()) + ".obj");
  }
  void TearDown() override { std::filesystem::remove(file_); }
  Scene load(const std::string& names) {
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    std::istringstream lines(names);
    int faces = 0;
    for (std::string line; std::getline(lines, line, ';');)
      text += line == "f" ? (++faces % 2 ? "f 1 2 3\n" : "f 1 2 4\n") : line + "\n";
    std::ofstream(file_) << text;
    return loadScene(file_);
  }
  std::vector<std::string> surfacesOf(const std::string& names) {
    std::vector<std::string> found;
    for (const Surface& surface : load(names).surfaces) found.push_back(surface.name);
    return found;
  }
  std::filesystem::path file_;
};

TEST_F(ObjNames, GroupsOfOneNameInDifferentObjectsStaySeparate) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(surfacesOf("o box1;g side;f;o box2;g side;f"), (Names{"box1/side", "box2/side"}));
  EXPECT_EQ(countWith(load("o box1;g side;f;o box2;g side;f"), "2 groups share their names"), 1u);
  EXPECT_EQ(surfacesOf("o desk;f;o lamp;g desk;f"), (Names{"desk", "lamp/desk"}));
  // These names differ already, or continue one surface.
  EXPECT_EQ(surfacesOf("o box1;g side;f;o box2;g top;f"), (Names{"side", "top"}));
  EXPECT_EQ(surfacesOf("o box;g box;f;o other;g other;f"), (Names{"box", "other"}));
  EXPECT_EQ(surfacesOf("g side;f;g top;f;g side"), (Names{"side", "top"}));
  EXPECT_EQ(load("g side;f;g top;f").warnings.size(), 0u);
  EXPECT_THROW(load("o a;g s;f;o b;g s;f;o a/s;f"), Error);
}

// Materials name surfaces where the file has neither objects nor groups.
TEST_F(ObjNames, MaterialsNameSurfacesWhereNothingElseDoes) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(surfacesOf("usemtl brick;f;usemtl glass;f;usemtl brick;f"), (Names{"brick", "glass"}));
  EXPECT_EQ(surfacesOf("f;usemtl glass;f"), (Names{file_.stem().string(), "glass"}));
  EXPECT_EQ(surfacesOf("g;o;usemtl brick;f"), (Names{"brick"}));
  EXPECT_EQ(surfacesOf("o wall;usemtl brick;f;usemtl glass;f"), (Names{"wall"}));
  EXPECT_EQ(surfacesOf("usemtl brick;f;g wall;f"), (Names{file_.stem().string(), "wall"}));
  EXPECT_TRUE(load("usemtl brick;f;usemtl glass;f").warnings.empty());
}

// Several solids of one name become surfaces of their own, with numbers after the name.
TEST(StlNames, SolidsOfOneNameStaySeparate) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("viewpeel_stl_names_" + std::to_string(::getpid()) + ".stl");
  const auto load = [&](const std::vector<std::string>& solids) {
    std::ofstream text(file);
    for (size_t k = 0; k < solids.size(); ++k)
      text << "solid " << solids[k] << "\nfacet normal 0 0 1\nouter loop\nvertex 0 0 " << k << "\nvertex 1 0 " << k
           << "\nvertex 0 1 " << k << "\nendloop\nendfacet\nendsolid\n";
    text.close();
    return loadScene(file);
  };
  const Scene scene = load({"part", "part", "lid", "part"});
  std::vector<std::string> names;
  for (const Surface& surface : scene.surfaces) names.push_back(surface.name);
  EXPECT_EQ(names, (std::vector<std::string>{"part", "part#2", "lid", "part#3"}));
  EXPECT_EQ(countWith(scene, "2 solids have the name of a solid before, and a number after it, as 'part#2'"), 1u);
  EXPECT_EQ(load({"", ""}).surfaces[1].name, file.stem().string() + "#2");
  EXPECT_EQ(load({"part", "lid"}).warnings.size(), 0u);
  EXPECT_THROW(load({"part", "part", "part#2"}), Error);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace viewpeel
