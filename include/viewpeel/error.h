// The library throws one type of exception.
#pragma once
#include <stdexcept>
#include <string>

namespace viewpeel {

// An ErrorCode lets the caller act on an error. The program maps bad_input and bad_usage to exit status 2, the rest to
// 1.
enum class ErrorCode {
  bad_input,  // a file says something that is not a scene, or not a checkpoint
  bad_usage,  // a request contradicts itself, or names an absent surface, face or file
  device,     // no Vulkan device can be used, or a call of its driver failed
  memory,     // the device has not enough of it
  output,     // a file cannot be written
  limit,      // more than the library can count or hold
  check,      // results contradict a check
};

// Error is the one exception type of the library. The message is one line. It names the file, line, polygon or device
// concerned, and the remedy.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace viewpeel
