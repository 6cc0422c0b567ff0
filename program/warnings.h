// Warnings are printed on stderr at once, a line each; --json repeats them.
#pragma once
#include <string>
#include <vector>

namespace viewpeel::program {

// Prints "viewpeel: warning: ..." on stderr and stores the text.
void warn(const std::string& text);

// Keeps warn() and complain() from printing. Of several ranks only rank 0 prints.
void silence();

// Returns all warnings so far.
const std::vector<std::string>& warnings();

// Returns whether text on stderr may be coloured: on a terminal, unless NO_COLOR is set (https://no-color.org).
bool isColoured();

// Prints a message on stderr in one line; control characters in quoted names become '?'.
void complain(std::string message);

}  // namespace viewpeel::program
