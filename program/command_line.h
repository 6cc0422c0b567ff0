// Results contain the command line that made them, so that they can be made again.
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace viewpeel::program {

// Stores the arguments of the program.
void keepCommandLine(int argc, const char* const* argv);
// Stores the subcommand and its options, as they were parsed.
void keepOptions(const CLI::App& app);

// Returns the command line as a shell accepts it: "viewpeel compute 'my room.obj' --tolerance 1e-3".
std::string commandLine();
// Returns the name of the subcommand; empty before it is parsed.
const std::string& commandName();

// A GivenOption is an option of the subcommand with its values: from the command line, or else the default.
struct GivenOption {
  std::string name;  // "tolerance" for --tolerance; for a positional argument its name
  std::vector<std::string> values;
  bool is_flag = false, is_text = false;  // is_text: a name or file, even if it looks like a number
};
const std::vector<GivenOption>& givenOptions();

}  // namespace viewpeel::program
