// This Vulkan layer fails on purpose, so that tests see how the program ends. VIEWPEEL_FAULT chooses the failure:
//   lost:N      the device is lost at the N-th submission, from 1, and stays lost
//   memory:N    no memory is left at the N-th allocation and after it
//   space:N     the device has N KiB of memory in all
//   texels:N    devices address N texels of a buffer
//   version     devices speak Vulkan 1.2 only
//   feature     devices lack 64-bit integers in shaders
//   clock       no queue takes timestamps
//   none        there are no devices
// Protocol: Khronos, Vulkan-Loader, LoaderLayerInterface.md, version 2.
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>

namespace {

// The program has one instance and one device at a time.
PFN_vkGetInstanceProcAddr next_instance_proc = nullptr;
PFN_vkGetDeviceProcAddr next_device_proc = nullptr;
VkInstance the_instance = VK_NULL_HANDLE;
VkDevice the_device = VK_NULL_HANDLE;
std::atomic<int> submissions = 0, allocations = 0;
std::mutex space_mutex;
std::map<VkDeviceMemory, VkDeviceSize> allocated;
VkDeviceSize allocated_bytes = 0;

std::string fault() {
  const char* text = std::getenv("VIEWPEEL_FAULT");
  return text ? text : "";
}

// Returns whether `kind` makes the count-th call fail.
bool failsAt(const std::string& kind, int count) {
  const std::string requested = fault();
  return requested.rfind(kind + ":", 0) == 0 && count >= std::strtol(requested.c_str() + kind.size() + 1, nullptr, 10);
}

bool hasSpace(VkDeviceSize size_bytes) {
  const std::string requested = fault();
  return requested.rfind("space:", 0) != 0 ||
         allocated_bytes + size_bytes <= std::strtoull(requested.c_str() + 6, nullptr, 10) << 10;
}

// Next holds the functions of the layer below. They are looked up when instance and device are created, because later
// the loader returns the functions of the topmost layer.
struct Next {
  PFN_vkEnumeratePhysicalDevices enumeratePhysicalDevices;
  PFN_vkGetPhysicalDeviceProperties2 getProperties2;
  PFN_vkGetPhysicalDeviceFeatures2 getFeatures2;
  PFN_vkGetPhysicalDeviceQueueFamilyProperties getQueueFamilies;
  PFN_vkQueueSubmit2 queueSubmit2;
  PFN_vkQueueWaitIdle queueWaitIdle;
  PFN_vkWaitForFences waitForFences;
  PFN_vkAllocateMemory allocateMemory;
  PFN_vkFreeMemory freeMemory;
} next{};

template <class Function>
void findOfInstance(const char* name, Function& function) {
  function = reinterpret_cast<Function>(next_instance_proc(the_instance, name));
}
template <class Function>
void findOfDevice(const char* name, Function& function) {
  function = reinterpret_cast<Function>(next_device_proc(the_device, name));
}

template <class Info>
Info* linkOf(const void* chain, VkStructureType type) {
  auto* info = static_cast<Info*>(const_cast<void*>(chain));
  while (info && !(info->sType == type && info->function == VK_LAYER_LINK_INFO))
    info = static_cast<Info*>(const_cast<void*>(info->pNext));
  return info;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                              VkInstance* instance) {
  auto* link = linkOf<VkLayerInstanceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  if (!link) return VK_ERROR_INITIALIZATION_FAILED;
  next_instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const VkResult result = reinterpret_cast<PFN_vkCreateInstance>(
      next_instance_proc(VK_NULL_HANDLE, "vkCreateInstance"))(info, allocator, instance);
  the_instance = *instance;
  if (result != VK_SUCCESS) return result;
  findOfInstance("vkEnumeratePhysicalDevices", next.enumeratePhysicalDevices);
  findOfInstance("vkGetPhysicalDeviceProperties2", next.getProperties2);
  findOfInstance("vkGetPhysicalDeviceFeatures2", next.getFeatures2);
  findOfInstance("vkGetPhysicalDeviceQueueFamilyProperties", next.getQueueFamilies);
  return result;
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkDevice* device) {
  auto* link = linkOf<VkLayerDeviceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  if (!link) return VK_ERROR_INITIALIZATION_FAILED;
  const auto below = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  next_device_proc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const VkResult result =
      reinterpret_cast<PFN_vkCreateDevice>(below(the_instance, "vkCreateDevice"))(physical, info, allocator, device);
  the_device = *device;
  if (result != VK_SUCCESS) return result;
  findOfDevice("vkQueueSubmit2", next.queueSubmit2);
  findOfDevice("vkQueueWaitIdle", next.queueWaitIdle);
  findOfDevice("vkWaitForFences", next.waitForFences);
  findOfDevice("vkAllocateMemory", next.allocateMemory);
  findOfDevice("vkFreeMemory", next.freeMemory);
  return result;
}

VKAPI_ATTR VkResult VKAPI_CALL enumeratePhysicalDevices(VkInstance instance, uint32_t* count,
                                                        VkPhysicalDevice* devices) {
  if (fault() == "none") {
    *count = 0;
    return VK_SUCCESS;
  }
  return next.enumeratePhysicalDevices(instance, count, devices);
}

VKAPI_ATTR void VKAPI_CALL getProperties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
  next.getProperties2(device, properties);
  if (fault() == "version") properties->properties.apiVersion = VK_API_VERSION_1_2;
  if (const std::string requested = fault(); requested.rfind("texels:", 0) == 0)
    properties->properties.limits.maxTexelBufferElements =
        static_cast<uint32_t>(std::strtoul(requested.c_str() + 7, nullptr, 10));
}

VKAPI_ATTR void VKAPI_CALL getFeatures2(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
  next.getFeatures2(device, features);
  if (fault() == "feature") features->features.shaderInt64 = VK_FALSE;
}

VKAPI_ATTR void VKAPI_CALL getQueueFamilies(VkPhysicalDevice device, uint32_t* count,
                                            VkQueueFamilyProperties* families) {
  next.getQueueFamilies(device, count, families);
  if (families && fault() == "clock")
    for (uint32_t k = 0; k < *count; ++k) families[k].timestampValidBits = 0;
}

VKAPI_ATTR VkResult VKAPI_CALL queueSubmit2(VkQueue queue, uint32_t count, const VkSubmitInfo2* submits,
                                            VkFence fence) {
  if (failsAt("lost", ++submissions)) {
    next.queueWaitIdle(queue);  // nothing runs on a lost device, so that the program may destroy what it used
    return VK_ERROR_DEVICE_LOST;
  }
  return next.queueSubmit2(queue, count, submits, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL waitForFences(VkDevice device, uint32_t count, const VkFence* fences, VkBool32 all,
                                             uint64_t timeout) {
  if (failsAt("lost", submissions)) return VK_ERROR_DEVICE_LOST;
  return next.waitForFences(device, count, fences, all, timeout);
}

VKAPI_ATTR VkResult VKAPI_CALL allocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                              const VkAllocationCallbacks* allocator, VkDeviceMemory* memory) {
  const std::lock_guard lock(space_mutex);
  if (failsAt("memory", ++allocations) || !hasSpace(info->allocationSize)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  const VkResult result = next.allocateMemory(device, info, allocator, memory);
  if (result == VK_SUCCESS) allocated_bytes += allocated[*memory] = info->allocationSize;
  return result;
}

VKAPI_ATTR void VKAPI_CALL freeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* allocator) {
  const std::lock_guard lock(space_mutex);
  if (const auto found = allocated.find(memory); found != allocated.end()) {
    allocated_bytes -= found->second;
    allocated.erase(found);
  }
  next.freeMemory(device, memory, allocator);
}

PFN_vkVoidFunction find(const char* name);

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProcAddr(VkInstance instance, const char* name) {
  if (const auto mine = find(name)) return mine;
  return next_instance_proc ? next_instance_proc(instance, name) : nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProcAddr(VkDevice device, const char* name) {
  if (const auto mine = find(name)) return mine;
  return next_device_proc(device, name);
}

PFN_vkVoidFunction find(const char* name) {
  const struct {
    const char* name;
    PFN_vkVoidFunction function;
  } mine[] = {{"vkGetInstanceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getInstanceProcAddr)},
              {"vkGetDeviceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getDeviceProcAddr)},
              {"vkCreateInstance", reinterpret_cast<PFN_vkVoidFunction>(createInstance)},
              {"vkCreateDevice", reinterpret_cast<PFN_vkVoidFunction>(createDevice)},
              {"vkEnumeratePhysicalDevices", reinterpret_cast<PFN_vkVoidFunction>(enumeratePhysicalDevices)},
              {"vkGetPhysicalDeviceProperties2", reinterpret_cast<PFN_vkVoidFunction>(getProperties2)},
              {"vkGetPhysicalDeviceFeatures2", reinterpret_cast<PFN_vkVoidFunction>(getFeatures2)},
              {"vkGetPhysicalDeviceQueueFamilyProperties", reinterpret_cast<PFN_vkVoidFunction>(getQueueFamilies)},
              {"vkQueueSubmit2", reinterpret_cast<PFN_vkVoidFunction>(queueSubmit2)},
              {"vkWaitForFences", reinterpret_cast<PFN_vkVoidFunction>(waitForFences)},
              {"vkAllocateMemory", reinterpret_cast<PFN_vkVoidFunction>(allocateMemory)},
              {"vkFreeMemory", reinterpret_cast<PFN_vkVoidFunction>(freeMemory)}};
  for (const auto& entry : mine)
    if (std::strcmp(name, entry.name) == 0) return entry.function;
  return nullptr;
}

}  // namespace

extern "C" VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  version->loaderLayerInterfaceVersion = 2;
  version->pfnGetInstanceProcAddr = getInstanceProcAddr;
  version->pfnGetDeviceProcAddr = getDeviceProcAddr;
  version->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}
