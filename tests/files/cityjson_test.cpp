// These tests read city models that follow the specification of CityJSON 2.0.1, among them its oddities.
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/ids.h>
#include "scene/readers.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

// A cube of 1 m, 84,500 m east and 447,000 m north of the origin, in millimetres from there.
constexpr const char* kVertices =
    "\"vertices\":[[0,0,0],[1000,0,0],[1000,1000,0],[0,1000,0],[0,0,1000],[1000,0,1000],[1000,1000,1000],[0,1000,1000]"
    "]";
constexpr const char* kTransform = "\"transform\":{\"scale\":[0.001,0.001,0.001],\"translate\":[84500,447000,3]}";
// Its surfaces, seen from outside: floor, four walls, roof.
constexpr const char* kShell = "[[0,3,2,1]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],[[3,0,4,7]],[[4,5,6,7]]";
constexpr const char* kSurfaces =
    "\"surfaces\":[{\"type\":\"WallSurface\"},{\"type\":\"RoofSurface\"},{\"type\":\"GroundSurface\"}]";

std::string model(const std::string& objects, const std::string& more = kVertices) {
  return fmt::format("{{\"type\":\"CityJSON\",\"version\":\"2.0\",{},\"CityObjects\":{{{}}},{}}}", kTransform, objects,
                     more);
}

// Returns an object that is a cube.    In: lod: as the file states it, such as "2.2" with its quotes
std::string cube(const std::string& lod) {
  return fmt::format(
      "{{\"type\":\"Solid\",\"lod\":{},\"boundaries\":[[{}]],\"semantics\":{{{},\"values\":[[2,0,0,0,0,1]]}}}}", lod,
      kShell, kSurfaces);
}

std::string object(const std::string& id, const std::string& type, const std::string& geometries,
                   const std::string& more = "") {
  return fmt::format("\"{}\":{{\"type\":\"{}\",\"geometry\":[{}]{}}}", id, type, geometries, more);
}

class CityJson : public TestFolder {
 protected:
  Ids idsOf(const std::string& text, double lod = INFINITY, const std::string& name = "a.city.json") {
    SceneOptions options;
    options.lod = lod;
    scene_ = loadScene(write(name, text), options);
    return makeIds(scene_, By::surface, false);
  }
  std::string refusal(const std::string& text, const std::string& name = "a.json") const {
    const fs::path file = write(name, text);
    return withoutPlace(refusalOf([&] { loadScene(file); }), file.string().size());
  }
  Scene scene_;
};

TEST_F(CityJson, SemanticTypesAreSurfacesOfTheirObject) {
  const Ids ids = idsOf(model(object("b1", "Building", cube("\"2.2\""))));
  ASSERT_EQ(ids.names, (Names{"b1/GroundSurface", "b1/WallSurface", "b1/RoofSurface"}));
  EXPECT_NEAR(ids.areas[0], 1, 1e-12);
  EXPECT_NEAR(ids.areas[1], 4, 1e-12);
  // A corner is the rounding of 447,000 m off, 3e-11 m, so normals of 1 m2 are 1e-10 off at most.
  EXPECT_NEAR(frontNormal(scene_, scene_.polygons[0]).z, -1, 1e-9);
  EXPECT_NEAR(frontNormal(scene_, scene_.polygons[1]).y, -1, 1e-9);
  EXPECT_NEAR(frontNormal(scene_, scene_.polygons[5]).z, 1, 1e-9);
  EXPECT_NEAR(scene_.centre.x, 84500.5, 1e-9);
  EXPECT_NEAR(scene_.centre.z, 3.5, 1e-9);
}

TEST_F(CityJson, AnObjectWithoutSemanticsIsASurface) {
  const std::string plain = fmt::format("{{\"type\":\"Solid\",\"lod\":\"1\",\"boundaries\":[[{}]]}}", kShell);
  const std::string some = fmt::format(
      "{{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":[[[0,1,2,3]],[[4,5,6,7]]],\"semantics\":{{{},"
      "\"values\":[null,1]}}}}",
      kSurfaces);
  EXPECT_EQ(idsOf(model(object("tree", "SolitaryVegetationObject", plain))).names, Names{"tree"});
  EXPECT_EQ(idsOf(model(object("shed", "Building", some))).names, (Names{"shed", "shed/RoofSurface"}));
}

// A room of 4 x 3 x 3 m, seen from within, whose south wall has a window. The wall, which has the window as a hole, and
// the window together receive what the wall without a hole would.
TEST_F(CityJson, WindowsAreHolesInWalls) {
  const std::string vertices =
      "\"vertices\":[[0,0,0],[4000,0,0],[4000,3000,0],[0,3000,0],[0,0,3000],[4000,0,3000],[4000,3000,3000],[0,3000,"
      "3000],"
      "[1000,0,1000],[3000,0,1000],[3000,0,2000],[1000,0,2000]]";
  const std::string rest =
      "[[0,1,2,3]],[[4,7,6,5]],[[1,5,6,2]],[[2,6,7,3]],[[3,7,4,0]]";  // floor, ceiling, east, north and west
  const auto room = [&](const std::string& south, const std::string& values) {
    return model(
        object("room", "BuildingRoom",
               fmt::format(
                   "{{\"type\":\"MultiSurface\",\"lod\":\"3\",\"boundaries\":[{},{}],\"semantics\":{{\"surfaces\":["
                   "{{\"type\":\"FloorSurface\"}},{{\"type\":\"InteriorWallSurface\"}},{{\"type\":\"Window\"}},"
                   "{{\"type\":\"CeilingSurface\"}}],\"values\":[0,3,null,null,null,{}]}}}}",
                   rest, south, values)),
        vertices);
  };
  Request request;
  request.by = By::surface;
  request.goal = EpsilonDelta{.epsilon = 1e-3};
  const Ids with = idsOf(room("[[0,4,5,1],[8,9,10,11]],[[8,11,10,9]]", "1,2"));
  ASSERT_EQ(with.names,
            (Names{"room/FloorSurface", "room/CeilingSurface", "room", "room/InteriorWallSurface", "room/Window"}));
  EXPECT_NEAR(with.areas[3], 12 - 2, 1e-9);
  EXPECT_NEAR(with.areas[4], 2, 1e-9);
  const Result cut = computeFormFactors(scene_, request);
  idsOf(room("[[0,4,5,1]]", "1"));
  const Result whole = computeFormFactors(scene_, request);
  // In a convex room nothing blocks a pair, so that all values are exact but for roundings.
  for (uint32_t from = 0; from < 3; ++from)
    EXPECT_NEAR(cut.form_factors.formFactor(from, 3).value + cut.form_factors.formFactor(from, 4).value,
                whole.form_factors.formFactor(from, 3).value, 1e-9);
}

TEST_F(CityJson, EachObjectHasItsHighestLevelOfDetail) {
  const std::string roof = "{\"type\":\"MultiSurface\",\"lod\":1.3,\"boundaries\":[[[4,5,6,7]]]}",
                    outline = "{\"type\":\"MultiSurface\",\"lod\":\"0\",\"boundaries\":[[[0,1,2,3]]]}";
  const std::string text = model(object("b", "Building", outline, ",\"children\":[\"b-0\"]") + "," +
                                 object("b-0", "BuildingPart", roof + "," + cube("\"2.2\"") + "," + outline) + "," +
                                 object("road", "Road", outline));
  EXPECT_EQ(idsOf(text).names, (Names{"b-0/GroundSurface", "b-0/WallSurface", "b-0/RoofSurface", "road"}));
  EXPECT_TRUE(scene_.warnings.empty());  // the footprint of `b` does not count, for `b` has parts
  EXPECT_EQ(idsOf(text, 2).names, (Names{"b-0", "road"}));
  EXPECT_EQ(idsOf(text, 1.3).names, (Names{"b-0", "road"}));
  EXPECT_EQ(idsOf(text, 1).names, Names{"road"});
  ASSERT_EQ(scene_.warnings.size(), 1u);
  EXPECT_EQ(withoutPlace(scene_.warnings[0], (folder_ / "a.city.json").string().size()),
            ": 1 object has no surfaces at a level of detail that is read, and is left out");
  const auto refusalAt = [&](const std::string& objects, double lod) {
    const fs::path file = write("b.json", model(objects));
    return withoutPlace(refusalOf([&] { readCityJson(file, lod); }), file.string().size());
  };
  EXPECT_EQ(refusalAt(object("b", "Building", cube("\"2.2\"") + "," + roof), 1.2),
            ": no object has a level of detail up to 1.2; they begin at 1.3, so give a larger --lod");
  EXPECT_EQ(refusalAt(object("b", "Building", outline), INFINITY),
            ": buildings have nothing but footprints, of levels of detail below 1; take a model with walls");
}

TEST_F(CityJson, OtherGeometriesArePassedOver) {
  const std::string
      line = "{\"type\":\"MultiLineString\",\"lod\":\"3\",\"boundaries\":[[0,1]]}",
      closure =
          "{\"type\":\"MultiSurface\",\"lod\":\"2\",\"boundaries\":[[[0,3,2,1]],[[4,5,6,7]]],\"semantics\":{"
          "\"surfaces\":[{\"type\":\"ClosureSurface\"}],\"values\":[null,0]}}";
  EXPECT_EQ(idsOf(model(object("barn", "Building", line + "," + closure) + "," +
                        object("group", "CityObjectGroup", "") + "," + object("path", "Road", line)))
                .areas,
            std::vector<double>{1});
  ASSERT_EQ(scene_.warnings.size(), 1u);
  EXPECT_NE(scene_.warnings[0].find(": 1 surface of type ClosureSurface, which only closes an opening, is left out"),
            std::string::npos);
}

TEST_F(CityJson, SolidsMayHaveCavitiesAndStandInLists) {
  const std::string both = fmt::format("[[{0}],[{0}]]", kShell);
  for (const char* type : {"MultiSolid", "CompositeSolid"})
    EXPECT_EQ(readCityJson(
                  write("a.json", model(object("s", "GenericCityObject",
                                               fmt::format("{{\"type\":\"{}\",\"lod\":\"1\",\"boundaries\":[{},{}]}}",
                                                           type, both, both)))))
                  .faces.size(),
              24u)
        << type;
}

// A template is scaled by 2 and moved by (10, 0, 0), from where the object stands: vertex 6, at (1, 1, 1).
TEST_F(CityJson, InstancesOfATemplate) {
  const std::string instance =
      "{\"type\":\"GeometryInstance\",\"template\":0,\"boundaries\":[6],"
      "\"transformationMatrix\":[2,0,0,10,0,2,0,0,0,0,2,0,0,0,0,1]}";
  const std::string templates =
      "\"geometry-templates\":{\"templates\":[{\"type\":\"MultiSurface\",\"lod\":\"2\",\"boundaries\":[[[0,1,2]]]}],"
      "\"vertices-templates\":[[0,0,0],[1,0,0],[0,0.5,0]]}";
  const InputScene scene = readCityJson(
      write("a.json", model(object("lamp", "CityFurniture", instance), fmt::format("{},{}", kVertices, templates))));
  ASSERT_EQ(scene.faces.size(), 1u);
  const glm::dvec3 at(84501 + 10, 447001, 4);
  const glm::dvec3 expected[] = {at, at + glm::dvec3(2, 0, 0), at + glm::dvec3(0, 1, 0)};
  for (size_t k = 0; k < 3; ++k) EXPECT_LT(glm::distance(scene.faces[0].corners[k], expected[k]), 1e-9) << k;
}

TEST_F(CityJson, ASequenceHasAFeatureOnEachLine) {
  const std::string head = fmt::format(
      "{{\"type\":\"CityJSON\",\"version\":\"2.0\",{},\"CityObjects\":{{}},\"vertices\":[]}}\n", kTransform);
  const auto feature = [&](const std::string& id, const std::string& vertices) {
    return fmt::format("{{\"type\":\"CityJSONFeature\",\"id\":\"{}\",\"CityObjects\":{{{}}},\"vertices\":[{}]}}\n", id,
                       object(id, "Road", "{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":[[[0,1,2]]]}"),
                       vertices);
  };
  const std::string text =
      head + feature("a", "[0,0,0],[2000,0,0],[0,1000,0]") + "\n" + feature("b", "[0,0,0],[4000,0,0],[0,1000,0]");
  const InputScene scene = readCityJsonSequence(write("a.city.jsonl", text));
  EXPECT_EQ(scene.surface_names, (Names{"a", "b"}));
  EXPECT_NEAR(scene.faces[1].corners[1].x, 84504, 1e-9);
  EXPECT_EQ(scene.faces[1].line, 4u);  // messages name it
  EXPECT_EQ(idsOf(text, INFINITY, "a.jsonl").names, (Names{"a", "b"}));
  EXPECT_EQ(refusal(head + "{\"type\":\"CityJSON\"}", "a.jsonl"),
            ":2: this line is no CityJSONFeature; export the file again");
  EXPECT_EQ(refusal(head + "{]\n", "a.jsonl"), ":2: not JSON here; correct it");
  EXPECT_EQ(refusal(head + feature("a", "[0,0,0]"), "a.jsonl"),
            ":2: object 'a': 1 is not the index of one of 1 vertices, counted from 0; export the file again");
}

// Members of objects may have the names of members of the document, and members that are not objects do not count.
TEST_F(CityJson, ObjectsStandInTheOrderOfTheFile) {
  const auto road = [](const std::string& id, const std::string& corners, const std::string& more = "") {
    return object(id, "Road", "{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":[[[" + corners + "]]]}", more);
  };
  const std::string objects = road("z", "0,1,2", ",\"attributes\":{\"CityObjects\":{\"no\":{\"geometry\":[]}}}") +
                              ",\"nothing\":7," + road("a", "4,5,6") + "," + road("m", "0,3,7");
  EXPECT_EQ(idsOf(model(objects, std::string(kVertices) + ",\"extra\":{\"x\":{\"y\":{}}}")).names,
            (Names{"z", "a", "m"}));
}

TEST_F(CityJson, BadFilesAreNamedInOneLine) {
  const auto road = [](const std::string& geometry) { return model(object("r", "Road", geometry)); };
  const auto surface = [&](const std::string& boundaries) {
    return road(fmt::format("{{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":{}}}", boundaries));
  };
  EXPECT_EQ(refusal("{\n\"a\":\n]}"), ":3: not JSON here; correct it");
  EXPECT_EQ(refusal("{}"), ": not CityJSON: its 'type' is not \"CityJSON\"; export the city model again");
  EXPECT_EQ(refusal("[1]"), ": not CityJSON: its 'type' is not \"CityJSON\"; export the city model again");
  EXPECT_EQ(refusal("{\"type\":\"CityJSON\"}"), ": there are no 'CityObjects'; export the file again");
  EXPECT_EQ(refusal("{\"type\":\"CityJSON\",\"CityObjects\":{}}"),
            ": there is no list of vertices; export the file again");
  EXPECT_EQ(refusal(model("", "\"vertices\":[[1,2]]")), ": a vertex has not three numbers; export the file again");
  EXPECT_EQ(refusal(model("", "\"vertices\":[[1,2,\"3\"]]")),
            ": a vertex has not three numbers; export the file again");
  EXPECT_EQ(refusal(model("", kVertices)), ": no usable polygon; the file has no faces, check the export");
  EXPECT_EQ(refusal(surface("[[[0,1,8]]]")),
            ": object 'r': 8 is not the index of one of 8 vertices, counted from 0; export the file again");
  EXPECT_EQ(refusal(surface("[[[0,1,-1]]]")),
            ": object 'r': -1 is not the index of one of 8 vertices, counted from 0; export the file again");
  EXPECT_EQ(refusal(surface("[[0,1,2]]")), ": object 'r': a ring is no list of vertices; export the file again");
  EXPECT_EQ(refusal(surface("[7]")), ": object 'r': its boundaries are not lists of lists; export the file again");
  EXPECT_EQ(refusal(surface("7")), ": object 'r': its boundaries are not lists of lists; export the file again");
  EXPECT_EQ(refusal(model(object("r", "Road", "{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":[[[0,1,2,3]]]}"),
                          "\"vertices\":[[0,0,0],[4000,0,0],[1000,2000,0],[1000,-1000,0]]")),
            ": face 'r' crosses itself; split it into simple ones");
  EXPECT_EQ(refusal(road("{\"type\":\"GeometryInstance\",\"template\":3,\"boundaries\":[0]}")),
            ": object 'r': its template is not one of the file's; export the file again");
  EXPECT_EQ(refusal(road("{\"type\":\"MultiSurface\",\"lod\":\"high\",\"boundaries\":[]}")),
            ": 'high' is not a number; correct it");
}

TEST_F(CityJson, OtherFormatsHaveNoLevels) {
  const fs::path file = write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  SceneOptions options;
  options.lod = 1;
  try {
    loadScene(file, options);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_usage);
    EXPECT_EQ(error.what(), file.string() + ": --lod is for city models, .json or .jsonl; leave it out");
  }
}

TEST_F(CityJson, HolesOutsideTheirSurfaceAreCounted) {
  idsOf(model(object("r", "Road",
                     "{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":[[[0,1,2,3],[4,5]]]},"
                     "{\"type\":\"MultiSurface\",\"lod\":\"1\",\"boundaries\":[[[4,5,6],[8,9,10]]]}"),
              "\"vertices\":[[0,0,0],[1000,0,0],[1000,1000,0],[0,1000,0],[0,0,1000],[1000,0,1000],[1000,1000,1000],[0,"
              "1000,1000],"
              "[5000,0,1000],[6000,0,1000],[6000,1000,1000]]"));
  ASSERT_EQ(scene_.warnings.size(), 1u);
  EXPECT_NE(scene_.warnings[0].find(": 1 hole does not lie within its surface, and is left out"), std::string::npos);
}

}  // namespace
}  // namespace viewpeel
