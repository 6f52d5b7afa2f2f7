// SPDX-License-Identifier: Apache-2.0
// Spaces. STAGE is the root. LOCAL has a fixed pose in it, which a recentre event changes. Timeline poses are
// in STAGE.
#include <algorithm>
#include <cmath>

#include "runtime.h"

namespace livegs::simulated {
namespace {

constexpr double kEyeDistance_m = 0.064;
// Field of view of the left eye; the right eye is its mirror image. Radians: left, right, up, down.
constexpr XrFovf kLeftFov{-0.90f, 0.75f, 0.80f, -0.85f};
// Poses are known up to this time after now, ns.
constexpr XrTime kMaxLookahead_ns = 1'000'000'000;

}  // namespace

XrPosef to_xr(const Pose& pose) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const Eigen::Quaterniond& q = pose.orientation;
  return {{f(q.x()), f(q.y()), f(q.z()), f(q.w())},
          {f(pose.position_m.x()), f(pose.position_m.y()), f(pose.position_m.z())}};
}

bool from_xr(const XrPosef& pose, Pose& read) {
  const Eigen::Quaterniond q(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z);
  read = {{pose.position.x, pose.position.y, pose.position.z}, q.normalized()};
  return read.position_m.allFinite() && std::abs(q.norm() - 1) < 0.01;
}

Pose head_pose(XrTime time, XrTime asked) {
  Pose pose{{0, 1.6, 0}, Eigen::Quaterniond::Identity()};
  if (runtime().timeline.has("head")) pose = runtime().timeline.pose("head", timeline_s(time));
  pose.position_m.x() +=
      runtime().misjudged_m_s * 1e-9 * static_cast<double>(std::max<XrTime>(0, time - asked));
  return pose;
}

Pose hand_pose(const std::string& hand, bool aim, XrTime time) {
  const std::string track = aim && runtime().timeline.has(hand + ".aim") ? hand + ".aim" : hand;
  // Future hand motion is unknown, as with real controllers: the hand is assumed to stay.
  return runtime().timeline.pose(track, timeline_s(std::min(time, now())));
}

Session* session_of(XrSpace space) {
  for (auto& [handle, session] : runtime().sessions) {
    if (session.spaces.contains(space)) return &session;
  }
  return nullptr;
}

bool locate(const Session& session, const Space& space, XrTime time, Pose& stage_from_space) {
  Pose stage_from_root;
  if (space.reference) {
    if (*space.reference == XR_REFERENCE_SPACE_TYPE_LOCAL) stage_from_root = runtime().stage_from_local;
    if (*space.reference == XR_REFERENCE_SPACE_TYPE_VIEW) stage_from_root = head_pose(time, now());
  } else {
    const auto state = session.inputs.find({space.action, space.subaction});
    if (session.state != XR_SESSION_STATE_FOCUSED || state == session.inputs.end() || !state->second.known)
      return false;
    const std::string hand = path_string(space.subaction) == "/user/hand/left" ? "left" : "right";
    if (!runtime().timeline.has(hand)) return false;
    bool aim = false;
    for (const Binding& binding : the_instance().suggested[session.profile])
      aim = aim || (binding.action == space.action && binding.path.ends_with("/aim/pose"));
    stage_from_root = hand_pose(hand, aim, time);
  }
  stage_from_space = stage_from_root * space.offset;
  return true;
}

}  // namespace livegs::simulated

using namespace livegs;
using namespace livegs::simulated;

XrResult xrEnumerateReferenceSpaces(XrSession session, uint32_t capacity, uint32_t* count,
                                    XrReferenceSpaceType* types) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrEnumerateReferenceSpaces")) return *refused;
  return fill(capacity, count, types,
              std::vector{XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL,
                          XR_REFERENCE_SPACE_TYPE_STAGE});
}

XrResult xrCreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrCreateReferenceSpace")) return *refused;
  Space made;
  if (!info || info->type != XR_TYPE_REFERENCE_SPACE_CREATE_INFO ||
      !from_xr(info->poseInReferenceSpace, made.offset))
    return misuse(XR_ERROR_POSE_INVALID, "xrCreateReferenceSpace: the pose is not valid");
  if (info->referenceSpaceType < XR_REFERENCE_SPACE_TYPE_VIEW ||
      info->referenceSpaceType > XR_REFERENCE_SPACE_TYPE_STAGE)
    return misuse(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED,
                  "xrCreateReferenceSpace: the space type was not enumerated");
  made.reference = info->referenceSpaceType;
  *space = new_handle<XrSpace>();
  ++found->spaces_made;
  found->spaces.emplace(*space, made);
  return success(*found);
}

XrResult xrGetReferenceSpaceBoundsRect(XrSession session, XrReferenceSpaceType, XrExtent2Df* bounds) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrGetReferenceSpaceBoundsRect")) return *refused;
  *bounds = {0, 0};
  return XR_SPACE_BOUNDS_UNAVAILABLE;
}

XrResult xrCreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrCreateActionSpace")) return *refused;
  Space made;
  if (!info || info->type != XR_TYPE_ACTION_SPACE_CREATE_INFO ||
      !from_xr(info->poseInActionSpace, made.offset))
    return misuse(XR_ERROR_POSE_INVALID, "xrCreateActionSpace: the pose is not valid");
  const auto action = the_instance().actions.find(info->action);
  if (action == the_instance().actions.end())
    return misuse(XR_ERROR_HANDLE_INVALID, "xrCreateActionSpace: no such action");
  if (action->second.type != XR_ACTION_TYPE_POSE_INPUT)
    return misuse(XR_ERROR_ACTION_TYPE_MISMATCH, "xrCreateActionSpace: the action is not a pose action");
  if (info->subactionPath != XR_NULL_PATH && !action->second.subactions.contains(info->subactionPath))
    return misuse(XR_ERROR_PATH_UNSUPPORTED, "xrCreateActionSpace: the action has no such subaction");
  made.action = info->action;
  made.subaction = info->subactionPath;
  *space = new_handle<XrSpace>();
  ++found->spaces_made;
  found->spaces.emplace(*space, made);
  return success(*found);
}

XrResult xrDestroySpace(XrSpace space) {
  std::lock_guard lock(runtime().mutex);
  Session* session = session_of(space);
  if (!session) return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroySpace: no such space");
  session->spaces.erase(space);
  return XR_SUCCESS;
}

XrResult xrLocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  std::lock_guard lock(runtime().mutex);
  Session* session = session_of(space);
  if (const auto refused = refuse(session, "xrLocateSpace")) return *refused;
  if (session_of(base) != session)
    return misuse(XR_ERROR_HANDLE_INVALID, "xrLocateSpace: the base is not a space of the session");
  if (!location || location->type != XR_TYPE_SPACE_LOCATION)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrLocateSpace: not an XrSpaceLocation");
  if (time <= 0 || time > now() + kMaxLookahead_ns)
    return misuse(XR_ERROR_TIME_INVALID, "xrLocateSpace: no poses are known at this time");
  location->locationFlags = 0;
  location->pose = to_xr({});
  Pose stage_from_space, stage_from_base;
  if (locate(*session, session->spaces[space], time, stage_from_space) &&
      locate(*session, session->spaces[base], time, stage_from_base)) {
    location->locationFlags = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                              XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT |
                              XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    location->pose = to_xr(stage_from_base.inverse() * stage_from_space);
  }
  return success(*session);
}

XrResult xrLocateViews(XrSession session, const XrViewLocateInfo* info, XrViewState* state, uint32_t capacity,
                       uint32_t* count, XrView* views) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrLocateViews")) return *refused;
  if (!info || info->type != XR_TYPE_VIEW_LOCATE_INFO || !state || state->type != XR_TYPE_VIEW_STATE)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrLocateViews: not an XrViewLocateInfo and an XrViewState");
  if (info->viewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
    return misuse(XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
                  "xrLocateViews: the view configuration is not stereo");
  if (info->displayTime <= 0)
    return misuse(XR_ERROR_TIME_INVALID, "xrLocateViews: no poses are known at this time");
  const auto base = found->spaces.find(info->space);
  if (base == found->spaces.end()) return misuse(XR_ERROR_HANDLE_INVALID, "xrLocateViews: no such space");
  *count = 2;
  Pose stage_from_base;
  if (!locate(*found, base->second, info->displayTime, stage_from_base)) {
    state->viewStateFlags = 0;
    return success(*found);
  }
  state->viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT |
                          XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT;
  if (capacity == 0) return success(*found);
  if (capacity < 2)
    return misuse(XR_ERROR_SIZE_INSUFFICIENT, "xrLocateViews: the array is too short for two views");
  const XrTime asked = now();  // the same time for the answer and for its record
  const double lead_s = 1e-9 * static_cast<double>(info->displayTime - asked);
  const Pose stage_from_head = head_pose(info->displayTime, asked);
  if (std::exchange(found->predicted_for, info->displayTime) != info->displayTime) found->predictions = {};
  for (size_t eye = 0; eye < 2; ++eye) {
    if (views[eye].type != XR_TYPE_VIEW)
      return misuse(XR_ERROR_VALIDATION_FAILURE, "xrLocateViews: not an XrView");
    const double side_m = (static_cast<double>(eye) - 0.5) * kEyeDistance_m;
    const Pose stage_from_eye = stage_from_head * Pose{{side_m, 0, 0}, Eigen::Quaterniond::Identity()};
    views[eye].pose = to_xr(stage_from_base.inverse() * stage_from_eye);
    EyePrediction& prediction = found->predictions[eye];
    prediction.last = to_xr(stage_from_eye).position;
    prediction.last_lead_s = lead_s;
    if (prediction.answers++ == 0) prediction.first = prediction.last, prediction.first_lead_s = lead_s;
    views[eye].fov =
        eye == 0 ? kLeftFov
                 : XrFovf{-kLeftFov.angleRight, -kLeftFov.angleLeft, kLeftFov.angleUp, kLeftFov.angleDown};
  }
  return success(*found);
}
