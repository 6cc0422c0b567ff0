// The option table describes the command line as data, for --help, the man page and completion. It is read from the
// parser's options, so each text is written once.
#pragma once
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace viewpeel::program {

// Groups of options, in the order of --help. An option is in the group of the last startGroup() before it.
inline constexpr const char *kWhat = "What to compute", *kHowExact = "How exact", *kMethod = "How it is sampled",
                            *kMachine = "Which machine", *kLongRuns = "Long runs", *kOutput = "Output";

// Puts options that are added to the command from now on into this group.
void startGroup(CLI::App* command, const char* group);

// OptionEntry is an option, or a positional argument, as a reader sees it.
struct OptionEntry {
  std::vector<std::string> names;    // "-o", "--output"; for a positional argument its name
  std::string value;                 // placeholder of its value: FILE, on|off; empty for a flag or positional argument
  std::vector<std::string> choices;  // allowed words, such as on and off
  std::string text;                  // one line: what it does, its default, which options it needs or excludes
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

  // Returns the usage line, such as: viewpeel compute [OPTIONS] SCENE
  std::string usage() const;
};

// Returns the entry of a command and of its subcommands.
CommandEntry describeCommand(const CLI::App& command);

}  // namespace viewpeel::program
