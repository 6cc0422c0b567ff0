// The fixture Program runs the program as a user does.
#pragma once
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace viewpeel {

// The beginning of commands that compute form factors between the surfaces of the office.
inline const std::string kComputeOffice = "compute " VIEWPEEL_SCENES "/office.obj --quiet --by surface ";

struct Result {
  int status;
  std::string output;  // stdout and stderr
};

inline Result run(const std::string& arguments, const std::string& environment = "") {
  const std::string command = environment + " " VIEWPEEL_PROGRAM " " + arguments + " 2>&1 </dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  Result result{-1, ""};
  std::array<char, 4096> buffer;
  while (size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) result.output.append(buffer.data(), got);
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

inline std::string readFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// Returns the rest of the first output line that begins with the label, without the spaces between. Without such a line
// it returns the whole output, so that a failing test shows it.
inline std::string shownValue(const std::string& output, const std::string& label) {
  const size_t line = ("\n" + output).find("\n" + label + " ");
  if (line == std::string::npos) return output;
  const size_t value = output.find_first_not_of(' ', line + label.size());
  return output.substr(value, output.find('\n', value) - value);
}

// Program is a test with a separate folder.
class Program : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("viewpeel_program_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  // Returns the replicates that a checkpoint holds, as `merge` shows them.
  std::string replicatesOf(const std::string& name) const {
    return shownValue(run("merge " + file(name)).output, "replicates");
  }
  std::filesystem::path folder_;
};

}  // namespace viewpeel
