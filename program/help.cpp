#include "program/help.h"

#include <sstream>

#include <fmt/format.h>

#include "program/examples.h"
#include "program/option_table.h"

namespace viewpeel::program {
namespace {

constexpr size_t kWidth = 80, kTextColumn = 22;

std::string describe(const OptionEntry& option) {
  std::string line = fmt::format("  {}", fmt::join(option.names, ", "));
  if (!option.isFlag()) line += " " + option.value;
  // The description of a long option begins on the next line.
  if (line.size() + 2 > kTextColumn) line += "\n" + std::string(kTextColumn, ' ');
  else line.resize(kTextColumn, ' ');
  return line + wrap(option.text, kTextColumn, kTextColumn) + "\n";
}

std::string describe(const CommandEntry& command) {
  std::string text = wrap(command.text, 0, 0) + "\n\nUsage: " + command.usage() + "\n";
  if (!command.positionals.empty()) text += "\n";
  for (const OptionEntry& positional : command.positionals) text += describe(positional);
  if (!command.commands.empty()) text += "\nCommands:\n";
  for (const CommandEntry& child : command.commands)
    text += fmt::format("  {:<12}{}\n", child.name, wrap(child.text, 14, 14));
  for (const OptionGroup& group : command.groups) {
    text += fmt::format("\n{}:\n", group.title);
    for (const OptionEntry& option : group.options) text += describe(option);
  }
  std::string examples;
  for (const Example& example : examplesOf(command.name))
    examples += fmt::format("  # {}\n  {}\n", example.purpose, example.line);
  if (!examples.empty()) text += "\nExamples:\n" + examples;
  if (!command.commands.empty()) text += "\n'viewpeel COMMAND --help' has the options of a command.\n";
  return text;
}

}  // namespace

std::string wrap(const std::string& text, size_t indent, size_t column) {
  std::istringstream words(text);
  std::string wrapped;
  bool is_first = true;
  for (std::string word; words >> word; is_first = false) {
    if (!is_first && column + 1 + word.size() > kWidth) {
      wrapped += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!is_first) {
      wrapped += ' ';
      ++column;
    }
    wrapped += word;
    column += word.size();
  }
  return wrapped;
}

void setHelp(CLI::App& app) {
  app.formatter_fn([](const CLI::App* command, const std::string&, CLI::AppFormatMode) {
    return describe(describeCommand(*command));
  });
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) setHelp(*command);
}

}  // namespace viewpeel::program
