// requireNumbers() refuses meaningless numbers in a request. Callers of the library have no options that check them.
#include <cmath>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "run/rules.h"

namespace viewpeel {
namespace {

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorCode::bad_usage, message); }

void requirePositive(const char* name, double value) {
  if (!(value > 0) || !std::isfinite(value)) refuse(fmt::format("{}: {} is not a number above 0", name, value));
}

template <class T>
void requireWithin(const char* name, T value, T least, T most) {
  if (value < least || value > most) refuse(fmt::format("{}: {} is not from {} to {}", name, value, least, most));
}

}  // namespace

void requireNumbers(const Request& request) {
  const Amount amount = amountOf(request);
  if (const auto* tolerance = std::get_if<Tolerance>(&request.goal)) {
    requirePositive("--tolerance", tolerance->standard_error);
    if (tolerance->relative) requirePositive("--relative", *tolerance->relative);
  }
  if (const auto* relative = std::get_if<Relative>(&request.goal))
    requirePositive("--relative", relative->standard_error);
  if (const auto* rms = std::get_if<RootMeanSquare>(&request.goal)) requirePositive("--rms", rms->standard_error);
  if (const auto* seconds = std::get_if<Seconds>(&request.goal)) requirePositive("--seconds", seconds->seconds);
  if (request.time_limit_s) requirePositive("--seconds", *request.time_limit_s);
  requirePositive("--floor", request.relative_floor);
  if (request.relative_floor > 1) refuse(fmt::format("--floor: {} is above 1", request.relative_floor));
  requireWithin("--directions", amount.directions, 0u, 1u << 30);
  requireWithin("--replicates", amount.replicates, 2u, 1u << 30);
  requireWithin("--resolution", amount.resolution, 0, kMaxResolution);
  requireWithin("--finest", amount.finest, 0, kMaxWindowResolution);
}

}  // namespace viewpeel
