// A control group (cgroup) limits processor time, not the number of processors, and memory. These tests cover versions
// 1 and 2, and limits of the group itself and of its parents.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/control_groups.h"
#include "host/threads.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class ControlGroups : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(groups_); }
  void write(const std::string& file, const std::string& text) {
    fs::create_directories((groups_ / file).parent_path());
    std::ofstream(groups_ / file) << text;
  }
  fs::path groups_ = fs::temp_directory_path() / ("viewpeel_groups_test_" + std::to_string(::getpid()));
};

TEST_F(ControlGroups, ProcessorQuotaIsTheLeastOfAGroupAndItsParents) {
  EXPECT_EQ(processorQuota(groups_, "0::/job/step\n"), INFINITY);
  write("job/step/cpu.max", "max 100000\n");
  EXPECT_EQ(processorQuota(groups_, "0::/job/step\n"), INFINITY);
  write("job/cpu.max", "250000 100000\n");
  EXPECT_EQ(processorQuota(groups_, "0::/job/step\n"), 2.5);
  EXPECT_EQ(processorQuota(groups_, "0::/other\n"), INFINITY);
  write("cpu.max", "50000 100000\n");
  EXPECT_EQ(processorQuota(groups_, "0::/job/step\n"), 0.5);
  EXPECT_EQ(processorQuota(groups_, "0::/\n"), 0.5);  // a container sees its own group as the root
}

TEST_F(ControlGroups, ProcessorQuotaOfVersion1IsThatOfTheProcessorsController) {
  write("cpu,cpuacct/job/cpu.cfs_quota_us", "300000\n");
  write("cpu,cpuacct/job/cpu.cfs_period_us", "100000\n");
  write("cpu,cpuacct/free/cpu.cfs_quota_us", "-1\n");
  write("cpu,cpuacct/free/cpu.cfs_period_us", "100000\n");
  write("memory/job/cpu.cfs_quota_us", "1\n");
  write("memory/job/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(processorQuota(groups_, "9:memory:/job\n4:cpu,cpuacct:/job\n"), 3);
  EXPECT_EQ(processorQuota(groups_, "4:cpu,cpuacct:/free\n"), INFINITY);
}

TEST_F(ControlGroups, NonsenseIsNoLimit) {
  write("job/cpu.max", "many\n");
  write("half/cpu.max", "100000\n");
  write("job/memory.max", "much\n");
  write("half/memory.max", "\n");
  for (const char* text : {"", "nonsense", "0:", "0::/job\n", "0::/half\n", "0::/../..\n"}) {
    EXPECT_EQ(processorQuota(groups_, text), INFINITY) << text;
    EXPECT_EQ(memoryQuota(groups_, text), INFINITY) << text;
  }
}

TEST_F(ControlGroups, MemoryQuotaIsTheLeastOfAGroupAndItsParents) {
  write("job/step/memory.max", "max\n");
  EXPECT_EQ(memoryQuota(groups_, "0::/job/step\n"), INFINITY);
  write("job/memory.max", "4294967296\n");
  EXPECT_EQ(memoryQuota(groups_, "0::/job/step\n"), 4294967296);
  write("memory/job/memory.limit_in_bytes", "1048576\n");
  write("cpu/job/memory.limit_in_bytes", "1\n");
  EXPECT_EQ(memoryQuota(groups_, "9:cpu:/job\n4:memory:/job\n"), 1048576);
}

TEST(Threads, LimitHoldsUntilItIsLifted) {
  const size_t all = threadCount();
  limitThreads(1);
  EXPECT_EQ(threadCount(), 1u);
  limitThreads(all + 5);
  EXPECT_EQ(threadCount(), all);
  limitThreads(0);
  EXPECT_EQ(threadCount(), all);
}

}  // namespace
}  // namespace viewpeel
