// processorQuota() and memoryQuota() read how much processor time and memory a control group (container, Slurm job)
// allows the process. This may be less than what the machine has.
#pragma once
#include <filesystem>
#include <string>

namespace viewpeel {

// Returns the number of processors whose time the control groups of this process allow; infinite without a limit.
//   In: groups: where the file system of control groups is mounted; membership: the text of /proc/self/cgroup
//   Out: the least limit of the process's group and all groups above it, of version 2 (cpu.max) or 1 (cpu.cfs_quota_us)
//   Source: Linux, Documentation/admin-guide/cgroup-v2.rst and cgroup-v1; files that are not there set no limit.
double processorQuota(const std::filesystem::path& groups, const std::string& membership);

// Returns the bytes of memory that the control groups allow all their processes together, as processorQuota() does.
//   Out: the least limit, of version 2 (memory.max) or 1 (memory.limit_in_bytes)
double memoryQuota(const std::filesystem::path& groups, const std::string& membership);

// Return the same of this process, with the control groups that the machine has.
double processorQuota();
double memoryQuota();

}  // namespace viewpeel
