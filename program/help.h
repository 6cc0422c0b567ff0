// --help shows options in groups, wrapped to 80 columns, with examples.
#pragma once
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace viewpeel::program {

// Breaks a text between words into lines of up to 80 columns.
//   In: indent: columns before each line but the first, which starts at column `column`
std::string wrap(const std::string& text, size_t indent, size_t column);

// Sets --help of the command and of all its subcommands.
void setHelp(CLI::App& app);

}  // namespace viewpeel::program
