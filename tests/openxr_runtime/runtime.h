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

// A runtime without a headset: a timeline moves the head and the hands, pictures are read back, hashed and
// recorded, and every call that OpenXR 1.0 forbids is refused and noted. One instance and one session at a
// time. A mutex guards all state; the calls of one application may come from any thread.
//   LIVEGS_XR_TIMELINE   the timeline; without it nothing moves and nothing happens
//   LIVEGS_XR_OUTPUT     the folder of the record; without it there is none
//   LIVEGS_XR_EYE_SIZE   WxH recommended for an eye; 128x144 without it
//   LIVEGS_XR_CONTROLLERS  the end of the path of the controllers' profile: touch_controller_plus,
//   touch_controller,
//                          simple_controller; without it, the first that the application knows of
//                          actions.cpp's kProfiles
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
  std::string path;  // as the profile has it, with its last component
};
// What an action read at the last sync. `known` is false while nothing that is bound to it can be read.
struct InputState {
  bool known = false, changed = false;
  float value = 0;
  XrTime changed_at = 0;
};

struct Swapchain {
  XrSwapchainCreateInfo info;
  std::vector<SwapchainImage> images;
  std::deque<uint32_t> acquired;  // in order
  bool waited = false;            // for the first of these
  uint32_t next = 0;
  std::optional<uint32_t> released;  // the last
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
  XrTime foretold_for = 0;  // what the next is of
  std::array<EyeForetold, 2> foretold;
  XrTime last_display_time = 0;
  std::set<XrTime> waited_for;  // display times handed out and not yet ended
  double waited_s = 0;          // when the last wait ended
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

const Pose kStageFromLocal{{0, 1.6, 0}, Eigen::Quaterniond::Identity()};  // before a recentre

struct Runtime {
  std::mutex mutex;
  std::condition_variable frame_begun;
  std::map<XrInstance, Instance> instances;  // of one at most, as sessions
  std::map<XrSession, Session> sessions;
  Timeline timeline;
  std::unique_ptr<Record> record;
  // The timeline: second anchor_s was at anchor_ns, when a frame last ended; 0 before the first picture.
  XrTime anchor_ns = 0;
  double anchor_s = 0;
  double played_s = -1;  // the timeline's events up to here have happened
  Pose stage_from_local = kStageFromLocal;
  double refresh_hz = 90, compositor_s = 0, misjudged_m_s = 0;
  uint64_t frames = 0, last_handle = 0;
};

Runtime& runtime();
constexpr XrSystemId kSystem = 7;

// Time: a clock of its own, so that none who takes it for the system's goes unnoticed.
constexpr XrTime kClockAhead_ns = 1'234'567'890'123;
XrTime now();
// It passes with the clock, but by no more than kMaxFrameWait_s a frame: what a slow application does not see
// does not happen.
constexpr double kMaxFrameWait_s = 0.1;
double timeline_s(XrTime time);

template <class Handle>
Handle new_handle() {
  return reinterpret_cast<Handle>(uintptr_t{++runtime().last_handle << 4});
}

// Notes that a call breaks a rule, and gives back the code for it.
XrResult misuse(XrResult code, const std::string& what);

// Null, or the thing of that handle.
Instance* find(XrInstance instance);
Session* find(XrSession session);
// The session that a space or a swapchain is of.
Session* session_of(XrSpace space);
Session* session_of(XrSwapchain swapchain);
// The only instance; calls of a session have one.
Instance& the_instance();
std::string path_string(XrPath path);
// Whether there are controllers of that profile.
bool has_controllers(const std::string& profile);
bool take_path(const std::string& text, XrPath& path);  // false where the text is no path

// What has to be said before anything of a session: HANDLE_INVALID, INSTANCE_LOST, SESSION_LOST, or nothing.
std::optional<XrResult> refuse(const Session* session, const char* call);
// What a call that went well gives back: LOSS_PENDING is a success.
XrResult success(const Session& session);

void push_event(const void* event, size_t bytes);
template <class Event>
void push_event(const Event& event) {
  static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
  push_event(&event, sizeof event);
}
// Lets the timeline's events happen that are due.
void play_timeline();

// Where things are in the stage.
Pose hand_pose(const std::string& hand, bool aim, XrTime time);
Pose head_pose(XrTime time, XrTime asked);  // as it is foretold at `asked`, for a time to come
XrPosef to_xr(const Pose& pose);
bool from_xr(const XrPosef& pose,
             Pose& read);  // false where the quaternion is not unit or a number not finite
// The stage from a space; false where it is not known: a hand that has no focus or is bound to nothing.
bool locate(const Session& session, const Space& space, XrTime time, Pose& stage_from_space);

// Fills an array by OpenXR's two-call idiom.
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
