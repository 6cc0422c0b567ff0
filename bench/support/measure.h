// The benches share these functions for time, medians, power laws, and the lines that name device, driver and commit.
#pragma once
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>

#include "stopwatch.h"
#include "vulkan/device.h"

namespace viewpeel::bench {

template <class Run>
double secondsOf(Run run) {
  const Clock::time_point start = Clock::now();
  run();
  return secondsSince(start);
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

// PowerLaw is y = exp(intercept) x^exponent, by least squares on logarithms. standard_error is that of the exponent,
// from the residuals.
struct PowerLaw {
  double exponent = 0, intercept = 0, standard_error = 0;
  double at(double x) const { return std::exp(intercept) * std::pow(x, exponent); }
};

inline PowerLaw fitPowerLaw(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = double(x.size());
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, yy = 0;
  for (size_t k = 0; k < x.size(); ++k) mean_x += std::log(x[k]) / n, mean_y += std::log(y[k]) / n;
  for (size_t k = 0; k < x.size(); ++k) {
    const double dx = std::log(x[k]) - mean_x, dy = std::log(y[k]) - mean_y;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  PowerLaw law{.exponent = xy / xx};
  law.intercept = mean_y - law.exponent * mean_x;
  law.standard_error = std::sqrt(std::max(0.0, yy - xy * xy / xx) / (n - 2) / xx);
  return law;
}

// Returns the commit of the source tree at `directory` as it is now; "unknown" without git.
inline std::string commitOf(const std::string& directory) {
  std::string commit;
  if (FILE* pipe = ::popen(
          fmt::format("git -C '{}' describe --always --dirty --exclude '*' 2>/dev/null", directory).c_str(), "r")) {
    char line[128];
    if (std::fgets(line, sizeof line, pipe)) commit = line;
    ::pclose(pipe);
  }
  while (!commit.empty() && commit.back() == '\n') commit.pop_back();
  return commit.empty() ? "unknown" : commit;
}

inline void printPlace(const Device& device, const std::string& source_directory) {
  const DeviceDescription& description = device.description();
  double load = 0;
  ::getloadavg(&load, 1);
  fmt::print("# device {} ({}; {})\n# commit {}\n# {} cores, load {:.1f} before the start\n", description.name,
             description.kind, description.driver, commitOf(source_directory), std::thread::hardware_concurrency(),
             load);
}

}  // namespace viewpeel::bench
