// The library throws one type of exception.
#pragma once
#include <stdexcept>
#include <string>

namespace viewpeel {

// An ErrorCode lets the caller act on an error. The program ends with exit status 2 for bad_input and bad_usage, and
// with 1 for the other codes.
enum class ErrorCode {
  bad_input,  // a file says something that is not a scene, or not a checkpoint
  bad_usage,  // a request contradicts itself, or names an absent surface, face or file
  device,     // no Vulkan device can be used, or a call of its driver failed
  memory,     // the device has not enough memory
  output,     // a file cannot be written
  limit,      // the library cannot count or hold this much
  check,      // a result contradicts a check
};

// Every exception that the library throws is an Error. Its message is one line, which names the file, line, polygon or
// device, and the remedy.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace viewpeel
