// Without a GPU the program does not ask Vulkan for one: loading all drivers takes several times as long as a small
// scene.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "vulkan/gpu_nodes.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

TEST(GpuNodes, AreDeviceFilesOfGraphicsDrivers) {
  const fs::path devices = fs::temp_directory_path() / ("viewpeel_gpu_nodes_" + std::to_string(::getpid()));
  EXPECT_FALSE(hasGpuNode(devices));  // no such folder
  fs::create_directories(devices / "dri/by-path");
  for (const char* other : {"null", "tty", "shm", "dri2", "dri/by-path/card0", "dri/controlD64"})
    std::ofstream(devices / other) << "";
  EXPECT_FALSE(hasGpuNode(devices));
  for (const char* node : {"dri/renderD128", "dri/card0", "nvidia0", "nvidiactl", "kfd", "dxg", "mali0", "kgsl-3d0"}) {
    std::ofstream(devices / node) << "";
    EXPECT_TRUE(hasGpuNode(devices)) << node;
    fs::remove(devices / node);
  }
  EXPECT_FALSE(hasGpuNode(devices));
  fs::remove_all(devices);
}

}  // namespace
}  // namespace viewpeel
