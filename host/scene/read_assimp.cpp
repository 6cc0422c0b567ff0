#include <cmath>
#include <fstream>
#include <sstream>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "error.h"
#include "scene/readers.h"

namespace viewpeel {
namespace {

// The line of a text file that spells a number that is not finite; 0 where there is none.
uint32_t findNonFiniteLine(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line, word;
  for (uint32_t number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    while (words >> word) {
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      if (*end == '\0' && std::abs(value) > 3.4028235e38) return number;
      if (*end == '\0' && std::isnan(value)) return number;
    }
  }
  return 0;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw Error(ErrorCode::bad_input, fmt::format("{}: {}", file.string(), what));
}

void checkFinite(const std::filesystem::path& file, const aiVector3D& v) {
  if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) return;
  const uint32_t line = findNonFiniteLine(file);
  refuse(line ? fmt::format("{}:{}", file.string(), line) : file.string(), "a coordinate is not a finite number; correct it");
}

void addMesh(const std::filesystem::path& file, const aiMesh& mesh, uint32_t surface, InputScene& scene) {
  for (unsigned k = 0; k < mesh.mNumFaces; ++k) {
    InputFace face{{}, surface, 0};
    for (unsigned c = 0; c < mesh.mFaces[k].mNumIndices; ++c) {
      const unsigned index = mesh.mFaces[k].mIndices[c];
      if (index >= mesh.mNumVertices)
        refuse(file, fmt::format("vertex index {} of face {} is out of range; there are {} vertices", index, k, mesh.mNumVertices));
      const aiVector3D& v = mesh.mVertices[index];
      checkFinite(file, v);
      face.corners.emplace_back(v.x, v.y, v.z);
    }
    if (face.corners.size() >= 3) scene.faces.push_back(std::move(face));
  }
}

void addNode(const std::filesystem::path& file, const aiScene& from, const aiNode& node, InputScene& scene) {
  for (unsigned k = 0; k < node.mNumMeshes; ++k) {
    const aiMesh& mesh = *from.mMeshes[node.mMeshes[k]];
    std::string name = node.mName.C_Str();
    if (name.empty() || name.front() == '<') name = mesh.mName.C_Str();
    if (name.empty() || name.front() == '<') name = file.stem().string();
    auto at = std::find(scene.surface_names.begin(), scene.surface_names.end(), name);
    if (at == scene.surface_names.end()) at = scene.surface_names.insert(at, name);
    addMesh(file, mesh, static_cast<uint32_t>(at - scene.surface_names.begin()), scene);
  }
  for (unsigned k = 0; k < node.mNumChildren; ++k) addNode(file, from, *node.mChildren[k], scene);
}

}  // namespace

InputScene readWithAssimp(const std::filesystem::path& file) {
  Assimp::Importer importer;
  const aiScene* from = importer.ReadFile(file.string(), 0);
  if (!from || !from->mRootNode) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason)
      if (static_cast<unsigned char>(c) < 32) c = ' ';
    refuse(file, reason + "; check or export it again");
  }
  InputScene scene{file.string(), {}, {}};
  addNode(file, *from, *from->mRootNode, scene);
  return scene;
}

}  // namespace viewpeel
