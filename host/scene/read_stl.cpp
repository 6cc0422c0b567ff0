// readStl() reads STL, text and binary.
#include <bit>
#include <cstring>
#include <fstream>
#include <iterator>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian and copied as it is");

constexpr size_t kHeaderBytes = 80, kFacetBytes = 50;

template <class T>
T readAt(const std::string& bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// Refuses a binary file that is shorter than its header says.
void checkSize(uint64_t size_bytes, uint32_t facet_count, const std::string& file) {
  if (size_bytes < kHeaderBytes + 4 + uint64_t(facet_count) * kFacetBytes)
    FilePlace{file}.refuse(fmt::format(
        "not STL text, and its size does not fit the {} binary facets of its header; export it again", facet_count));
}

void readBinary(const std::string& bytes, InputScene& scene) {
  const FilePlace place{scene.file};
  if (bytes.size() < kHeaderBytes + 4) place.refuse("the file ends in its header; export it again");
  const auto count = readAt<uint32_t>(bytes, kHeaderBytes);
  checkSize(bytes.size(), count, scene.file);
  for (uint32_t k = 0; k < count; ++k) {
    InputFace face{{}, 0, 0};
    for (size_t corner = 0; corner < 3; ++corner) {
      const size_t at = kHeaderBytes + 4 + k * kFacetBytes + 12 + 12 * corner;
      face.corners.emplace_back(readAt<float>(bytes, at), readAt<float>(bytes, at + 4), readAt<float>(bytes, at + 8));
      for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(face.corners.back()[axis]))
          place.refuse(fmt::format("facet {}: a coordinate is not a finite number; correct it", k + 1));
    }
    scene.faces.push_back(std::move(face));
  }
}

// Warns that solids share a name, or refuses names that stay equal even with numbers.
void checkRepeated(const std::vector<std::string>& repeated, InputScene& scene) {
  if (repeated.empty()) return;
  std::unordered_set<std::string_view> names;
  for (const std::string& name : scene.surface_names)
    if (!names.insert(name).second)
      FilePlace{scene.file}.refuse(fmt::format(
          "a solid is called '{}', and so is another one by its number among solids of one name; rename one of them",
          printable(name)));
  scene.warnings.push_back(
      fmt::format("{}: {} the name of a solid before, and a number after it, as '{}'; rename solids that are to have "
                  "names of their own",
                  scene.file, repeated.size() == 1 ? "1 solid has" : fmt::format("{} solids have", repeated.size()),
                  printable(repeated.front())));
}

void readText(std::string_view rest, const std::string& stem, InputScene& scene) {
  FilePlace place{scene.file};
  bool in_solid = false, in_facet = false;
  uint32_t surface = 0;
  InputFace face;
  std::unordered_map<std::string, uint32_t> uses;  // how often each name has occurred
  std::vector<std::string> repeated;
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++place.line;
    const std::string_view keyword = nextWord(line);
    if (keyword == "solid") {
      const std::string given = joinWords(line), name = given.empty() ? stem : given;
      const uint32_t use = ++uses[name];
      surface = static_cast<uint32_t>(scene.surface_names.size());
      scene.surface_names.push_back(use > 1 ? fmt::format("{}#{}", name, use) : name);
      if (use > 1) repeated.push_back(scene.surface_names.back());
      in_solid = true;
    } else if (keyword == "facet" && in_solid) {
      face = {{}, surface, place.line};
      in_facet = true;
    } else if (keyword == "vertex" && in_facet) {
      glm::dvec3 corner;
      for (int axis = 0; axis < 3; ++axis) corner[axis] = parseFinite(nextWord(line), place);
      face.corners.push_back(corner);
    } else if (keyword == "endfacet" && in_facet) {
      if (face.corners.size() < 3) place.refuse("a facet needs three vertices; complete it");
      scene.faces.push_back(std::exchange(face, {}));
      in_facet = false;
    } else if (keyword == "endsolid" && !in_facet) {
      in_solid = false;
    } else if (!keyword.empty() && keyword != "outer" && keyword != "endloop") {
      place.refuse(fmt::format("'{}' is out of place; export the file again", printable(keyword)));
    }
  }
  if (in_solid) place.refuse("the file ends before 'endsolid'; export it again");
  checkRepeated(repeated, scene);
}

}  // namespace

InputScene readStl(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  InputScene scene{file.string(), {}, {}};
  // The header is compared with the file's size first, so that a wrong number of facets does not fill the memory.
  std::string bytes(kHeaderBytes + 4, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(in.gcount()));
  std::error_code failure;
  const uint64_t size = std::filesystem::file_size(file, failure);
  if (!failure && bytes.size() == kHeaderBytes + 4 && !skipByteOrderMark(bytes).starts_with("solid"))
    checkSize(size, readAt<uint32_t>(bytes, kHeaderBytes), scene.file);
  bytes.append(std::istreambuf_iterator<char>(in), {});
  // Some binary files begin with "solid", too. Their size shows what they are.
  const bool fits_binary =
      bytes.size() >= kHeaderBytes + 4 &&
      bytes.size() == kHeaderBytes + 4 + uint64_t(readAt<uint32_t>(bytes, kHeaderBytes)) * kFacetBytes;
  const std::string_view text = skipByteOrderMark(bytes);
  if (text.starts_with("solid") && !fits_binary) {
    readText(text, file.stem().string(), scene);
  } else {
    scene.surface_names.push_back(file.stem().string());
    readBinary(bytes, scene);
  }
  return scene;
}

}  // namespace viewpeel
