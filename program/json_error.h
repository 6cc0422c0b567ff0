// An error is a JSON object, too, where the command line has --json.
#pragma once
#include <string>

namespace viewpeel::program {

// Returns an object with `error`, one line, and `status`, the exit status; and a newline.
std::string errorAsJson(const std::string& message, int status);

}  // namespace viewpeel::program
