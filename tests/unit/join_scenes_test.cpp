// Several files make one scene.
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/vec3.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/scene.h>

#include "scene/read_groups.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class JoinScenes : public TestFolder {
 protected:
  // Writes a unit square at a height, whose front is above it or, turned over, below.
  fs::path writeSquare(const std::string& name, double height, bool is_turned, const std::string& before = "") const {
    std::string text = before;
    for (const char* corner : {"0 0", "1 0", "1 1", "0 1"}) text += fmt::format("v {} {}\n", corner, height);
    return write(name, text + (is_turned ? "f 4 3 2 1\n" : "f 1 2 3 4\n"));
  }
  // Writes a text STL file of one triangle at a height.
  fs::path writeStl(const std::string& name, double height, const std::string& solid) const {
    fs::create_directories((folder_ / name).parent_path());
    return write(name, fmt::format("solid {0}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {1}\nvertex 1 0 {1}\nvertex "
                                   "0 1 {1}\nendloop\nendfacet\nendsolid\n",
                                   solid, height));
  }
  static std::vector<std::string> namesOf(const Scene& scene) {
    std::vector<std::string> names;
    for (const Surface& surface : scene.surfaces) names.push_back(surface.name);
    return names;
  }
  static std::string usageErrorOf(const std::vector<fs::path>& files, const fs::path& groups = "") {
    try {
      loadGroupedScene(files, groups, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_usage);
      return error.what();
    }
    return "none";
  }
};

TEST_F(JoinScenes, FacesAreInTheOrderOfFilesAndSeeEachOther) {
  const std::vector<fs::path> files{writeSquare("lower.obj", 0, false), writeSquare("upper.obj", 1, true)};
  const Scene scene = loadScene(files);
  EXPECT_EQ(scene.file, "lower.obj, upper.obj");
  EXPECT_EQ(namesOf(scene), (std::vector<std::string>{"lower", "upper"}));
  EXPECT_EQ(scene.faces[1].row, 1u);
  EXPECT_TRUE(scene.warnings.empty());
  const Result result = computeFormFactors(scene, {});
  // Unit squares opposite each other at distance 1 (Howell, A Catalog of Radiation Configuration Factors, C-11).
  EXPECT_NEAR(result.form_factors.formFactor(0, 1).value, 0.199824895698, 5e-13);
}

TEST_F(JoinScenes, IsTheSceneOfOneFileWithTheSameFaces) {
  const std::string lower = "o lower\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                    upper = "o upper\nv 0 0 1\nv 0 1 1\nv 1 0 1\n";
  const Scene joined = loadScene(std::vector{write("a.obj", lower), write("b.obj", upper + "f 1 2 3\n")});
  EXPECT_EQ(fingerprint(joined), fingerprint(loadScene(write("all.obj", lower + upper + "f 4 5 6\n"))));
}

TEST_F(JoinScenes, NamesThatFilesShareHaveTheFileBeforeThem) {
  const Scene scene = loadScene(std::vector{writeStl("inner.stl", 0, "wall"), writeStl("outer.stl", 1, "wall"),
                                            writeStl("lamp.stl", 2, "lamp"), writeStl("more.stl", 3, "wall")});
  EXPECT_EQ(namesOf(scene), (std::vector<std::string>{"inner/wall", "outer/wall", "lamp", "more/wall"}));
  EXPECT_EQ(scene.file, "inner.stl, outer.stl, lamp.stl and 1 more");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("'inner/wall'"), std::string::npos) << scene.warnings[0];
}

TEST_F(JoinScenes, FilesOfOneNameHaveTheirFoldersBeforeNames) {
  const fs::path a = writeStl("a/part.stl", 0, ""), b = writeStl("b/part.stl", 1, "");
  EXPECT_EQ(namesOf(loadScene(std::vector{a, b})),
            (std::vector<std::string>{a.string() + "/part", b.string() + "/part"}));
}

TEST_F(JoinScenes, NamesThatStayEqualAreRefused) {
  const fs::path a = writeStl("a.stl", 0, "b/wall"), b = writeStl("b.stl", 1, "wall"), c = writeStl("c.stl", 2, "wall");
  EXPECT_EQ(refusalOf([&] {
              loadScene(std::vector{a, b, c});
            }),
            b.string() + ": a surface is called 'b/wall', and so is one of " + a.string() + "; rename one of them");
}

// A part in single precision lies on a part in double precision, in an oblique plane from which rounding moves corners.
TEST_F(JoinScenes, PartsThatTouchMayDifferInPrecision) {
  const glm::dvec3 origin(100.1, 200.2, 300.3), right(0.36, 0.48, 0.8), up(-0.8, 0.6, 0);
  std::string lower, upper = "solid upper\nfacet normal 0 0 1\nouter loop\n";
  const auto at = [&](const std::pair<int, int>& uv) {
    return origin + double(uv.first) * right + double(uv.second) * up;
  };
  for (const std::pair<int, int>& uv : {std::pair(0, 0), {3, 0}, {3, 3}, {0, 3}})
    lower += fmt::format("v {:.17g} {:.17g} {:.17g}\n", at(uv).x, at(uv).y, at(uv).z);
  for (const std::pair<int, int>& uv : {std::pair(1, 1), {1, 2}, {2, 1}})  // the other way round
    upper += fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", float(at(uv).x), float(at(uv).y), float(at(uv).z));
  const Coincidences found = loadScene(std::vector{write("lower.obj", lower + "f 1 2 3 4\n"),
                                                   write("upper.stl", upper + "endloop\nendfacet\nendsolid\n")})
                                 .coincidences;
  EXPECT_EQ(found.sheets + found.contacts, 1u);
}

TEST_F(JoinScenes, MessagesNameTheFileOfAFace) {
  const fs::path good = writeSquare("good.obj", 0, false),
                 bad = write("bad.obj", "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_EQ(refusalOf([&] { loadScene(std::vector{good, bad}); }).find(bad.string() + ":5: "), 0u);
  EXPECT_EQ(refusalOf([&] { loadScene(std::vector{bad, good}); }).find(bad.string() + ":5: "), 0u);
  const fs::path none = write("none.obj", "v 0 0 0\n");
  EXPECT_EQ(refusalOf([&] { loadScene(std::vector{good, none}); }).find(none.string() + ": the file has no faces"), 0u);
  const Scene twice = loadScene(std::vector{good, writeSquare("again.obj", 0, false)});
  ASSERT_EQ(twice.warnings.size(), 1u);
  EXPECT_NE(twice.warnings[0].find((folder_ / "again.obj").string() + ":5"), std::string::npos) << twice.warnings[0];
}

TEST_F(JoinScenes, RefusesWholeScenesAndFilesNamedTwice) {
  const fs::path square = writeSquare("square.obj", 0, false);
  const fs::path box = write("box.vs3", "F 3\nV 1 0 0 0\n");
  EXPECT_EQ(usageErrorOf({}), "a scene needs a file; name one");
  EXPECT_EQ(usageErrorOf({square, folder_ / "." / "square.obj"}),
            (folder_ / "." / "square.obj").string() + ": is named twice; leave one out");
  EXPECT_EQ(usageErrorOf({square, box}), box.string() + ": a file of this format is a whole scene; give it alone");
  EXPECT_EQ(usageErrorOf({square, writeSquare("other.obj", 1, true)}, "g.csv"),
            "g.csv: --groups names the faces of one file; give one scene file, or leave it out");
}

}  // namespace
}  // namespace viewpeel
