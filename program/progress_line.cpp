#include "program/progress_line.h"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace viewpeel::program {
namespace {

constexpr double kSecondsApart = 0.1;

std::string describeGoal(const Request& request, const Progress& progress) {
  const auto soFar = [&](const std::string& goal) {
    return std::isfinite(progress.largest_standard_error)
               ? fmt::format("largest standard error {:.1e}, {}", progress.largest_standard_error, goal)
               : goal;
  };
  const std::string limit = request.time_limit_s ? fmt::format("until {:.0f} s", *request.time_limit_s) : "";
  if (const auto* tolerance = std::get_if<Tolerance>(&request.goal))
    return soFar(limit.empty() ? fmt::format("goal {:.1e}", tolerance->standard_error) : limit);
  if (const auto* relative = std::get_if<Relative>(&request.goal))
    return limit.empty() ? fmt::format("goal {:.1e} of a form factor", relative->standard_error) : limit;
  if (const auto* seconds = std::get_if<Seconds>(&request.goal)) return fmt::format("until {:.0f} s", seconds->seconds);
  return fmt::format("of {}", request.amount.replicates);
}

}  // namespace

ProgressLine::ProgressLine(const Request& request, bool shows)
    : request_(request), shows_(shows && ::isatty(STDERR_FILENO)) {}

std::function<void(const Progress&)> ProgressLine::listener() {
  if (!shows_) return {};
  return [this](const Progress& progress) { show(progress); };
}

void ProgressLine::clear() const {
  if (shows_) fmt::print(stderr, "\r\033[K");
}

std::string ProgressLine::describe(const Progress& progress) const {
  if (progress.most_blocks)
    return fmt::format("block {} of {} expected, {} at most", progress.replicates, progress.expected_blocks,
                       progress.most_blocks);
  if (!progress.directions_of_replicate) return fmt::format("pilot, direction {}", progress.directions);
  return fmt::format("replicate {} {}, direction {} of {}", progress.replicates + 1, describeGoal(request_, progress),
                     progress.directions, progress.directions_of_replicate);
}

void ProgressLine::show(const Progress& progress) {
  if (secondsSince(shown_) < kSecondsApart) return;
  shown_ = Clock::now();
  fmt::print(stderr, "\r\033[K{}, {:.1f} s", describe(progress), secondsSince(start_));
  std::fflush(stderr);
}

}  // namespace viewpeel::program
