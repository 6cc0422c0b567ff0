#include <fmt/core.h>

#include "program/commands.h"
#include "vulkan/device.h"

namespace viewpeel::program {

void addDevices(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("devices", "List the Vulkan devices, and why one cannot be used");
  command->callback([&chosen] {
    chosen = [] {
      for (const DeviceDescription& device : listDevices())
        fmt::print("{}  {}  ({}; {}; Vulkan {})  {}\n", device.index, device.name, device.kind, device.driver,
                   device.api, device.refusal.empty() ? "usable" : "refused: " + device.refusal);
      return 0;
    };
  });
}

}  // namespace viewpeel::program
