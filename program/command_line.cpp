#include "program/command_line.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace viewpeel::program {
namespace {

std::string kept;

bool isPlain(unsigned char c) { return std::isalnum(c) || std::string_view("-_./,:=+@%").find(c) != std::string::npos; }

std::string quote(std::string_view word) {
  if (!word.empty() && std::ranges::all_of(word, isPlain)) return std::string(word);
  std::string quoted = "'";
  for (char c : word)
    if (c == '\'') quoted += "'\\''";
    else quoted += c;
  quoted += '\'';
  return quoted;
}

}  // namespace

void keepCommandLine(int argc, const char* const* argv) {
  kept = "viewpeel";
  for (int k = 1; k < argc; ++k) kept.append(" ").append(quote(argv[k]));
}

std::string commandLine() { return kept; }

}  // namespace viewpeel::program
