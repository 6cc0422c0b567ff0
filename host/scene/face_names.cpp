#include "scene/face_names.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <unordered_map>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/join_scenes.h"
#include "scene/nearest_word.h"

namespace viewpeel {
namespace {

// A NumberedName has the parts of "desk[3]".
struct NumberedName {
  std::string surface;
  uint32_t number;
};

std::optional<NumberedName> splitName(const std::string& name) {
  const size_t open = name.rfind('[');
  if (open == std::string::npos || open == 0 || !name.ends_with("]")) return std::nullopt;
  const char *first = name.data() + open + 1, *last = name.data() + name.size() - 1;
  uint32_t number = 0;
  const auto [end, failure] = std::from_chars(first, last, number);
  if (failure != std::errc() || end != last || number == 0 || *first == '0') return std::nullopt;
  return NumberedName{name.substr(0, open), number};
}

// Returns "FILE:LINE" of a surface's first face, or "FILE" where faces have no lines.
std::string placeOf(const InputScene& input, uint32_t surface) {
  const auto face = std::ranges::find(input.faces, surface, &InputFace::surface);
  return placeOfFace(input, *face);
}

std::vector<uint32_t> countFaces(const InputScene& input) {
  std::vector<uint32_t> counts(input.surface_names.size(), 0);
  for (const InputFace& face : input.faces) ++counts[face.surface];
  return counts;
}

}  // namespace

std::string explainUnknownName(const std::string& name, const std::vector<std::string>& surfaces,
                               const std::vector<uint32_t>& face_counts) {
  constexpr size_t kMostNamed = 5;
  const auto at = std::ranges::find(surfaces, surfaceOfName(name));
  if (at != surfaces.end() && !face_counts.empty()) {
    const uint32_t count = face_counts[static_cast<size_t>(at - surfaces.begin())];
    return count == 1 ? fmt::format("'{}' has one face, which has its name", *at)
                      : fmt::format("'{0}' has {1} faces, '{0}[1]' to '{0}[{1}]'", *at, count);
  }
  std::string some;
  for (size_t k = 0; k < std::min(surfaces.size(), kMostNamed); ++k)
    some += fmt::format("{}{}", k ? ", " : "", surfaces[k]);
  const std::optional<std::string> nearest = nearestWord(name, surfaces);
  return fmt::format("{}surfaces are {}{}", nearest ? fmt::format("did you mean '{}'? ", *nearest) : "", some,
                     surfaces.size() > kMostNamed ? ", ..." : "");
}

std::string surfaceOfName(const std::string& name) {
  const std::optional<NumberedName> parts = splitName(name);
  return parts ? parts->surface : name;
}

std::string faceName(const Scene& scene, uint32_t face_index) {
  const Face& face = scene.faces[face_index];
  const Surface& surface = scene.surfaces[face.surface];
  return surface.face_count == 1 ? surface.name : fmt::format("{}[{}]", surface.name, face.number);
}

std::vector<uint32_t> findFaces(const InputScene& input, const std::string& name, const char* option) {
  std::vector<uint32_t> found;
  const std::optional<NumberedName> numbered = splitName(name);
  uint32_t number = 0;
  for (uint32_t k = 0; k < input.faces.size(); ++k) {
    const std::string& surface = input.surface_names[input.faces[k].surface];
    if (surface == name || (numbered && surface == numbered->surface && ++number == numbered->number))
      found.push_back(k);
  }
  if (found.empty())
    throw Error(ErrorCode::bad_usage, fmt::format("{}: {} has no surface or face '{}'; {}", option, input.file, name,
                                                  explainUnknownName(name, input.surface_names, countFaces(input))));
  return found;
}

std::vector<std::string> nameFaces(const InputScene& input) {
  const std::vector<uint32_t> counts = countFaces(input);
  std::vector<uint32_t> numbers(counts.size(), 0);
  std::vector<std::string> names;
  names.reserve(input.faces.size());
  for (const InputFace& face : input.faces) {
    const std::string& surface = input.surface_names[face.surface];
    ++numbers[face.surface];
    names.push_back(counts[face.surface] == 1 ? surface : fmt::format("{}[{}]", surface, numbers[face.surface]));
  }
  return names;
}

bool isReservedName(const std::string& name) {
  constexpr std::array kReserved{"environment", "environment:up", "environment:down", "leak"};
  return std::ranges::find(kReserved, name) != kReserved.end();
}

void requireDistinctNames(const InputScene& input) {
  const std::vector<uint32_t> counts = countFaces(input);
  std::unordered_map<std::string_view, uint32_t> surfaces;
  for (uint32_t k = 0; k < counts.size(); ++k) {
    surfaces.emplace(input.surface_names[k], k);
    if (counts[k] && isReservedName(input.surface_names[k]))
      throw Error(ErrorCode::bad_input,
                  fmt::format("{}: a surface is called '{}', which stands for something else in results and "
                              "materials; rename it",
                              placeOf(input, k), input.surface_names[k]));
  }
  for (uint32_t k = 0; k < counts.size(); ++k) {
    const std::optional<NumberedName> numbered = splitName(input.surface_names[k]);
    if (!numbered || counts[k] == 0) continue;
    const auto at = surfaces.find(numbered->surface);
    if (at == surfaces.end() || counts[at->second] < numbered->number) continue;
    throw Error(
        ErrorCode::bad_input,
        fmt::format("{}: a surface is called '{}', as face {} of surface '{}' is in the results; rename one of the two",
                    placeOf(input, k), input.surface_names[k], numbered->number, numbered->surface));
  }
}

}  // namespace viewpeel
