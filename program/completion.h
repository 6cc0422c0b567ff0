// Completion of the command line in shells, and the man page: texts made of the option table.
#pragma once
#include <string>

#include "program/option_table.h"

namespace viewpeel::program {

// Each returns a script that completes commands, options, their words and files.
//   In: program: the table of all commands
std::string completeBash(const CommandEntry& program);
std::string completeZsh(const CommandEntry& program);
std::string completeFish(const CommandEntry& program);

// Returns the man page viewpeel.1 (macros of man(7)).
std::string manPage(const CommandEntry& program);

// Returns the start of an option's text, for a list in which each option has one line.
std::string shortText(const std::string& text);

// Returns all options of a command, group by group.
std::vector<OptionEntry> optionsOf(const CommandEntry& command);

// Returns the text in single quotes, as bash and zsh read it.
std::string quote(const std::string& text);

}  // namespace viewpeel::program
