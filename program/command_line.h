// The command line stands in results, so that they say how to make them again.
#pragma once
#include <string>

namespace viewpeel::program {

// Keeps what the program was called with.
void keepCommandLine(int argc, const char* const* argv);

// Returns it in a form that a shell takes: "viewpeel compute 'my room.obj' --tolerance 1e-3".
std::string commandLine();

}  // namespace viewpeel::program
