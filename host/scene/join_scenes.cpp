#include "scene/join_scenes.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/words.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

// Returns a short name for each part: its file without folder and ending, or all of the path where two are alike.
std::vector<std::string> labelsOf(const std::vector<InputScene>& parts) {
  std::map<std::string, size_t> uses;
  for (const InputScene& part : parts) ++uses[fs::path(part.file).stem().string()];
  std::vector<std::string> labels;
  for (const InputScene& part : parts) {
    const std::string stem = fs::path(part.file).stem().string();
    labels.push_back(uses[stem] == 1 ? stem : part.file);
  }
  return labels;
}

// Returns the number of parts that have each surface name.
std::map<std::string, size_t> countNames(const std::vector<InputScene>& parts) {
  std::map<std::string, size_t> counts;
  for (const InputScene& part : parts)
    for (const std::string& name : part.surface_names) ++counts[name];
  return counts;
}

// Returns the names of the files, without folders; of many files the first ones.
std::string titleOf(const std::vector<InputScene>& parts) {
  constexpr size_t kMostNamed = 3;
  std::string title;
  for (size_t k = 0; k < std::min(parts.size(), kMostNamed); ++k)
    title += (k ? ", " : "") + fs::path(parts[k].file).filename().string();
  return parts.size() > kMostNamed ? fmt::format("{} and {} more", title, parts.size() - kMostNamed) : title;
}

}  // namespace

InputScene joinScenes(std::vector<InputScene> parts) {
  const std::vector<std::string> labels = labelsOf(parts);
  const std::map<std::string, size_t> counts = countNames(parts);
  InputScene joined{titleOf(parts), {}, {}};
  std::unordered_map<std::string, size_t> part_of_name;
  std::string prefixed;  // the first surface name that has its file's name before it
  for (size_t k = 0; k < parts.size(); ++k) {
    InputScene& part = parts[k];
    const FilePlace place{part.file};
    if (part.faces.empty()) place.refuse("the file has no faces; check the export, or leave it out");
    joined.files.push_back({part.file, static_cast<uint32_t>(joined.faces.size())});
    const auto first_surface = static_cast<uint32_t>(joined.surface_names.size());
    for (const std::string& name : part.surface_names) {
      const bool is_shared = counts.at(name) > 1;
      joined.surface_names.push_back(is_shared ? fmt::format("{}/{}", labels[k], name) : name);
      const std::string& unique = joined.surface_names.back();
      if (is_shared && prefixed.empty()) prefixed = unique;
      const auto [earlier, is_new] = part_of_name.emplace(unique, k);
      if (!is_new)
        place.refuse(fmt::format("a surface is called '{}', and so is one of {}; rename one of them", printable(unique),
                                 parts[earlier->second].file));
    }
    for (InputFace& face : part.faces) {
      face.surface += first_surface;
      joined.faces.push_back(std::move(face));
    }
    std::ranges::move(part.warnings, std::back_inserter(joined.warnings));
  }
  if (!prefixed.empty())
    joined.warnings.push_back(fmt::format(
        "{}: surfaces of several files have one name, and their file's name before it, as '{}'; rename surfaces that "
        "are to have names of their own",
        joined.file, withoutControls(prefixed)));
  return joined;
}

std::string placeOfFace(const InputScene& input, const InputFace& face) {
  const std::string* file = &input.file;
  if (!input.files.empty()) {
    const auto index = static_cast<uint32_t>(&face - input.faces.data());
    file = &std::prev(std::ranges::upper_bound(input.files, index, {}, &InputFile::first_face))->file;
  }
  return face.line ? fmt::format("{}:{}", *file, face.line) : *file;
}

}  // namespace viewpeel
