#include <fmt/format.h>

#include "program/completion.h"

namespace viewpeel::program {
namespace {

// Puts a backslash before the characters that have a meaning in zsh's specification of an argument.
std::string escape(const std::string& text) {
  std::string escaped;
  for (char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string valueOf(const OptionEntry& option) {
  if (option.isFlag()) return "";
  const std::string words = option.takes_file        ? "_files"
                            : option.choices.empty() ? " "
                                                     : fmt::format("({})", fmt::join(option.choices, " "));
  return fmt::format(":{}:{}", escape(option.value), words);
}

// Returns zsh's specifications of an option, one for each of its names.
std::string specify(const OptionEntry& option) {
  std::string text;
  for (const std::string& name : option.names) {
    const bool is_long = name.starts_with("--");
    const std::string excluded = option.is_repeatable ? "*" : fmt::format("({})", fmt::join(option.names, " "));
    const char* glue = option.isFlag() ? "" : is_long ? "=" : "+";
    text += fmt::format("        {} \\\n", quote(fmt::format("{}{}{}[{}]{}", excluded, name, glue,
                                                             escape(shortText(option.text)), valueOf(option))));
  }
  return text;
}

}  // namespace

std::string completeZsh(const CommandEntry& program) {
  std::string commands, cases;
  for (const CommandEntry& command : program.commands) {
    commands += fmt::format("    {}\n", quote(command.name + ":" + escape(shortText(command.text))));
    cases += fmt::format("    {})\n      _arguments -S \\\n", command.name);
    for (const OptionEntry& option : optionsOf(command)) cases += specify(option);
    cases += "        '*:file:_files'\n      ;;\n";
  }
  return fmt::format(R"(#compdef viewpeel
# Completion of viewpeel for zsh, made by `viewpeel completion zsh`.
_viewpeel() {{
  local -a commands=(
{})
  if (( CURRENT == 2 )); then
    _describe -t commands command commands
    _files
    return
  fi
  # A file in place of a command is a scene to compute.
  local command=compute
  if (( ${{commands[(I)${{words[2]}}:*]}} )); then
    command=${{words[2]}}
    shift words
    (( CURRENT-- ))
  fi
  case $command in
{}  esac
}}
if [[ ${{funcstack[1]}} == _viewpeel ]]; then _viewpeel "$@"; else compdef _viewpeel viewpeel; fi
)",
                     commands, cases);
}

}  // namespace viewpeel::program
