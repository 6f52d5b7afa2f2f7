// SPDX-License-Identifier: Apache-2.0
// OpenXR 1.0: session states (section 9.3), the frame loop (10.4), loss of a session (9.5).
#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "core/clock.h"
#include "core/log.h"
#include "xr/headset_display.h"
#include "xr/openxr/openxr_hands.h"
#include "xr/openxr/openxr_instance.h"
#include "xr/openxr/openxr_swapchain.h"
#include "xr/openxr/openxr_text_layer.h"

namespace livegs {
namespace {

constexpr XrViewConfigurationType kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
constexpr int64_t kRetry_ns = 500'000'000;  // between attempts to find a lost headset
constexpr int64_t kPoll_ns = 20'000'000;    // while there is nothing to draw
constexpr int64_t kFinish_ns = 2'000'000'000;

class OpenXrDisplay final : public HeadsetDisplay {
 public:
  ~OpenXrDisplay() override { end_session(); }
  Result<void> create(VulkanDeviceOptions options);

  std::optional<PlannedFrame> wait_frame() override;
  Result<void> submit(const PlannedFrame& frame, std::span<const Image> images) override;
  Result<void> finish() override;

  const std::string& runtime_name() const override { return instance_->name(); }
  std::shared_ptr<VulkanDevice> device() const override { return device_; }
  void set_scene_from_local(const Pose& scene_from_local) override { scene_from_local_ = scene_from_local; }
  void set_scale(double scale) override { scale_ = std::clamp(scale, 0.25, 1.0); }
  const HeadsetInput& input() const override { return input_; }
  double period_s() const override { return period_s_; }
  void set_notice(const std::string& text) override { plate_->set(text); }
  void update_views(PlannedFrame& frame) override;
  bool update_input() override;
  std::optional<DeviceImage> acquire() override;
  void vibrate(size_t hand, float amplitude, double seconds) override;
  const Counts& counts() const override { return counts_; }

 private:
  bool ok(XrResult result, const char* call);
  Result<void> begin_session(XrSystemId system);
  void end_session();
  void look_for_headset();
  void take_events();
  void take_state(XrSessionState state);
  bool begin_frame(PlannedFrame& frame);
  void take_input();
  bool locate_views();
  std::vector<Camera> cameras() const;

  std::unique_ptr<OpenXrInstance> instance_;
  std::unique_ptr<OpenXrHands> hands_;
  std::shared_ptr<VulkanDevice> device_;
  int width_ = 0, height_ = 0;
  XrEnvironmentBlendMode blend_mode_ = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;

  // Session state.
  XrSession session_ = XR_NULL_HANDLE;
  XrSpace local_ = XR_NULL_HANDLE;
  std::optional<OpenXrSwapchain> swapchain_;
  std::optional<OpenXrTextLayer> plate_;  // kept across sessions, except for its session objects
  XrSessionState state_ = XR_SESSION_STATE_UNKNOWN;
  bool running_ = false;
  int64_t next_try_ns_ = 0;

  // State of the frame between wait_frame and submit.
  bool begun_ = false, draws_ = false;
  XrTime display_time_ = 0;
  std::array<XrView, 2> views_{};

  std::deque<XrTime> recentres_;  // pending
  Pose scene_from_local_;
  double scale_ = 1, period_s_ = 1.0 / 90;
  HeadsetInput input_;
  Counts counts_;
  uint64_t planned_ = 0;
  bool ended_ = false;
  std::optional<Error> failure_;
};

// False if the call failed: the session is then lost, or, for any other error, the display has ended.
bool OpenXrDisplay::ok(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  if (result == XR_ERROR_SESSION_LOST) {
    log_warn("openxr: session lost (%s); waiting for the headset", call);
    ++counts_.losses;
    end_session();
    next_try_ns_ = now_ns() + kRetry_ns;
  } else {
    failure_ = instance_->check(result, call).error();
    ended_ = true;
  }
  return false;
}

Result<void> OpenXrDisplay::create(VulkanDeviceOptions options) {
  auto instance = OpenXrInstance::create();
  if (!instance) return instance.error();
  instance_ = *std::move(instance);
  auto system = instance_->find_headset();
  if (!system) return system.error();
  if (!*system)
    return Error{ErrorCode::Unavailable,
                 "openxr: " + instance_->name() + " has no headset; connect one and put it on"};
  OpenXrVulkanMaker maker(*instance_, **system);
  options.maker = &maker;
  auto device = VulkanDevice::create(options);
  if (!device) return device.error();
  device_ = *std::move(device);
  if (!device_->can_draw())
    return Error{ErrorCode::Unavailable, "openxr: the headset's device " + device_->name() +
                                             " does not support graphics; update its driver"};
  plate_.emplace(device_->handles());
  hands_ = std::make_unique<OpenXrHands>(*instance_);
  if (auto made = hands_->create(); !made) return made;

  std::vector<XrViewConfigurationView> views(
      2, openxr_info<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW));
  uint32_t count = 0;
  if (auto done = instance_->check(
          xrEnumerateViewConfigurationViews(instance_->handle(), **system, kStereo, 2, &count, views.data()),
          "xrEnumerateViewConfigurationViews");
      !done)
    return done;
  for (const XrViewConfigurationView& view : views) {
    width_ = std::max(width_, static_cast<int>(view.recommendedImageRectWidth));
    height_ = std::max(height_, static_cast<int>(view.recommendedImageRectHeight));
  }
  std::vector<XrEnvironmentBlendMode> modes(8);
  if (XR_SUCCEEDED(xrEnumerateEnvironmentBlendModes(instance_->handle(), **system, kStereo,
                                                    static_cast<uint32_t>(modes.size()), &count,
                                                    modes.data())) &&
      count > 0)
    blend_mode_ = modes[0];  // the runtime's preferred mode
  for (XrView& view : views_) view = openxr_info<XrView>(XR_TYPE_VIEW);
  if (auto begun = begin_session(**system); !begun) return begun;
  log_info("openxr: %s, %d x %d per eye, on %s", instance_->name().c_str(), width_, height_,
           device_->name().c_str());
  return {};
}

Result<void> OpenXrDisplay::begin_session(XrSystemId system) {
  const VulkanHandles& vulkan = device_->handles();
  auto asked = openxr_info<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR);
  instance_->get_requirements(instance_->handle(), system, &asked);
  auto binding = openxr_info<XrGraphicsBindingVulkan2KHR>(XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
  binding.instance = vulkan.instance;
  binding.physicalDevice = vulkan.physical_device;
  binding.device = vulkan.device;
  binding.queueFamilyIndex = vulkan.queue_family;
  binding.queueIndex = 0;
  auto info = openxr_info<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  info.next = &binding;
  info.systemId = system;
  if (auto made = instance_->check(xrCreateSession(instance_->handle(), &info, &session_), "xrCreateSession");
      !made) {
    session_ = XR_NULL_HANDLE;
    return made;
  }
  ++counts_.sessions;
  if (auto made = instance_->check(hands_->attach(session_), "xrAttachSessionActionSets"); !made) return made;
  auto space = openxr_info<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  space.poseInReferenceSpace.orientation.w = 1;
  if (auto made =
          instance_->check(xrCreateReferenceSpace(session_, &space, &local_), "xrCreateReferenceSpace");
      !made)
    return made;
  swapchain_.emplace(vulkan);
  return instance_->check(swapchain_->create(session_, width_, height_), "xrCreateSwapchain");
}

void OpenXrDisplay::end_session() {
  begun_ = draws_ = running_ = false;
  state_ = XR_SESSION_STATE_UNKNOWN;
  input_ = {};
  recentres_.clear();
  if (!session_) return;
  swapchain_.reset();
  plate_->end();
  hands_->detach();
  if (local_) xrDestroySpace(local_);
  xrDestroySession(session_);
  local_ = XR_NULL_HANDLE;
  session_ = XR_NULL_HANDLE;
}

void OpenXrDisplay::look_for_headset() {
  if (now_ns() < next_try_ns_) return;
  next_try_ns_ = now_ns() + kRetry_ns;
  auto system = instance_->find_headset();
  if (!system) {
    failure_ = system.error();
    ended_ = true;
  } else if (*system) {
    const auto begun = begin_session(**system);
    if (!begun) {
      log_warn("%s (retrying)", begun.error().message.c_str());
      end_session();
    } else {
      log_info("openxr: headset reconnected");
    }
  }
}

void OpenXrDisplay::take_state(XrSessionState state) {
  state_ = state;
  switch (state) {
    case XR_SESSION_STATE_READY: {
      auto info = openxr_info<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
      info.primaryViewConfigurationType = kStereo;
      running_ = ok(xrBeginSession(session_, &info), "xrBeginSession");
      break;
    }
    case XR_SESSION_STATE_STOPPING:
      running_ = false;
      ok(xrEndSession(session_), "xrEndSession");
      break;
    case XR_SESSION_STATE_LOSS_PENDING:
      ok(XR_ERROR_SESSION_LOST, "announced by the runtime");
      break;
    case XR_SESSION_STATE_EXITING:
      end_session();
      ended_ = true;
      break;
    default:
      break;
  }
}

void OpenXrDisplay::take_events() {
  for (;;) {
    auto event = openxr_info<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    const XrResult result = xrPollEvent(instance_->handle(), &event);
    if (result == XR_EVENT_UNAVAILABLE || !ok(result, "xrPollEvent") || ended_) return;
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      const auto& changed = reinterpret_cast<const XrEventDataSessionStateChanged&>(event);
      if (session_ && changed.session == session_) take_state(changed.state);
    } else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) {
      failure_ = instance_->gone();
      end_session();
      ended_ = true;
    } else if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
      const auto& changed = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
      if (changed.referenceSpaceType != XR_REFERENCE_SPACE_TYPE_LOCAL) continue;
      recentres_.push_back(changed.changeTime);
      ++counts_.recentres;
    } else if (event.type == XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB) {
      const auto& changed = reinterpret_cast<const XrEventDataDisplayRefreshRateChangedFB&>(event);
      log_info("openxr: refresh rate %.0f Hz (was %.0f Hz)", changed.toDisplayRefreshRate,
               changed.fromDisplayRefreshRate);
      ++counts_.refresh_changes;
    }
  }
}

std::optional<PlannedFrame> OpenXrDisplay::wait_frame() {
  PlannedFrame frame;
  frame.index = planned_++;
  frame.display_time_ns = now_ns();
  input_ = {};
  if (!session_ && !ended_) look_for_headset();
  if (!ended_) take_events();
  if (ended_) return std::nullopt;
  if (!running_) {
    sleep_until_ns(now_ns() + kPoll_ns);
    return frame;
  }
  if (!begin_frame(frame)) return ended_ ? std::nullopt : std::optional(frame);
  return frame;
}

bool OpenXrDisplay::begin_frame(PlannedFrame& frame) {
  const auto wait = openxr_info<XrFrameWaitInfo>(XR_TYPE_FRAME_WAIT_INFO);
  auto state = openxr_info<XrFrameState>(XR_TYPE_FRAME_STATE);
  if (!ok(xrWaitFrame(session_, &wait, &state), "xrWaitFrame")) return false;
  const auto begin = openxr_info<XrFrameBeginInfo>(XR_TYPE_FRAME_BEGIN_INFO);
  if (!ok(xrBeginFrame(session_, &begin), "xrBeginFrame")) return false;
  begun_ = true;
  display_time_ = state.predictedDisplayTime;
  period_s_ = seconds_from_ns(state.predictedDisplayPeriod);
  frame.display_time_ns = instance_->moment_ns(display_time_);
  take_input();
  if (!session_) return false;
  draws_ = state.shouldRender && locate_views();
  if (draws_) frame.views = cameras();
  return session_ != XR_NULL_HANDLE;
}

void OpenXrDisplay::take_input() {
  input_.focused = state_ == XR_SESSION_STATE_FOCUSED;
  bool recentred = false;
  while (!recentres_.empty() && recentres_.front() <= display_time_) {
    recentres_.pop_front();
    recentred = true;
  }
  if (!input_.focused) return;
  if (!ok(hands_->read(local_, display_time_, input_.hands), "xrSyncActions")) return;
  for (HandSample& hand : input_.hands) {
    if (recentred) hand = {};
    hand.aim = scene_from_local_ * hand.aim;
    hand.grip = scene_from_local_ * hand.grip;
  }
}

bool OpenXrDisplay::locate_views() {
  auto info = openxr_info<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
  info.viewConfigurationType = kStereo;
  info.displayTime = display_time_;
  info.space = local_;
  auto state = openxr_info<XrViewState>(XR_TYPE_VIEW_STATE);
  uint32_t count = 0;
  auto views = views_;
  if (!ok(xrLocateViews(session_, &info, &state, 2, &count, views.data()), "xrLocateViews")) return false;
  constexpr XrViewStateFlags kBoth = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
  if ((state.viewStateFlags & kBoth) != kBoth) return false;
  views_ = views;
  return true;
}

std::vector<Camera> OpenXrDisplay::cameras() const {
  const int width = std::max(16, static_cast<int>(std::lround(scale_ * width_)));
  const int height = std::max(16, static_cast<int>(std::lround(scale_ * height_)));
  std::vector<Camera> made;
  for (const XrView& view : views_) {
    const XrFovf& fov = view.fov;
    made.push_back(camera_from_fov(scene_from_local_ * pose_from_openxr(view.pose), fov.angleLeft,
                                   fov.angleRight, fov.angleUp, fov.angleDown, std::min(width, width_),
                                   std::min(height, height_)));
  }
  return made;
}

void OpenXrDisplay::update_views(PlannedFrame& frame) {
  if (begun_ && draws_ && locate_views()) frame.views = cameras();
}

bool OpenXrDisplay::update_input() {
  if (!begun_ || !input_.focused) return false;
  take_input();
  return session_ != XR_NULL_HANDLE && input_.focused;
}

std::optional<DeviceImage> OpenXrDisplay::acquire() {
  DeviceImage image;
  if (!begun_ || !draws_ || !ok(swapchain_->acquire(image), "xrAcquireSwapchainImage")) return std::nullopt;
  return image;
}

Result<void> OpenXrDisplay::submit(const PlannedFrame& frame, std::span<const Image> images) {
  if (!begun_) return {};
  if (!images.empty() && !swapchain_->acquired() && !acquire()) return {};
  const bool acquired = swapchain_->acquired();
  const bool drawn =
      acquired && frame.views.size() == 2;  // else the frame was begun for a picture that failed
  if (!images.empty()) {
    if (auto done = swapchain_->upload(images); !done) return done;
  }
  if (acquired && !ok(swapchain_->release(), "xrReleaseSwapchainImage")) return {};
  std::array<XrCompositionLayerProjectionView, 2> views;
  for (uint32_t e = 0; drawn && e < 2; ++e) {
    views[e] = openxr_info<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
    views[e].pose = views_[e].pose;
    views[e].fov = views_[e].fov;
    views[e].subImage = {swapchain_->handle(), {{0, 0}, {frame.views[e].width, frame.views[e].height}}, e};
  }
  auto layer = openxr_info<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
  layer.space = local_;
  layer.viewCount = 2;
  layer.views = views.data();
  std::optional<XrCompositionLayerQuad> plate;
  if (draws_ && !ok(plate_->layer(session_, plate), "the notice")) return {};
  std::vector<const XrCompositionLayerBaseHeader*> layers;
  if (drawn) layers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer));
  if (plate) layers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&*plate));
  auto info = openxr_info<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  info.displayTime = display_time_;
  info.environmentBlendMode = blend_mode_;
  info.layerCount = static_cast<uint32_t>(layers.size());
  info.layers = layers.data();
  begun_ = false;
  if (ok(xrEndFrame(session_, &info), "xrEndFrame") && drawn) ++counts_.pictures;
  return {};
}

void OpenXrDisplay::vibrate(size_t hand, float amplitude, double seconds) {
  if (running_ && input_.focused) ok(hands_->vibrate(hand, amplitude, seconds), "xrApplyHapticFeedback");
}

Result<void> OpenXrDisplay::finish() {
  if (running_ && !ended_) ok(xrRequestExitSession(session_), "xrRequestExitSession");
  const int64_t begun_ns = now_ns();
  while (session_ && running_ && !ended_ && now_ns() - begun_ns < kFinish_ns) {
    const auto frame = wait_frame();
    if (frame && !ended_) (void)submit(*frame, {});
  }
  // EXITING follows the end of the session at once, so there is no need to wait.
  if (!ended_ && session_) take_events();
  end_session();
  ended_ = true;
  return failure_ ? Result<void>(*failure_) : Result<void>();
}

}  // namespace

Result<std::unique_ptr<HeadsetDisplay>> HeadsetDisplay::open(VulkanDeviceOptions options) {
  auto display = std::make_unique<OpenXrDisplay>();
  if (auto made = display->create(std::move(options)); !made) return made.error();
  return Result<std::unique_ptr<HeadsetDisplay>>(std::move(display));
}

}  // namespace livegs
