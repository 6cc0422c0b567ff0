// hasGpuNode() says whether the machine may have a GPU, without asking Vulkan.
#pragma once
#include <filesystem>

namespace viewpeel {

// Returns whether a folder has the device file of a GPU: those of Linux's graphics drivers, NVIDIA's, AMD's compute
// driver, WSL 2, and drivers of ARM and Qualcomm. Without one no program can use a GPU.
//   In: devices: /dev
bool hasGpuNode(const std::filesystem::path& devices);

}  // namespace viewpeel
