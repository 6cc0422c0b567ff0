// These examples are shown in --help and in the man page. Each runs in the folder scenes/ (tests/program/help_test).
#pragma once
#include <string>
#include <vector>

namespace viewpeel::program {

struct Example {
  const char* purpose;  // under 76 columns
  const char* line;     // under 78 columns
};

// Returns the examples of a command; `viewpeel` is the program itself.
std::vector<Example> examplesOf(const std::string& command);

}  // namespace viewpeel::program
