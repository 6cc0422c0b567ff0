#include "processor_quota.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

// Returns the number of processors that a limit allows. The text is "max 100000" or "150000 100000": microseconds of
// processor time, and of the period.
double quotaOf(std::istream&& text) {
  double quota = 0, period = 0;
  return text >> quota >> period && quota > 0 && period > 0 ? quota / period : INFINITY;
}

double quotaOfFolder(const fs::path& folder) {
  if (std::ifstream both(folder / "cpu.max"); both) return quotaOf(std::move(both));
  std::ifstream quota(folder / "cpu.cfs_quota_us"), period(folder / "cpu.cfs_period_us");
  std::stringstream both;
  both << quota.rdbuf() << ' ' << period.rdbuf();
  return quotaOf(std::move(both));
}

}  // namespace

double processorQuota(const fs::path& groups, const std::string& membership) {
  double least = INFINITY;
  std::istringstream lines(membership);
  for (std::string line; std::getline(lines, line);) {
    // A line of /proc/self/cgroup is "0::/user.slice/run" in version 2, "4:cpu,cpuacct:/job" in version 1.
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && ("," + controllers + ",").find(",cpu,") == std::string::npos) continue;
    const fs::path root = controllers.empty() ? groups : groups / controllers;
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
      least = std::min(least, quotaOfFolder(root / group));
      if (group.empty()) break;
    }
  }
  return least;
}

}  // namespace viewpeel
