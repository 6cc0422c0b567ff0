// These functions explain a command line that cannot be parsed, and guess what was meant.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace viewpeel::program {

// Inserts "compute" where the command line begins with a scene file instead of a subcommand: `viewpeel room.obj`.
//   In: arguments: without the program's name
void addDefaultCommand(const CLI::App& app, std::vector<std::string>& arguments);

// Returns one line: the mistake, the nearest correct word if there is one, and the help to read.
//   In: arguments: as parsed; error: as the parser threw it
std::string describeMistake(const CLI::App& app, const std::vector<std::string>& arguments,
                            const CLI::ParseError& error);

}  // namespace viewpeel::program
