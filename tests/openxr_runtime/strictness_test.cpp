// SPDX-License-Identifier: Apache-2.0
// Invalid calls of an application with a session: the simulated runtime refuses each with the code of OpenXR
// 1.0. Also valid calls that it must accept.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <thread>

#include "openxr_runtime/plain_application.h"
#include "openxr_runtime/record_files.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

struct Misuse {
  const char* what;
  XrResult code;
  std::function<XrResult()> call;
};

class StrictRuntime : public ::testing::Test {
 protected:
  void SetUp() override {
    ::setenv("XR_RUNTIME_JSON", LIVEGS_SIMULATED_OPENXR, 1);
    ::setenv("LIVEGS_XR_OUTPUT", (folder_ / "").c_str(), 1);
    ::unsetenv("LIVEGS_XR_TIMELINE");
    const std::string missing = app_.open();
    if (missing == "no Vulkan") GTEST_SKIP() << missing;
    ASSERT_EQ(missing, "");
  }
  void TearDown() override { ::unsetenv("LIVEGS_XR_OUTPUT"); }

  void attach() {
    auto info = openxr<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    info.countActionSets = 1;
    info.actionSets = &app_.set;
    ASSERT_EQ(xrAttachSessionActionSets(app_.session, &info), XR_SUCCESS);
  }
  void focus() {
    attach();
    ASSERT_EQ(app_.begin(), XR_SUCCESS);
    ASSERT_TRUE(app_.run_until(XR_SESSION_STATE_FOCUSED));
    XrActiveActionSet active{app_.set, XR_NULL_PATH};
    auto sync = openxr<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
    sync.countActiveActionSets = 1;
    sync.activeActionSets = &active;
    ASSERT_EQ(xrSyncActions(app_.session, &sync), XR_SUCCESS);
  }

  // Each call is refused with its code and recorded once.
  void expect_refused(const std::vector<Misuse>& table) {
    for (const Misuse& misuse : table) {
      const size_t before = noted();
      EXPECT_EQ(misuse.call(), misuse.code) << misuse.what;
      EXPECT_EQ(noted(), before + 1) << misuse.what << "\n" << text(folder_ / "misuse.txt");
    }
  }
  size_t noted() const {
    const std::string all = text(folder_ / "misuse.txt");
    return static_cast<size_t>(std::count(all.begin(), all.end(), '\n'));
  }

  // Submits a valid frame with one change.
  XrResult end_frame_with(const std::function<void(PlainApplication::Ending&)>& change) {
    XrFrameState state;
    PlainApplication::Ending ending;
    EXPECT_EQ(app_.wait(state), XR_SUCCESS);
    EXPECT_EQ(xrBeginFrame(app_.session, nullptr), XR_SUCCESS);
    app_.fill(ending, state.predictedDisplayTime);
    change(ending);
    return xrEndFrame(app_.session, &ending.info);
  }
  XrResult swapchain_with(const std::function<void(XrSwapchainCreateInfo&)>& change) const {
    XrSwapchainCreateInfo info = app_.swapchain_info;
    change(info);
    XrSwapchain made = XR_NULL_HANDLE;
    return xrCreateSwapchain(app_.session, &info, &made);
  }
  XrActionStateGetInfo of_action(XrAction action, const char* subaction = nullptr) const {
    auto get = openxr<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    get.action = action;
    if (subaction) get.subactionPath = app_.path(subaction);
    return get;
  }
  XrResult read_button(const XrActionStateGetInfo& get) const {
    auto state = openxr<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
    return xrGetActionStateBoolean(app_.session, &get, &state);
  }
  XrResult vibrate(XrAction action, float amplitude, const char* subaction = "/user/hand/right") const {
    auto info = openxr<XrHapticActionInfo>(XR_TYPE_HAPTIC_ACTION_INFO);
    info.action = action;
    info.subactionPath = app_.path(subaction);
    auto vibration = openxr<XrHapticVibration>(XR_TYPE_HAPTIC_VIBRATION);
    vibration.amplitude = amplitude;
    vibration.duration = XR_MIN_HAPTIC_DURATION;
    return xrApplyHapticFeedback(app_.session, &info,
                                 reinterpret_cast<const XrHapticBaseHeader*>(&vibration));
  }
  XrResult profile_of(const char* user) const {
    auto state = openxr<XrInteractionProfileState>(XR_TYPE_INTERACTION_PROFILE_STATE);
    return xrGetCurrentInteractionProfile(app_.session, app_.path(user), &state);
  }
  XrResult views_at(XrTime time,
                    XrViewConfigurationType type = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) const {
    auto info = openxr<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
    info.viewConfigurationType = type;
    info.displayTime = time;
    info.space = app_.local;
    auto state = openxr<XrViewState>(XR_TYPE_VIEW_STATE);
    uint32_t count = 0;
    std::array views{openxr<XrView>(XR_TYPE_VIEW), openxr<XrView>(XR_TYPE_VIEW)};
    return xrLocateViews(app_.session, &info, &state, 2, &count, views.data());
  }

  ScratchFolder folder_;
  PlainApplication app_;
};

TEST_F(StrictRuntime, RefusesCallsOfASessionThatIsNotRunning) {
  XrFrameState state;
  auto nothing = openxr<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  auto sync = openxr<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
  XrActiveActionSet active{app_.set, XR_NULL_PATH};
  sync.countActiveActionSets = 1;
  sync.activeActionSets = &active;
  auto none = openxr<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
  auto mono = openxr<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  mono.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO;
  const XrSession session = app_.session;
  expect_refused({
      {"a frame is waited for", XR_ERROR_SESSION_NOT_RUNNING, [&] { return app_.wait(state); }},
      {"a frame is begun", XR_ERROR_SESSION_NOT_RUNNING, [&] { return xrBeginFrame(session, nullptr); }},
      {"a frame is ended", XR_ERROR_SESSION_NOT_RUNNING, [&] { return xrEndFrame(session, &nothing); }},
      {"the session is ended", XR_ERROR_SESSION_NOT_RUNNING, [&] { return xrEndSession(session); }},
      {"the exit of the session is requested", XR_ERROR_SESSION_NOT_RUNNING,
       [&] { return xrRequestExitSession(session); }},
      {"the session begins with a mono view", XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
       [&] { return xrBeginSession(session, &mono); }},
      {"no action sets are attached", XR_ERROR_VALIDATION_FAILURE,
       [&] { return xrAttachSessionActionSets(session, &none); }},
      {"an action set that is not attached is synchronised", XR_ERROR_ACTIONSET_NOT_ATTACHED,
       [&] { return xrSyncActions(session, &sync); }},
      {"an action that is not attached is read", XR_ERROR_ACTIONSET_NOT_ATTACHED,
       [&] { return read_button(of_action(app_.shoot)); }},
      {"an action that is not attached vibrates", XR_ERROR_ACTIONSET_NOT_ATTACHED,
       [&] { return vibrate(app_.feel, 0.5f); }},
      {"the profile is queried before attaching", XR_ERROR_ACTIONSET_NOT_ATTACHED,
       [&] { return profile_of("/user/hand/left"); }},
      {"a second session", XR_ERROR_LIMIT_REACHED,
       [&] {
         auto info = openxr<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
         info.systemId = app_.system;
         XrSession second = XR_NULL_HANDLE;
         return xrCreateSession(app_.instance, &info, &second);
       }},
  });
}

TEST_F(StrictRuntime, RefusesInvalidAndMisorderedFrames) {
  focus();
  const XrSession session = app_.session;
  XrFrameState state;
  auto nothing = openxr<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  nothing.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  XrSpace gone_space = XR_NULL_HANDLE;
  auto space = openxr<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  space.poseInReferenceSpace.orientation.w = 1;
  ASSERT_EQ(xrCreateReferenceSpace(session, &space, &gone_space), XR_SUCCESS);
  ASSERT_EQ(xrDestroySpace(gone_space), XR_SUCCESS);
  XrSwapchain unreleased = XR_NULL_HANDLE, gone_swapchain = XR_NULL_HANDLE;
  ASSERT_EQ(xrCreateSwapchain(session, &app_.swapchain_info, &unreleased), XR_SUCCESS);
  ASSERT_EQ(xrCreateSwapchain(session, &app_.swapchain_info, &gone_swapchain), XR_SUCCESS);
  ASSERT_EQ(xrDestroySwapchain(gone_swapchain), XR_SUCCESS);
  using Ending = PlainApplication::Ending;
  const auto with = [&](auto change) { return [this, change] { return end_frame_with(change); }; };
  const auto unknown = openxr<XrCompositionLayerBaseHeader>(XR_TYPE_COMPOSITION_LAYER_CUBE_KHR);
  const uint64_t frames_before = rows(folder_ / "frames.csv").size();
  expect_refused({
      {"begun without a wait", XR_ERROR_CALL_ORDER_INVALID, [&] { return xrBeginFrame(session, nullptr); }},
      {"ended without a begin", XR_ERROR_CALL_ORDER_INVALID, [&] { return xrEndFrame(session, &nothing); }},
      {"ended between wait and begin", XR_ERROR_CALL_ORDER_INVALID,
       [&] {
         EXPECT_EQ(app_.wait(state), XR_SUCCESS);
         return xrEndFrame(session, &nothing);
       }},
      // The previous wait is still open. The specification lets this call block forever on a single thread.
      {"waited for twice", XR_ERROR_CALL_ORDER_INVALID, [&] { return app_.wait(state); }},
      {"begun twice", XR_FRAME_DISCARDED,
       [&] {
         EXPECT_EQ(xrBeginFrame(session, nullptr), XR_SUCCESS);
         EXPECT_EQ(app_.wait(state), XR_SUCCESS);
         return xrBeginFrame(session, nullptr);
       }},
      // Stricter than the specification, which only recommends the display time of the wait.
      {"ended with a different display time", XR_ERROR_TIME_INVALID,
       [&] {
         Ending ending;
         app_.fill(ending, state.predictedDisplayTime + 1);
         return xrEndFrame(session, &ending.info);
       }},
      {"ended twice", XR_ERROR_CALL_ORDER_INVALID,
       [&] {
         EXPECT_EQ(end_frame_with([](Ending& ending) { ending.info.layerCount = 0; }), XR_SUCCESS);
         return xrEndFrame(session, &nothing);
       }},
      {"a blend mode that was not enumerated", XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED,
       with([](Ending& ending) { ending.info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_ADDITIVE; })},
      {"layers is null", XR_ERROR_LAYER_INVALID, with([](Ending& ending) { ending.info.layers = nullptr; })},
      {"a layer is null", XR_ERROR_LAYER_INVALID, with([](Ending& ending) { ending.layers[0] = nullptr; })},
      {"a layer of unknown type", XR_ERROR_LAYER_INVALID,
       with([&](Ending& ending) { ending.layers[0] = &unknown; })},
      {"more layers than the limit", XR_ERROR_LAYER_LIMIT_EXCEEDED, with([](Ending& ending) {
         ending.layers.resize(XR_MIN_COMPOSITION_LAYERS_SUPPORTED + 1, ending.layers[0]);
         ending.info.layers = ending.layers.data();
         ending.info.layerCount = static_cast<uint32_t>(ending.layers.size());
       })},
      {"a projection with one view", XR_ERROR_VALIDATION_FAILURE,
       with([](Ending& ending) { ending.layer.viewCount = 1; })},
      {"a view without a structure type", XR_ERROR_VALIDATION_FAILURE,
       with([](Ending& ending) { ending.views[1].type = XR_TYPE_UNKNOWN; })},
      {"a destroyed space", XR_ERROR_HANDLE_INVALID,
       with([&](Ending& ending) { ending.layer.space = gone_space; })},
      {"a destroyed swapchain", XR_ERROR_HANDLE_INVALID,
       with([&](Ending& ending) { ending.views[1].subImage.swapchain = gone_swapchain; })},
      {"a swapchain without a released image", XR_ERROR_LAYER_INVALID,
       with([&](Ending& ending) { ending.views[0].subImage.swapchain = unreleased; })},
      {"a rectangle that is too wide", XR_ERROR_SWAPCHAIN_RECT_INVALID,
       with([](Ending& ending) { ++ending.views[0].subImage.imageRect.extent.width; })},
      {"a rectangle that ends below its image", XR_ERROR_SWAPCHAIN_RECT_INVALID,
       with([](Ending& ending) { ending.views[1].subImage.imageRect.offset.y = 1; })},
      {"a rectangle that begins before its image", XR_ERROR_SWAPCHAIN_RECT_INVALID,
       with([](Ending& ending) { ending.views[1].subImage.imageRect.offset.x = -1; })},
      {"a rectangle of negative size", XR_ERROR_SWAPCHAIN_RECT_INVALID,
       with([](Ending& ending) { ending.views[0].subImage.imageRect.extent.height = -4; })},
      {"an array layer that the image does not have", XR_ERROR_VALIDATION_FAILURE,
       with([](Ending& ending) { ending.views[0].subImage.imageArrayIndex = 2; })},
      {"a pose that is not valid", XR_ERROR_POSE_INVALID,
       with([](Ending& ending) { ending.views[0].pose.orientation.w = 0.5f; })},
      {"an empty field of view", XR_ERROR_VALIDATION_FAILURE,
       with([](Ending& ending) { ending.views[0].fov.angleRight = ending.views[0].fov.angleLeft; })},
  });
  // Only the valid, empty frame among these was shown. The next valid frame is accepted.
  EXPECT_EQ(rows(folder_ / "frames.csv").size(), frames_before + 1);
  EXPECT_EQ(end_frame_with([](Ending&) {}), XR_SUCCESS);
  EXPECT_EQ(rows(folder_ / "frames.csv").size(), frames_before + 3);
  EXPECT_EQ(xrDestroySwapchain(unreleased), XR_SUCCESS);
}

TEST_F(StrictRuntime, RefusesInvalidAndMisorderedSwapchainCalls) {
  focus();
  const XrSwapchain swapchain = app_.swapchain;
  auto wait = openxr<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  wait.timeout = XR_INFINITE_DURATION;
  uint32_t index = 0;
  expect_refused({
      {"waited for without an acquire", XR_ERROR_CALL_ORDER_INVALID,
       [&] { return xrWaitSwapchainImage(swapchain, &wait); }},
      {"released without an acquire", XR_ERROR_CALL_ORDER_INVALID,
       [&] { return xrReleaseSwapchainImage(swapchain, nullptr); }},
      {"released without a wait", XR_ERROR_CALL_ORDER_INVALID,
       [&] {
         EXPECT_EQ(xrAcquireSwapchainImage(swapchain, nullptr, &index), XR_SUCCESS);
         return xrReleaseSwapchainImage(swapchain, nullptr);
       }},
      {"waited for twice", XR_ERROR_CALL_ORDER_INVALID,
       [&] {
         EXPECT_EQ(xrWaitSwapchainImage(swapchain, &wait), XR_SUCCESS);
         return xrWaitSwapchainImage(swapchain, &wait);
       }},
      {"acquired more often than the number of images", XR_ERROR_CALL_ORDER_INVALID,
       [&] {
         EXPECT_EQ(xrAcquireSwapchainImage(swapchain, nullptr, &index), XR_SUCCESS);
         EXPECT_EQ(xrAcquireSwapchainImage(swapchain, nullptr, &index), XR_SUCCESS);
         return xrAcquireSwapchainImage(swapchain, nullptr, &index);
       }},
      {"a format that was not enumerated", XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED,
       [&] { return swapchain_with([](auto& info) { info.format = VK_FORMAT_R8_UINT; }); }},
      {"a width of zero", XR_ERROR_VALIDATION_FAILURE,
       [&] { return swapchain_with([](auto& info) { info.width = 0; }); }},
      {"two faces", XR_ERROR_VALIDATION_FAILURE,
       [&] { return swapchain_with([](auto& info) { info.faceCount = 2; }); }},
      {"no array layers", XR_ERROR_VALIDATION_FAILURE,
       [&] { return swapchain_with([](auto& info) { info.arraySize = 0; }); }},
      {"a cube map", XR_ERROR_FEATURE_UNSUPPORTED,
       [&] { return swapchain_with([](auto& info) { info.faceCount = 6; }); }},
      {"protected", XR_ERROR_FEATURE_UNSUPPORTED,
       [&] {
         return swapchain_with(
             [](auto& info) { info.createFlags = XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT; });
       }},
      {"a depth usage", XR_ERROR_FEATURE_UNSUPPORTED,
       [&] {
         return swapchain_with(
             [](auto& info) { info.usageFlags = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT; });
       }},
      {"destroyed twice", XR_ERROR_HANDLE_INVALID,
       [&] {
         XrSwapchain made = XR_NULL_HANDLE;
         EXPECT_EQ(xrCreateSwapchain(app_.session, &app_.swapchain_info, &made), XR_SUCCESS);
         EXPECT_EQ(xrDestroySwapchain(made), XR_SUCCESS);
         return xrDestroySwapchain(made);
       }},
  });
}

TEST_F(StrictRuntime, RefusesInvalidSpacesViewsAndActions) {
  focus();
  const XrSession session = app_.session;
  XrSpace made = XR_NULL_HANDLE;
  const auto reference = [&](XrReferenceSpaceType type, float w) {
    auto info = openxr<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    info.referenceSpaceType = type;
    info.poseInReferenceSpace.orientation.w = w;
    return xrCreateReferenceSpace(session, &info, &made);
  };
  const auto of_hand = [&](XrAction action, const char* subaction) {
    auto info = openxr<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
    info.action = action;
    info.subactionPath = app_.path(subaction);
    info.poseInActionSpace.orientation.w = 1;
    return xrCreateActionSpace(session, &info, &made);
  };
  const auto located = [&](XrTime time) {
    auto location = openxr<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    return xrLocateSpace(app_.local, app_.local, time, &location);
  };
  auto begin = openxr<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  begin.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  auto attached = openxr<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
  attached.countActionSets = 1;
  attached.actionSets = &app_.set;
  auto late_action = openxr<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
  late_action.actionType = XR_ACTION_TYPE_BOOLEAN_INPUT;
  std::snprintf(late_action.actionName, XR_MAX_ACTION_NAME_SIZE, "late");
  std::snprintf(late_action.localizedActionName, XR_MAX_LOCALIZED_ACTION_NAME_SIZE, "Late");
  XrAction action = XR_NULL_HANDLE;
  XrActionSuggestedBinding binding{app_.shoot, app_.path("/user/hand/right/input/a/click")};
  auto suggested =
      openxr<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
  suggested.interactionProfile = app_.path("/interaction_profiles/oculus/touch_controller");
  suggested.countSuggestedBindings = 1;
  suggested.suggestedBindings = &binding;
  expect_refused({
      {"the session begins twice", XR_ERROR_SESSION_RUNNING, [&] { return xrBeginSession(session, &begin); }},
      {"the session ends before STOPPING", XR_ERROR_SESSION_NOT_STOPPING,
       [&] { return xrEndSession(session); }},
      {"a space with an invalid pose", XR_ERROR_POSE_INVALID,
       [&] { return reference(XR_REFERENCE_SPACE_TYPE_LOCAL, 0.5f); }},
      {"a space type that was not enumerated", XR_ERROR_REFERENCE_SPACE_UNSUPPORTED,
       [&] { return reference(XR_REFERENCE_SPACE_TYPE_UNBOUNDED_MSFT, 1); }},
      {"a space of a button action", XR_ERROR_ACTION_TYPE_MISMATCH,
       [&] { return of_hand(app_.shoot, "/user/hand/right"); }},
      {"a space of a subaction that the action does not have", XR_ERROR_PATH_UNSUPPORTED,
       [&] { return of_hand(app_.grip, "/user/head"); }},
      {"a space located at an unknown time", XR_ERROR_TIME_INVALID, [&] { return located(0); }},
      {"views located at an unknown time", XR_ERROR_TIME_INVALID, [&] { return views_at(-1); }},
      {"a mono view configuration", XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
       [&] { return views_at(1, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO); }},
      {"action sets attached twice", XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
       [&] { return xrAttachSessionActionSets(session, &attached); }},
      {"an action created after attaching", XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
       [&] { return xrCreateAction(app_.set, &late_action, &action); }},
      {"bindings suggested after attaching", XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
       [&] { return xrSuggestInteractionProfileBindings(app_.instance, &suggested); }},
      {"a pose read as a button", XR_ERROR_ACTION_TYPE_MISMATCH,
       [&] { return read_button(of_action(app_.grip)); }},
      {"a subaction that the action does not have", XR_ERROR_PATH_UNSUPPORTED,
       [&] { return read_button(of_action(app_.shoot, "/user/gamepad")); }},
      {"haptics on a button action", XR_ERROR_ACTION_TYPE_MISMATCH,
       [&] { return vibrate(app_.shoot, 0.5f); }},
      {"an amplitude above 1", XR_ERROR_VALIDATION_FAILURE, [&] { return vibrate(app_.feel, 1.5f); }},
      {"haptics on the head", XR_ERROR_PATH_UNSUPPORTED,
       [&] { return vibrate(app_.feel, 0.5f, "/user/head"); }},
      {"the profile of a button path", XR_ERROR_PATH_UNSUPPORTED,
       [&] { return profile_of("/user/hand/right/input/a/click"); }},
  });
  EXPECT_EQ(vibrate(app_.feel, 1.0f), XR_SUCCESS);
  EXPECT_EQ(read_button(of_action(app_.shoot, "/user/hand/right")), XR_SUCCESS);
}

// The application waits for the next frame on another thread before the current frame has begun.
TEST_F(StrictRuntime, ConcurrentWaitBlocksUntilFrameBegins) {
  focus();
  XrFrameState first, second;
  ASSERT_EQ(app_.wait(first), XR_SUCCESS);
  XrResult waited = XR_ERROR_RUNTIME_FAILURE;
  std::thread other([&] { waited = app_.wait(second); });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(xrBeginFrame(app_.session, nullptr), XR_SUCCESS);
  other.join();
  EXPECT_EQ(waited, XR_SUCCESS);
  EXPECT_GT(second.predictedDisplayTime, first.predictedDisplayTime);
  EXPECT_EQ(noted(), 0u);
}

}  // namespace
}  // namespace livegs
