// These tests read scene files, and check that broken files are refused.
#include <filesystem>
#include <fstream>

#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/scene.h>

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class Load : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("viewpeel_load_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  Scene load(const std::string& name, const std::string& text) { return loadScene(write(name, text)); }

  // Expects that the file is refused in one line that starts with `where`, after the folder, and contains `what`.
  void expectRefused(const std::string& name, const std::string& text, const std::string& where,
                     const std::string& what) {
    try {
      load(name, text);
      ADD_FAILURE() << name << " was accepted:\n" << text.substr(0, 200);
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(error.code(), ErrorCode::bad_input) << message;
      EXPECT_EQ(message.find((folder_ / where).string() + ":"), 0u) << message;
      EXPECT_NE(message.find(what), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }

  fs::path folder_;
};

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST_F(Load, ObjNamesAreSurfacesAndPolygonsStayWhole) {
  const Scene scene =
      load("a.obj", "# comment\nmtllib x.mtl\n" + kSquare +
                        "v 0 0 2\nv 1 0 2\nvt 0 0\nvn 0 0 1\no floor one\nf 1/1/1 2/1/1 3//1 4\nusemtl m\ns off\n"
                        "g tri\nf -6 -5 -2\no floor one\nf 1 3 5\n");
  ASSERT_EQ(scene.surfaces.size(), 2u);
  EXPECT_EQ(scene.surfaces[0].name, "floor one");
  EXPECT_EQ(scene.surfaces[0].face_count, 2u);  // the same name later means the same surface
  EXPECT_EQ(scene.surfaces[1].name, "tri");
  ASSERT_EQ(scene.polygons.size(), 3u);
  EXPECT_EQ(scene.polygons[0].corner_count, 4u);
  EXPECT_NEAR(scene.polygons[0].area * scene.scale * scene.scale, 1, 1e-14);
  EXPECT_EQ(scene.faces[2].number, 2u);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(Load, ObjNegativeIndicesCountBack) {
  const Scene scene = load("a.obj", kSquare + "f -4 -3 -2 -1\nv 9 9 9\n");
  EXPECT_EQ(scene.polygons[0].corner_count, 4u);
  EXPECT_EQ(scene.surfaces[0].name, "a");  // the file's name stands for a missing one
}

TEST_F(Load, ObjTakesWindowsLinesContinuationsAndUtf8) {
  const Scene scene = load("a.obj", "v 0 0 0\r\nv 1 0 \\\r\n 0\r\nv +1 1e0 0\r\no Tür süd\r\nf 1 2 \\\r\n3\r\n");
  EXPECT_EQ(scene.surfaces[0].name, "Tür süd");
  EXPECT_EQ(scene.polygons.size(), 1u);
}

// The latest of the statements o and g gives the name. An empty g goes back to the object's name.
TEST_F(Load, ObjGroupWithoutNameFallsBackToObject) {
  const Scene scene = load("a.obj", kSquare + "o thing\ng part\nf 1 2 3\ng\nf 1 3 4\n");
  ASSERT_EQ(scene.surfaces.size(), 2u);
  EXPECT_EQ(scene.surfaces[0].name, "part");
  EXPECT_EQ(scene.surfaces[1].name, "thing");
}

TEST_F(Load, ObjKeepsDoubles) {
  // These unit squares lie a million units away and 1e-6 apart. Single precision would merge them.
  const Scene scene = load("far.obj",
                           "v 1000000 0 0\nv 1000001 0 0\nv 1000001 1 0\nv 1000000 1 0\n"
                           "v 1000000 0 0.000001\nv 1000001 0 0.000001\nv 1000001 1 0.000001\nf 1 2 3 4\nf 7 6 5\n");
  EXPECT_EQ(scene.planes.size(), 2u);
  const double gap = (scene.corners[4].z - scene.corners[0].z) * scene.scale;
  EXPECT_NEAR(gap, 1e-6, 1e-15);
}

TEST_F(Load, ObjRefusesWhatIsBroken) {
  expectRefused("a.obj", "", "a.obj", "empty");
  expectRefused("a.obj", "# nothing\n", "a.obj", "no usable polygon");
  expectRefused("a.obj", kSquare + "f 1 2 7\n", "a.obj:5", "7 is out of range");
  expectRefused("a.obj", kSquare + "\nf 0 1 2\n", "a.obj:6", "out of range");
  expectRefused("a.obj", kSquare + "f -5 1 2\n", "a.obj:5", "out of range");
  expectRefused("a.obj", kSquare + "f 1 2\n", "a.obj:5", "three corners");
  expectRefused("a.obj", kSquare + "f 1 x 2\n", "a.obj:5", "'x'");
  expectRefused("a.obj", kSquare + "f 99999999999999999999 1 2\n", "a.obj:5", "vertex index");
  expectRefused("a.obj", "v 0 0 0\nv nan 0 0\n", "a.obj:2", "finite");
  expectRefused("a.obj", "v 0 0 0\nv 0 -inf 0\n", "a.obj:2", "finite");
  expectRefused("a.obj", "v 0 0 1e999\n", "a.obj:1", "finite");
  expectRefused("a.obj", "v 0 0\n", "a.obj:1", "three coordinates");
  expectRefused("a.obj", "v 0 0 zero\n", "a.obj:1", "'zero'");
  expectRefused("a.obj", "v 1.7e308 0 0\nv -1.7e308 0 0\nv 0 1.7e308 1\nf 1 2 3\n", "a.obj", "");
  expectRefused("a.obj", kSquare + "f 1 1 1\n", "a.obj", "no usable polygon");
  expectRefused("a.obj", "curv2 1 2\n", "a.obj:1", "curv2");
  expectRefused("a.obj",
                std::string("\x7f"
                            "ELF\0\1\2",
                            7),
                "a.obj:1", "not a statement");
}

std::string asciiStl(const std::string& name, const std::string& last_x = "1") {
  return "solid " + name + "\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex " +
         last_x + " 1 0\n  endloop\n endfacet\nendsolid " + name + "\n";
}

std::string asciiPly(const std::string& face, const std::string& x = "0") {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face "
         "1\n"
         "property list uchar int vertex_indices\nend_header\n" +
         x + " 0 0\n1 0 0\n1 1 0\n0 1 0\n" + face + "\n";
}

// Some editors begin UTF-8 files with a byte order mark, which is not part of the first word.
TEST_F(Load, ByteOrderMarkIsSkipped) {
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(load("a.obj", mark + kSquare + "f 1 2 3 4\n").polygons.size(), 1u);
  EXPECT_EQ(load("a.obj", mark + "# comment\n" + kSquare + "f 1 2 3 4\n").polygons.size(), 1u);
  EXPECT_EQ(load("a.stl", mark + asciiStl("part")).surfaces[0].name, "part");
  EXPECT_EQ(load("a.ply", mark + asciiPly("4 0 1 2 3")).polygons.size(), 1u);
  expectRefused("a.obj", kSquare + mark + "f 1 2 3 4\n", "a.obj:5", "not a statement");  // elsewhere it is an error
}

// Messages cut quoted text between characters, and replace control characters, which could steer a terminal.
TEST_F(Load, MessagesQuoteWholePrintableCharacters) {
  expectRefused("a.obj", "aaaaaaaaaaaaaaaaaaa\u00FC\n", "a.obj:1", "'aaaaaaaaaaaaaaaaaaa' is not");
  expectRefused("a.obj", "aaaaaaaaaaaaaaaaaa\u00FCb\n", "a.obj:1", "'aaaaaaaaaaaaaaaaaa\u00FC' is not");
  expectRefused("a.obj", "a\x1B[2J\x7F\n", "a.obj:1", "'a?[2J?' is not");
}

TEST_F(Load, MissingFileDirectoryAndUnknownFormat) {
  for (const auto& [file, what] : {std::pair(folder_ / "none.obj", "no such file"), std::pair(folder_, "directory"),
                                   std::pair(write("a.xyz", "hello"), "unknown format")}) {
    try {
      loadScene(file);
      ADD_FAILURE() << file;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find(file.string()), 0u) << error.what();
    }
  }
}

std::string binaryStl(uint32_t count, size_t bytes_missing = 0) {
  std::string text(80, ' ');
  text.append(reinterpret_cast<const char*>(&count), 4);
  for (uint32_t k = 0; k < count; ++k) {
    const float z = float(k), facet[12] = {0, 0, 1, 0, 0, z, 1, 0, z, 1, 1, z};
    text.append(reinterpret_cast<const char*>(facet), 48).append(2, '\0');
  }
  return text.substr(0, text.size() - bytes_missing);
}

TEST_F(Load, StlBothKinds) {
  const Scene ascii = load("a.stl", asciiStl("part"));
  ASSERT_EQ(ascii.polygons.size(), 1u);
  EXPECT_NEAR(ascii.polygons[0].area * ascii.scale * ascii.scale, 0.5, 1e-14);
  EXPECT_EQ(ascii.surfaces[0].name, "part");
  const Scene two = load("two.stl", asciiStl("one") + asciiStl("other", "2"));
  ASSERT_EQ(two.surfaces.size(), 2u);
  EXPECT_EQ(two.surfaces[1].name, "other");
  const Scene binary = load("b.stl", binaryStl(3));
  EXPECT_EQ(binary.polygons.size(), 3u);
  EXPECT_EQ(binary.surfaces[0].name, "b");
}

TEST_F(Load, StlRefusesWhatIsBroken) {
  expectRefused("a.stl", asciiStl("part", "nan"), "a.stl:6", "finite");
  expectRefused("a.stl", asciiStl("part", "1e999"), "a.stl:6", "finite");
  expectRefused("a.stl", binaryStl(3, 60), "a.stl", "3 binary facets");
  expectRefused("a.stl", "solid\nendsolid\n", "a.stl", "no usable polygon");
  expectRefused("a.stl", "solid x\n facet normal 0 0 1\n", "a.stl:2", "ends before");
  expectRefused("a.stl", "solid x\n vertex 0 0 0\n", "a.stl:2", "out of place");
  expectRefused("a.stl", "nonsense", "a.stl", "header");
}

// The header of a sparse 2 GB file announces 4 billion facets. Only the header is read, so memory does not grow.
TEST_F(Load, StlWhoseSizeBeliesItsHeaderIsNotRead) {
  const fs::path file = folder_ / "sparse.stl";
  std::string head(80, ' ');
  head += "\xee\xff\xff\xee";
  std::ofstream(file, std::ios::binary) << head;
  fs::resize_file(file, uint64_t(2) << 30);
  const auto largestResidentKiB = [] {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    return used.ru_maxrss;
  };
  const long before = largestResidentKiB();
  std::string message;
  try {
    loadScene(file);
  } catch (const Error& error) {
    message = error.what();
  }
  EXPECT_LT(largestResidentKiB() - before, 100'000);  // reading the whole file would need 2 GB
  EXPECT_NE(message.find("not STL text, and its size does not fit the 4009754606 binary facets of its header"),
            std::string::npos)
      << message;
}

TEST_F(Load, PlyKeepsPolygons) {
  const Scene scene = load("a.ply", asciiPly("4 0 1 2 3"));
  ASSERT_EQ(scene.polygons.size(), 1u);
  EXPECT_EQ(scene.polygons[0].corner_count, 4u);
  EXPECT_EQ(scene.surfaces[0].name, "a");
}

TEST_F(Load, PlyRefusesWhatIsBroken) {
  expectRefused("a.ply", asciiPly("3 0 1 9"), "a.ply:14", "9 is out of range");
  expectRefused("a.ply", asciiPly("3 0 1 -1"), "a.ply:14", "out of range");
  expectRefused("a.ply", asciiPly("2 0 1"), "a.ply:14", "three corners");
  expectRefused("a.ply", asciiPly("4 0 1 2"), "a.ply:14", "too few");
  expectRefused("a.ply", asciiPly("3 0 1 2", "inf"), "a.ply:10", "finite");
  expectRefused("a.ply", "ply\nformat ascii 1.0\nelement vertex 4\n", "a.ply:3", "ends too early");
  expectRefused("a.ply", "nonsense\n", "a.ply:1", "not a PLY file");
  expectRefused("a.ply", asciiPly("3.5 0 1 2 3"), "a.ply:14", "3.5 is not the length");
  expectRefused("a.ply", asciiPly("-1"), "a.ply:14", "-1 is not the length");
  const std::string head = "ply\nformat binary_little_endian 1.0\n", end = "end_header\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  expectRefused("a.ply",
                head + "element vertex 4\nproperty float x\nproperty list uchar float y\nproperty float z\n" + end,
                "a.ply:7", "no property 'y'");
  expectRefused("a.ply", head + "element face 1\nproperty list uchar int vertices\n" + end, "a.ply:5",
                "no list 'vertex_indices'");
  // Records without properties have no bytes. 4e9 of them fit into any file, but not into memory.
  expectRefused("a.ply", head + "element edge 4000000000\nelement vertex 4000000000\n" + xyz + end, "a.ply:8",
                "element 'edge' has no property");
}

std::string binaryPly(bool little) {
  std::string text = asciiPly("");
  text = text.substr(0, text.find("end_header\n") + 11);
  text.replace(text.find("ascii"), 5, little ? "binary_little_endian" : "binary_big_endian");
  const auto append = [&](auto value) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (!little) std::reverse(bytes.begin(), bytes.end());  // this machine is little-endian
    text += bytes;
  };
  for (float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) append(x);
  append(uint8_t(4));
  for (int32_t index : {0, 1, 2, 3}) append(index);
  return text;
}

TEST_F(Load, PlyBinaryOfEitherByteOrder) {
  for (bool little : {true, false}) {
    const Scene scene = load("a.ply", binaryPly(little));
    ASSERT_EQ(scene.polygons.size(), 1u);
    EXPECT_NEAR(scene.polygons[0].area * scene.scale * scene.scale, 1, 1e-14);
  }
}

// A file that is cut short anywhere is refused, and never read in part.
TEST_F(Load, TruncatedFilesAreRefused) {
  for (const auto& [name, text] : {std::pair<std::string, std::string>("a.ply", asciiPly("4 0 1 2 3")),
                                   {"a.ply", binaryPly(true)},
                                   {"a.stl", asciiStl("part")},
                                   {"a.stl", binaryStl(2)}})
    for (size_t length = 1; length + 2 < text.size(); ++length) {
      if (name == "a.stl" && text.substr(length).find("endsolid") == std::string::npos && text.starts_with("solid"))
        continue;
      EXPECT_THROW(load(name, text.substr(0, length)), Error) << name << " of " << length << " bytes";
    }
}

TEST_F(Load, ExampleScenesAreWhatTheyClaim) {
  for (const auto& [name, closed] :
       {std::pair("office", true), std::pair("cube", true), std::pair("plates", false), std::pair("street", false)}) {
    const Scene scene = loadScene(std::string(VIEWPEEL_SCENES "/") + name + ".obj");
    EXPECT_EQ(isClosed(scene), closed) << name;
    EXPECT_TRUE(scene.warnings.empty()) << name;
  }
  const Scene office = loadScene(VIEWPEEL_SCENES "/office.obj");
  EXPECT_GE(office.polygons.size(), 300u);
  EXPECT_LE(office.polygons.size(), 1000u);
}

}  // namespace
}  // namespace viewpeel
