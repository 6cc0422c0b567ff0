#include <fmt/format.h>

#include "program/completion.h"

namespace viewpeel::program {
namespace {

std::string quoteForFish(const std::string& text) {
  std::string quoted = "'";
  for (char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "'";
}

std::string specify(const std::string& command, const OptionEntry& option) {
  std::string line = fmt::format("complete -c viewpeel -n '__viewpeel_command {}'", command);
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (option.takes_file) line += " -r -F";
  else if (!option.isFlag()) line += " -x";
  if (!option.choices.empty()) line += fmt::format(" -a '{}'", fmt::join(option.choices, " "));
  return line + fmt::format(" -d {}\n", quoteForFish(shortText(option.text)));
}

}  // namespace

std::string completeFish(const CommandEntry& program) {
  std::string names, lines;
  for (const CommandEntry& command : program.commands) names += " " + command.name;
  std::string text = fmt::format(R"(# Completion of viewpeel for fish, made by `viewpeel completion fish`.
function __viewpeel_command -a wanted
    set -l words (commandline -opc)
    set -q words[2]; or return 1
    # A file in place of a command is a scene to compute.
    contains -- $words[2]{0}; or set words[2] compute
    test $words[2] = $wanted
end
function __viewpeel_no_command
    test (count (commandline -opc)) -eq 1
end
)",
                                 names);
  for (const CommandEntry& command : program.commands) {
    text += fmt::format("complete -c viewpeel -n __viewpeel_no_command -a {} -d {}\n", command.name,
                        quoteForFish(shortText(command.text)));
    for (const OptionEntry& option : optionsOf(command)) lines += specify(command.name, option);
  }
  return text + lines;
}

}  // namespace viewpeel::program
