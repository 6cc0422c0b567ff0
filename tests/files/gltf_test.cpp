// These tests read glTF scenes that assimp has written, compare tinygltf's reading of them, and read small scenes with
// transforms, strips and errors that follow the specification.
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>
#include <tiny_gltf.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/ids.h>
#include "scene/readers.h"
#include "tests/support/python.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class Gltf : public TestFolder {
 protected:
  std::string refusal(const std::string& text) const {
    const fs::path file = write("a.gltf", text);
    return withoutPlace(refusalOf([&] { readGltf(file); }), file.string().size());
  }
};

TEST_F(Gltf, AssimpWritesThem) {
  write("shed.obj",
        "o floor\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nf 1 2 3 4\n"
        "o heater\nv 1 1 1\nv 1 2 1\nv 2 2 1\nv 2 1 1\nf 5 6 7 8\n");
  ASSERT_EQ(std::system(fmt::format("cd '{}' && assimp export shed.obj shed.glb >said 2>&1 && assimp export shed.obj "
                                    "shed.gltf -fgltf2 >said 2>&1",
                                    folder_.string())
                            .c_str()),
            0);
  for (const char* name : {"shed.glb", "shed.gltf"}) {
    const Scene scene = loadScene(folder_ / name);
    const Ids ids = makeIds(scene, By::surface, false);
    ASSERT_EQ(ids.names, (std::vector<std::string>{"floor", "heater"})) << name;
    EXPECT_NEAR(ids.areas[0], 12, 1e-14) << name;
    EXPECT_NEAR(ids.areas[1], 1, 1e-14) << name;
    for (const Polygon& polygon : scene.polygons)
      EXPECT_GT(frontNormal(scene, polygon).z * (scene.faces[polygon.face].surface == 0 ? 1 : -1), 0.99) << name;
  }
}

// The file's buffer holds one triangle, with single-precision positions and 16-bit indices.
constexpr const char* kBuffer =
    "\"buffers\":[{\"byteLength\":42,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}],";
constexpr const char* kAccessors =
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
    "{\"bufferView\":1,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":3}],";
std::string document(const std::string& nodes, const std::string& rest = "",
                     const std::string& primitive = "\"attributes\":{\"POSITION\":0},\"indices\":1") {
  return fmt::format(
      "{{\"asset\":{{\"version\":\"2.0\"}},{}{}\"meshes\":[{{\"name\":\"m\",\"primitives\":[{{{}}}]}}],{}"
      "\"nodes\":{}}}",
      kBuffer, kAccessors, primitive, rest, nodes);
}

// The transform of a node comes first, then its parents' transforms. A mirroring transform reverses corners, so that
// fronts stay outside.
TEST_F(Gltf, NodesHaveTransformsAndNames) {
  const InputScene scene = readGltf(write(
      "a.gltf",
      document(
          "[{\"name\":\"group\",\"translation\":[10,0,0],\"children\":[1,2]},"
          "{\"name\":\"wall\",\"mesh\":0,\"rotation\":[0,0,0.7071067811865476,0.7071067811865476],\"scale\":[2,1,1]},"
          "{\"mesh\":0,\"scale\":[1,1,-1]},{\"name\":\"wall\",\"mesh\":0,"
          "\"matrix\":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}]")));
  EXPECT_EQ(scene.surface_names, (std::vector<std::string>{"wall", "m", "wall#2"}));
  ASSERT_EQ(scene.faces.size(), 3u);
  const std::vector<std::vector<glm::dvec3>> expected = {
      {{10, 0, 0}, {10, 2, 0}, {9, 0, 0}}, {{10, 0, 0}, {10, 1, 0}, {11, 0, 0}}, {{0, 0, 5}, {1, 0, 5}, {0, 1, 5}}};
  for (size_t k = 0; k < 3; ++k)
    for (size_t c = 0; c < 3; ++c) EXPECT_LT(glm::distance(scene.faces[k].corners[c], expected[k][c]), 1e-14) << k << c;
  // The file's default scene has node 3 alone.
  EXPECT_EQ(readGltf(write("b.gltf", document("[{},{},{},{\"name\":\"shown\",\"mesh\":0}]",
                                              "\"scene\":1,\"scenes\":[{\"nodes\":[0]},{\"nodes\":[3]}],")))
                .surface_names,
            std::vector<std::string>{"shown"});
}

// TinyGltfReader makes the same triangles of what tinygltf has read, whose accessors it trusts.
struct TinyGltfReader {
  tinygltf::Model model;
  std::vector<std::string> names;                  // of each triangle
  std::vector<std::vector<glm::dvec3>> triangles;  // in the scene's coordinates

  explicit TinyGltfReader(const fs::path& file) {
    tinygltf::TinyGLTF loader;
    std::string error, warning;
    const bool is_read = file.extension() == ".glb" ? loader.LoadBinaryFromFile(&model, &error, &warning, file.string())
                                                    : loader.LoadASCIIFromFile(&model, &error, &warning, file.string());
    EXPECT_TRUE(is_read) << error;
    for (const int root : model.scenes.at(static_cast<size_t>(std::max(model.defaultScene, 0))).nodes)
      add(root, glm::dmat4(1));
  }

 private:
  const unsigned char* at(const tinygltf::Accessor& accessor) const {
    const tinygltf::BufferView& view = model.bufferViews.at(static_cast<size_t>(accessor.bufferView));
    return &model.buffers.at(static_cast<size_t>(view.buffer)).data.at(view.byteOffset + accessor.byteOffset);
  }
  uint32_t index(const tinygltf::Accessor& accessor, size_t k) const {
    uint32_t value = 0;
    const size_t size = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
    std::memcpy(&value, at(accessor) + k * size, size);
    return value;
  }
  glm::dvec3 point(const tinygltf::Accessor& accessor, size_t k) const {
    const auto stride = accessor.ByteStride(model.bufferViews.at(static_cast<size_t>(accessor.bufferView)));
    float p[3];
    std::memcpy(p, at(accessor) + k * static_cast<size_t>(stride), sizeof p);
    return {p[0], p[1], p[2]};
  }
  void add(int number, glm::dmat4 transform) {
    const tinygltf::Node& node = model.nodes.at(static_cast<size_t>(number));
    if (!node.matrix.empty()) transform *= glm::make_mat4(node.matrix.data());
    const std::vector<double>&t = node.translation, &r = node.rotation, &s = node.scale;
    if (!t.empty()) transform = glm::translate(transform, glm::dvec3(t[0], t[1], t[2]));
    if (!r.empty()) transform *= glm::mat4_cast(glm::dquat(r[3], r[0], r[1], r[2]));
    if (!s.empty()) transform = glm::scale(transform, glm::dvec3(s[0], s[1], s[2]));
    if (node.mesh >= 0) {
      const tinygltf::Mesh& mesh = model.meshes.at(static_cast<size_t>(node.mesh));
      for (const tinygltf::Primitive& primitive : mesh.primitives) {
        const auto& positions = model.accessors.at(static_cast<size_t>(primitive.attributes.at("POSITION")));
        const auto& indices = model.accessors.at(static_cast<size_t>(primitive.indices));
        for (size_t k = 0; k + 2 < indices.count; k += 3) {
          names.push_back(node.name.empty() ? mesh.name : node.name);
          std::vector<glm::dvec3>& corners = triangles.emplace_back();
          for (size_t c = 0; c < 3; ++c)
            corners.emplace_back(transform * glm::dvec4(point(positions, index(indices, k + c)), 1));
          if (glm::determinant(glm::dmat3(transform)) < 0) std::swap(corners[1], corners[2]);
        }
      }
    }
    for (const int child : node.children) add(child, transform);
  }
};

// A corner is a product of a few matrices, so it differs by some roundings of its size, up to 16.
TEST_F(Gltf, TinyGltfReadsTheSame) {
  write("shed.obj",
        "o floor\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nf 1 2 3 4\n"
        "o heater\nv 1 1 1\nv 1 2 1\nv 2 2 1\nv 2 1 1\nf 5 6 7 8\n");
  ASSERT_EQ(std::system(fmt::format("cd '{}' && assimp export shed.obj shed.glb >said 2>&1", folder_.string()).c_str()),
            0);
  write("nodes.gltf",
        document("[{\"name\":\"group\",\"translation\":[10,0,0],\"children\":[1,2]},"
                 "{\"name\":\"wall\",\"mesh\":0,\"rotation\":[0.1,0.2,0.3,0.9273618495495703],\"scale\":[2,3,-1]},"
                 "{\"mesh\":0,\"matrix\":[0,1,0,0, -1,0,0,0, 0,0,2,0, 3,4,5,1]}]",
                 "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"));
  for (const auto& [name, count] : {std::pair<const char*, size_t>("shed.glb", 4), {"nodes.gltf", 2}}) {
    const InputScene ours = readGltf(folder_ / name);
    const TinyGltfReader theirs(folder_ / name);
    ASSERT_EQ(theirs.triangles.size(), count) << name;
    ASSERT_EQ(ours.faces.size(), count) << name;
    for (size_t k = 0; k < count; ++k) {
      EXPECT_EQ(ours.surface_names[ours.faces[k].surface], theirs.names[k]) << name << k;
      for (size_t c = 0; c < 3; ++c)
        EXPECT_LT(glm::distance(ours.faces[k].corners[c], theirs.triangles[k][c]), 2e-13) << name << k << c;
    }
  }
}

TEST_F(Gltf, StripsAndFansAreTriangles) {
  const std::string indices =
      "\"buffers\":[{\"byteLength\":52,\"uri\":\"data:;base64,"
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAAAAECAw==\"}],"
      "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":4}],"
      "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":4},"
      "{\"bufferView\":1,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":4}],";
  for (const int mode : {5, 6}) {
    const InputScene scene = readGltf(
        write("a.gltf", fmt::format("{{\"asset\":{{}},{}\"meshes\":[{{\"primitives\":[{{\"mode\":{},\"attributes\":{{"
                                    "\"POSITION\":0}},\"indices\":1}},{{\"mode\":1}}]}}],\"nodes\":[{{\"mesh\":0}}]}}",
                                    indices, mode)));
    ASSERT_EQ(scene.faces.size(), 2u);
    EXPECT_EQ(scene.warnings.size(), 1u);  // The warning says that lines were left out.
    EXPECT_EQ(scene.surface_names, std::vector<std::string>{"node 0"});
    const glm::dvec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(1, 1, 0);
    EXPECT_EQ(scene.faces[0].corners, (std::vector<glm::dvec3>{a, b, c}));
    EXPECT_EQ(scene.faces[1].corners,
              mode == 5 ? (std::vector<glm::dvec3>{b, d, c}) : (std::vector<glm::dvec3>{a, c, d}));
  }
}

TEST_F(Gltf, FilesThatAreNoneAreRefused) {
  const std::string node = "[{\"mesh\":0}]";
  EXPECT_EQ(refusal(document(node)), "none");
  EXPECT_EQ(refusal("{"), ": not glTF: there is no JSON object; export it again");
  EXPECT_EQ(refusal("{}"), ": not glTF: there is no 'asset'; export it again");
  EXPECT_EQ(refusal(document("[{\"mesh\":1}]")), ": there is no element 1 of meshes; export the file again");
  EXPECT_EQ(refusal(document("[{\"mesh\":0,\"children\":[0]}]", "\"scenes\":[{\"nodes\":[0]}],")),
            ": nodes are nested too deeply, or in a circle; export the file again");
  EXPECT_EQ(refusal(document("[{\"mesh\":0,\"scale\":[1,2]}]")), ": 'scale' has not 3 numbers; export the file again");
  EXPECT_EQ(refusal(document(node, "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],")),
            ": needs the extension KHR_draco_mesh_compr; export it without compression and extensions");
  EXPECT_EQ(refusal(document(node, "", "\"attributes\":{\"POSITION\":1}")),
            ": an accessor is not of type VEC3; export the file again");
  std::string text = document(node);
  text.replace(text.find("\"byteLength\":36"), 15, "\"byteLength\":35");
  EXPECT_EQ(refusal(text), ": an accessor goes beyond its buffer; export the file again");
  text = document(node);
  text.replace(text.find("AAABAAIA"), 8, "AAABAAMA");
  EXPECT_EQ(refusal(text), ": there is no point 3; export the file again");
  text = document(node);
  text.replace(text.find("data:app"), 4, "no/such");
  EXPECT_NE(refusal(text).find("cannot be read; keep it beside the file"), std::string::npos);
}

}  // namespace
}  // namespace viewpeel
