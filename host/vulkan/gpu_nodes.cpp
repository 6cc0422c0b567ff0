#include "vulkan/gpu_nodes.h"

#include <algorithm>
#include <string>

namespace viewpeel {

bool hasGpuNode(const std::filesystem::path& devices) {
  std::error_code error;  // a folder that cannot be read has no device that can be used
  const auto has = [&](const std::filesystem::path& folder, auto&&... prefixes) {
    const std::filesystem::directory_iterator files(folder, error);
    return !error && std::any_of(begin(files), end(files), [&](const std::filesystem::directory_entry& file) {
      const std::string name = file.path().filename();
      return (name.starts_with(prefixes) || ...);
    });
  };
  return has(devices / "dri", "card", "renderD") || has(devices, "nvidia", "kfd", "dxg", "mali", "kgsl");
}

}  // namespace viewpeel
