// Options that several subcommands share.
#pragma once
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "engines/engine.h"
#include "engines/lattice_options.h"
#include "matrix/ids.h"
#include "vulkan/device.h"

namespace viewpeel::cli {

// An option that takes one of a few words; the first is the default.
template <class T>
void addChoice(CLI::App* command, const std::string& name, T& value, const std::vector<std::pair<std::string, T>>& choices, const std::string& text) {
  std::string words;
  for (const auto& choice : choices) words += (words.empty() ? "" : "|") + choice.first;
  const auto choose = [&value, choices, name, words](const std::string& word) {
    for (const auto& choice : choices) {
      if (choice.first != word) continue;
      value = choice.second;
      return;
    }
    throw CLI::ValidationError(name, fmt::format("'{}' is not one of {}", word, words));
  };
  command->add_option_function<std::string>(name, choose, text)->default_str(choices.front().first)->type_name(words);
}

enum class EngineKind { compute, graphics, exact };

// An engine that counts lattice points on the device.
std::unique_ptr<Engine> makeLatticeEngine(EngineKind kind, const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options);

}  // namespace viewpeel::cli
