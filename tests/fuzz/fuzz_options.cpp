// This target parses the bytes as a command line, one argument a line, and does not run it.
#include <cstdlib>
#include <sstream>

#include "program/commands.h"
#include <viewpeel/error.h>
#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count) {
  using namespace viewpeel;
  std::istringstream in(std::string(bytes, bytes + count));
  std::vector<std::string> arguments = {"viewpeel"};
  for (std::string line; std::getline(in, line);)
    arguments.push_back(line.substr(0, line.find('\0')));  // C strings end at a NUL
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  CLI::App app;
  app.require_subcommand(1);
  program::Run chosen;
  program::Job job;
  program::addCompute(app, chosen, job);
  program::addSolve(app, chosen, job);
  program::addPlan(app, chosen);
  program::addCheck(app, chosen);
  program::addMerge(app, chosen);
  program::addDevices(app, chosen);
  program::addCompletion(app, chosen);
  try {
    app.parse(static_cast<int>(argv.size()), argv.data());
    if (!chosen) std::abort();  // accepted, but no command was chosen
  } catch (const CLI::ParseError&) {
  } catch (const Error& error) {
    fuzz::requireOneLine(error.what());
  }
  return 0;
}
