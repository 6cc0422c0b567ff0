// With --json an error is printed as a JSON object, too.
#pragma once
#include <string>

namespace viewpeel::program {

// Returns a line with an object of two members: `error`, the message, and `status`, the exit status.
std::string errorAsJson(const std::string& message, int status);

}  // namespace viewpeel::program
