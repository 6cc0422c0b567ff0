#include <fmt/format.h>

#include "program/completion.h"

namespace viewpeel::program {
namespace {

// Returns the branch of bash's `case` for a command: its options, and how their values are completed.
std::string caseOf(const CommandEntry& command) {
  std::string names, values;
  std::vector<std::string> free;  // options whose value may be any word
  for (const OptionEntry& option : optionsOf(command)) {
    for (const std::string& name : option.names) names += " " + name;
    if (option.isFlag()) continue;
    if (option.takes_file) values += fmt::format("        {}) kind=file ;;\n", fmt::join(option.names, "|"));
    else if (option.choices.empty()) free.insert(free.end(), option.names.begin(), option.names.end());
    else
      values += fmt::format("        {}) kind=words words='{}' ;;\n", fmt::join(option.names, "|"),
                            fmt::join(option.choices, " "));
  }
  if (!free.empty()) values += fmt::format("        {}) kind=none ;;\n", fmt::join(free, "|"));
  std::string text = fmt::format("    {})\n      options='{}'\n", command.name, names.substr(1));
  if (!values.empty()) text += fmt::format("      case $before in\n{}      esac\n", values);
  return text + "      ;;\n";
}

constexpr const char* kStart = R"(# Completion of viewpeel for bash, made by `viewpeel completion bash`.
_viewpeel() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local command=${COMP_WORDS[1]} kind=any words= options=
  # Where bash takes = for a word, --option=value is three words.
  if [[ $word == = ]]; then
    word=
  elif [[ $before == = ]] && ((COMP_CWORD > 2)); then
    before=${COMP_WORDS[COMP_CWORD - 2]}
  fi
)";

constexpr const char* kEnd = R"(  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(
      compgen -W "$commands --help --version" -- "$word"
      [[ $word == -* ]] || compgen -f -- "$word"
    )
  elif [[ $kind == words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  elif [[ $kind == any && $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
  elif [[ $kind != none ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -F _viewpeel viewpeel
)";

}  // namespace

std::string completeBash(const CommandEntry& program) {
  std::string names, cases;
  for (const CommandEntry& command : program.commands) {
    names += (names.empty() ? "" : " ") + command.name;
    cases += caseOf(command);
  }
  // Where a file stands in place of a command, the command is compute.
  return fmt::format(
      "{}  local commands='{}'\n  [[ \" $commands \" == *\" $command \"* ]] || command=compute\n"
      "  case $command in\n{}  esac\n{}",
      kStart, names, cases, kEnd);
}

}  // namespace viewpeel::program
