#include "program/warnings.h"

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <unistd.h>

namespace viewpeel::program {
namespace {

std::vector<std::string> kept;
bool is_silent = false;

constexpr const char *kRed = "\033[1;31m", *kYellow = "\033[1;33m", *kPlain = "\033[0m";

// Prints a line by fputs, for fmt::print throws where stderr cannot be written.
void print(const char* colour, const std::string& lead, std::string text) {
  if (is_silent) return;
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  const bool is_coloured = isColoured();
  std::fputs(
      fmt::format("{}viewpeel: {}{}{}\n", is_coloured ? colour : "", lead, is_coloured ? kPlain : "", text).c_str(),
      stderr);
}

}  // namespace

bool isColoured() {
  static const bool is_coloured = [] {
    const char *no_color = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
    return ::isatty(STDERR_FILENO) && !(no_color && *no_color) && !(terminal && std::string(terminal) == "dumb");
  }();
  return is_coloured;
}

void warn(const std::string& text) {
  kept.push_back(text);
  print(kYellow, "warning: ", text);
}

void silence() { is_silent = true; }

const std::vector<std::string>& warnings() { return kept; }

void complain(std::string message) { print(kRed, "", std::move(message)); }

}  // namespace viewpeel::program
