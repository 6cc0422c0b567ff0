// The command line stands in results, so that they say how to make them again.
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace viewpeel::program {

// Keeps what the program was called with.
void keepCommandLine(int argc, const char* const* argv);
// Keeps the subcommand and its options, as parsed.
void keepOptions(const CLI::App& app);

// Returns the command line in a form that a shell takes: "viewpeel compute 'my room.obj' --tolerance 1e-3".
std::string commandLine();
// Returns the name of the subcommand; empty before one is known.
const std::string& commandName();

// A GivenOption is an option of the subcommand with the values that it was given, or those that it has without.
struct GivenOption {
  std::string name;  // without dashes; of an argument, its name
  std::vector<std::string> values;
  bool is_flag = false, is_text = false;  // text: a name or file, even where it looks like a number
};
const std::vector<GivenOption>& givenOptions();

}  // namespace viewpeel::program
