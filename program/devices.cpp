#include <fmt/core.h>

#include "program/commands.h"
#include "program/option_table.h"
#include "program/options.h"
#include "program/result_json.h"
#include "vulkan/device.h"

namespace viewpeel::program {

void addDevices(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand("devices", "List the Vulkan devices, and why one cannot be used");
  const auto as_json = std::make_shared<bool>(false);
  startGroup(command, kOutput);
  command->add_flag("--json", *as_json, kJsonHelp);
  command->callback([&chosen, as_json] {
    chosen = [as_json] {
      if (*as_json) {
        Json report = startReport(), devices = Json::array();
        for (const DeviceDescription& device : listDevices()) devices.push_back(jsonOf(device));
        report["devices"] = std::move(devices);
        printReport(std::move(report));
        return 0;
      }
      for (const DeviceDescription& device : listDevices())
        fmt::print("{}  {}  ({}; {}; Vulkan {})  {}\n", device.index, device.name, device.kind, device.driver,
                   device.api, device.refusal.empty() ? "usable" : "refused: " + device.refusal);
      return 0;
    };
  });
}

}  // namespace viewpeel::program
