// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OpenXR and Vulkan headers for this folder. Each OpenXR call is a function of the same name, hidden in
// the library. negotiate.cpp returns their addresses.

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#define XR_EXTENSION_PROTOTYPES
#define VK_NO_PROTOTYPES
#include <time.h>
#include <vulkan/vulkan.h>
// Must follow the Vulkan header.
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

// clang-format off
#define OPENXR_CALLS(X)                                                                                              \
  X(xrEnumerateInstanceExtensionProperties) X(xrCreateInstance) X(xrDestroyInstance) X(xrGetInstanceProperties)      \
  X(xrPollEvent) X(xrGetSystem) X(xrGetSystemProperties) X(xrEnumerateEnvironmentBlendModes)                         \
  X(xrEnumerateViewConfigurations) X(xrGetViewConfigurationProperties) X(xrEnumerateViewConfigurationViews)          \
  X(xrStringToPath) X(xrPathToString) X(xrResultToString) X(xrStructureTypeToString)                                 \
  X(xrGetVulkanGraphicsRequirements2KHR) X(xrCreateVulkanInstanceKHR) X(xrGetVulkanGraphicsDevice2KHR)               \
  X(xrCreateVulkanDeviceKHR) X(xrConvertTimeToTimespecTimeKHR) X(xrConvertTimespecTimeToTimeKHR)                     \
  X(xrCreateSession) X(xrDestroySession) X(xrBeginSession) X(xrEndSession) X(xrRequestExitSession)                   \
  X(xrWaitFrame) X(xrBeginFrame) X(xrEndFrame)                                                                       \
  X(xrEnumerateDisplayRefreshRatesFB) X(xrGetDisplayRefreshRateFB) X(xrRequestDisplayRefreshRateFB)                  \
  X(xrEnumerateSwapchainFormats) X(xrCreateSwapchain) X(xrDestroySwapchain) X(xrEnumerateSwapchainImages)            \
  X(xrAcquireSwapchainImage) X(xrWaitSwapchainImage) X(xrReleaseSwapchainImage)                                      \
  X(xrEnumerateReferenceSpaces) X(xrCreateReferenceSpace) X(xrGetReferenceSpaceBoundsRect) X(xrCreateActionSpace)    \
  X(xrLocateSpace) X(xrDestroySpace) X(xrLocateViews)                                                                \
  X(xrCreateActionSet) X(xrDestroyActionSet) X(xrCreateAction) X(xrDestroyAction)                                    \
  X(xrSuggestInteractionProfileBindings) X(xrAttachSessionActionSets) X(xrGetCurrentInteractionProfile)              \
  X(xrSyncActions) X(xrGetActionStateBoolean) X(xrGetActionStateFloat) X(xrGetActionStateVector2f)                   \
  X(xrGetActionStatePose) X(xrEnumerateBoundSourcesForAction) X(xrGetInputSourceLocalizedName)                       \
  X(xrApplyHapticFeedback) X(xrStopHapticFeedback)
// clang-format on
