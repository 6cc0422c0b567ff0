// An allocation beyond free memory fails at once: the system does not kill the process later.
#include <sys/resource.h>

#include <cstdlib>
#include <fstream>
#include <new>
#include <sstream>

#include <gtest/gtest.h>

#include "host/memory.h"

namespace viewpeel {
namespace {

TEST(Memory, FreeIsWhatIsAvailableAndFreeSwap) {
  std::istringstream meminfo("MemTotal: 4000 kB\nMemAvailable:   3000 kB\nHugePages_Total:   7\nSwapFree: 20 kB\n");
  EXPECT_EQ(freeMemory(meminfo), 3020u * 1024);
  std::istringstream nothing("");
  EXPECT_EQ(freeMemory(nothing), 0u);
}

// Allocates twice three fifths of some bytes, and touches nothing. Ends the process with status 0 where both fit.
[[noreturn]] void allocateTwice(uint64_t bytes) {
  try {
    // A compiler may leave out new expressions, but no calls of operator new.
    void* const one = ::operator new(bytes / 5 * 3);
    void* const other = ::operator new(bytes / 5 * 3);
    std::_Exit(one != other ? 0 : 2);
  } catch (const std::bad_alloc&) {
    std::_Exit(1);
  }
}

TEST(Memory, LimitMakesAllocationsFail) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer reserves more memory than there is";
#endif
  std::ifstream meminfo("/proc/meminfo"), overcommit("/proc/sys/vm/overcommit_memory");
  int policy = 0;
  overcommit >> policy;
  constexpr int kStrict = 2;  // the system itself refuses what does not fit
  if (policy != kStrict) {
    const uint64_t free = freeMemory(meminfo);
    EXPECT_EXIT(allocateTwice(free), testing::ExitedWithCode(0), "");
  }
  EXPECT_EXIT(
      {
        const uint64_t bytes = limitMemory();
        rlimit after{};
        if (bytes == 0 || ::getrlimit(RLIMIT_DATA, &after) != 0 || after.rlim_cur > bytes) std::_Exit(3);
        allocateTwice(bytes);
      },
      testing::ExitedWithCode(1), "");
}

}  // namespace
}  // namespace viewpeel
