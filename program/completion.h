// Scripts that complete the command line in shells, and the man page, are made from the option table.
#pragma once
#include <string>

#include "program/option_table.h"

namespace viewpeel::program {

// Each of these returns a script that completes commands, options, values and files.
//   In: program: the table of all commands
std::string completeBash(const CommandEntry& program);
std::string completeZsh(const CommandEntry& program);
std::string completeFish(const CommandEntry& program);

// Returns the man page viewpeel.1 (macros of man(7)).
std::string manPage(const CommandEntry& program);

// Returns the first part of an option's description, for lists with one line an option.
std::string shortText(const std::string& text);

// Returns all options of a command, in the order of their groups.
std::vector<OptionEntry> optionsOf(const CommandEntry& command);

// Returns the text in single quotes, as bash and zsh read it.
std::string quote(const std::string& text);

}  // namespace viewpeel::program
