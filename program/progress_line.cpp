#include "program/progress_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "program/warnings.h"
#include "run/summaries.h"

namespace viewpeel::program {
namespace {

constexpr double kSecondsApart = 0.1, kSecondsApartInLogs = 60;
constexpr size_t kColumns = 79;
// A prediction needs this many seconds of counting, and is made where this many are left.
constexpr double kLeastCounted = 1, kLeastLeft = 10;
constexpr double kMostBeforeTheEnd = 0.99;  // shown at most before the end, for a running run has not reached its goal

// The variable VIEWPEEL_PROGRESS_SECONDS sets the time between two lines of a log.
double secondsApartInLogs() {
  const char* given = std::getenv("VIEWPEEL_PROGRESS_SECONDS");
  const double seconds = given ? std::strtod(given, nullptr) : 0;
  return seconds > 0 ? seconds : kSecondsApartInLogs;
}

std::optional<double> toleranceOf(const Request& request) {
  const auto* tolerance = std::get_if<Tolerance>(&request.goal);
  return tolerance ? std::optional(tolerance->standard_error) : std::nullopt;
}

// Returns the expected number of replicates: as many as are requested, or more where present errors predict more.
double expectedReplicates(const Request& request, const Progress& progress) {
  const auto* fixed = std::get_if<FixedAmount>(&request.goal);
  const double least = fixed ? fixed->replicates : request.amount.replicates;
  const std::optional<double> tolerance = toleranceOf(request);
  if (!tolerance || request.amount.is_exact || progress.replicates < 2 ||
      !std::isfinite(progress.largest_standard_error))
    return least;
  const double ratio = progress.largest_standard_error / *tolerance;
  return std::max(least, std::ceil(double(progress.replicates) * ratio * ratio));
}

std::string inShort(double seconds) {
  return seconds < 100    ? fmt::format("{:.0f} s", seconds)
         : seconds < 6000 ? fmt::format("{:.0f} min", seconds / 60)
                          : fmt::format("{:.1f} h", seconds / 3600);
}

std::string describeCount(const Request& request, const Progress& progress) {
  if (progress.most_blocks) {
    const uint64_t block = progress.replicates + 1;
    return block > progress.expected_blocks ? fmt::format("block {}", block)
                                            : fmt::format("block {} of {} expected", block, progress.expected_blocks);
  }
  if (progress.phase != Progress::Phase::counting)
    return progress.directions ? fmt::format("direction {} of a pilot", progress.directions) : "";
  const bool has_end = !request.time_limit_s && !std::holds_alternative<Seconds>(request.goal);
  const double expected = expectedReplicates(request, progress), next = double(progress.replicates) + 1;
  std::string text = fmt::format("replicate {:.0f}", has_end ? std::min(next, expected) : next);
  if (has_end) text += fmt::format(" of {}{:.0f}", toleranceOf(request) ? "about " : "", expected);
  if (std::isfinite(progress.largest_standard_error))
    text += fmt::format(", error {:.1e}", progress.largest_standard_error);
  if (const auto tolerance = toleranceOf(request)) text += fmt::format(", goal {:.1e}", *tolerance);
  return text;
}

// Returns the part of the fraction that earlier runs counted.
double resumedFraction(const Request& request, const Progress& progress) {
  const double all = progress.most_blocks ? double(progress.expected_blocks) : expectedReplicates(request, progress);
  return progress.resumed ? double(progress.resumed) / std::max(all, 1.0) : 0;
}

}  // namespace

std::optional<double> measureFraction(const Request& request, const Progress& progress, double elapsed_s) {
  if (progress.phase != Progress::Phase::counting) return std::nullopt;
  double fraction = 0;
  if (const auto* seconds = std::get_if<Seconds>(&request.goal)) {
    fraction = elapsed_s / seconds->seconds;
  } else if (progress.most_blocks) {
    fraction = double(progress.replicates) / double(std::max<uint64_t>(progress.expected_blocks, 1));
  } else if (!std::holds_alternative<Relative>(request.goal)) {
    const double of_replicate =
        progress.directions_of_replicate ? double(progress.directions) / double(progress.directions_of_replicate) : 0;
    fraction = (double(progress.replicates) + of_replicate) / expectedReplicates(request, progress);
  } else if (!request.time_limit_s) {
    return std::nullopt;
  }
  if (request.time_limit_s) fraction = std::max(fraction, elapsed_s / *request.time_limit_s);
  return std::clamp(fraction, 0.0, kMostBeforeTheEnd);
}

std::string describeProgress(const Request& request, const Progress& progress, double elapsed_s, double counted_s) {
  using Phase = Progress::Phase;
  std::string text = progress.phase == Phase::planning     ? "pilot"
                     : progress.phase == Phase::unoccluded ? "unoccluded form factors"
                                                           : "counting";
  const std::optional<double> fraction = measureFraction(request, progress, elapsed_s);
  if (fraction) text += fmt::format(" {:2.0f} %", 100 * *fraction);
  const double counted = fraction ? *fraction - resumedFraction(request, progress) : 0;
  if (counted > 0 && counted_s > 0) text += fmt::format(", {} left", inShort(counted_s * (1 - *fraction) / counted));
  else text += fmt::format(", {}", inShort(elapsed_s));
  if (const std::string count = describeCount(request, progress); !count.empty()) text += "; " + count;
  return text.substr(0, kColumns);
}

std::optional<std::string> predictEnd(const Request& request, const Progress& progress, double counted_s) {
  const bool has_end = !progress.most_blocks && !request.time_limit_s &&
                       !std::holds_alternative<Seconds>(request.goal) &&
                       !std::holds_alternative<Relative>(request.goal);
  const uint64_t counted = progress.replicates - progress.resumed;
  if (!has_end || progress.phase != Progress::Phase::counting || counted == 0 || counted_s < kLeastCounted)
    return std::nullopt;
  const double expected = expectedReplicates(request, progress),
               left = counted_s * (expected - double(progress.replicates)) / double(counted);
  if (!(left >= kLeastLeft)) return std::nullopt;
  const double rounded = expected < 1000 ? expected : std::round(expected / 100) * 100;
  return fmt::format("expected   {}{:.0f} replicates in all, {} more\n", toleranceOf(request) ? "about " : "", rounded,
                     inWords(left));
}

ProgressLine::ProgressLine(const Request& request, bool shows)
    : request_(request),
      shows_(shows),
      is_terminal_(::isatty(STDERR_FILENO)),
      seconds_apart_(is_terminal_ ? kSecondsApart : secondsApartInLogs()) {}

std::function<void(const Progress&)> ProgressLine::listener() {
  if (!shows_) return {};
  return [this](const Progress& progress) { show(progress); };
}

void ProgressLine::begin(const std::string& phase) const {
  if (!shows_ || !is_terminal_) return;
  fmt::print(stderr, "\r\033[K{}", phase.substr(0, kColumns));
  std::fflush(stderr);
}

void ProgressLine::clear() const {
  if (shows_ && is_terminal_) fmt::print(stderr, "\r\033[K");
}

std::optional<std::string> ProgressLine::predict() const {
  return predictEnd(request_, last_, secondsSince(counting_));
}

void ProgressLine::show(const Progress& progress) {
  last_ = progress;
  const bool is_new_phase = std::exchange(phase_, progress.phase) != std::optional(progress.phase);
  if (is_new_phase && progress.phase == Progress::Phase::counting) counting_ = Clock::now();
  const bool is_due = secondsSince(shown_) >= seconds_apart_;
  if (!is_due && !(is_new_phase && is_terminal_)) return;
  shown_ = Clock::now();
  const std::string line = describeProgress(request_, progress, secondsSince(start_), secondsSince(counting_));
  if (!is_terminal_) {
    fmt::print(stderr, "viewpeel: {}\n", line);
  } else {
    const size_t word = line.find_first_of(" ,");
    fmt::print(stderr, "\r\033[K{}{}{}{}", isColoured() ? "\033[32m" : "", line.substr(0, word),
               isColoured() ? "\033[0m" : "", line.substr(word));
  }
  std::fflush(stderr);
}

}  // namespace viewpeel::program
