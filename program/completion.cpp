#include "program/completion.h"

#include <algorithm>

#include <fmt/format.h>

#include "program/commands.h"
#include "program/options.h"

namespace viewpeel::program {

std::string shortText(const std::string& text) {
  size_t end = text.size();
  for (const char* mark : {". ", "; ", " ("}) end = std::min(end, text.find(mark));
  return text.substr(0, end);
}

std::vector<OptionEntry> optionsOf(const CommandEntry& command) {
  std::vector<OptionEntry> options;
  for (const OptionGroup& group : command.groups)
    options.insert(options.end(), group.options.begin(), group.options.end());
  return options;
}

std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (char c : text)
    if (c == '\'') quoted += "'\\''";
    else quoted += c;
  return quoted + "'";
}

void addCompletion(CLI::App& app, Run& chosen) {
  using Make = std::string (*)(const CommandEntry&);
  CLI::App* command = app.add_subcommand(
      "completion", "Print completion for a shell, or the man page; an installation has all of them");
  command
      ->add_option_function<std::string>(
          "TARGET",
          [&app, &chosen](const std::string& target) {
            const Make make = target == "bash"   ? completeBash
                              : target == "zsh"  ? completeZsh
                              : target == "fish" ? completeFish
                                                 : manPage;
            chosen = [&app, make] {
              fmt::print("{}", make(describeCommand(app)));
              return 0;
            };
          },
          "bash, zsh, fish or man")
      ->required()
      ->check(isOneOf("bash|zsh|fish|man"));
}

}  // namespace viewpeel::program
