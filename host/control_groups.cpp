#include "control_groups.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGroups = "/sys/fs/cgroup";

std::string membershipOfProcess() {
  std::stringstream membership;
  membership << std::ifstream("/proc/self/cgroup").rdbuf();
  return membership.str();
}

// Returns the number of processors that a limit allows. The text is "max 100000" or "150000 100000": microseconds of
// processor time, and of the period.
double quotaOf(std::istream&& text) {
  double quota = 0, period = 0;
  return text >> quota >> period && quota > 0 && period > 0 ? quota / period : INFINITY;
}

double processorsOf(const fs::path& folder) {
  if (std::ifstream both(folder / "cpu.max"); both) return quotaOf(std::move(both));
  std::ifstream quota(folder / "cpu.cfs_quota_us"), period(folder / "cpu.cfs_period_us");
  std::stringstream both;
  both << quota.rdbuf() << ' ' << period.rdbuf();
  return quotaOf(std::move(both));
}

// Returns the bytes that a folder's limit allows. The file holds "max" or a number.
double bytesOf(const fs::path& folder) {
  double bytes = 0;
  for (const char* name : {"memory.max", "memory.limit_in_bytes"})
    if (std::ifstream(folder / name) >> bytes && bytes > 0) return bytes;
  return INFINITY;
}

// Returns the least limit of the process's groups and all groups above them.
//   In: controller: what the limit is of, for version 1; limit_of: returns the limit of a group's folder
double leastLimit(const fs::path& groups, const std::string& membership, const std::string& controller,
                  const std::function<double(const fs::path&)>& limit_of) {
  double least = INFINITY;
  std::istringstream lines(membership);
  for (std::string line; std::getline(lines, line);) {
    // A line of /proc/self/cgroup is "0::/user.slice/run" in version 2, "4:cpu,cpuacct:/job" in version 1.
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && ("," + controllers + ",").find("," + controller + ",") == std::string::npos) continue;
    const fs::path root = controllers.empty() ? groups : groups / controllers;
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
      least = std::min(least, limit_of(root / group));
      if (group.empty()) break;
    }
  }
  return least;
}

}  // namespace

double processorQuota(const fs::path& groups, const std::string& membership) {
  return leastLimit(groups, membership, "cpu", processorsOf);
}

double memoryQuota(const fs::path& groups, const std::string& membership) {
  return leastLimit(groups, membership, "memory", bytesOf);
}

double processorQuota() { return processorQuota(kGroups, membershipOfProcess()); }

double memoryQuota() { return memoryQuota(kGroups, membershipOfProcess()); }

}  // namespace viewpeel
