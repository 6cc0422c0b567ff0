// A Device is a Vulkan device with one queue for compute, graphics and transfers. Unless the user names it, its kind
// decides: discrete GPUs before integrated ones, CPUs last.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include <volk.h>

#include <viewpeel/device.h>

namespace viewpeel {

class ComputePipelines;

class Device {
 public:
  // Throws: Error device where no device will do; it names every device and why it was refused.
  explicit Device(const DeviceOptions& options = {});
  ~Device();
  Device(Device&&) noexcept;
  Device& operator=(Device&&) noexcept;

  VkDevice handle() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  VkQueue queue() const { return queue_; }
  uint32_t queueFamily() const { return queue_family_; }
  const DeviceDescription& description() const { return description_; }
  const VkPhysicalDeviceProperties& properties() const { return properties_; }
  // Returns the size of the largest single buffer or image allocation.
  VkDeviceSize maxAllocationBytes() const { return max_allocation_bytes_; }
  // Returns the size of the device's memory, or of the machine's memory where the device is a CPU.
  uint64_t memoryBytes() const;
  // Returns the index of a memory type that has all of `flags`.
  //   In: allowed: bit k is set where type k may be taken    Throws: Error device where there is none.
  uint32_t memoryType(uint32_t allowed, VkMemoryPropertyFlags flags) const;

  // Returns the compute pipelines that were made on this device. They live as long as the device.
  ComputePipelines& pipelines() const { return *pipelines_; }

  // Returns the validation layer's errors since the device was made: none when validation is off.
  const std::vector<std::string>& validationErrors() const;
  bool validationEnabled() const { return messenger_ != VK_NULL_HANDLE; }

 private:
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  uint32_t queue_family_ = 0;
  VkDeviceSize max_allocation_bytes_ = 0;
  VkPhysicalDeviceProperties properties_{};
  DeviceDescription description_;
  std::unique_ptr<std::vector<std::string>> validation_errors_;
  std::unique_ptr<ComputePipelines> pipelines_;
};

// Checks the result of a Vulkan call.
//   Throws: Error memory where the device is out of memory, Error device for other errors; both name the call.
void check(VkResult result, const char* call);

}  // namespace viewpeel
