// These tests check the adapter for View3D, a rival in the bench: the input file it writes and the output file it
// reads.
#include "bench/rivals/view3d.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "scene/read_vs3.h"
#include "scenes/named_scenes.h"

namespace viewpeel::bench {
namespace {

namespace ts = test_scenes;

InputScene squareAndTriangle() {
  InputScene scene{"two shapes", {}, {}};
  ts::addFace(scene, "square", {{0, 0, 0}, {0.1, 0, 0}, {0.1, 1. / 3, 0}, {0, 1. / 3, 0}});
  ts::addFace(scene, "triangle", {{0, 0, 2}, {0, 1, 2}, {1, 0, 2}});
  return scene;
}

TEST(View3d, SurfacesAreWrittenWithTheirCornersInOrder) {
  const InputScene input = squareAndTriangle();
  const std::string name = testing::TempDir() + "viewpeel_view3d_test.vs3";
  std::ofstream out(name);
  writeView3d(buildScene(input), 1e-5, out);
  out.close();
  const Vs3File file = parseVs3(name);
  EXPECT_EQ(file.control.eps, 1e-5);
  const std::vector<Vs3Surface>& surfaces = file.surfaces;
  ASSERT_EQ(surfaces.size(), 2u);
  for (size_t k = 0; k < 2; ++k) {
    ASSERT_EQ(surfaces[k].corners.size(), input.faces[k].corners.size());
    // Corners were moved to the unit ball and back, whose radius and offset are below 2, which costs a few ulps.
    for (size_t c = 0; c < surfaces[k].corners.size(); ++c)
      EXPECT_LT(glm::length(surfaces[k].corners[c] - input.faces[k].corners[c]), 1e-15);
  }
}

// This file follows View3D's output format, for three surfaces of areas 2, 1 and 4.
constexpr const char* kOutput =
    "View3D 4.0.0 0 0 0 3          \n2 1 4\n"
    "0.000000 0.250000 0.5\n0.5 0.000000 1.25e-1\n0.25 0.030 0.000000\n0.900 0.900 0.900\n";

TEST(View3d, FormFactorsAreReadWithBothDirectionsAveraged) {
  std::istringstream file(kOutput);
  const ExchangeMatrix exchange = readView3d(file, 3, "file");
  EXPECT_DOUBLE_EQ(exchange.at(0, 1), (2 * 0.25 + 1 * 0.5) / 2);
  EXPECT_DOUBLE_EQ(exchange.at(2, 0), (2 * 0.5 + 4 * 0.25) / 2);
  EXPECT_DOUBLE_EQ(exchange.at(1, 2), (1 * 0.125 + 4 * 0.03) / 2);
}

TEST(View3d, WhatIsNoOutputIsRefused) {
  const std::string output = kOutput;
  const auto refusal = [](const std::string& text, uint32_t count) -> std::string {
    std::istringstream file(text);
    try {
      readView3d(file, count, "out.txt");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(refusal(output, 3), "none");
  EXPECT_EQ(refusal(output, 4), "out.txt: 3 surfaces in place of 4; give View3D's own text output");
  EXPECT_EQ(refusal("View2D 3.3\n1\n", 1),
            "out.txt: the first line is not `View3D version out encl emit N`; give View3D's own text output");
  EXPECT_EQ(refusal("", 1),
            "out.txt: the first line is not `View3D version out encl emit N`; give View3D's own text output");
  EXPECT_EQ(refusal(output.substr(0, output.find("0.030")), 3),
            "out.txt: a form factor is missing or no number; give View3D's own text output");
  EXPECT_EQ(refusal(output.substr(0, output.rfind("0.900")), 3),
            "out.txt: an emissivity is missing or no number; give View3D's own text output");
}

// Writes a shell script that takes the place of View3D.
std::string writeProgram(const std::string& body) {
  std::string file = testing::TempDir() + "viewpeel_view3d_program";
  std::ofstream(file) << "#!/bin/sh\n" << body;
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

TEST(View3d, ItsProgramTakesInputAndOutput) {
  const Scene scene = buildScene(squareAndTriangle());
  const std::string program = writeProgram(
      "grep -q '^S 2 ' \"$1\" && printf 'View3D 4.0.0 0 0 0 2\\n2 1\\n0 0.25\\n0.5 0\\n0.9 0.9\\n' > \"$2\"\n");
  const View3dRun run = runView3d(program, scene, 1e-4, testing::TempDir());
  EXPECT_DOUBLE_EQ(run.exchange.at(0, 1), 0.5);
  EXPECT_GT(run.time.seconds, 0);
  EXPECT_GT(run.time.cpu_seconds, 0);  // of the shell and grep
  try {
    runView3d(writeProgram("exit 3\n"), scene, 1e-4, testing::TempDir());
    FAIL() << "a program that fails is taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_usage);
    EXPECT_NE(std::string(error.what()).find("ends with status 3; give the path of View3D's program"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace viewpeel::bench
