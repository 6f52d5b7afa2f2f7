// SPDX-License-Identifier: Apache-2.0
#include "xr/openxr/openxr_text_layer.h"

namespace livegs {
namespace {

// The plate is 44 degrees wide, which both eyes of every headset see, and a line is two degrees high. It lies
// below the centre of the view, which stays free.
constexpr float kDistance_m = 1.0f, kBelow_m = 0.2f, kWidth_m = 0.8f;
constexpr std::array<uint8_t, 3> kErrorColour{255, 138, 120};  // the colour of errors in the window's panels

}  // namespace

void OpenXrTextLayer::end() {
  swapchain_.reset();
  if (view_) xrDestroySpace(view_);
  view_ = XR_NULL_HANDLE;
  written_.clear();
}

XrResult OpenXrTextLayer::write(XrSession session) {
  if (!view_) {
    auto space = openxr_info<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_VIEW;
    space.poseInReferenceSpace.orientation.w = 1;
    if (const XrResult made = xrCreateReferenceSpace(session, &space, &view_); XR_FAILED(made)) return made;
  }
  if (!swapchain_) {
    swapchain_.emplace(handles_);
    const XrResult made = swapchain_->create(session, TextPlate::kWidth_px, TextPlate::kMaxHeight_px, 1);
    if (XR_FAILED(made)) return made;
  }
  DeviceImage image;
  if (const XrResult acquired = swapchain_->acquire(image); XR_FAILED(acquired)) return acquired;
  const TextPlate::Picture picture = plate_.draw(text_, kErrorColour);
  const auto uploaded = swapchain_->upload(picture.rgba, picture.width_px, picture.height_px);
  const XrResult released = swapchain_->release();
  if (!uploaded) return XR_ERROR_RUNTIME_FAILURE;
  height_px_ = picture.height_px;
  written_ = text_;
  return released;
}

XrResult OpenXrTextLayer::layer(XrSession session, std::optional<XrCompositionLayerQuad>& layer) {
  layer.reset();
  if (text_.empty()) return XR_SUCCESS;
  if (text_ != written_) {
    if (const XrResult done = write(session); XR_FAILED(done)) return done;
  }
  layer = openxr_info<XrCompositionLayerQuad>(XR_TYPE_COMPOSITION_LAYER_QUAD);
  layer->space = view_;
  layer->eyeVisibility = XR_EYE_VISIBILITY_BOTH;
  layer->subImage = {swapchain_->handle(), {{0, 0}, {TextPlate::kWidth_px, height_px_}}, 0};
  layer->pose = openxr_from_pose({{0, -kBelow_m, -kDistance_m}, Eigen::Quaterniond::Identity()});
  layer->size = {kWidth_m, kWidth_m * static_cast<float>(height_px_) / TextPlate::kWidth_px};
  return XR_SUCCESS;
}

}  // namespace livegs
