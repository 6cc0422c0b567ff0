#include "scene/read_groups.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <unordered_map>
#include <utility>

#include "scene/words.h"

namespace viewpeel {
namespace {

// Returns the text between quotes (RFC 4180), or the text itself where it has no quotes.
std::string unquote(std::string_view text, const FilePlace& place) {
  if (!text.starts_with('"')) return std::string(text);
  std::string name;
  for (size_t k = 1; k < text.size(); ++k) {
    if (text[k] != '"') {
      name += text[k];
    } else if (k + 1 < text.size() && text[k + 1] == '"') {
      name += text[k++];
    } else {
      if (k + 1 != text.size()) place.refuse("text follows the closing quote of a name; double the quotes in it");
      return name;
    }
  }
  place.refuse("a name has no closing quote; add it");
}

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t start = std::min(text.find_first_not_of(kBlank), text.size());
  return text.substr(start, text.find_last_not_of(kBlank) + 1 - start);
}

// Reads the number of a face, from 1.
uint64_t parseFace(std::string_view word, uint64_t face_count, const FilePlace& place) {
  word = trim(word);
  uint64_t face = 0;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), face);
  if (failure != std::errc() || end != word.data() + word.size())
    place.refuse(fmt::format("'{}' is not the number of a face; write 12, or 12-40", printable(word)));
  if (face < 1 || face > face_count)
    place.refuse(fmt::format("there is no face {}; the scene has faces 1 to {}", face, face_count));
  return face;
}

}  // namespace

void nameFaces(const std::filesystem::path& groups, InputScene& scene) {
  FilePlace place{groups.string()};
  errno = 0;
  std::ifstream in(groups, std::ios::binary);
  if (!in) place.refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
  std::unordered_map<std::string, uint32_t> surfaces;
  for (uint32_t k = 0; k < scene.surface_names.size(); ++k) surfaces.emplace(scene.surface_names[k], k);
  std::vector<uint32_t> named_in(scene.faces.size(), 0);  // number of the line that named each face
  std::string text;
  while (std::getline(in, text)) {
    ++place.line;
    const std::string_view line = trim(place.line == 1 ? skipByteOrderMark(text) : std::string_view(text));
    if (line.empty() || line.starts_with('#') || (place.line == 1 && line == "face,name")) continue;
    const size_t comma = line.find(',');
    if (comma == std::string_view::npos) place.refuse("a line is a face and a name: 12,wall or 12-40,wall");
    const std::string_view faces = line.substr(0, comma);
    const std::string name = unquote(trim(line.substr(comma + 1)), place);
    if (name.empty()) place.refuse("a face has no name; write one after the comma");
    const size_t dash = faces.find('-');
    const uint64_t first = parseFace(faces.substr(0, dash), scene.faces.size(), place),
                   last = dash == std::string_view::npos ? first
                                                         : parseFace(faces.substr(dash + 1), scene.faces.size(), place);
    if (last < first) place.refuse(fmt::format("the range {}-{} runs backwards; turn it round", first, last));
    const auto [surface, is_new] = surfaces.emplace(name, static_cast<uint32_t>(scene.surface_names.size()));
    if (is_new) scene.surface_names.push_back(name);
    for (uint64_t face = first; face <= last; ++face) {
      if (const uint32_t earlier = std::exchange(named_in[face - 1], place.line))
        place.refuse(fmt::format("line {} names face {} already; give each face one name", earlier, face));
      scene.faces[face - 1].surface = surface->second;
    }
  }
}

Scene loadGroupedScene(const std::vector<std::filesystem::path>& files, const std::filesystem::path& groups,
                       const SceneOptions& options) {
  if (groups.empty()) return loadScene(files, options);
  if (files.size() != 1)
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("{}: --groups names the faces of one file; give one scene file, or leave it out", groups.string()));
  const std::filesystem::path& file = files.front();
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".stl" && extension != ".ply")
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: --groups names the faces of .stl and .ply files; this format has names of its own, "
                            "leave it out",
                            file.string()));
  InputScene scene = readScene(file, options);
  nameFaces(groups, scene);
  return buildScene(scene, options);
}

}  // namespace viewpeel
