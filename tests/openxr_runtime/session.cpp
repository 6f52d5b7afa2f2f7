// SPDX-License-Identifier: Apache-2.0
// The session, its states, and the effects of timeline events on it.
#include "runtime.h"

namespace livegs::simulated {
namespace {

const char* name_of(XrSessionState state) {
  constexpr const char* kNames[] = {"unknown", "idle",     "ready",        "synchronized", "visible",
                                    "focused", "stopping", "loss pending", "exiting"};
  return kNames[state];
}

void move_to(Session& session, XrSessionState state) {
  Runtime& all = runtime();
  session.state = state;
  session.frames_in_state = 0;
  all.record->state(timeline_s(now()), name_of(state));
  push_event(XrEventDataSessionStateChanged{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr,
                                            all.sessions.begin()->first, state, now()});
}

// Moves one state towards the target; states are never skipped.
void step_towards(Session& session, XrSessionState wanted) {
  if (!session.running || session.state < XR_SESSION_STATE_SYNCHRONIZED ||
      session.state > XR_SESSION_STATE_FOCUSED)
    return;
  while (session.state > wanted) move_to(session, static_cast<XrSessionState>(session.state - 1));
}

void begin_exit(Session& session) {
  session.exiting = true;
  if (!session.running) return;
  step_towards(session, XR_SESSION_STATE_SYNCHRONIZED);
  move_to(session, XR_SESSION_STATE_STOPPING);
}

void recentre(const Timeline::Event& event) {
  const double turn = event.numbers[3] * EIGEN_PI / 180;
  runtime().stage_from_local = {{event.numbers[0], event.numbers[1], event.numbers[2]},
                                Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()))};
  XrEventDataReferenceSpaceChangePending change{};
  change.type = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
  change.session = runtime().sessions.begin()->first;
  change.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  change.changeTime = now();
  change.poseValid = XR_FALSE;
  push_event(change);
}

void refresh(double hz) {
  const auto from = static_cast<float>(std::exchange(runtime().refresh_hz, hz));
  if (!the_instance().extensions.contains(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME)) return;
  push_event(XrEventDataDisplayRefreshRateChangedFB{XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB,
                                                    nullptr, from, static_cast<float>(hz)});
}

void happen(Session& session, const Timeline::Event& event) {
  constexpr XrTime kUnplugged_ns = 300'000'000;
  if (event.name == "hide") {
    session.hidden = true;
    step_towards(session, XR_SESSION_STATE_SYNCHRONIZED);
  } else if (event.name == "show") {
    session.hidden = false;
  } else if (event.name == "take-focus") {
    session.unfocused = true;
    step_towards(session, XR_SESSION_STATE_VISIBLE);
  } else if (event.name == "give-focus") {
    session.unfocused = false;
  } else if (event.name == "lose-session") {
    the_instance().no_headset_until = now() + kUnplugged_ns;
    session.loss = Session::Loss::Pending;
    move_to(session, XR_SESSION_STATE_LOSS_PENDING);
  } else if (event.name == "cut-session") {
    session.loss = Session::Loss::Lost;
    runtime().record->state(timeline_s(now()), "lost");
  } else if (event.name == "vanish") {
    XrEventDataInstanceLossPending pending{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, nullptr, now()};
    push_event(pending);
  } else if (event.name == "die") {
    the_instance().dead = true;
    runtime().record->state(timeline_s(now()), "dead");
  } else if (event.name == "recentre") {
    recentre(event);
  } else if (event.name == "refresh") {
    refresh(event.numbers[0]);
  } else if (event.name == "compositor") {
    runtime().compositor_s = event.numbers[0];
  } else if (event.name == "misjudge") {
    runtime().misjudged_m_s = event.numbers[0];
  } else if (event.name == "picture") {
    session.keep_next = true;
  } else if (event.name == "exit") {
    begin_exit(session);
  }
}

}  // namespace

void play_timeline() {
  Runtime& all = runtime();
  if (all.sessions.empty() || the_instance().dead) return;  // due events wait for a session
  Session& session = all.sessions.begin()->second;
  const double now_s = all.anchor_ns == 0 ? -1 : timeline_s(now());
  for (const Timeline::Event& event : all.timeline.events(all.played_s, now_s)) {
    if (session.loss != Session::Loss::None || the_instance().dead) break;
    all.played_s = event.time_s;
    happen(session, event);
  }
  // One frame in each state on the way up, so that the application observes every state.
  if (session.loss != Session::Loss::None || the_instance().dead || session.exiting ||
      session.frames_in_state == 0)
    return;
  if (session.state == XR_SESSION_STATE_SYNCHRONIZED && !session.hidden)
    move_to(session, XR_SESSION_STATE_VISIBLE);
  else if (session.state == XR_SESSION_STATE_VISIBLE && !session.unfocused && !session.hidden)
    move_to(session, XR_SESSION_STATE_FOCUSED);
  else if (session.state == XR_SESSION_STATE_READY && session.running)
    move_to(session, XR_SESSION_STATE_SYNCHRONIZED);
}

Session* find(XrSession session) {
  const auto found = runtime().sessions.find(session);
  return found == runtime().sessions.end() ? nullptr : &found->second;
}

std::optional<XrResult> refuse(const Session* session, const char* call) {
  if (!session) return misuse(XR_ERROR_HANDLE_INVALID, std::string(call) + ": no such handle");
  if (the_instance().dead) return XR_ERROR_INSTANCE_LOST;
  if (session->loss == Session::Loss::Lost) return XR_ERROR_SESSION_LOST;
  return std::nullopt;
}

XrResult success(const Session& session) {
  return session.loss == Session::Loss::Pending ? XR_SESSION_LOSS_PENDING : XR_SUCCESS;
}

}  // namespace livegs::simulated

using namespace livegs::simulated;

XrResult xrCreateSession(XrInstance instance, const XrSessionCreateInfo* info, XrSession* session) {
  std::lock_guard lock(runtime().mutex);
  Runtime& all = runtime();
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrCreateSession: no such instance");
  if (found->dead) return XR_ERROR_INSTANCE_LOST;
  if (!info || info->type != XR_TYPE_SESSION_CREATE_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateSession: not an XrSessionCreateInfo");
  if (info->systemId != kSystem) return misuse(XR_ERROR_SYSTEM_INVALID, "xrCreateSession: no such system");
  if (!all.sessions.empty())
    return misuse(XR_ERROR_LIMIT_REACHED, "xrCreateSession: a session exists already");
  const auto* binding = static_cast<const XrGraphicsBindingVulkan2KHR*>(info->next);
  if (!binding || binding->type != XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR || !binding->device)
    return misuse(XR_ERROR_GRAPHICS_DEVICE_INVALID,
                  "xrCreateSession: the binding is not an XrGraphicsBindingVulkan2KHR");
  if (!found->requirements_asked)
    return misuse(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING,
                  "xrCreateSession: called before xrGetVulkanGraphicsRequirements2KHR");
  if (now() < found->no_headset_until) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
  Session made;
  if (!made.graphics.open(found->vulkan_of, *binding)) return XR_ERROR_RUNTIME_FAILURE;
  *session = new_handle<XrSession>();
  ++found->sessions_made;
  Session& created = all.sessions.emplace(*session, std::move(made)).first->second;
  move_to(created, XR_SESSION_STATE_IDLE);
  move_to(created, XR_SESSION_STATE_READY);
  return XR_SUCCESS;
}

XrResult xrDestroySession(XrSession session) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroySession: no such session");
  runtime().record->handles("session", "swapchain", found->swapchains_made, found->swapchains.size());
  runtime().record->handles("session", "space", found->spaces_made, found->spaces.size());
  for (auto& [handle, swapchain] : found->swapchains) {
    for (SwapchainImage& image : swapchain.images) found->graphics.destroy(image);
  }
  found->graphics.close();
  runtime().sessions.erase(session);
  for (auto& [handle, set] : the_instance().sets) set.attached = false;
  the_instance().events.clear();  // events of the destroyed session
  return XR_SUCCESS;
}

XrResult xrBeginSession(XrSession session, const XrSessionBeginInfo* info) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrBeginSession")) return *refused;
  if (found->running) return misuse(XR_ERROR_SESSION_RUNNING, "xrBeginSession: the session is running");
  if (found->state != XR_SESSION_STATE_READY)
    return misuse(XR_ERROR_SESSION_NOT_READY, "xrBeginSession: the state is not READY");
  if (!info || info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
    return misuse(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
                  "xrBeginSession: the view configuration is not stereo");
  found->running = true;
  if (found->exiting) begin_exit(*found);
  return success(*found);
}

XrResult xrEndSession(XrSession session) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrEndSession")) return *refused;
  if (!found->running)
    return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrEndSession: the session is not running");
  if (found->state != XR_SESSION_STATE_STOPPING)
    return misuse(XR_ERROR_SESSION_NOT_STOPPING, "xrEndSession: the state is not STOPPING");
  found->running = false;
  found->waited = found->begun = false;
  move_to(*found, XR_SESSION_STATE_IDLE);
  move_to(*found, found->exiting ? XR_SESSION_STATE_EXITING : XR_SESSION_STATE_READY);
  return success(*found);
}

XrResult xrRequestExitSession(XrSession session) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrRequestExitSession")) return *refused;
  if (!found->running)
    return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrRequestExitSession: the session is not running");
  if (!found->exiting) begin_exit(*found);
  return success(*found);
}

namespace {
constexpr float kRates[] = {72, 80, 90, 120};
}

XrResult xrEnumerateDisplayRefreshRatesFB(XrSession session, uint32_t capacity, uint32_t* count,
                                          float* rates) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrEnumerateDisplayRefreshRatesFB")) return *refused;
  return fill(capacity, count, rates, kRates);
}

XrResult xrGetDisplayRefreshRateFB(XrSession session, float* rate) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrGetDisplayRefreshRateFB")) return *refused;
  *rate = static_cast<float>(runtime().refresh_hz);
  return XR_SUCCESS;
}

XrResult xrRequestDisplayRefreshRateFB(XrSession session, float rate) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrRequestDisplayRefreshRateFB")) return *refused;
  if (rate == 0) return XR_SUCCESS;  // 0: no preferred rate
  for (const float one : kRates) {
    if (one != rate) continue;
    if (rate != static_cast<float>(runtime().refresh_hz)) refresh(rate);
    return XR_SUCCESS;
  }
  return misuse(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB, "xrRequestDisplayRefreshRateFB: no such rate");
}
