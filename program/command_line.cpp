#include "program/command_line.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include <CLI/CLI.hpp>

namespace viewpeel::program {
namespace {

std::string kept_line, kept_command;
std::vector<GivenOption> kept_options;

bool isText(const CLI::Option& option) {
  constexpr std::array kTexts = {"NAME", "FILE", "A B", "DEVICE", "TEXT", "V", "K/N"};
  return std::ranges::find(kTexts, option.get_type_name()) != kTexts.end();
}

bool isPlain(unsigned char c) { return std::isalnum(c) || std::string_view("-_./,:=+@%").find(c) != std::string::npos; }

std::string quote(std::string_view word) {
  if (!word.empty() && std::ranges::all_of(word, isPlain)) return std::string(word);
  std::string quoted = "'";
  for (char c : word)
    if (c == '\'') quoted += "'\\''";
    else quoted += c;
  quoted += '\'';
  return quoted;
}

}  // namespace

void keepCommandLine(int argc, const char* const* argv) {
  kept_line = "viewpeel";
  for (int k = 1; k < argc; ++k) kept_line.append(" ").append(quote(argv[k]));
}

void keepOptions(const CLI::App& app) {
  if (app.get_subcommands().empty()) return;
  const CLI::App& command = *app.get_subcommands().front();
  kept_command = command.get_name();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_lnames().empty() ? option->get_name() : option->get_lnames().front();
    const bool is_flag = option->get_expected_max() == 0;
    if (name == "help" || (!option->count() && (is_flag || option->get_default_str().empty()))) continue;
    const bool is_given = option->count() > 0;
    kept_options.push_back(
        {name, is_given ? option->results() : std::vector{option->get_default_str()}, is_flag, isText(*option)});
  }
}

std::string commandLine() { return kept_line; }
const std::string& commandName() { return kept_command; }
const std::vector<GivenOption>& givenOptions() { return kept_options; }

}  // namespace viewpeel::program
