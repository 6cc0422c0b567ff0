#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/readers.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw Error(ErrorCode::bad_input, fmt::format("{}: {}", file.string(), what));
}

std::string extensionOf(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

}  // namespace

Scene loadScene(const fs::path& file, const SceneOptions& options) {
  std::error_code failure;
  const fs::file_status status = fs::status(file, failure);
  if (status.type() == fs::file_type::not_found) refuse(file, "no such file; check the name");
  if (status.type() == fs::file_type::directory) refuse(file, "is a directory; name a scene file");
  // Readers open a file anew, and a pipe would wait for ever.
  if (fs::exists(status) && !fs::is_regular_file(status)) refuse(file, "is not a regular file; write the scene to one");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(file, fmt::format("cannot be read: {}", std::strerror(errno)));
  if (in.peek() == std::ifstream::traits_type::eof()) refuse(file, "the file is empty; export the scene again");
  in.close();
  const std::string extension = extensionOf(file);
  if (extension == ".obj") return buildScene(readObj(file), options);
  if (extension == ".stl") return buildScene(readStl(file), options);
  if (extension == ".ply") return buildScene(readPly(file), options);
  refuse(file, "unknown format; use .obj, .stl or .ply");
}

}  // namespace viewpeel
