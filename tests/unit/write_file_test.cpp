// Files are written under a temporary name in the same folder and then renamed. Other users may be able to write to
// this folder.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/io/file_lock.h"
#include "host/io/write_file.h"
#include "tests/support/test_folder.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

class WriteFile : public TestFolder {
 protected:
  static std::string textOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  static mode_t modeOf(const fs::path& file) {
    struct stat found {};
    EXPECT_EQ(::stat(file.c_str(), &found), 0);
    return found.st_mode & 07777;
  }
};

void writeNew(const fs::path& file) {
  writeFile(file, [](std::ostream& out) { out << "new"; });
}

TEST_F(WriteFile, KeepsTheModeOfAFileThatWasThere) {
  const fs::path file = folder_ / "a.csv";
  for (const mode_t mode : {0640, 0600, 0666}) {
    std::ofstream(file) << "old";
    ASSERT_EQ(::chmod(file.c_str(), mode), 0);
    writeNew(file);
    EXPECT_EQ(modeOf(file), mode);
    EXPECT_EQ(textOf(file), "new");
  }
}

TEST_F(WriteFile, KeepsTheOwnerWhereTheSystemAllowsIt) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root may give files away";
  const fs::path file = folder_ / "a.csv";
  constexpr uid_t kOther = 12345;
  std::ofstream(file) << "old";
  ASSERT_EQ(::chown(file.c_str(), kOther, kOther), 0);
  writeNew(file);
  struct stat found {};
  ASSERT_EQ(::stat(file.c_str(), &found), 0);
  EXPECT_EQ(found.st_uid, kOther);
  EXPECT_EQ(found.st_gid, kOther);
}

TEST_F(WriteFile, NewFilesObeyTheMask) {
  const mode_t old = ::umask(027);
  writeNew(folder_ / "a.csv");
  ::umask(old);
  EXPECT_EQ(modeOf(folder_ / "a.csv"), 0640u);
}

TEST_F(WriteFile, ASymbolicLinkStaysAndItsTargetIsReplaced) {
  fs::create_directory(folder_ / "elsewhere");
  std::ofstream(folder_ / "elsewhere" / "target.csv") << "old";
  for (const char* target : {"target.csv", "not_there_yet.csv"}) {
    const fs::path link = folder_ / "link.csv";
    fs::remove(link);
    fs::create_symlink(fs::path("elsewhere") / target, link);
    writeNew(link);
    EXPECT_TRUE(fs::is_symlink(link)) << target;
    EXPECT_EQ(textOf(folder_ / "elsewhere" / target), "new");
  }
}

// Another user who guesses the temporary name could put a link there, so that a file elsewhere is overwritten. The name
// once was FILE.PID.part. Now it is random, and links are not followed.
TEST_F(WriteFile, TemporaryNamesDifferAndAreNotFollowed) {
  const fs::path file = folder_ / "a.csv", victim = folder_ / "victim";
  std::ofstream(victim) << "precious";
  fs::create_symlink(victim, folder_ / ("a.csv." + std::to_string(::getpid()) + ".part"));
  std::set<std::string> names;
  for (int k = 0; k < 8; ++k)
    writeFile(file, [&](std::ostream& out) {
      for (const auto& entry : fs::directory_iterator(folder_))
        if (!entry.is_symlink() && entry.path().extension() == ".part") names.insert(entry.path().filename());
      out << "new";
    });
  checkWritable(file);
  EXPECT_EQ(textOf(victim), "precious");
  EXPECT_EQ(names.size(), 8u);  // all differ, of 2^64 possible names
}

// A run once locked its new checkpoint after the file had its name. Between the two another run could take it.
TEST_F(WriteFile, NobodyElseCanLockAFileThatIsReplaced) {
  constexpr int kTimes = 200;  // that the file is written, and that the other thread tries to lock it, at least
  const fs::path file = folder_ / "a.h5";
  writeNew(file);
  FileLock mine;
  ASSERT_TRUE(mine.take(file));
  std::atomic<bool> is_over = false;
  std::atomic<int> tries = 0, taken = 0;
  std::thread other([&] {
    for (; !is_over; ++tries) taken += FileLock().take(file);
  });
  for (int k = 0; k < kTimes || tries < kTimes; ++k) {
    writeFile(
        file, [](std::ostream& out) { out << "newer"; }, &mine);
    EXPECT_TRUE(mine.isOn(file));
  }
  is_over = true;
  other.join();
  EXPECT_EQ(taken, 0);
  mine.release();
  EXPECT_TRUE(FileLock().take(file));
}

TEST_F(WriteFile, NothingIsLeftBehind) {
  checkWritable(folder_ / "a.csv");
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_THROW(writeFile(folder_ / "a.csv", [](std::ostream&) { throw std::runtime_error("stop"); }),
               std::runtime_error);
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_THROW(writeFile("/dev/full/a.csv", [](std::ostream&) {}), Error);
}

}  // namespace
}  // namespace viewpeel
