// A TestFolder is a test with an empty, separate folder.
#pragma once
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/error.h>

namespace viewpeel {

class TestFolder : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  // Returns the message of the Error bad_input that `read` throws, or "none" if it throws nothing.
  static std::string refusalOf(const std::function<void()>& read) {
    try {
      read();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.what();
    }
    return "none";
  }
  // Returns the message without its first `length` characters, which name the file. "none" stays.
  static std::string withoutPlace(const std::string& message, size_t length) {
    return message == "none" ? message : message.substr(length);
  }
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      (std::string("viewpeel_") + testing::UnitTest::GetInstance()->current_test_info()->test_suite_name() + "_" +
       std::to_string(::getpid()));
};

}  // namespace viewpeel
