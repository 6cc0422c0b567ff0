#include "program/option_table.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace viewpeel::program {
namespace {

constexpr std::array kGroups = {kWhat, kHowExact, kMethod, kMachine, kLongRuns, kOutput};

// Options with these values take the name of a file.
constexpr std::array kFiles = {"FILE", "SCENE", "RESULT", "CHECKPOINT"};

std::vector<std::string> split(const std::string& words) {
  std::vector<std::string> parts;
  size_t start = 0;
  for (size_t bar; (bar = words.find('|', start)) != std::string::npos; start = bar + 1)
    parts.push_back(words.substr(start, bar - start));
  parts.push_back(words.substr(start));
  return parts;
}

// Returns the names of `some` options, in the order in which the command defines them.
std::string namesOf(const std::set<CLI::Option*>& some, const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    if (std::ranges::find(some, option) != some.end()) names.push_back("--" + option->get_lnames().front());
  return fmt::format("{}", fmt::join(names, ", "));
}

OptionEntry describeOption(const CLI::Option& option, const CLI::App& command) {
  OptionEntry entry;
  entry.text = option.get_description();
  entry.is_required = option.get_required();
  entry.is_repeatable = option.get_expected_max() == CLI::detail::expected_max_vector_size;
  if (option.get_positional()) {
    entry.names = {option.get_name(true, false)};
    entry.takes_file = std::ranges::find(kFiles, entry.names.front()) != kFiles.end();
    return entry;
  }
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  if (option.get_type_size() != 0) entry.value = option.get_type_name();
  if (entry.value.find('|') != std::string::npos) entry.choices = split(entry.value);
  entry.takes_file = std::ranges::find(kFiles, entry.value) != kFiles.end();
  if (entry.is_repeatable) entry.text += "; may be given several times";
  if (entry.is_required) entry.text += "; required";
  std::vector<std::string> remarks;
  if (!entry.isFlag() && !option.get_default_str().empty()) remarks.push_back("default: " + option.get_default_str());
  if (!option.get_needs().empty()) remarks.push_back("needs " + namesOf(option.get_needs(), command));
  if (!option.get_excludes().empty()) remarks.push_back("not with " + namesOf(option.get_excludes(), command));
  if (!remarks.empty()) entry.text += fmt::format(" ({})", fmt::join(remarks, "; "));
  return entry;
}

// Returns the place of a group in --help; unknown groups come last.
size_t placeOf(const std::string& title) { return std::ranges::find(kGroups, title) - kGroups.begin(); }

}  // namespace

void startGroup(CLI::App* command, const char* group) { command->option_defaults()->group(group); }

std::string CommandEntry::usage() const {
  std::string line = "viewpeel";
  if (!commands.empty()) return line + " COMMAND [OPTIONS] ...";
  line += fmt::format(" {} [OPTIONS]", name);
  for (const OptionEntry& positional : positionals) {
    const std::string word = positional.names.front() + (positional.is_repeatable ? "..." : "");
    line += positional.is_required ? " " + word : " [" + word + "]";
  }
  return line;
}

CommandEntry describeCommand(const CLI::App& command) {
  CommandEntry entry;
  entry.name = command.get_name();
  entry.text = command.get_description();
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) {
      entry.positionals.push_back(describeOption(*option, command));
      continue;
    }
    // --help is listed last in a command's Output, whatever group was current when it was defined.
    const bool is_help = option == command.get_help_ptr() && command.get_parent();
    const std::string title = is_help ? kOutput : option->get_group();
    if (title.empty()) continue;  // a hidden option
    auto group = std::ranges::find(entry.groups, title, &OptionGroup::title);
    if (group == entry.groups.end()) group = entry.groups.insert(entry.groups.end(), {title, {}});
    group->options.push_back(describeOption(*option, command));
  }
  std::ranges::stable_sort(entry.groups, {}, [](const OptionGroup& group) { return placeOf(group.title); });
  for (OptionGroup& group : entry.groups)
    std::stable_partition(group.options.begin(), group.options.end(),
                          [](const OptionEntry& o) { return o.names.back() != "--help"; });
  for (const CLI::App* child : command.get_subcommands([](const CLI::App*) { return true; }))
    entry.commands.push_back(describeCommand(*child));
  return entry;
}

}  // namespace viewpeel::program
