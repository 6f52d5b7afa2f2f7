// SPDX-License-Identifier: Apache-2.0
#include "compute/vulkan_device.h"

#include <dlfcn.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "compute/pass.h"
#include "compute/pipeline_cache.h"
#include "compute/vulkan_handles.h"
#include "compute/vulkan_maker.h"
#include "core/log.h"
#include "core/sanitizers.h"
#include "core/user_cache.h"

namespace livegs {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr const char* kDriverRemedy =
    "install the GPU's driver, or the package mesa-vulkan-drivers for a software device";

// The loader is never closed, because drivers leave threads and thread-local destructors behind.
PFN_vkGetInstanceProcAddr open_loader() {
  static void* const library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  return library ? reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"))
                 : nullptr;
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                          VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  static_cast<const VulkanHandles*>(user)->on_validation_message(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(VulkanHandles& handles) {
  auto info = vulkan_info<VkDebugUtilsMessengerCreateInfoEXT>(
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  info.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  info.pfnUserCallback = on_message;
  info.pUserData = &handles;
  return info;
}

bool wants_validation(const VulkanDeviceOptions& options) {
  const char* variable = std::getenv("LIVEGS_VULKAN_VALIDATION");
  return options.validation || (variable && std::string_view(variable) == "1");
}

VkDeviceSize memory_limit(const VulkanDeviceOptions& options) {
  const char* variable = std::getenv("LIVEGS_VULKAN_MEMORY_MB");
  const double megabytes = variable ? std::atof(variable) : 0;
  return megabytes > 0 && megabytes < 1e9 ? static_cast<VkDeviceSize>(megabytes * 1e6)
                                          : options.memory_limit_bytes;
}

Result<void> check_validation_layer(PFN_vkGetInstanceProcAddr get) {
  const auto enumerate = reinterpret_cast<PFN_vkEnumerateInstanceLayerProperties>(
      get(VK_NULL_HANDLE, "vkEnumerateInstanceLayerProperties"));
  uint32_t count = 0;
  std::vector<VkLayerProperties> layers;
  if (enumerate && enumerate(&count, nullptr) == VK_SUCCESS) {
    layers.resize(count);
    if (enumerate(&count, layers.data()) < 0) layers.clear();
  }
  for (const VkLayerProperties& layer : layers) {
    if (std::strcmp(layer.layerName, kValidationLayer) == 0) return {};
  }
  return Error{
      ErrorCode::Unavailable,
      "vulkan: the validation layer is not installed; install vulkan-validationlayers or disable validation"};
}

// The loader reports VK_ERROR_INCOMPATIBLE_DRIVER if it finds no driver, or none that it can open.
Error no_instance(VkResult why) {
  const Error error = vulkan_error("vkCreateInstance", why);
  if (error.code != ErrorCode::Unavailable) return error;
  const std::string what = why == VK_ERROR_INCOMPATIBLE_DRIVER
                               ? "vulkan: no usable driver"
                               : "vulkan: vkCreateInstance failed with VkResult " + std::to_string(why);
  return Error{ErrorCode::Unavailable, what + "; " + kDriverRemedy};
}

Result<void> create_instance(VulkanHandles& handles, const VulkanDeviceOptions& options) {
  const PFN_vkGetInstanceProcAddr get = open_loader();
  if (!get) {
    return Error{ErrorCode::Unavailable,
                 "vulkan: the loader (libvulkan.so.1) is missing; install the package libvulkan1, and " +
                     std::string(kDriverRemedy)};
  }
  handles.get = get;
  const bool validation = wants_validation(options);
  if (validation) {
    if (auto found = check_validation_layer(get); !found) return found;
  }
  const auto enumerate_version =
      reinterpret_cast<PFN_vkEnumerateInstanceVersion>(get(VK_NULL_HANDLE, "vkEnumerateInstanceVersion"));
  uint32_t version = VK_API_VERSION_1_0;
  if (enumerate_version) enumerate_version(&version);
  if (version < VK_API_VERSION_1_3) {
    return Error{ErrorCode::Unavailable,
                 "vulkan: the loader is older than Vulkan 1.3; install a newer libvulkan1"};
  }

  auto application = vulkan_info<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "livegs";
  application.apiVersion = VK_API_VERSION_1_3;
  auto info = vulkan_info<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pApplicationInfo = &application;
  // This chain receives messages about creating and destroying the instance; the messenger receives all
  // others.
  VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(handles);
  const VkValidationFeatureEnableEXT synchronization =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  auto features = vulkan_info<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &synchronization;
  features.pNext = &messenger;
  const std::array extensions{VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  if (validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = extensions.size();
    info.ppEnabledExtensionNames = extensions.data();
  }
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(VK_NULL_HANDLE, "vkCreateInstance"));
  if (const VkResult made = options.maker ? options.maker->create_instance(get, info, &handles.instance)
                                          : create(&info, nullptr, &handles.instance);
      made != VK_SUCCESS) {
    handles.instance = VK_NULL_HANDLE;
    return no_instance(made);
  }

  VulkanFunctions& vk = handles.vk;
#define LIVEGS_LOAD(name) vk.name = reinterpret_cast<PFN_vk##name>(get(handles.instance, "vk" #name));
  LIVEGS_VULKAN_FUNCTIONS(LIVEGS_LOAD)
  if (!validation) return {};
  LIVEGS_LOAD(CreateDebugUtilsMessengerEXT)
  LIVEGS_LOAD(DestroyDebugUtilsMessengerEXT)
  LIVEGS_LOAD(CmdBeginDebugUtilsLabelEXT)
  LIVEGS_LOAD(CmdEndDebugUtilsLabelEXT)
#undef LIVEGS_LOAD
  if (const VkResult made =
          vk.CreateDebugUtilsMessengerEXT(handles.instance, &messenger, nullptr, &handles.messenger);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateDebugUtilsMessengerEXT", made);
  }
  return {};
}

int preference(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    default:
      return 1;
  }
}

// Vulkan 1.3 requires multiview and dynamic rendering, so they are not checked.
bool has_features(const VulkanFunctions& vk, VkPhysicalDevice device) {
  auto features13 =
      vulkan_info<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  auto features = vulkan_info<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  features.pNext = &features13;
  vk.GetPhysicalDeviceFeatures2(device, &features);
  return features13.synchronization2 && features13.maintenance4;
}

bool has_limits(const VkPhysicalDeviceLimits& limits) {
  return limits.maxPerStageDescriptorStorageBuffers >= kMaxPassBuffers &&
         limits.maxPushConstantsSize >= kMaxPassConstantsBytes &&
         limits.maxComputeWorkGroupInvocations >= kMaxPassGroupSize &&
         limits.maxComputeWorkGroupSize[0] >= kMaxPassGroupSize;
}

// The first queue family that supports compute and graphics, otherwise the first with compute. Both support
// transfers.
bool find_queue_family(const VulkanFunctions& vk, VkPhysicalDevice device, uint32_t& family, bool& draws,
                       uint32_t& timestamp_bits) {
  uint32_t count = 0;
  vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (const VkQueueFlags wanted :
       {VkQueueFlags{VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT}, VkQueueFlags{VK_QUEUE_COMPUTE_BIT}}) {
    for (family = 0; family < count; ++family) {
      draws = (wanted & VK_QUEUE_GRAPHICS_BIT) != 0;
      timestamp_bits = families[family].timestampValidBits;
      if ((families[family].queueFlags & wanted) == wanted) return true;
    }
  }
  return false;
}

Result<void> choose_physical_device(VulkanHandles& handles, VulkanMaker* maker) {
  const VulkanFunctions& vk = handles.vk;
  uint32_t count = 0;
  std::vector<VkPhysicalDevice> devices;
  if (maker) {
    if (const VkPhysicalDevice chosen = maker->choose(handles.instance)) devices.push_back(chosen);
  } else if (vk.EnumeratePhysicalDevices(handles.instance, &count, nullptr) == VK_SUCCESS) {
    devices.resize(count);
    if (vk.EnumeratePhysicalDevices(handles.instance, &count, devices.data()) < 0) devices.clear();
  }
  int best = 0;
  for (const VkPhysicalDevice device : devices) {
    VkPhysicalDeviceProperties properties;
    vk.GetPhysicalDeviceProperties(device, &properties);
    uint32_t family = 0, timestamp_bits = 0;
    bool draws = false;
    if (properties.apiVersion < VK_API_VERSION_1_3 || preference(properties.deviceType) <= best ||
        !has_features(vk, device) || !has_limits(properties.limits) ||
        !find_queue_family(vk, device, family, draws, timestamp_bits)) {
      continue;
    }
    best = preference(properties.deviceType);
    handles.physical_device = device;
    handles.properties = properties;
    handles.queue_family = family;
    handles.draws = draws;
    handles.timestamp_bits = timestamp_bits;
  }
  if (best == 0) {
    return Error{ErrorCode::Unavailable, "vulkan: none of " + std::to_string(devices.size()) +
                                             " devices supports compute with Vulkan 1.3; " + kDriverRemedy};
  }
  handles.name = handles.properties.deviceName;
  vk.GetPhysicalDeviceMemoryProperties(handles.physical_device, &handles.memory);
  return {};
}

Result<void> create_device(VulkanHandles& handles, VulkanMaker* maker) {
  const float priority = 1.0f;
  auto queue = vulkan_info<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = handles.queue_family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  auto features13 =
      vulkan_info<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  features13.synchronization2 = VK_TRUE;
  features13.maintenance4 = VK_TRUE;  // a group size by specialization constant is LocalSizeId in SPIR-V 1.6
  features13.dynamicRendering = handles.draws ? VK_TRUE : VK_FALSE;
  auto features11 =
      vulkan_info<VkPhysicalDeviceVulkan11Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
  features11.multiview = handles.draws ? VK_TRUE : VK_FALSE;
  features11.pNext = &features13;
  auto info = vulkan_info<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  info.pNext = &features11;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  if (const VkResult made =
          maker ? maker->create_device(handles.get, handles.physical_device, info, &handles.device)
                : handles.vk.CreateDevice(handles.physical_device, &info, nullptr, &handles.device);
      made != VK_SUCCESS) {
    handles.device = VK_NULL_HANDLE;
    return vulkan_error("vkCreateDevice", made);
  }
  handles.vk.GetDeviceQueue(handles.device, handles.queue_family, 0, &handles.queue);
  return {};
}

}  // namespace

std::filesystem::path user_pipeline_cache_folder() {
  if (const char* folder = std::getenv("LIVEGS_PIPELINE_CACHE"); folder != nullptr && *folder != '\0')
    return folder;
  const auto folder = user_cache_folder();
  return folder ? *folder : std::filesystem::path();
}

VulkanHandles::~VulkanHandles() {
  if (pipeline_cache) vk.DestroyPipelineCache(device, pipeline_cache, nullptr);
  if (device) vk.DestroyDevice(device, nullptr);
  if (messenger) vk.DestroyDebugUtilsMessengerEXT(instance, messenger, nullptr);
  if (instance) vk.DestroyInstance(instance, nullptr);
}

VulkanDevice::VulkanDevice(std::unique_ptr<VulkanHandles> handles) : handles_(std::move(handles)) {}
VulkanDevice::~VulkanDevice() { save_pipeline_cache(*handles_); }

bool VulkanDevice::is_software() const {
  return handles_->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
}
bool VulkanDevice::can_draw() const { return handles_->draws; }
const std::string& VulkanDevice::name() const { return handles_->name; }

Result<std::shared_ptr<VulkanDevice>> VulkanDevice::create(const VulkanDeviceOptions& options) {
  auto handles = std::make_unique<VulkanHandles>();
  handles->on_validation_message = options.on_validation_message;
  if (!handles->on_validation_message) {
    handles->on_validation_message = [](const std::string& message) { log_warn("%s", message.c_str()); };
  }
  handles->memory_limit = memory_limit(options);
  [[maybe_unused]] const IgnoredLeaks of_drivers;  // which keep memory until the process ends
  if (auto made = create_instance(*handles, options); !made) return made.error();
  if (auto chosen = choose_physical_device(*handles, options.maker); !chosen) return chosen.error();
  if (auto made = create_device(*handles, options.maker); !made) return made.error();
  if (auto made = create_pipeline_cache(*handles, options.pipeline_cache_folder); !made) return made.error();
  return std::shared_ptr<VulkanDevice>(new VulkanDevice(std::move(handles)));
}

}  // namespace livegs
