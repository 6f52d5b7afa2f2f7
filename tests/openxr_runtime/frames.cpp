// SPDX-License-Identifier: Apache-2.0
// The frame loop and the submitted layers.
#include <algorithm>
#include <cmath>
#include <thread>

#include "runtime.h"

namespace livegs::simulated {
namespace {

// A second xrWaitFrame blocks until another thread has begun the first frame. On a single thread it would
// block forever; after this time the call is refused.
constexpr auto kMaxThreadWait = std::chrono::milliseconds(500);
// Rendering must end this long before display, in addition to one period.
constexpr XrTime kMargin_ns = 3'000'000;

uint64_t fnv1a(const std::vector<uint8_t>& bytes) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3;
  return hash;
}

XrResult read_image(Session& session, const XrSwapchainSubImage& image, std::vector<uint8_t>& rgba) {
  const auto swapchain = session.swapchains.find(image.swapchain);
  if (swapchain == session.swapchains.end())
    return misuse(XR_ERROR_HANDLE_INVALID, "xrEndFrame: a layer's swapchain is not valid");
  const Swapchain& chain = swapchain->second;
  if (!chain.released)
    return misuse(XR_ERROR_LAYER_INVALID, "xrEndFrame: no image of a layer's swapchain was released");
  const XrRect2Di& rect = image.imageRect;
  if (rect.offset.x < 0 || rect.offset.y < 0 || rect.extent.width <= 0 || rect.extent.height <= 0 ||
      rect.offset.x + rect.extent.width > static_cast<int>(chain.info.width) ||
      rect.offset.y + rect.extent.height > static_cast<int>(chain.info.height))
    return misuse(XR_ERROR_SWAPCHAIN_RECT_INVALID, "xrEndFrame: a layer's rectangle is not within its image");
  if (image.imageArrayIndex >= chain.info.arraySize)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame: a layer's image has no such layer");
  if (!session.graphics.read(chain.images[*chain.released].image, image.imageArrayIndex, rect, rgba))
    return XR_ERROR_RUNTIME_FAILURE;
  if (chain.info.format == VK_FORMAT_B8G8R8A8_SRGB) {
    for (size_t i = 0; i < rgba.size(); i += 4) std::swap(rgba[i], rgba[i + 2]);
  }
  return XR_SUCCESS;
}

XrResult check_view(Session& session, const XrCompositionLayerProjectionView& view, const Space& space,
                    XrTime time, EyeRecord& eye) {
  Pose space_from_eye, stage_from_space;
  if (!from_xr(view.pose, space_from_eye))
    return misuse(XR_ERROR_POSE_INVALID, "xrEndFrame: a view's pose is not valid");
  if (!(view.fov.angleLeft < view.fov.angleRight) || !(view.fov.angleDown < view.fov.angleUp))
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame: a view's field of view is empty");
  if (!locate(session, space, time, stage_from_space))
    return misuse(XR_ERROR_LAYER_INVALID, "xrEndFrame: the layer's space is unknown");
  eye.pose = to_xr(stage_from_space * space_from_eye);
  eye.fov = view.fov;
  eye.width = view.subImage.imageRect.extent.width;
  eye.height = view.subImage.imageRect.extent.height;
  return read_image(session, view.subImage, eye.rgba);
}

XrResult check_projection(Session& session, const XrCompositionLayerProjection& layer, const Space& space,
                          XrTime time, std::vector<EyeRecord>& eyes) {
  if (!eyes.empty())
    return misuse(XR_ERROR_LAYER_INVALID,
                  "xrEndFrame: a second projection layer, which this runtime does not support");
  if (layer.viewCount != 2 || !layer.views)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame: a projection layer does not have two views");
  for (uint32_t v = 0; v < 2; ++v) {
    if (layer.views[v].type != XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW)
      return misuse(XR_ERROR_VALIDATION_FAILURE,
                    "xrEndFrame: a view is not an XrCompositionLayerProjectionView");
    const XrResult checked = check_view(session, layer.views[v], space, time, eyes.emplace_back());
    if (checked != XR_SUCCESS) return checked;
    if (session.predicted_for == time) eyes.back().prediction = session.predictions[v];
  }
  return XR_SUCCESS;
}

// Draws the quad over the pictures of the eyes: the nearest pixel of the quad at the point that the ray
// through an eye's pixel hits.
XrResult check_quad(Session& session, const XrCompositionLayerQuad& layer, const Space& space, XrTime time,
                    std::vector<EyeRecord>& eyes) {
  Pose space_from_quad, stage_from_space;
  if (!from_xr(layer.pose, space_from_quad))
    return misuse(XR_ERROR_POSE_INVALID, "xrEndFrame: a quad's pose is not valid");
  if (!(layer.size.width > 0) || !(layer.size.height > 0))
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame: a quad's size is not positive");
  if (layer.eyeVisibility != XR_EYE_VISIBILITY_BOTH || layer.layerFlags != 0)
    return misuse(XR_ERROR_LAYER_INVALID,
                  "xrEndFrame: a quad for one eye or with blending, which this runtime does not support");
  if (!locate(session, space, time, stage_from_space))
    return misuse(XR_ERROR_LAYER_INVALID, "xrEndFrame: a quad's space is unknown");
  std::vector<uint8_t> rgba;
  if (const XrResult read = read_image(session, layer.subImage, rgba); read != XR_SUCCESS) return read;
  const int width = layer.subImage.imageRect.extent.width, height = layer.subImage.imageRect.extent.height;
  for (EyeRecord& eye : eyes) {
    Pose stage_from_eye;
    if (!from_xr(eye.pose, stage_from_eye)) return XR_ERROR_RUNTIME_FAILURE;
    const Pose quad_from_eye = (stage_from_space * space_from_quad).inverse() * stage_from_eye;
    const Eigen::Vector3d from = quad_from_eye.position_m;
    const auto slope = [](float low, float high, double share) {
      return std::tan(low) + share * (std::tan(high) - std::tan(low));
    };
    for (int y = 0; y < eye.height; ++y) {
      for (int x = 0; x < eye.width; ++x) {
        const Eigen::Vector3d ray =
            quad_from_eye.orientation *
            Eigen::Vector3d(slope(eye.fov.angleLeft, eye.fov.angleRight, (x + 0.5) / eye.width),
                            slope(eye.fov.angleUp, eye.fov.angleDown, (y + 0.5) / eye.height), -1);
        if (!(from.z() > 0) || !(ray.z() < 0)) continue;  // quads are visible from the front only
        const Eigen::Vector3d met = from - from.z() / ray.z() * ray;
        const int u = static_cast<int>(std::floor((met.x() / layer.size.width + 0.5) * width));
        const int v = static_cast<int>(std::floor((0.5 - met.y() / layer.size.height) * height));
        if (u < 0 || u >= width || v < 0 || v >= height) continue;
        std::copy_n(&rgba[4 * (static_cast<size_t>(v) * width + u)], 4,
                    &eye.rgba[4 * (static_cast<size_t>(y) * eye.width + x)]);
      }
    }
  }
  return XR_SUCCESS;
}

XrResult check_layers(Session& session, const XrFrameEndInfo& info, std::vector<EyeRecord>& eyes) {
  if (info.layerCount > XR_MIN_COMPOSITION_LAYERS_SUPPORTED)
    return misuse(XR_ERROR_LAYER_LIMIT_EXCEEDED, "xrEndFrame: more layers than the system supports");
  if (info.layerCount > 0 && !info.layers)
    return misuse(XR_ERROR_LAYER_INVALID, "xrEndFrame: layerCount is not 0, but layers is null");
  for (uint32_t i = 0; i < info.layerCount; ++i) {
    const XrCompositionLayerBaseHeader* header = info.layers[i];
    if (!header || (header->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION &&
                    header->type != XR_TYPE_COMPOSITION_LAYER_QUAD))
      return misuse(XR_ERROR_LAYER_INVALID, "xrEndFrame: a layer is neither a projection nor a quad");
    const auto space = session.spaces.find(header->space);
    if (space == session.spaces.end())
      return misuse(XR_ERROR_HANDLE_INVALID, "xrEndFrame: a layer's space is not valid");
    const XrResult checked =
        header->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION
            ? check_projection(session, *reinterpret_cast<const XrCompositionLayerProjection*>(header),
                               space->second, info.displayTime, eyes)
            : check_quad(session, *reinterpret_cast<const XrCompositionLayerQuad*>(header), space->second,
                         info.displayTime, eyes);
    if (checked != XR_SUCCESS) return checked;
  }
  for (EyeRecord& eye : eyes) eye.hash = fnv1a(eye.rgba);
  return XR_SUCCESS;
}

}  // namespace
}  // namespace livegs::simulated

using namespace livegs::simulated;

XrResult xrWaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state) {
  XrTime displayed = 0, period = 0, slow = 0;
  {
    std::unique_lock lock(runtime().mutex);
    Session* found = find(session);
    if (const auto refused = refuse(found, "xrWaitFrame")) return *refused;
    if (info && info->type != XR_TYPE_FRAME_WAIT_INFO)
      return misuse(XR_ERROR_VALIDATION_FAILURE, "xrWaitFrame: not an XrFrameWaitInfo");
    if (!state || state->type != XR_TYPE_FRAME_STATE)
      return misuse(XR_ERROR_VALIDATION_FAILURE, "xrWaitFrame: not an XrFrameState");
    if (!found->running)
      return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrWaitFrame: the session is not running");
    if (found->waited) {
      runtime().frame_begun.wait_for(lock, kMaxThreadWait,
                                     [&] { return !find(session) || !find(session)->waited; });
      found = find(session);
      if (const auto refused = refuse(found, "xrWaitFrame")) return *refused;
      if (found->waited)
        return misuse(XR_ERROR_CALL_ORDER_INVALID, "xrWaitFrame: called twice without xrBeginFrame");
      if (!found->running)
        return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrWaitFrame: the session is not running");
    }
    found->waited = true;
    period = std::llround(1e9 / runtime().refresh_hz);
    slow = std::llround(1e9 * runtime().compositor_s);
    // The next display time that leaves one period and the margin, and that no other frame has.
    const XrTime earliest = std::max(now() + period + kMargin_ns + slow, found->last_display_time + 1);
    displayed = (earliest + period - 1) / period * period;
    found->last_display_time = displayed;
  }
  std::this_thread::sleep_for(
      std::chrono::nanoseconds(std::max<XrTime>(0, displayed - period - kMargin_ns - now())));
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrWaitFrame")) return *refused;
  play_timeline();
  if (const auto refused = refuse(found, "xrWaitFrame")) return *refused;
  found->waited_for.insert(displayed);
  found->waited_s = timeline_s(now());
  state->predictedDisplayTime = displayed;
  state->predictedDisplayPeriod = period;
  state->shouldRender = found->state == XR_SESSION_STATE_VISIBLE || found->state == XR_SESSION_STATE_FOCUSED;
  return success(*found);
}

XrResult xrBeginFrame(XrSession session, const XrFrameBeginInfo*) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrBeginFrame")) return *refused;
  if (!found->running)
    return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrBeginFrame: the session is not running");
  if (!found->waited) return misuse(XR_ERROR_CALL_ORDER_INVALID, "xrBeginFrame: called without xrWaitFrame");
  found->waited = false;
  runtime().frame_begun.notify_all();
  if (std::exchange(found->begun, true))
    return misuse(XR_FRAME_DISCARDED, "xrBeginFrame: the previous frame was not ended");
  return success(*found);
}

XrResult xrEndFrame(XrSession session, const XrFrameEndInfo* info) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrEndFrame")) return *refused;
  if (!info || info->type != XR_TYPE_FRAME_END_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrEndFrame: not an XrFrameEndInfo");
  if (!found->running) return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrEndFrame: the session is not running");
  if (!std::exchange(found->begun, false))
    return misuse(XR_ERROR_CALL_ORDER_INVALID, "xrEndFrame: called without xrBeginFrame");
  if (!found->waited_for.contains(info->displayTime))
    return misuse(XR_ERROR_TIME_INVALID,
                  "xrEndFrame: displayTime is not that of the frame that was waited for");
  if (info->environmentBlendMode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE)
    return misuse(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED,
                  "xrEndFrame: the blend mode was not enumerated");
  std::vector<EyeRecord> eyes;
  const XrResult checked = check_layers(*found, *info, eyes);
  found->waited_for.erase(found->waited_for.begin(), found->waited_for.upper_bound(info->displayTime));
  if (checked != XR_SUCCESS) return checked;
  if (!eyes.empty() || runtime().anchor_ns != 0) {
    const XrTime ended = now();
    runtime().anchor_s = timeline_s(ended);
    runtime().anchor_ns = ended;
  }
  ++found->frames_in_state;
  const bool keep = found->keep_next && !eyes.empty();
  if (keep) found->keep_next = false;
  runtime().record->frame(runtime().frames++, found->waited_s, timeline_s(now()),
                          timeline_s(info->displayTime), eyes, keep);
  // The loss follows one or two frames after the warning.
  if (found->loss == Session::Loss::Pending && found->frames_in_state >= 2) found->loss = Session::Loss::Lost;
  return success(*found);
}
