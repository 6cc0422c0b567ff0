// A FoamCase is OpenFOAM's room of tests/files/openfoam_room in a folder of its own, with Debian's programs.
#pragma once
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <viewpeel/form_factors.h>
#include "tests/support/test_folder.h"

namespace viewpeel {

class FoamCase : public TestFolder {
 protected:
  void SetUp() override {
    TestFolder::SetUp();
    std::filesystem::copy(VIEWPEEL_TEST_FILES "/openfoam_room", folder_, std::filesystem::copy_options::recursive);
  }
  void replace(const std::string& name, const std::string& old, const std::string& text) const {
    std::ostringstream bytes;
    bytes << std::ifstream(folder_ / name, std::ios::binary).rdbuf();
    std::string all = bytes.str();
    ASSERT_NE(all.find(old), std::string::npos) << name;
    all.replace(all.find(old), old.size(), text);
    std::ofstream(folder_ / name, std::ios::binary) << all;
  }
  void runFoam(const std::string& program, int ranks = 0) const {
    const std::string command =
        ranks ? fmt::format("mpirun --oversubscribe -np {} {} -parallel", ranks, program) : program;
    const int status = std::system(fmt::format("cd '{}' && WM_PROJECT_DIR=/usr/share/openfoam OMPI_ALLOW_RUN_AS_ROOT=1 "
                                               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 {} >said 2>&1 </dev/null",
                                               folder_.string(), command)
                                       .c_str());
    std::ostringstream said;
    said << std::ifstream(folder_ / "said").rdbuf();
    ASSERT_EQ(status, 0) << program << said.str().substr(said.str().size() - std::min<size_t>(said.str().size(), 2000));
  }
  static std::string dense(const FormFactors& f) {
    std::vector<std::vector<double>> values(f.ids().count(), std::vector<double>(f.ids().count()));
    for (uint32_t i = 0; i < f.ids().count(); ++i)
      for (uint32_t j = 0; j < f.ids().count(); ++j) values[i][j] = f.formFactor(i, j).value;
    return fmt::format("{}", values);
  }
};

}  // namespace viewpeel
