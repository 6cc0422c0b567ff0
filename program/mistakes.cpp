#include "program/mistakes.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "scene/nearest_word.h"

namespace viewpeel::program {
namespace {

std::vector<std::string> commandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty()) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> optionsOf(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string suggest(const std::optional<std::string>& nearest) {
  return nearest ? fmt::format("; did you mean {}?", *nearest) : "";
}

// Returns the first argument that is an unknown option; empty where there is none.
std::string unknownOption(const CLI::App& command, const std::vector<std::string>& arguments) {
  const std::vector<std::string> names = optionsOf(command);
  for (const std::string& argument : arguments) {
    if (argument == "--") break;
    const std::string name = argument.substr(0, argument.find('='));
    if (name.starts_with("--") && std::ranges::find(names, name) == names.end()) return name;
  }
  return "";
}

// Returns how to write an option that has too few values or too many.    In: fault: CLI11's text, which begins with the
// option's name
std::string describeUse(const CLI::App& command, const std::string& fault) {
  const CLI::Option* option = command.get_option_no_throw(fault.substr(0, fault.find(':')));
  if (!option) return fault;
  const bool is_given_too_much = fault.find("At Most") != std::string::npos;
  return fmt::format("{}: write it {}as {} {}", option->get_name(), is_given_too_much ? "once, " : "",
                     option->get_name(), option->get_type_name());
}

}  // namespace

void addDefaultCommand(const CLI::App& app, std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments[0].starts_with("-")) return;
  const std::vector<std::string> commands = commandsOf(app);
  std::error_code failure;
  if (std::ranges::find(commands, arguments[0]) == commands.end() && std::filesystem::exists(arguments[0], failure))
    arguments.insert(arguments.begin(), "compute");
}

std::string describeMistake(const CLI::App& app, const std::vector<std::string>& arguments,
                            const CLI::ParseError& error) {
  const std::vector<const CLI::App*> chosen = [&] {
    const auto parsed = app.get_subcommands();
    return std::vector<const CLI::App*>(parsed.begin(), parsed.end());
  }();
  if (chosen.empty()) {
    const std::string list = fmt::format("{}", fmt::join(commandsOf(app), ", "));
    if (arguments.empty() || arguments[0].starts_with("-"))
      return fmt::format("{}; name one of {}; see 'viewpeel --help'", error.what(), list);
    const std::optional<std::string> nearest = nearestWord(arguments[0], commandsOf(app));
    return fmt::format("'{}' is neither a command nor a file{}; commands are {}; see 'viewpeel --help'", arguments[0],
                       suggest(nearest), list);
  }
  const CLI::App& command = *chosen.front();
  const std::string help = fmt::format("; see 'viewpeel {} --help'", command.get_name());
  if (dynamic_cast<const CLI::ExtrasError*>(&error)) {
    if (const std::string option = unknownOption(command, arguments); !option.empty())
      return fmt::format("there is no option {}{}{}", option, suggest(nearestWord(option, optionsOf(command))), help);
    std::vector<std::string> extra = app.remaining(true);
    return fmt::format("'{}' is not expected{}", extra.empty() ? "" : extra.front(), help);
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) return describeUse(command, error.what()) + help;
  return error.what() + help;
}

}  // namespace viewpeel::program
