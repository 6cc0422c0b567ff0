// A .csv file names the faces of formats without names.
#include <fstream>

#include <fmt/format.h>

#include "scene/read_groups.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

class ReadGroups : public TestFolder {
 protected:
  // Writes a binary STL file of a fan of triangles.
  std::filesystem::path writeStl(uint32_t facets) const {
    std::string bytes(80, ' ');
    const auto add = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    add(facets);
    for (uint32_t k = 0; k < facets; ++k) {
      for (float normal : {0.0F, 0.0F, 1.0F}) add(normal);
      for (float x : {0.0F, 0.0F, 0.0F, 1.0F, float(k), 0.0F, 1.0F, float(k + 1), 0.0F}) add(x);
      add(uint16_t(0));
    }
    return write("fan.stl", bytes);
  }
};

TEST_F(ReadGroups, NamesFacesOfBinaryStl) {
  const auto scene =
      loadGroupedScene({writeStl(6)},
                       write("g.csv",
                             "\xEF\xBB\xBF"
                             "face,name\n1-2,roof\r\n# the rest\n\n 4 , \"wall, \"\"north\"\"\"\n6,roof\n"),
                       {});
  std::vector<std::string> names;
  for (const Face& face : scene.faces) names.push_back(scene.surfaces[face.surface].name);
  EXPECT_EQ(names, (std::vector<std::string>{"roof", "roof", "fan", "wall, \"north\"", "fan", "roof"}));
}

TEST_F(ReadGroups, APlyFileToo) {
  const auto ply =
      write("a.ply",
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
  const Scene scene = loadGroupedScene({ply}, write("g.csv", "2,b\n1,a\n"), {});
  ASSERT_EQ(scene.surfaces.size(), 2u);  // no face of the surface with the file's name is left
  EXPECT_EQ(scene.surfaces[scene.faces[0].surface].name, "a");
  EXPECT_EQ(scene.surfaces[scene.faces[1].surface].name, "b");
}

TEST_F(ReadGroups, FaultsNameFileAndLine) {
  const std::filesystem::path stl = writeStl(6), groups = folder_ / "g.csv";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"1,a\n7,b\n", ":2: there is no face 7; the scene has faces 1 to 6"},
           {"0,a\n", ":1: there is no face 0; the scene has faces 1 to 6"},
           {"1-3,a\n\n2,b\n", ":3: line 1 names face 2 already; give each face one name"},
           {"4-2,a\n", ":1: the range 4-2 runs backwards; turn it round"},
           {"face,name\nroof,1\n", ":2: 'roof' is not the number of a face; write 12, or 12-40"},
           {"1\n", ":1: a line is a face and a name: 12,wall or 12-40,wall"},
           {"1,\n", ":1: a face has no name; write one after the comma"},
           {"1,\"a\n", ":1: a name has no closing quote; add it"},
           {"1,\"a\"b\n", ":1: text follows the closing quote of a name; double the quotes in it"},
           {"-3,a\n", ":1: '' is not the number of a face; write 12, or 12-40"},
           {"18446744073709551617,a\n",
            ":1: '18446744073709551617' is not the number of a face; write 12, or 12-40"}}) {
    write("g.csv", text);
    EXPECT_EQ(refusalOf([&] { loadGroupedScene({stl}, groups, {}); }), groups.string() + message);
  }
  EXPECT_EQ(refusalOf([&] { loadGroupedScene({stl}, folder_ / "none.csv", {}); }),
            (folder_ / "none.csv").string() + ": cannot be read: No such file or directory");
}

TEST_F(ReadGroups, OfAFormatWithNamesIsRefused) {
  const auto obj = write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  try {
    loadGroupedScene({obj}, write("g.csv", "1,a\n"), {});
    FAIL() << "was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_usage);
  }
}

}  // namespace
}  // namespace viewpeel
