#include "vulkan/device.h"

#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "shaders/double_math.comp.h"
#include "tests/support/test_device.h"
#include "vulkan/buffer.h"
#include "vulkan/commands.h"
#include "vulkan/kernel.h"

namespace viewpeel {
namespace {

TEST(Device, ListNamesEveryDeviceWithItsReason) {
  const auto devices = listDevices();
  ASSERT_FALSE(devices.empty());
  for (size_t k = 0; k < devices.size(); ++k) {
    EXPECT_EQ(devices[k].index, k);
    EXPECT_FALSE(devices[k].name.empty());
    EXPECT_FALSE(devices[k].kind.empty());
  }
}

TEST(Device, ChosenByIndexPartOfTheNameAndKind) {
  const DeviceDescription& first = testDevice().description();
  const std::string index = std::to_string(first.index), part = first.name.substr(1, 4),
                    kind = first.kind == "cpu" ? "cpu" : "gpu";
  for (const std::string& selector : {index, part, kind}) {
    const Device device({.selector = selector, .validation = false});
    EXPECT_EQ(device.description().kind, first.kind) << selector;
    if (selector != kind) {
      EXPECT_EQ(device.description().name, first.name) << selector;
    }
  }
}

TEST(Device, RefusalNamesTheDevicesAndTheReasons) {
  try {
    Device device({.selector = "no such device", .validation = false});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::device);
    const std::string message = error.what();
    EXPECT_NE(message.find("no such device"), std::string::npos);
    EXPECT_NE(message.find(testDevice().description().name), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

// This is the negative control of all device tests: the validation layer reports misuse.
TEST(Device, ValidationSeesMisuse) {
  const Device device({.selector = "", .validation = true});
  ASSERT_TRUE(device.validationEnabled());
  EXPECT_TRUE(device.validationErrors().empty());
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = 0;  // an invalid size
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  VkBuffer buffer = VK_NULL_HANDLE;
  if (vkCreateBuffer(device.handle(), &info, nullptr, &buffer) == VK_SUCCESS)
    vkDestroyBuffer(device.handle(), buffer, nullptr);
  EXPECT_FALSE(device.validationErrors().empty());
}

// Negative control: two transfers to one buffer without a barrier are reported. The layer does not watch accesses of
// shaders by device address.
TEST(Device, ValidationSeesAMissingBarrier) {
  for (bool waits : {true, false}) {
    const Device device({.selector = "", .validation = true});
    const Buffer buffer(device, 256, MemoryUse::device);
    Commands commands(device);
    commands.begin();
    commands.fill(buffer, 1);
    if (waits) commands.barrier();
    commands.fill(buffer, 2);
    commands.submitAndWait();
    EXPECT_EQ(device.validationErrors().empty(), waits);
    for (const std::string& message : device.validationErrors())
      EXPECT_NE(message.find("SYNC-HAZARD-WRITE-AFTER-WRITE"), std::string::npos) << message;
  }
}

TEST(Kernel, KernelsThatAreAlikeShareAPipeline) {
  Device device({.validation = true});
  const auto pipelineOf = [&](uint32_t push_bytes, const std::vector<uint32_t>& constants, uint32_t texel_buffers) {
    return Kernel(device, double_math_comp, push_bytes, constants, texel_buffers).pipeline();
  };
  const VkPipeline first = pipelineOf(20, {}, 0);
  EXPECT_NE(first, VkPipeline(VK_NULL_HANDLE));
  EXPECT_EQ(pipelineOf(20, {}, 0), first);
  const VkPipeline others[] = {pipelineOf(24, {}, 0), pipelineOf(20, {1}, 0), pipelineOf(20, {2}, 0),
                               pipelineOf(20, {}, 1)};
  EXPECT_EQ(device.pipelines().count(), 1 + std::size(others));
  EXPECT_EQ(std::set<VkPipeline>(std::begin(others), std::end(others)).size(), std::size(others));
  // A device that is moved takes its pipelines along.
  const Device moved = std::move(device);
  EXPECT_EQ(Kernel(moved, double_math_comp, 20).pipeline(), first);
  EXPECT_TRUE(moved.validationErrors().empty());
}

TEST(Buffer, ImpossibleSizeIsAnErrorThatNamesIt) {
  try {
    Buffer buffer(testDevice(), VkDeviceSize(1) << 46, MemoryUse::device);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("67108864"), std::string::npos) << error.what();  // the size in MiB
  }
}

}  // namespace
}  // namespace viewpeel
