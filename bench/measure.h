// What the benches share: time, medians, and the lines that say what was measured where.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>

#include "vulkan/device.h"

namespace viewpeel::bench {

using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

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

// Of the source tree at `directory` as it is now; "unknown" without git.
inline std::string commitOf(const std::string& directory) {
  std::string commit;
  if (FILE* pipe = ::popen(fmt::format("git -C '{}' describe --always --dirty --exclude '*' 2>/dev/null", directory).c_str(), "r")) {
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
  fmt::print("# device {} ({}; {})\n# commit {}\n# {} cores, load {:.1f} before the start\n", description.name, description.kind, description.driver,
             commitOf(source_directory), std::thread::hardware_concurrency(), load);
}

}  // namespace viewpeel::bench
