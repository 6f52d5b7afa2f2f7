// SPDX-License-Identifier: Apache-2.0
// The instance, the system, paths, events and time conversion.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <openxr/openxr_reflection.h>

#include "runtime.h"

namespace livegs::simulated {

Runtime& runtime() {
  static Runtime& one = *new Runtime;  // not destroyed: calls may arrive while the process ends
  return one;
}

XrTime now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return kClockAhead_ns + t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

double timeline_s(XrTime time) {
  const Runtime& all = runtime();
  if (all.anchor_ns == 0) return 0;
  return all.anchor_s + std::min(1e-9 * static_cast<double>(time - all.anchor_ns), kMaxFrameWait_s);
}

XrResult misuse(XrResult code, const std::string& what) {
  if (!runtime().record) runtime().record = std::make_unique<Record>();
  runtime().record->misuse(what);
  return code;
}

Instance* find(XrInstance instance) {
  const auto found = runtime().instances.find(instance);
  return found == runtime().instances.end() ? nullptr : &found->second;
}

Instance& the_instance() { return runtime().instances.begin()->second; }

std::string path_string(XrPath path) {
  const Instance& instance = the_instance();
  return path == XR_NULL_PATH || path > instance.paths.size() ? "" : instance.paths[path - 1];
}

bool take_path(const std::string& text, XrPath& path) {
  if (text.size() < 2 || text.size() >= XR_MAX_PATH_LENGTH || text[0] != '/' || text.back() == '/' ||
      text.find("//") != std::string::npos ||
      text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_./") != std::string::npos)
    return false;
  std::vector<std::string>& paths = the_instance().paths;
  for (size_t i = 0; i < paths.size(); ++i) {
    if (paths[i] == text) {
      path = i + 1;
      return true;
    }
  }
  paths.push_back(text);
  path = paths.size();
  return true;
}

void push_event(const void* event, size_t bytes) {
  XrEventDataBuffer buffer{};
  std::memcpy(&buffer, event, bytes);
  the_instance().events.push_back(buffer);
}

}  // namespace livegs::simulated

using namespace livegs::simulated;

namespace {

struct Extension {
  const char* name;
  uint32_t version;
};
constexpr const char* kTouchPlus = "XR_META_touch_controller_plus";
constexpr Extension kExtensions[] = {
    {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, XR_KHR_vulkan_enable2_SPEC_VERSION},
    {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, XR_KHR_convert_timespec_time_SPEC_VERSION},
    {XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, XR_FB_display_refresh_rate_SPEC_VERSION},
    {kTouchPlus, 1},
};

// The extension of the newest controllers is offered only if the headset has these controllers.
bool has(const Extension& extension) {
  return std::strcmp(extension.name, kTouchPlus) != 0 ||
         has_controllers("/interaction_profiles/meta/touch_controller_plus");
}

XrResult check_system(XrInstance instance, XrSystemId system, const char* call) {
  if (!find(instance)) return misuse(XR_ERROR_HANDLE_INVALID, std::string(call) + ": no such instance");
  if (find(instance)->dead) return XR_ERROR_INSTANCE_LOST;
  if (system != kSystem) return misuse(XR_ERROR_SYSTEM_INVALID, std::string(call) + ": no such system");
  return XR_SUCCESS;
}

}  // namespace

XrResult xrEnumerateInstanceExtensionProperties(const char* layer, uint32_t capacity, uint32_t* count,
                                                XrExtensionProperties* properties) {
  if (layer) return XR_ERROR_API_LAYER_NOT_PRESENT;
  std::vector<XrExtensionProperties> all;
  for (const Extension& extension : kExtensions) {
    if (!has(extension)) continue;
    XrExtensionProperties one{XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", extension.version};
    std::snprintf(one.extensionName, sizeof one.extensionName, "%s", extension.name);
    all.push_back(one);
  }
  return fill(capacity, count, properties, all);
}

XrResult xrCreateInstance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  std::lock_guard lock(runtime().mutex);
  Runtime& all = runtime();
  if (!all.record) all.record = std::make_unique<Record>();
  if (!info || info->type != XR_TYPE_INSTANCE_CREATE_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateInstance: not an XrInstanceCreateInfo");
  if (!all.instances.empty())
    return misuse(XR_ERROR_LIMIT_REACHED, "xrCreateInstance: an instance exists already");
  if (XR_VERSION_MAJOR(info->applicationInfo.apiVersion) != 1) return XR_ERROR_API_VERSION_UNSUPPORTED;
  if (info->applicationInfo.applicationName[0] == 0)
    return misuse(XR_ERROR_NAME_INVALID, "xrCreateInstance: no application name");
  Instance made;
  for (uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
    bool known = false;
    for (const Extension& extension : kExtensions)
      known = known || (has(extension) && std::strcmp(extension.name, info->enabledExtensionNames[i]) == 0);
    if (!known) return XR_ERROR_EXTENSION_NOT_PRESENT;
    made.extensions.insert(info->enabledExtensionNames[i]);
  }
  if (const char* path = std::getenv("LIVEGS_XR_TIMELINE"); path) {
    auto timeline = Timeline::read(path);
    if (!timeline) {
      std::fprintf(stderr, "simulated runtime: %s\n", timeline.error().message.c_str());
      return XR_ERROR_RUNTIME_FAILURE;
    }
    all.timeline = *std::move(timeline);
  }
  *instance = new_handle<XrInstance>();
  all.instances.emplace(*instance, std::move(made));
  return XR_SUCCESS;
}

XrResult xrDestroyInstance(XrInstance instance) {
  std::lock_guard lock(runtime().mutex);
  const Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroyInstance: no such instance");
  runtime().record->handles("instance", "session", found->sessions_made, runtime().sessions.size());
  runtime().record->handles("instance", "action set", found->sets_made, found->sets.size());
  runtime().record->handles("instance", "action", found->actions_made, found->actions.size());
  if (!runtime().sessions.empty())
    misuse(XR_ERROR_CALL_ORDER_INVALID,
           "xrDestroyInstance: a session was not destroyed");  // allowed, but a leak of the application's
  for (auto& [handle, session] : runtime().sessions) session.graphics.close();
  runtime().sessions.clear();
  Runtime& all = runtime();
  all.instances.clear();
  all.record.reset();
  all.timeline = {};
  all.anchor_ns = 0;
  all.anchor_s = 0;
  all.played_s = -1;
  all.stage_from_local = kStageFromLocal;
  all.refresh_hz = 90;
  all.compositor_s = all.misjudged_m_s = 0;
  all.frames = 0;
  return XR_SUCCESS;
}

XrResult xrGetInstanceProperties(XrInstance instance, XrInstanceProperties* properties) {
  std::lock_guard lock(runtime().mutex);
  if (!find(instance)) return misuse(XR_ERROR_HANDLE_INVALID, "xrGetInstanceProperties: no such instance");
  properties->runtimeVersion = XR_MAKE_VERSION(0, 1, 0);
  std::snprintf(properties->runtimeName, sizeof properties->runtimeName, "LiveGS simulated runtime");
  return XR_SUCCESS;
}

XrResult xrPollEvent(XrInstance instance, XrEventDataBuffer* event) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrPollEvent: no such instance");
  if (event->type != XR_TYPE_EVENT_DATA_BUFFER)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrPollEvent: type is not EVENT_DATA_BUFFER");
  play_timeline();
  if (found->dead) return XR_ERROR_INSTANCE_LOST;
  if (found->events.empty()) return XR_EVENT_UNAVAILABLE;
  *event = found->events.front();
  found->events.pop_front();
  return XR_SUCCESS;
}

XrResult xrGetSystem(XrInstance instance, const XrSystemGetInfo* info, XrSystemId* system) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrGetSystem: no such instance");
  if (found->dead) return XR_ERROR_INSTANCE_LOST;
  if (!info || info->type != XR_TYPE_SYSTEM_GET_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrGetSystem: not an XrSystemGetInfo");
  if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  if (now() < found->no_headset_until) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
  *system = kSystem;
  return XR_SUCCESS;
}

XrResult xrGetSystemProperties(XrInstance instance, XrSystemId system, XrSystemProperties* properties) {
  std::lock_guard lock(runtime().mutex);
  if (const XrResult wrong = check_system(instance, system, "xrGetSystemProperties"); wrong != XR_SUCCESS)
    return wrong;
  properties->systemId = kSystem;
  properties->vendorId = 0;
  std::snprintf(properties->systemName, sizeof properties->systemName, "simulated headset");
  properties->graphicsProperties = {4096, 4096, XR_MIN_COMPOSITION_LAYERS_SUPPORTED};
  properties->trackingProperties = {XR_TRUE, XR_TRUE};
  return XR_SUCCESS;
}

XrResult xrEnumerateEnvironmentBlendModes(XrInstance instance, XrSystemId system,
                                          XrViewConfigurationType type, uint32_t capacity, uint32_t* count,
                                          XrEnvironmentBlendMode* modes) {
  std::lock_guard lock(runtime().mutex);
  if (const XrResult wrong = check_system(instance, system, "xrEnumerateEnvironmentBlendModes");
      wrong != XR_SUCCESS)
    return wrong;
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  return fill(capacity, count, modes, std::vector{XR_ENVIRONMENT_BLEND_MODE_OPAQUE});
}

XrResult xrEnumerateViewConfigurations(XrInstance instance, XrSystemId system, uint32_t capacity,
                                       uint32_t* count, XrViewConfigurationType* types) {
  std::lock_guard lock(runtime().mutex);
  if (const XrResult wrong = check_system(instance, system, "xrEnumerateViewConfigurations");
      wrong != XR_SUCCESS)
    return wrong;
  return fill(capacity, count, types, std::vector{XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO});
}

XrResult xrGetViewConfigurationProperties(XrInstance instance, XrSystemId system,
                                          XrViewConfigurationType type,
                                          XrViewConfigurationProperties* properties) {
  std::lock_guard lock(runtime().mutex);
  if (const XrResult wrong = check_system(instance, system, "xrGetViewConfigurationProperties");
      wrong != XR_SUCCESS)
    return wrong;
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  properties->viewConfigurationType = type;
  properties->fovMutable = XR_FALSE;
  return XR_SUCCESS;
}

XrResult xrEnumerateViewConfigurationViews(XrInstance instance, XrSystemId system,
                                           XrViewConfigurationType type, uint32_t capacity, uint32_t* count,
                                           XrViewConfigurationView* views) {
  std::lock_guard lock(runtime().mutex);
  if (const XrResult wrong = check_system(instance, system, "xrEnumerateViewConfigurationViews");
      wrong != XR_SUCCESS)
    return wrong;
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  unsigned width = 128, height = 144;
  if (const char* size = std::getenv("LIVEGS_XR_EYE_SIZE")) std::sscanf(size, "%ux%u", &width, &height);
  const XrViewConfigurationView view{
      XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, width, 4096, height, 4096, 1, 1};
  return fill(capacity, count, views, std::vector{view, view});
}

XrResult xrStringToPath(XrInstance instance, const char* text, XrPath* path) {
  std::lock_guard lock(runtime().mutex);
  if (!find(instance)) return misuse(XR_ERROR_HANDLE_INVALID, "xrStringToPath: no such instance");
  return take_path(text, *path)
             ? XR_SUCCESS
             : misuse(XR_ERROR_PATH_FORMAT_INVALID, std::string("xrStringToPath: ") + text);
}

XrResult xrPathToString(XrInstance instance, XrPath path, uint32_t capacity, uint32_t* count, char* text) {
  std::lock_guard lock(runtime().mutex);
  if (!find(instance)) return misuse(XR_ERROR_HANDLE_INVALID, "xrPathToString: no such instance");
  const std::string found = path_string(path);
  if (found.empty()) return misuse(XR_ERROR_PATH_INVALID, "xrPathToString: no such path");
  return fill(capacity, count, text, found + '\0');
}

XrResult xrResultToString(XrInstance, XrResult value, char buffer[XR_MAX_RESULT_STRING_SIZE]) {
  switch (value) {
#define SIMULATED_RESULT(name, number)                             \
  case name:                                                       \
    std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", #name); \
    return XR_SUCCESS;
    XR_LIST_ENUM_XrResult(SIMULATED_RESULT)
#undef SIMULATED_RESULT
  }
  std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "XR_UNKNOWN_%d", value);
  return XR_SUCCESS;
}

XrResult xrStructureTypeToString(XrInstance, XrStructureType value, char buffer[XR_MAX_STRUCTURE_NAME_SIZE]) {
  switch (value) {
#define SIMULATED_TYPE(name, number)                                \
  case name:                                                        \
    std::snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "%s", #name); \
    return XR_SUCCESS;
    XR_LIST_ENUM_XrStructureType(SIMULATED_TYPE)
#undef SIMULATED_TYPE
  }
  std::snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "XR_UNKNOWN_STRUCTURE_%d", value);
  return XR_SUCCESS;
}

XrResult xrConvertTimeToTimespecTimeKHR(XrInstance instance, XrTime time, timespec* converted) {
  std::lock_guard lock(runtime().mutex);
  if (!find(instance))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrConvertTimeToTimespecTimeKHR: no such instance");
  const int64_t ns = time - kClockAhead_ns;
  *converted = {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  return XR_SUCCESS;
}

XrResult xrConvertTimespecTimeToTimeKHR(XrInstance instance, const timespec* time, XrTime* converted) {
  std::lock_guard lock(runtime().mutex);
  if (!find(instance))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrConvertTimespecTimeToTimeKHR: no such instance");
  *converted = kClockAhead_ns + time->tv_sec * 1'000'000'000 + time->tv_nsec;
  return XR_SUCCESS;
}
