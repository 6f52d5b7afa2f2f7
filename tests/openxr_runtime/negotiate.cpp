// SPDX-License-Identifier: Apache-2.0
// The only exported function, through which the OpenXR loader gets all others. Declared here because Debian
// does not package openxr_loader_negotiation.h. Source: "Runtime Interface Negotiation" in the loader
// specification.
#include <cstring>

#include "runtime.h"

namespace {

struct NegotiateLoaderInfo {
  uint32_t structType, structVersion;
  size_t structSize;
  uint32_t minInterfaceVersion, maxInterfaceVersion;
  XrVersion minApiVersion, maxApiVersion;
};
struct NegotiateRuntimeRequest {
  uint32_t structType, structVersion;
  size_t structSize;
  uint32_t runtimeInterfaceVersion;
  XrVersion runtimeApiVersion;
  PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};
constexpr uint32_t kLoaderInfo = 1, kRuntimeRequest = 3, kVersion = 1;

XrResult XRAPI_CALL get_instance_proc_addr(XrInstance, const char* name, PFN_xrVoidFunction* function) {
  *function = nullptr;
  if (std::strcmp(name, "xrGetInstanceProcAddr") == 0)
    *function = reinterpret_cast<PFN_xrVoidFunction>(get_instance_proc_addr);
#define SIMULATED_FIND(call) \
  if (std::strcmp(name, #call) == 0) *function = reinterpret_cast<PFN_xrVoidFunction>(call);
  OPENXR_CALLS(SIMULATED_FIND)
#undef SIMULATED_FIND
  return *function ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderRuntimeInterface(const NegotiateLoaderInfo* info, NegotiateRuntimeRequest* request) {
  if (!info || info->structType != kLoaderInfo || info->structSize != sizeof *info || !request ||
      request->structType != kRuntimeRequest || request->structSize != sizeof *request ||
      info->minInterfaceVersion > kVersion || info->maxInterfaceVersion < kVersion)
    return XR_ERROR_INITIALIZATION_FAILED;
  request->runtimeInterfaceVersion = kVersion;
  request->runtimeApiVersion = XR_CURRENT_API_VERSION;
  request->getInstanceProcAddr = get_instance_proc_addr;
  return XR_SUCCESS;
}
