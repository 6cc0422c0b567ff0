// This header lists Vulkan devices, and says how one is chosen.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace viewpeel {

// A DeviceDescription is one physical device as `viewpeel devices` lists it.
struct DeviceDescription {
  uint32_t index = 0;
  std::string name;
  std::string kind;     // "discrete gpu", "integrated gpu", "virtual gpu", "cpu", "other"
  std::string driver;   // name and version
  std::string api;      // Vulkan version
  std::string refusal;  // why it cannot be used; empty where it can
};

// Lists every physical device that the Vulkan loader finds.
//   In: nothing    Out: in the loader's order, refused ones too    Error: none.
//   Throws: Error device where there is no Vulkan loader or driver.
//   Cost: loads the drivers, some 10 ms.
std::vector<DeviceDescription> listDevices();

// DeviceOptions choose a device.
struct DeviceOptions {
  // The selector is an index of listDevices(), part of the name, "cpu" or "gpu". Where it is empty, the environment
  // variable VIEWPEEL_DEVICE decides, else the kind: the best one.
  std::string selector;
  // The validation layer runs with synchronisation validation. The environment variable VIEWPEEL_VALIDATION=1 switches
  // it on, too.
  bool validation = false;
};

}  // namespace viewpeel
