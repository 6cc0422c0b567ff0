// listDevices() lists the Vulkan devices of this machine. DeviceOptions choose one.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace viewpeel {

// A DeviceDescription describes one physical device, as `viewpeel devices` lists it.
struct DeviceDescription {
  uint32_t index = 0;
  std::string name;
  std::string kind;     // "discrete gpu", "integrated gpu", "virtual gpu", "cpu", "other"
  std::string driver;   // name and version of the driver
  std::string api;      // Vulkan version
  std::string refusal;  // why the device cannot be used; empty for a usable device
};

// Lists every physical device that the Vulkan loader finds.
//   Out: the devices in the loader's order, usable or not    Error: none.
//   Throws: Error device where there is no Vulkan loader or driver.
//   Cost: loads the drivers, some 10 ms.
std::vector<DeviceDescription> listDevices();

// DeviceOptions choose a device.
struct DeviceOptions {
  // The selector is an index of listDevices(), part of a name, "cpu" or "gpu". Where it is empty, the environment
  // variable VIEWPEEL_DEVICE is the selector. Where that is empty, too, the first device of the best kind is chosen:
  // discrete gpu, integrated gpu, virtual gpu, other, cpu.
  std::string selector;
  // The validation layer runs with synchronisation validation. The environment variable VIEWPEEL_VALIDATION=1 switches
  // it on, too.
  bool validation = false;
};

}  // namespace viewpeel
