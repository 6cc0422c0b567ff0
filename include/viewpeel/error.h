#pragma once
#include <stdexcept>
#include <string>

namespace viewpeel {

// What went wrong, for the caller to act on: the program maps bad_input and bad_usage to exit status 2, the rest to 1; memory is the device's.
enum class ErrorCode { bad_input, bad_usage, device, memory, output, limit, check };

// The one exception type of the library. The message is one line that names the file, line, polygon or device
// concerned and says what to do about it.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace viewpeel
