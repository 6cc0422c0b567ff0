// These options belong to several subcommands.
#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "program/option_table.h"
#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <glm/vec3.hpp>
#include <viewpeel/ids.h>
#include "vulkan/device.h"

namespace viewpeel::program {

// Checks that a text is a number in a range. Like CLI11's checks it returns the fault, or an empty text. CLI11's own
// check of ranges is not used, because it accepts nan and takes -1 for 2^64 - 1.
inline std::string isNumber(const std::string& text, double least, double most) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= least && value <= most
             ? ""
             : fmt::format("{} is not a number from {} to {}", text, least, most);
}
inline std::string isWholeNumber(const std::string& text) {
  uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() && end == text.data() + text.size()
             ? ""
             : text + " is not a whole number from 0 to 2^64 - 1";
}

// Returns a check of whole numbers in a range. It rewrites 1e6 as 1000000, which CLI11 reads.
inline CLI::Validator isWholeNumberFrom(uint64_t least, uint64_t most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        double value = 0;
        if (!CLI::detail::lexical_cast(text, value) || value != std::floor(value) || value < double(least) ||
            value > double(most))
          return fmt::format("{} is not a whole number from {} to {}", text, least, most);
        text = std::to_string(static_cast<uint64_t>(value));
        return std::string();
      },
      "");
}

// Returns a check that a text is one of a few words.    In: words: with | between them
inline auto isOneOf(const std::string& words) {
  return [words](const std::string& text) {
    const std::vector<std::string> all = CLI::detail::split(words, '|');
    return std::ranges::find(all, text) != all.end() ? "" : fmt::format("'{}' is not one of {}", text, words);
  };
}

// Adds an option that takes one of a few words; the first is the default.
template <class T>
void addChoice(CLI::App* command, const std::string& name, T& value,
               const std::vector<std::pair<std::string, T>>& choices, const std::string& text) {
  std::string words;
  for (const auto& choice : choices) words += (words.empty() ? "" : "|") + choice.first;
  const auto choose = [&value, choices](const std::string& word) {
    for (const auto& choice : choices)
      if (choice.first == word) value = choice.second;
  };
  command->add_option_function<std::string>(name, choose, text)
      ->default_str(choices.front().first)
      ->type_name(words)
      ->check(isOneOf(words));
}

// This text describes the argument SCENE.
inline constexpr const char* kSceneText =
    "Scene file: .obj, .stl, .ply, .gltf, .glb, .vs3, .inp, .msh, .vtp, .vtu, .json or .jsonl (CityJSON), .idf or "
    ".epJSON, or the folder of an OpenFOAM case; or several files, each with a part of the scene";

// Adds the options that decide what a scene file leaves open: --sheets, --solids, --flip and --fix-normals.
void addSceneOptions(CLI::App* command, SceneOptions& options);

// Adds --up X,Y,Z, the upward direction, which separates sky and ground.
CLI::Option* addUpOption(CLI::App* command, const std::function<void(const glm::dvec3& up)>& use,
                         const std::string& text);

// Adds --groups, a file with names for the faces of a scene.
void addGroupsOption(CLI::App* command, std::string& groups);

// This text describes --json.
constexpr const char* kJsonHelp = "Print one JSON object: what was done, errors too";

// Adds --threads, which limits the processor's threads, also the threads of a software Vulkan device.
void addThreadsOption(CLI::App* command);

}  // namespace viewpeel::program
