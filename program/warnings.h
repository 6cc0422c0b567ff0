// Warnings go to stderr at once, a line each; --json has them, too.
#pragma once
#include <string>
#include <vector>

namespace viewpeel::program {

// Prints one line on stderr, "viewpeel: warning: ...", and keeps it.
void warn(const std::string& text);

// Returns all warnings up to now.
const std::vector<std::string>& warnings();

// Returns whether words on stderr may be coloured: on a terminal, unless NO_COLOR is set (https://no-color.org).
bool isColoured();

// Prints one line on stderr, also where the message quotes control characters of a name.
void complain(std::string message);

}  // namespace viewpeel::program
