#include "memory.h"

#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include "control_groups.h"

namespace viewpeel {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // a sanitizer reserves far more memory than there is
#else
constexpr bool kIsSanitized = false;
#endif

// Returns the bytes that the process may still take: free memory of the machine, or what its control groups allow if
// that is less. Returns 0 where /proc/meminfo does not say.
uint64_t availableMemory() {
  std::ifstream meminfo("/proc/meminfo");
  return static_cast<uint64_t>(std::min(double(freeMemory(meminfo)), memoryQuota()));
}

}  // namespace

void keepFreedMemory() {
  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, -1);  // never return memory to the system
  if (kIsSanitized) return;
  const size_t bytes = availableMemory() / 2;
  char* const ahead = static_cast<char*>(std::malloc(bytes));
  constexpr uintptr_t kHuge = uintptr_t(1) << 21;
  if (!ahead || bytes < kHuge) return std::free(ahead);
  char* const first = ahead + (kHuge - reinterpret_cast<uintptr_t>(ahead) % kHuge);
  ::madvise(first, (bytes - size_t(first - ahead)) / kHuge * kHuge, MADV_HUGEPAGE);
  std::free(ahead);
}

uint64_t freeMemory(std::istream& meminfo) {
  constexpr uint64_t kKilobyte = 1024;
  uint64_t all = 0;
  std::string name;
  for (uint64_t kilobytes = 0; meminfo >> name >> kilobytes; meminfo.ignore(INT16_MAX, '\n'))
    if (name == "MemAvailable:" || name == "SwapFree:") all += kilobytes * kKilobyte;
  return all;
}

uint64_t limitMemory() {
  const uint64_t bytes = availableMemory();
  rlimit limit{};
  if (bytes == 0 || kIsSanitized || ::getrlimit(RLIMIT_DATA, &limit) != 0) return bytes;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, bytes);
  ::setrlimit(RLIMIT_DATA, &limit);
  return limit.rlim_cur;
}

void returnFreedMemory() { ::malloc_trim(0); }

}  // namespace viewpeel
