// SPDX-License-Identifier: Apache-2.0
#include "xr/openxr/openxr_hands.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "core/log.h"

namespace livegs {
namespace {

constexpr const char* kUsers[] = {"/user/hand/left", "/user/hand/right"};

}  // namespace

OpenXrHands::~OpenXrHands() {
  if (set_) xrDestroyActionSet(set_);
}

Result<void> OpenXrHands::make_action(XrActionType type, const char* name, const char* shown,
                                      XrAction& action) {
  auto info = openxr_info<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
  std::snprintf(info.actionName, XR_MAX_ACTION_NAME_SIZE, "%s", name);
  std::snprintf(info.localizedActionName, XR_MAX_LOCALIZED_ACTION_NAME_SIZE, "%s", shown);
  info.actionType = type;
  info.countSubactionPaths = paths_.size();
  info.subactionPaths = paths_.data();
  return instance_.check(xrCreateAction(set_, &info, &action), "xrCreateAction");
}

Result<void> OpenXrHands::create() {
  for (size_t hand = 0; hand < 2; ++hand) paths_[hand] = instance_.path(kUsers[hand]);
  auto info = openxr_info<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
  std::snprintf(info.actionSetName, XR_MAX_ACTION_SET_NAME_SIZE, "touch");
  std::snprintf(info.localizedActionSetName, XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE, "Touch objects");
  if (auto made = instance_.check(xrCreateActionSet(instance_.handle(), &info, &set_), "xrCreateActionSet");
      !made)
    return made;
  for (auto made : {make_action(XR_ACTION_TYPE_POSE_INPUT, "aim", "Aim", aim_),
                    make_action(XR_ACTION_TYPE_POSE_INPUT, "grip", "Hand", grip_),
                    make_action(XR_ACTION_TYPE_FLOAT_INPUT, "pull", "Pull by the ray", trigger_),
                    make_action(XR_ACTION_TYPE_FLOAT_INPUT, "grab", "Grab", squeeze_),
                    make_action(XR_ACTION_TYPE_BOOLEAN_INPUT, "shoot", "Shoot a ball", shoot_),
                    make_action(XR_ACTION_TYPE_VIBRATION_OUTPUT, "feel", "Feel contacts", haptic_)}) {
    if (!made) return made;
  }
  suggest("/interaction_profiles/khr/simple_controller", "menu/click", "menu/click", "select/click", nullptr);
  suggest("/interaction_profiles/oculus/touch_controller", "x/click", "a/click", "trigger/value",
          "squeeze/value");
  if (instance_.has_touch_plus())
    suggest("/interaction_profiles/meta/touch_controller_plus", "x/click", "a/click", "trigger/value",
            "squeeze/value");
  return {};
}

void OpenXrHands::suggest(const char* profile, const char* shoot_left, const char* shoot_right,
                          const char* trigger, const char* squeeze) {
  std::vector<XrActionSuggestedBinding> bindings;
  for (size_t hand = 0; hand < 2; ++hand) {
    const auto bind = [&](XrAction action, const char* part, const char* component) {
      if (component)
        bindings.push_back({action, instance_.path((std::string(kUsers[hand]) + part + component).c_str())});
    };
    bind(aim_, "/input/", "aim/pose");
    bind(grip_, "/input/", "grip/pose");
    bind(trigger_, "/input/", trigger);
    bind(squeeze_, "/input/", squeeze);
    bind(shoot_, "/input/", hand == 0 ? shoot_left : shoot_right);
    bind(haptic_, "/output/", "haptic");
  }
  auto info =
      openxr_info<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
  info.interactionProfile = instance_.path(profile);
  info.countSuggestedBindings = static_cast<uint32_t>(bindings.size());
  info.suggestedBindings = bindings.data();
  const auto taken = instance_.check(xrSuggestInteractionProfileBindings(instance_.handle(), &info),
                                     "xrSuggestInteractionProfileBindings");
  if (!taken) log_warn("%s: is not supported (%s)", profile, taken.error().message.c_str());
}

XrResult OpenXrHands::attach(XrSession session) {
  session_ = session;
  auto info = openxr_info<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
  info.countActionSets = 1;
  info.actionSets = &set_;
  XrResult result = xrAttachSessionActionSets(session, &info);
  for (size_t hand = 0; hand < 2 && XR_SUCCEEDED(result); ++hand) {
    auto space = openxr_info<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
    space.subactionPath = paths_[hand];
    space.poseInActionSpace.orientation.w = 1;
    space.action = aim_;
    result = xrCreateActionSpace(session, &space, &aim_spaces_[hand]);
    if (XR_FAILED(result)) break;
    space.action = grip_;
    result = xrCreateActionSpace(session, &space, &grip_spaces_[hand]);
  }
  return result;
}

void OpenXrHands::detach() {
  for (auto* spaces : {&aim_spaces_, &grip_spaces_}) {
    for (XrSpace& space : *spaces) {
      if (space) xrDestroySpace(space);
      space = XR_NULL_HANDLE;
    }
  }
  session_ = XR_NULL_HANDLE;
}

XrResult OpenXrHands::read(XrSpace space, XrTime time, std::array<HandSample, 2>& hands) {
  hands = {};
  const XrActiveActionSet active{set_, XR_NULL_PATH};
  auto info = openxr_info<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
  info.countActiveActionSets = 1;
  info.activeActionSets = &active;
  if (const XrResult result = xrSyncActions(session_, &info); result != XR_SUCCESS)
    return result;  // for example NOT_FOCUSED
  for (size_t hand = 0; hand < 2; ++hand) {
    if (const XrResult result = read_hand(hand, space, time, hands[hand]); XR_FAILED(result)) return result;
  }
  return XR_SUCCESS;
}

XrResult OpenXrHands::read_float(XrAction action, size_t hand, float& value) {
  auto get = openxr_info<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
  get.action = action;
  get.subactionPath = paths_[hand];
  auto state = openxr_info<XrActionStateFloat>(XR_TYPE_ACTION_STATE_FLOAT);
  const XrResult result = xrGetActionStateFloat(session_, &get, &state);
  if (XR_SUCCEEDED(result) && state.isActive) value = std::clamp(state.currentState, 0.0f, 1.0f);
  return result;
}

XrResult OpenXrHands::read_hand(size_t hand, XrSpace space, XrTime time, HandSample& sample) {
  bool tracked = true;
  const auto locate = [&](XrSpace located, Pose& pose) {
    auto location = openxr_info<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    const XrResult result = xrLocateSpace(located, space, time, &location);
    constexpr XrSpaceLocationFlags kBoth =
        XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    tracked = tracked && (location.locationFlags & kBoth) == kBoth;
    if (tracked) pose = pose_from_openxr(location.pose);
    return result;
  };
  auto get = openxr_info<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
  get.action = shoot_;
  get.subactionPath = paths_[hand];
  auto shoot = openxr_info<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
  for (const XrResult result :
       {locate(aim_spaces_[hand], sample.aim), locate(grip_spaces_[hand], sample.grip),
        read_float(trigger_, hand, sample.trigger), read_float(squeeze_, hand, sample.squeeze),
        xrGetActionStateBoolean(session_, &get, &shoot)}) {
    if (XR_FAILED(result)) return result;
  }
  if (!tracked) {
    sample = {};
    return XR_SUCCESS;
  }
  sample.active = true;
  sample.shoot = shoot.isActive && shoot.currentState;
  return XR_SUCCESS;
}

XrResult OpenXrHands::vibrate(size_t hand, float amplitude, double seconds) {
  if (!session_) return XR_SUCCESS;
  auto info = openxr_info<XrHapticActionInfo>(XR_TYPE_HAPTIC_ACTION_INFO);
  info.action = haptic_;
  info.subactionPath = paths_[hand];
  auto vibration = openxr_info<XrHapticVibration>(XR_TYPE_HAPTIC_VIBRATION);
  vibration.amplitude = std::clamp(amplitude, 0.0f, 1.0f);
  vibration.duration = static_cast<XrDuration>(seconds * 1e9);
  vibration.frequency = XR_FREQUENCY_UNSPECIFIED;
  return xrApplyHapticFeedback(session_, &info, reinterpret_cast<const XrHapticBaseHeader*>(&vibration));
}

}  // namespace livegs
