#define VOLK_IMPLEMENTATION
#include "vulkan/device.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include <viewpeel/error.h>

#include "vulkan/kernel.h"

namespace viewpeel {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

// Features has the structs in which Vulkan reports and enables features. kNeededFeatures names the features that a
// device must have; the same table serves to check a device and to enable them.
struct Features {
  VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, nullptr};
  VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &v13};
  VkPhysicalDeviceFeatures2 v10{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &v12};
  Features() = default;
  Features(const Features&) = delete;  // its structs point to each other
};

constexpr const char* kNeededExtension = VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME;

struct NeededFeature {
  const char* name;
  VkBool32& (*in)(Features&);
};

constexpr NeededFeature kNeededFeatures[] = {
    {"shaderInt64", [](Features& f) -> VkBool32& { return f.v10.features.shaderInt64; }},
    {"shaderFloat64", [](Features& f) -> VkBool32& { return f.v10.features.shaderFloat64; }},
    {"shaderBufferInt64Atomics", [](Features& f) -> VkBool32& { return f.v12.shaderBufferInt64Atomics; }},
    {"bufferDeviceAddress", [](Features& f) -> VkBool32& { return f.v12.bufferDeviceAddress; }},
    {"scalarBlockLayout", [](Features& f) -> VkBool32& { return f.v12.scalarBlockLayout; }},
    {"synchronization2", [](Features& f) -> VkBool32& { return f.v13.synchronization2; }},
    {"maintenance4", [](Features& f) -> VkBool32& { return f.v13.maintenance4; }},
    {"dynamicRendering", [](Features& f) -> VkBool32& { return f.v13.dynamicRendering; }},
};

void initialiseLoader() {
  if (volkInitialize() != VK_SUCCESS)
    throw Error(ErrorCode::device,
                "no Vulkan loader found; install libvulkan1 and a driver such as mesa-vulkan-drivers");
}

bool hasLayer(const char* name) {
  uint32_t count = 0;
  check(vkEnumerateInstanceLayerProperties(&count, nullptr), "vkEnumerateInstanceLayerProperties");
  std::vector<VkLayerProperties> layers(count);
  check(vkEnumerateInstanceLayerProperties(&count, layers.data()), "vkEnumerateInstanceLayerProperties");
  return std::any_of(layers.begin(), layers.end(), [&](const auto& l) { return std::strcmp(l.layerName, name) == 0; });
}

VKAPI_ATTR VkBool32 VKAPI_CALL recordMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                             const VkDebugUtilsMessengerCallbackDataEXT* data, void* messages) {
  static_cast<std::vector<std::string>*>(messages)->push_back(data->pMessage);
  return VK_FALSE;
}

VkInstance createInstance(bool validation) {
  initialiseLoader();
  if (validation && !hasLayer(kValidationLayer))
    throw Error(ErrorCode::device,
                "validation was asked for but the layer is missing; install vulkan-validationlayers");
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "viewpeel";
  application.apiVersion = VK_API_VERSION_1_3;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;
  if (validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance);
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    throw Error(ErrorCode::device, "no Vulkan driver found; install one, such as mesa-vulkan-drivers for the CPU");
  check(result, "vkCreateInstance");
  volkLoadInstance(instance);
  return instance;
}

std::vector<VkPhysicalDevice> physicalDevices(VkInstance instance) {
  uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
  if (devices.empty())
    throw Error(ErrorCode::device, "no Vulkan driver found; install one, such as mesa-vulkan-drivers for the CPU");
  return devices;
}

const char* kindName(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete gpu";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated gpu";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual gpu";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "cpu";
    default:
      return "other";
  }
}

std::string versionName(uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

// Returns the index of a queue family for both graphics and compute, or -1.
int findQueueFamily(VkPhysicalDevice device) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (uint32_t k = 0; k < count; ++k)
    if ((families[k].queueFlags & kNeeded) == kNeeded) return static_cast<int>(k);
  return -1;
}

bool hasExtension(VkPhysicalDevice device, const char* name) {
  uint32_t count = 0;
  check(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr), "vkEnumerateDeviceExtensionProperties");
  std::vector<VkExtensionProperties> extensions(count);
  check(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()),
        "vkEnumerateDeviceExtensionProperties");
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

std::string findRefusal(VkPhysicalDevice device, uint32_t api_version) {
  if (api_version < VK_API_VERSION_1_3) return "needs Vulkan 1.3";
  if (findQueueFamily(device) < 0) return "no queue for graphics and compute";
  Features have;
  vkGetPhysicalDeviceFeatures2(device, &have.v10);
  std::string missing;
  if (!hasExtension(device, kNeededExtension)) missing = fmt::format("lacks {}", kNeededExtension);
  for (const NeededFeature& needed : kNeededFeatures)
    if (!needed.in(have)) missing += fmt::format("{}{}", missing.empty() ? "lacks " : ", ", needed.name);
  return missing;
}

DeviceDescription describe(VkPhysicalDevice device, uint32_t index) {
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
  vkGetPhysicalDeviceProperties2(device, &properties);
  const VkPhysicalDeviceProperties& p = properties.properties;
  return {index,
          p.deviceName,
          kindName(p.deviceType),
          fmt::format("{} {}", driver.driverName, driver.driverInfo),
          versionName(p.apiVersion),
          findRefusal(device, p.apiVersion)};
}

int rankOfKind(const std::string& kind) {
  constexpr std::array kRanks = {"discrete gpu", "integrated gpu", "virtual gpu", "other", "cpu"};
  return static_cast<int>(std::find(kRanks.begin(), kRanks.end(), kind) - kRanks.begin());
}

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool matches(const DeviceDescription& device, const std::string& selector) {
  if (selector.empty()) return true;
  uint32_t index = 0;
  const auto parsed = std::from_chars(selector.data(), selector.data() + selector.size(), index);
  if (parsed.ec == std::errc() && parsed.ptr == selector.data() + selector.size()) return device.index == index;
  const std::string wanted = lowerCase(selector);
  if (wanted == "cpu") return device.kind == "cpu";
  if (wanted == "gpu") return device.kind.ends_with("gpu");
  return lowerCase(device.name).find(wanted) != std::string::npos;
}

const DeviceDescription& chooseDevice(const std::vector<DeviceDescription>& devices, const std::string& selector) {
  const DeviceDescription* best = nullptr;
  std::string reasons;
  for (const DeviceDescription& device : devices) {
    const std::string reason = !matches(device, selector) ? "not asked for" : device.refusal;
    reasons += fmt::format("{}{}: {} ({})", reasons.empty() ? "" : "; ", device.index, device.name, reason);
    if (reason.empty() && (!best || rankOfKind(device.kind) < rankOfKind(best->kind))) best = &device;
  }
  if (!best)
    throw Error(ErrorCode::device, fmt::format("no usable device{}: {}; see 'viewpeel devices'",
                                               selector.empty() ? "" : " for '" + selector + "'", reasons));
  return *best;
}

}  // namespace

void check(VkResult result, const char* call) {
  if (result >= 0) return;
  const char* meaning =
      result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? ": out of device memory; try a smaller --resolution or scene"
      : result == VK_ERROR_OUT_OF_HOST_MEMORY ? ": out of host memory"
      : result == VK_ERROR_DEVICE_LOST        ? ": the device was lost; run again, or choose another with --device"
                                              : "";
  throw Error(result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? ErrorCode::memory : ErrorCode::device,
              fmt::format("{} failed with VkResult {}{}", call, static_cast<int>(result), meaning));
}

std::vector<DeviceDescription> listDevices() {
  const VkInstance instance = createInstance(false);
  std::vector<DeviceDescription> descriptions;
  for (VkPhysicalDevice device : physicalDevices(instance))
    descriptions.push_back(describe(device, static_cast<uint32_t>(descriptions.size())));
  vkDestroyInstance(instance, nullptr);
  return descriptions;
}

Device::Device(const DeviceOptions& options)
    : validation_errors_(std::make_unique<std::vector<std::string>>()),
      pipelines_(std::make_unique<ComputePipelines>()) {
  const char* wanted = std::getenv("VIEWPEEL_VALIDATION");
  const bool validation = options.validation || (wanted && std::strcmp(wanted, "1") == 0);
  instance_ = createInstance(validation);
  if (validation) {
    VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
    info.pfnUserCallback = recordMessage;
    info.pUserData = validation_errors_.get();
    check(vkCreateDebugUtilsMessengerEXT(instance_, &info, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
  }

  std::string selector = options.selector;
  if (const char* environment = std::getenv("VIEWPEEL_DEVICE"); selector.empty() && environment) selector = environment;
  const std::vector<VkPhysicalDevice> candidates = physicalDevices(instance_);
  std::vector<DeviceDescription> descriptions;
  for (VkPhysicalDevice candidate : candidates)
    descriptions.push_back(describe(candidate, static_cast<uint32_t>(descriptions.size())));
  description_ = chooseDevice(descriptions, selector);
  physical_ = candidates[description_.index];
  VkPhysicalDeviceMaintenance3Properties maintenance{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &maintenance};
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  properties_ = properties.properties;
  max_allocation_bytes_ = maintenance.maxMemoryAllocationSize;

  queue_family_ = static_cast<uint32_t>(findQueueFamily(physical_));
  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  Features features;
  for (const NeededFeature& needed : kNeededFeatures) needed.in(features) = VK_TRUE;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features.v10};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = 1;
  info.ppEnabledExtensionNames = &kNeededExtension;
  check(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
}

Device::~Device() {
  if (device_) {
    vkDeviceWaitIdle(device_);
    pipelines_.reset();
    vkDestroyDevice(device_, nullptr);
  }
  // The function is looked up in this instance: the global pointer belongs to the instance that was made last.
  const auto destroy_messenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
      instance_ ? vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT") : nullptr);
  if (messenger_) destroy_messenger(instance_, messenger_, nullptr);
  if (instance_) vkDestroyInstance(instance_, nullptr);
}

Device::Device(Device&& other) noexcept { *this = std::move(other); }

Device& Device::operator=(Device&& other) noexcept {
  std::swap(instance_, other.instance_);
  std::swap(messenger_, other.messenger_);
  std::swap(physical_, other.physical_);
  std::swap(device_, other.device_);
  std::swap(queue_, other.queue_);
  std::swap(queue_family_, other.queue_family_);
  std::swap(max_allocation_bytes_, other.max_allocation_bytes_);
  std::swap(properties_, other.properties_);
  std::swap(description_, other.description_);
  std::swap(validation_errors_, other.validation_errors_);
  std::swap(pipelines_, other.pipelines_);
  return *this;
}

uint64_t Device::memoryBytes() const {
  if (properties_.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU)
    return uint64_t(sysconf(_SC_PHYS_PAGES)) * uint64_t(sysconf(_SC_PAGESIZE));
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
  uint64_t largest = 0;
  for (uint32_t k = 0; k < memory.memoryHeapCount; ++k)
    if (memory.memoryHeaps[k].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      largest = std::max<uint64_t>(largest, memory.memoryHeaps[k].size);
  return largest;
}

uint32_t Device::memoryType(uint32_t allowed, VkMemoryPropertyFlags flags) const {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
  for (uint32_t k = 0; k < memory.memoryTypeCount; ++k)
    if ((allowed >> k & 1) && (memory.memoryTypes[k].propertyFlags & flags) == flags) return k;
  throw Error(ErrorCode::device, fmt::format("{} has no memory with property flags {}; choose another --device",
                                             description_.name, flags));
}

const std::vector<std::string>& Device::validationErrors() const { return *validation_errors_; }

}  // namespace viewpeel
