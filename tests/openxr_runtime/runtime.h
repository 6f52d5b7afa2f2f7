// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/pose.h"
#include "graphics.h"
#include "openxr_calls.h"
#include "record.h"
#include "timeline.h"

// An OpenXR runtime without a headset. A timeline moves the head and the hands. Submitted pictures are read
// back, hashed and recorded. Calls that OpenXR 1.0 forbids are refused and recorded. One instance and one
// session at a time. A mutex guards all state; the application may call from any thread.
//   LIVEGS_XR_TIMELINE     path of the timeline; default: nothing moves
//   LIVEGS_XR_OUTPUT       folder of the record; default: no record
//   LIVEGS_XR_EYE_SIZE     recommended size per eye as WxH; default: 128x144
//   LIVEGS_XR_CONTROLLERS  last part of the controllers' profile path: touch_controller_plus,
//                          touch_controller or simple_controller; default: the first of kProfiles
//                          (actions.cpp) that the application suggests bindings for
namespace livegs::simulated {

struct Action {
  XrActionSet set;
  XrActionType type;
  std::string name, localized;
  std::set<XrPath> subactions;
};
struct ActionSet {
  std::string name, localized;
  uint32_t priority = 0;
  bool attached = false;
};
struct Binding {
  XrAction action;
  std::string path;  // full path in the profile, including the component
};
// State of an action at the last sync. `known` is false if no source that is bound to the action can be read.
struct InputState {
  bool known = false, changed = false;
  float value = 0;
  XrTime changed_at = 0;
};

struct Swapchain {
  XrSwapchainCreateInfo info;
  std::vector<SwapchainImage> images;
  std::deque<uint32_t> acquired;  // oldest first
  bool waited = false;            // for the oldest acquired image
  uint32_t next = 0;
  std::optional<uint32_t> released;  // the last released image
};
struct Space {
  std::optional<XrReferenceSpaceType> reference;
  XrAction action = XR_NULL_HANDLE;
  XrPath subaction = XR_NULL_PATH;
  Pose offset;
};

struct Session {
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;
  bool running = false, exiting = false, hidden = false, unfocused = false;
  enum class Loss { None, Pending, Lost } loss = Loss::None;
  Graphics graphics;
  bool attached = false;
  std::map<std::pair<XrAction, XrPath>, InputState> inputs;
  std::string profile;  // in use; empty before the first sync
  // Frames.
  bool waited = false, begun = false;
  uint64_t frames_in_state = 0;
  XrTime predicted_for = 0;  // display time of the predictions below
  std::array<EyePrediction, 2> predictions;
  XrTime last_display_time = 0;
  std::set<XrTime> waited_for;  // display times of frames that have not ended
  double waited_s = 0;          // time when the last wait ended
  bool keep_next = false;
  std::map<XrSpace, Space> spaces;
  std::map<XrSwapchain, Swapchain> swapchains;
  size_t spaces_made = 0, swapchains_made = 0;
};

struct Instance {
  std::set<std::string> extensions;
  std::deque<XrEventDataBuffer> events;
  std::vector<std::string> paths;  // XrPath is the index plus one
  bool requirements_asked = false;
  VkInstance vulkan = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr vulkan_of = nullptr;
  std::map<XrActionSet, ActionSet> sets;
  std::map<XrAction, Action> actions;
  std::map<std::string, std::vector<Binding>> suggested;  // by profile
  XrTime no_headset_until = 0;
  size_t sessions_made = 0, sets_made = 0, actions_made = 0;
  bool dead = false;
};

const Pose kStageFromLocal{{0, 1.6, 0}, Eigen::Quaterniond::Identity()};  // before a recentre event

struct Runtime {
  std::mutex mutex;
  std::condition_variable frame_begun;
  std::map<XrInstance, Instance> instances;  // at most one, like sessions
  std::map<XrSession, Session> sessions;
  Timeline timeline;
  std::unique_ptr<Record> record;
  // Timeline time anchor_s corresponds to anchor_ns, the end of the last frame. 0 before the first frame.
  XrTime anchor_ns = 0;
  double anchor_s = 0;
  double played_s = -1;  // timeline events up to this time have been processed
  Pose stage_from_local = kStageFromLocal;
  double refresh_hz = 90, compositor_s = 0, misjudged_m_s = 0;
  uint64_t frames = 0, last_handle = 0;
};

Runtime& runtime();
constexpr XrSystemId kSystem = 7;

// The clock differs from the system clock by this offset, so that a confusion of the two is detected.
constexpr XrTime kClockAhead_ns = 1'234'567'890'123;
XrTime now();
// Timeline time advances with the clock, but by at most kMaxFrameWait_s per frame, so that a slow application
// does not miss events.
constexpr double kMaxFrameWait_s = 0.1;
double timeline_s(XrTime time);

template <class Handle>
Handle new_handle() {
  return reinterpret_cast<Handle>(uintptr_t{++runtime().last_handle << 4});
}

// Records that a call violates the specification, and returns the code for it.
XrResult misuse(XrResult code, const std::string& what);

// Returns the object of a handle, or null.
Instance* find(XrInstance instance);
Session* find(XrSession session);
// The session that owns a space or a swapchain.
Session* session_of(XrSpace space);
Session* session_of(XrSwapchain swapchain);
// The only instance. Valid in all calls on a session.
Instance& the_instance();
std::string path_string(XrPath path);
// True if the simulated headset has controllers of this profile.
bool has_controllers(const std::string& profile);
bool take_path(const std::string& text, XrPath& path);  // false if the text is not a valid path

// Checks that precede every call on a session. Returns HANDLE_INVALID, INSTANCE_LOST, SESSION_LOST, or
// nothing if the session is usable.
std::optional<XrResult> refuse(const Session* session, const char* call);
// Result of a successful call: SUCCESS, or LOSS_PENDING if the session is about to be lost.
XrResult success(const Session& session);

void push_event(const void* event, size_t bytes);
template <class Event>
void push_event(const Event& event) {
  static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
  push_event(&event, sizeof event);
}
// Processes the timeline events that are due.
void play_timeline();

// Poses in stage space.
Pose hand_pose(const std::string& hand, bool aim, XrTime time);
Pose head_pose(XrTime time, XrTime asked);  // predicted at time `asked`
XrPosef to_xr(const Pose& pose);
bool from_xr(const XrPosef& pose,
             Pose& read);  // false if the quaternion is not a unit quaternion or a number is not finite
// Computes stage_from_space. Returns false if the pose is unknown: a hand without focus or without binding.
bool locate(const Session& session, const Space& space, XrTime time, Pose& stage_from_space);

// Fills an array with OpenXR's two-call idiom.
template <class T, class Values>
XrResult fill(uint32_t capacity, uint32_t* count, T* array, const Values& values) {
  if (!count) return XR_ERROR_VALIDATION_FAILURE;
  const size_t size = std::size(values);
  *count = static_cast<uint32_t>(size);
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < size) return XR_ERROR_SIZE_INSUFFICIENT;
  size_t i = 0;
  for (const auto& value : values) array[i++] = value;
  return XR_SUCCESS;
}

}  // namespace livegs::simulated
