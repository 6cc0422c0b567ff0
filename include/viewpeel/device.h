// Vulkan devices: which there are, and how one is chosen.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace viewpeel {

// One physical device as `viewpeel devices` lists it.
struct DeviceDescription {
  uint32_t index = 0;
  std::string name;
  std::string kind;     // "discrete gpu", "integrated gpu", "virtual gpu", "cpu", "other"
  std::string driver;   // name and version
  std::string api;      // Vulkan version
  std::string refusal;  // why it cannot be used; empty where it can
};

// Lists every physical device that the Vulkan loader finds.
//   Out: in the loader's order, refused ones too
//   Throws: Error device where there is no Vulkan loader or driver.
//   Cost: loads the drivers, some 10 ms.
std::vector<DeviceDescription> listDevices();

// How a device is chosen.
struct DeviceOptions {
  // Index of listDevices(), part of the name, "cpu" or "gpu". Empty: the environment variable VIEWPEEL_DEVICE, else the
  // best by kind.
  std::string selector;
  // Validation layer with synchronisation validation; also switched on by the environment variable
  // VIEWPEEL_VALIDATION=1.
  bool validation = false;
};

}  // namespace viewpeel
