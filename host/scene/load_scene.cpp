#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/energyplus.h"
#include "scene/join_scenes.h"
#include "scene/read_groups.h"
#include "scene/readers.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

using Reader = InputScene (*)(const fs::path&);
constexpr std::pair<const char*, Reader> kReaders[] = {
    {".obj", readObj}, {".stl", readStl}, {".ply", readPly}, {".vs3", readVs3},   {".inp", readInp},
    {".msh", readMsh}, {".vtp", readVtp}, {".vtu", readVtu}, {".gltf", readGltf}, {".glb", readGltf}};

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw Error(ErrorCode::bad_input, fmt::format("{}: {}", file.string(), what));
}

std::string extensionOf(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// Refuses a file whose format describes a whole scene: its cavities, zones or ranks.
void requirePart(const fs::path& file) {
  const std::string extension = extensionOf(file);
  std::error_code failure;
  if (fs::is_directory(file, failure) || isEnergyPlus(file) || extension == ".vs3" || extension == ".inp")
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: a file of this format is a whole scene; give it alone", file.string()));
}

}  // namespace

InputScene readScene(const fs::path& file, const SceneOptions& options) {
  std::error_code failure;
  const fs::file_status status = fs::status(file, failure);
  if (status.type() == fs::file_type::not_found) refuse(file, "no such file; check the name");
  if (status.type() == fs::file_type::directory) return readFoam(file);
  // A pipe is refused, because readers open a file more than once, and would then wait for ever.
  if (fs::exists(status) && !fs::is_regular_file(status)) refuse(file, "is not a regular file; write the scene to one");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(file, fmt::format("cannot be read: {}", std::strerror(errno)));
  if (in.peek() == std::ifstream::traits_type::eof()) refuse(file, "the file is empty; export the scene again");
  in.close();
  if (isEnergyPlus(file))
    return options.outside ? readEnergyPlusOutside(file) : readEnergyPlusZones(file, options.zones);
  if (options.outside || !options.zones.empty())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: {} is for buildings of EnergyPlus, .idf or .epJSON; leave it out", file.string(),
                            options.outside ? "--outside" : "--zone"));
  const std::string extension = extensionOf(file);
  if (extension == ".json") return readCityJson(file, options.lod);
  if (extension == ".jsonl") return readCityJsonSequence(file, options.lod);
  if (options.lod < INFINITY)
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: --lod is for city models, .json or .jsonl; leave it out", file.string()));
  for (const auto& [name, read] : kReaders)
    if (extension == name) return read(file);
  refuse(file,
         "unknown format; use .obj, .stl, .ply, .gltf, .glb, .vs3, .inp, .msh, .vtp, .vtu, .json or .jsonl (CityJSON), "
         ".idf or .epJSON (EnergyPlus), or the folder of an OpenFOAM case");
}

InputScene readScene(const std::vector<fs::path>& files, const SceneOptions& options) {
  if (files.empty()) throw Error(ErrorCode::bad_usage, "a scene needs a file; name one");
  if (files.size() == 1) return readScene(files.front(), options);
  std::vector<InputScene> parts;
  for (size_t k = 0; k < files.size(); ++k) {
    requirePart(files[k]);
    parts.push_back(readScene(files[k], options));
    std::error_code failure;
    for (size_t earlier = 0; earlier < k; ++earlier)
      if (fs::equivalent(files[earlier], files[k], failure))
        throw Error(ErrorCode::bad_usage, fmt::format("{}: is named twice; leave one out", files[k].string()));
  }
  return joinScenes(std::move(parts));
}

Scene loadScene(const fs::path& file, const SceneOptions& options) {
  return buildScene(readScene(file, options), options);
}

Scene loadScene(const std::vector<fs::path>& files, const SceneOptions& options) {
  return buildScene(readScene(files, options), options);
}

}  // namespace viewpeel
