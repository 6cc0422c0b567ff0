// A control group (container, Slurm job) may allow a process less than the processors that it may run on.
#pragma once
#include <filesystem>
#include <string>

namespace viewpeel {

// Returns how many processors' time the control groups of this process allow, as a number; infinite without a limit.
//   In: groups: where the file system of control groups is mounted; membership: the text of /proc/self/cgroup
//   Out: the least of the own group's and all groups' above it, of version 2 (cpu.max) or 1 (cpu.cfs_quota_us)
//   Source: Linux, Documentation/admin-guide/cgroup-v2.rst and cgroup-v1; files that are not there set no limit.
double processorQuota(const std::filesystem::path& groups, const std::string& membership);

}  // namespace viewpeel
