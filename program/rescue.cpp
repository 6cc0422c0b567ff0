#include "program/rescue.h"

#include <iostream>

#include <fmt/format.h>
#include <unistd.h>

#include "program/warnings.h"
#include <viewpeel/error.h>

namespace viewpeel::program {

std::string writeSomewhere(const std::string& file, const std::function<void(const std::string&)>& write, bool may_ask,
                           const std::string& remedy) {
  const bool asks = may_ask && ::isatty(STDIN_FILENO) && ::isatty(STDERR_FILENO);
  std::string place = file;
  while (true) {
    try {
      write(place);
      return place;
    } catch (const Error& error) {
      if (!asks && error.code() == ErrorCode::output) throw Error(error.code(), error.what() + remedy);
      if (!asks) throw;
      complain(error.what());
    }
    fmt::print(stderr,
               "viewpeel: the result is still in memory; type a file to write it to, or only Enter to give it up: ");
    std::fflush(stderr);
    std::string answer;
    if (!std::getline(std::cin, answer) || answer.empty())
      throw Error(ErrorCode::output, fmt::format("{}: the result was not written{}", file, remedy));
    place = answer;
  }
}

}  // namespace viewpeel::program
