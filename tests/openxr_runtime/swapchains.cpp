// SPDX-License-Identifier: Apache-2.0
#include "runtime.h"

namespace livegs::simulated {
namespace {

constexpr uint32_t kImages = 3;
constexpr int64_t kFormats[] = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R8G8B8A8_UNORM};

Swapchain* find(XrSwapchain swapchain) {
  Session* session = session_of(swapchain);
  return session ? &session->swapchains.find(swapchain)->second : nullptr;
}

}  // namespace

Session* session_of(XrSwapchain swapchain) {
  for (auto& [handle, session] : runtime().sessions) {
    if (session.swapchains.contains(swapchain)) return &session;
  }
  return nullptr;
}

}  // namespace livegs::simulated

using namespace livegs::simulated;

XrResult xrEnumerateSwapchainFormats(XrSession session, uint32_t capacity, uint32_t* count,
                                     int64_t* formats) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrEnumerateSwapchainFormats")) return *refused;
  return fill(capacity, count, formats, kFormats);
}

XrResult xrCreateSwapchain(XrSession session, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrCreateSwapchain")) return *refused;
  if (!info || info->type != XR_TYPE_SWAPCHAIN_CREATE_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateSwapchain: not an XrSwapchainCreateInfo");
  bool known = false;
  for (const int64_t format : kFormats) known = known || format == info->format;
  if (!known)
    return misuse(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, "xrCreateSwapchain: the format was not enumerated");
  if (info->width == 0 || info->height == 0 || info->width > 4096 || info->height > 4096 ||
      info->sampleCount == 0 || info->arraySize == 0 || info->mipCount == 0 ||
      (info->faceCount != 1 && info->faceCount != 6))
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateSwapchain: the image size is zero");
  constexpr XrSwapchainUsageFlags kUsages =
      XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT |
      XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT;
  if (info->sampleCount != 1 || info->faceCount != 1 || info->mipCount != 1 || info->createFlags != 0 ||
      (info->usageFlags & ~kUsages) != 0)
    return misuse(XR_ERROR_FEATURE_UNSUPPORTED,
                  "xrCreateSwapchain: samples, faces, mips, flags or usages that are not supported");
  Swapchain made{*info, {}, {}, false, 0, {}};
  made.info.next = nullptr;
  for (uint32_t i = 0; i < kImages; ++i) {
    if (!found->graphics.make_image(*info, made.images.emplace_back())) return XR_ERROR_RUNTIME_FAILURE;
  }
  *swapchain = new_handle<XrSwapchain>();
  ++found->swapchains_made;
  found->swapchains.emplace(*swapchain, std::move(made));
  return success(*found);
}

XrResult xrDestroySwapchain(XrSwapchain swapchain) {
  std::lock_guard lock(runtime().mutex);
  Session* session = session_of(swapchain);
  if (!session) return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroySwapchain: no such swapchain");
  for (SwapchainImage& image : session->swapchains.find(swapchain)->second.images)
    session->graphics.destroy(image);
  session->swapchains.erase(swapchain);
  return XR_SUCCESS;
}

XrResult xrEnumerateSwapchainImages(XrSwapchain swapchain, uint32_t capacity, uint32_t* count,
                                    XrSwapchainImageBaseHeader* images) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(session_of(swapchain), "xrEnumerateSwapchainImages")) return *refused;
  const Swapchain& found = *find(swapchain);
  *count = kImages;
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < kImages) return XR_ERROR_SIZE_INSUFFICIENT;
  auto* made = reinterpret_cast<XrSwapchainImageVulkan2KHR*>(images);
  for (uint32_t i = 0; i < kImages; ++i) {
    if (made[i].type != XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR)
      return misuse(XR_ERROR_VALIDATION_FAILURE,
                    "xrEnumerateSwapchainImages: not XrSwapchainImageVulkan2KHR");
    made[i].image = found.images[i].image;
  }
  return XR_SUCCESS;
}

XrResult xrAcquireSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*, uint32_t* index) {
  std::lock_guard lock(runtime().mutex);
  Session* session = session_of(swapchain);
  if (const auto refused = refuse(session, "xrAcquireSwapchainImage")) return *refused;
  Swapchain& found = *find(swapchain);
  if (found.acquired.size() == kImages)
    return misuse(XR_ERROR_CALL_ORDER_INVALID, "xrAcquireSwapchainImage: all images are acquired");
  *index = found.next;
  found.next = (found.next + 1) % kImages;
  found.acquired.push_back(*index);
  return success(*session);
}

XrResult xrWaitSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageWaitInfo* info) {
  std::lock_guard lock(runtime().mutex);
  Session* session = session_of(swapchain);
  if (const auto refused = refuse(session, "xrWaitSwapchainImage")) return *refused;
  if (!info || info->type != XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrWaitSwapchainImage: not an XrSwapchainImageWaitInfo");
  Swapchain& found = *find(swapchain);
  if (found.acquired.empty() || found.waited)
    return misuse(XR_ERROR_CALL_ORDER_INVALID, "xrWaitSwapchainImage: no image to wait for");
  found.waited = true;
  return success(*session);
}

XrResult xrReleaseSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo*) {
  std::lock_guard lock(runtime().mutex);
  Session* session = session_of(swapchain);
  if (const auto refused = refuse(session, "xrReleaseSwapchainImage")) return *refused;
  Swapchain& found = *find(swapchain);
  if (!found.waited)
    return misuse(XR_ERROR_CALL_ORDER_INVALID, "xrReleaseSwapchainImage: no image was waited for");
  found.waited = false;
  found.released = found.acquired.front();
  found.acquired.pop_front();
  return success(*session);
}
