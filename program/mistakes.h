// A command line that cannot be parsed is answered by what is wrong with it and what was meant.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace viewpeel::program {

// Puts "compute" before a command line that begins with a scene file in place of a subcommand: `viewpeel room.obj`.
//   In: arguments: without the program's name
void addDefaultCommand(const CLI::App& app, std::vector<std::string>& arguments);

// Returns the one line that says what is wrong, the nearest right word where there is one, and which help to read.
//   In: arguments: as parsed; error: of that parse
std::string describeMistake(const CLI::App& app, const std::vector<std::string>& arguments,
                            const CLI::ParseError& error);

}  // namespace viewpeel::program
