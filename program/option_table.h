// The command line as data, for --help, the man page and completion. It is made from the options that read it, so
// nothing is written twice.
#pragma once
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace viewpeel::program {

// Groups of options, in the order of --help. An option is in the group of the last startGroup() before it.
inline constexpr const char *kWhat = "What to compute", *kHowExact = "How exact", *kMethod = "How it is sampled",
                            *kMachine = "Which machine", *kLongRuns = "Long runs", *kOutput = "Output";

// Puts the options that are added to the command next into this group.
void startGroup(CLI::App* command, const char* group);

// OptionEntry is an option, or a positional argument, as a reader sees it.
struct OptionEntry {
  std::vector<std::string> names;    // "-o", "--output"; of a positional its name alone
  std::string value;                 // what follows it: FILE, on|off; empty for a flag and for a positional
  std::vector<std::string> choices;  // on, off
  std::string text;                  // one line: what it does, its default, what it needs, what it excludes
  bool takes_file = false, is_repeatable = false, is_required = false;

  bool isFlag() const { return value.empty(); }
};

struct OptionGroup {
  std::string title;
  std::vector<OptionEntry> options;
};

// CommandEntry is the program itself (name viewpeel) or one of its commands.
struct CommandEntry {
  std::string name, text;
  std::vector<OptionEntry> positionals;
  std::vector<OptionGroup> groups;
  std::vector<CommandEntry> commands;

  // Returns the line of usage: viewpeel compute [OPTIONS] SCENE
  std::string usage() const;
};

// Returns the command's entry, and those of its subcommands.
CommandEntry describeCommand(const CLI::App& command);

}  // namespace viewpeel::program
