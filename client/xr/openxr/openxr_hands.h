// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/input_sample.h"
#include "xr/openxr/openxr_instance.h"

namespace livegs {

// The controllers: their action bindings and current state. The action set belongs to the instance and is
// attached to every new session. One thread.
class OpenXrHands {
 public:
  explicit OpenXrHands(const OpenXrInstance& instance) : instance_(instance) {}
  ~OpenXrHands();
  OpenXrHands(const OpenXrHands&) = delete;
  OpenXrHands& operator=(const OpenXrHands&) = delete;

  // Creates the actions and the bindings of each profile; call once. Profiles that the runtime rejects are
  // logged and skipped.
  Result<void> create();
  // Attaches the actions to a new session, before its first frame.
  XrResult attach(XrSession session);
  void detach();  // call before the session is destroyed

  // Reads the hands at a time, in `space`. Untracked or unfocused hands are inactive. SESSION_LOST is the
  // only failure to be handled.
  XrResult read(XrSpace space, XrTime time, std::array<HandSample, 2>& hands);
  // amplitude 0..1; hand: 0 left, 1 right.
  XrResult vibrate(size_t hand, float amplitude, double seconds);

 private:
  Result<void> make_action(XrActionType type, const char* name, const char* shown, XrAction& action);
  void suggest(const char* profile, const char* shoot_left, const char* shoot_right, const char* trigger,
               const char* squeeze);
  XrResult read_hand(size_t hand, XrSpace space, XrTime time, HandSample& sample);
  XrResult read_float(XrAction action, size_t hand, float& value);

  const OpenXrInstance& instance_;
  XrActionSet set_ = XR_NULL_HANDLE;
  XrAction aim_ = XR_NULL_HANDLE, grip_ = XR_NULL_HANDLE, trigger_ = XR_NULL_HANDLE,
           squeeze_ = XR_NULL_HANDLE, shoot_ = XR_NULL_HANDLE, haptic_ = XR_NULL_HANDLE;
  std::array<XrPath, 2> paths_{};
  XrSession session_ = XR_NULL_HANDLE;
  std::array<XrSpace, 2> aim_spaces_{}, grip_spaces_{};
};

}  // namespace livegs
