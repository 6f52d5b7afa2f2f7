// SPDX-License-Identifier: Apache-2.0
// Action sets, interaction profiles, and input from the timeline.
#include <algorithm>
#include <cstdlib>

#include "runtime.h"

namespace livegs::simulated {
namespace {

// The components of a profile in one string; "l:" and "r:" mark components of one hand. The profile in use is
// the first one that the headset has controllers for and that the application suggests bindings for.
struct Profile {
  const char* path;
  const char* components;
};
constexpr Profile kProfiles[] = {
    {"/interaction_profiles/meta/touch_controller_plus",
     " input/grip/pose input/aim/pose input/trigger/value input/trigger/touch input/squeeze/value "
     "input/thumbstick/x"
     " input/thumbstick/y input/thumbstick/click l:input/x/click l:input/y/click l:input/menu/click "
     "r:input/a/click"
     " r:input/b/click r:input/system/click output/haptic "},
    {"/interaction_profiles/oculus/touch_controller",
     " input/grip/pose input/aim/pose input/trigger/value input/trigger/touch input/squeeze/value "
     "input/thumbstick/x"
     " input/thumbstick/y input/thumbstick/click input/thumbrest/touch l:input/x/click l:input/y/click "
     "l:input/menu/click"
     " r:input/a/click r:input/b/click r:input/system/click output/haptic "},
    {"/interaction_profiles/khr/simple_controller",
     " input/grip/pose input/aim/pose input/select/click input/menu/click output/haptic "},
    {"/interaction_profiles/htc/vive_controller",
     " input/grip/pose input/aim/pose input/squeeze/click input/menu/click input/trigger/value "
     "input/trigger/click output/haptic "},
    {"/interaction_profiles/valve/index_controller",
     " input/grip/pose input/aim/pose input/squeeze/value input/squeeze/force input/trigger/value "
     "input/a/click input/b/click"
     " output/haptic "},
    {"/interaction_profiles/microsoft/motion_controller",
     " input/grip/pose input/aim/pose input/squeeze/click input/menu/click input/trigger/value "
     "output/haptic "},
};

// The component that a binding refers to, with the suffix added if the binding omits it. Empty if the profile
// does not have the component.
std::string component_of(const Profile& profile, const std::string& path) {
  const bool left = path.starts_with("/user/hand/left/"), right = path.starts_with("/user/hand/right/");
  if (!left && !right) return "";
  const std::string rest = path.substr(path.find("hand/") + (left ? 10 : 11));
  const std::string all = profile.components;
  for (const char* ending : {"", "/value", "/click", "/pose"}) {
    const std::string whole = rest + ending;
    for (const char* side : {" ", left ? " l:" : " r:"}) {
      if (all.find(side + whole + " ") != std::string::npos) return whole;
    }
  }
  return "";
}

// The timeline track of a component, for example "left.trigger".
std::string track_of(const std::string& path) {
  const std::string hand = path.starts_with("/user/hand/left/") ? "left." : "right.";
  for (const auto& [part, track] : {std::pair("/trigger/", "trigger"),
                                    {"/select/", "trigger"},
                                    {"/squeeze/", "squeeze"},
                                    {"/x/", "primary"},
                                    {"/a/", "primary"},
                                    {"/y/", "secondary"},
                                    {"/b/", "secondary"},
                                    {"/menu/", "menu"}}) {
    if (path.find(part) != std::string::npos) return hand + track;
  }
  return "";
}

bool is_input_of(XrActionType type, const std::string& component) {
  if (component.ends_with("/pose")) return type == XR_ACTION_TYPE_POSE_INPUT;
  if (component == "output/haptic") return type == XR_ACTION_TYPE_VIBRATION_OUTPUT;
  return type == XR_ACTION_TYPE_BOOLEAN_INPUT || type == XR_ACTION_TYPE_FLOAT_INPUT;
}

std::string hand_of(const std::string& path) {
  return path.starts_with("/user/hand/left") ? "/user/hand/left" : "/user/hand/right";
}

void use_profile(Session& session) {
  for (const Profile& profile : kProfiles) {
    if (!session.profile.empty() || !the_instance().suggested.contains(profile.path) ||
        !has_controllers(profile.path))
      continue;
    session.profile = profile.path;
    runtime().record->profile(timeline_s(now()), session.profile);
    push_event(XrEventDataInteractionProfileChanged{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, nullptr,
                                                    runtime().sessions.begin()->first});
  }
}

// Current value of a bound component. Buttons are pressed above 0.5.
float value_of(const Binding& binding, XrActionType type, double time_s) {
  const auto value = static_cast<float>(runtime().timeline.input(track_of(binding.path), time_s));
  const bool button = type == XR_ACTION_TYPE_BOOLEAN_INPUT || binding.path.ends_with("/click");
  return button ? (value > 0.5f ? 1.0f : 0.0f) : value;
}

void read_inputs(Session& session) {
  const auto before = std::exchange(session.inputs, {});
  const Instance& instance = the_instance();
  const XrTime at = now();
  const bool focused = session.state == XR_SESSION_STATE_FOCUSED;
  const auto bindings = instance.suggested.find(session.profile);
  for (const auto& [handle, action] : instance.actions) {
    const auto set = instance.sets.find(action.set);
    if (set == instance.sets.end() || !set->second.attached) continue;
    std::vector<XrPath> subactions(action.subactions.begin(), action.subactions.end());
    subactions.push_back(XR_NULL_PATH);  // no subaction: the combined state
    for (const XrPath subaction : subactions) {
      InputState state;
      if (focused && bindings != instance.suggested.end()) {
        for (const Binding& binding : bindings->second) {
          if (binding.action != handle ||
              (subaction != XR_NULL_PATH && path_string(subaction) != hand_of(binding.path)))
            continue;
          state.known = true;
          state.value = std::max(state.value, value_of(binding, action.type, timeline_s(at)));
        }
      }
      const auto last = before.find({handle, subaction});
      state.changed =
          last != before.end() && last->second.known && state.known && last->second.value != state.value;
      state.changed_at = state.changed || last == before.end() ? at : last->second.changed_at;
      session.inputs[{handle, subaction}] = state;
    }
  }
}

// Finds the state that a getter refers to; returns an error code for an invalid call.
XrResult look_up(XrSession handle, const XrActionStateGetInfo* info, XrActionType type, const char* call,
                 InputState& state) {
  Session* session = find(handle);
  if (const auto refused = refuse(session, call)) return *refused;
  if (!info || info->type != XR_TYPE_ACTION_STATE_GET_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, std::string(call) + ": not an XrActionStateGetInfo");
  const Instance& instance = the_instance();
  const auto action = instance.actions.find(info->action);
  if (action == instance.actions.end())
    return misuse(XR_ERROR_HANDLE_INVALID, std::string(call) + ": no such action");
  if (action->second.type != type)
    return misuse(XR_ERROR_ACTION_TYPE_MISMATCH,
                  std::string(call) + ": " + action->second.name + " has a different type");
  if (!instance.sets.at(action->second.set).attached)
    return misuse(XR_ERROR_ACTIONSET_NOT_ATTACHED,
                  std::string(call) + ": the set of " + action->second.name + " is not attached");
  if (info->subactionPath != XR_NULL_PATH && !action->second.subactions.contains(info->subactionPath))
    return misuse(XR_ERROR_PATH_UNSUPPORTED,
                  std::string(call) + ": " + action->second.name + " has no such subaction");
  const auto found = session->inputs.find({info->action, info->subactionPath});
  if (found != session->inputs.end()) state = found->second;
  return success(*session);
}

bool is_top_level(const std::string& path) {
  return path == "/user/hand/left" || path == "/user/hand/right" || path == "/user/head" ||
         path == "/user/gamepad";
}

// Checks that an output action can be used; returns an error code otherwise.
std::optional<XrResult> refuse_output(const Session* session, const XrHapticActionInfo* info,
                                      const char* call) {
  if (const auto refused = refuse(session, call)) return refused;
  if (!info || info->type != XR_TYPE_HAPTIC_ACTION_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, std::string(call) + ": not an XrHapticActionInfo");
  const auto action = the_instance().actions.find(info->action);
  if (action == the_instance().actions.end())
    return misuse(XR_ERROR_HANDLE_INVALID, std::string(call) + ": no such action");
  if (action->second.type != XR_ACTION_TYPE_VIBRATION_OUTPUT)
    return misuse(XR_ERROR_ACTION_TYPE_MISMATCH, std::string(call) + ": not an output action");
  if (!the_instance().sets.at(action->second.set).attached)
    return misuse(XR_ERROR_ACTIONSET_NOT_ATTACHED,
                  std::string(call) + ": the set of " + action->second.name + " is not attached");
  if (info->subactionPath != XR_NULL_PATH && !action->second.subactions.contains(info->subactionPath))
    return misuse(XR_ERROR_PATH_UNSUPPORTED,
                  std::string(call) + ": " + action->second.name + " has no such subaction");
  return std::nullopt;
}

bool is_name(const char* name) {
  return name[0] &&
         std::string(name).find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_.") == std::string::npos;
}

}  // namespace

bool has_controllers(const std::string& profile) {
  const char* there = std::getenv("LIVEGS_XR_CONTROLLERS");
  return !there || profile.ends_with(std::string("/") + there);
}

}  // namespace livegs::simulated

using namespace livegs::simulated;

XrResult xrCreateActionSet(XrInstance instance, const XrActionSetCreateInfo* info, XrActionSet* set) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrCreateActionSet: no such instance");
  if (!info || !is_name(info->actionSetName))
    return misuse(XR_ERROR_NAME_INVALID, "xrCreateActionSet: no name");
  if (!info->localizedActionSetName[0])
    return misuse(XR_ERROR_LOCALIZED_NAME_INVALID, "xrCreateActionSet: no localized name");
  for (const auto& [handle, other] : found->sets) {
    if (other.name == info->actionSetName)
      return misuse(XR_ERROR_NAME_DUPLICATED, "xrCreateActionSet: duplicate name");
    if (other.localized == info->localizedActionSetName)
      return misuse(XR_ERROR_LOCALIZED_NAME_DUPLICATED, "xrCreateActionSet: duplicate localized name");
  }
  *set = new_handle<XrActionSet>();
  ++found->sets_made;
  found->sets[*set] = {info->actionSetName, info->localizedActionSetName, info->priority, false};
  return XR_SUCCESS;
}

XrResult xrDestroyActionSet(XrActionSet set) {
  std::lock_guard lock(runtime().mutex);
  if (runtime().instances.empty() || !the_instance().sets.erase(set))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroyActionSet: no such set");
  std::erase_if(the_instance().actions, [&](const auto& action) { return action.second.set == set; });
  return XR_SUCCESS;
}

XrResult xrCreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  std::lock_guard lock(runtime().mutex);
  Instance& instance = the_instance();
  const auto found = instance.sets.find(set);
  if (found == instance.sets.end()) return misuse(XR_ERROR_HANDLE_INVALID, "xrCreateAction: no such set");
  if (found->second.attached)
    return misuse(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "xrCreateAction: its set is attached");
  if (!info || !is_name(info->actionName)) return misuse(XR_ERROR_NAME_INVALID, "xrCreateAction: no name");
  if (!info->localizedActionName[0])
    return misuse(XR_ERROR_LOCALIZED_NAME_INVALID, "xrCreateAction: no localized name");
  for (const auto& [handle, other] : instance.actions) {
    if (other.set != set) continue;
    if (other.name == info->actionName)
      return misuse(XR_ERROR_NAME_DUPLICATED, "xrCreateAction: duplicate name");
    if (other.localized == info->localizedActionName)
      return misuse(XR_ERROR_LOCALIZED_NAME_DUPLICATED, "xrCreateAction: duplicate localized name");
  }
  Action made{set, info->actionType, info->actionName, info->localizedActionName, {}};
  for (uint32_t i = 0; i < info->countSubactionPaths; ++i) {
    const std::string path = path_string(info->subactionPaths[i]);
    if (!is_top_level(path))
      return misuse(XR_ERROR_PATH_UNSUPPORTED, "xrCreateAction: " + path + " is not a subaction path");
    if (!made.subactions.insert(info->subactionPaths[i]).second)
      return misuse(XR_ERROR_PATH_UNSUPPORTED, "xrCreateAction: " + path + " is given twice");
  }
  *action = new_handle<XrAction>();
  ++instance.actions_made;
  instance.actions.emplace(*action, std::move(made));
  return XR_SUCCESS;
}

XrResult xrDestroyAction(XrAction action) {
  std::lock_guard lock(runtime().mutex);
  if (runtime().instances.empty() || !the_instance().actions.erase(action))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroyAction: no such action");
  return XR_SUCCESS;
}

XrResult xrSuggestInteractionProfileBindings(XrInstance instance,
                                             const XrInteractionProfileSuggestedBinding* info) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrSuggestInteractionProfileBindings: no such instance");
  const std::string path = path_string(info->interactionProfile);
  const auto profile = std::find_if(std::begin(kProfiles), std::end(kProfiles),
                                    [&](const Profile& one) { return path == one.path; });
  if (profile == std::end(kProfiles) || (path.find("plus") != std::string::npos &&
                                         !found->extensions.contains("XR_META_touch_controller_plus")))
    return misuse(XR_ERROR_PATH_UNSUPPORTED, "xrSuggestInteractionProfileBindings: no profile " + path);
  std::vector<Binding> bindings;
  for (uint32_t i = 0; i < info->countSuggestedBindings; ++i) {
    const auto action = found->actions.find(info->suggestedBindings[i].action);
    if (action == found->actions.end())
      return misuse(XR_ERROR_HANDLE_INVALID, "xrSuggestInteractionProfileBindings: no such action");
    if (found->sets.at(action->second.set).attached)
      return misuse(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
                    "xrSuggestInteractionProfileBindings: after xrAttachSessionActionSets");
    const std::string bound = path_string(info->suggestedBindings[i].binding);
    const std::string component = component_of(*profile, bound);
    if (component.empty() || !is_input_of(action->second.type, component))
      return misuse(XR_ERROR_PATH_UNSUPPORTED, "xrSuggestInteractionProfileBindings: " + path + " has no " +
                                                   bound + " for " + action->second.name);
    bindings.push_back({action->first, hand_of(bound) + "/" + component});
  }
  found->suggested[path] = std::move(bindings);
  return XR_SUCCESS;
}

XrResult xrAttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrAttachSessionActionSets")) return *refused;
  if (found->attached)
    return misuse(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "xrAttachSessionActionSets: called twice");
  if (!info || info->type != XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO || info->countActionSets == 0)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrAttachSessionActionSets: no sets");
  for (uint32_t i = 0; i < info->countActionSets; ++i) {
    const auto set = the_instance().sets.find(info->actionSets[i]);
    if (set == the_instance().sets.end())
      return misuse(XR_ERROR_HANDLE_INVALID, "xrAttachSessionActionSets: no such set");
    set->second.attached = true;
  }
  found->attached = true;
  return success(*found);
}

XrResult xrGetCurrentInteractionProfile(XrSession session, XrPath user, XrInteractionProfileState* state) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrGetCurrentInteractionProfile")) return *refused;
  if (!found->attached)
    return misuse(XR_ERROR_ACTIONSET_NOT_ATTACHED, "xrGetCurrentInteractionProfile: no set is attached");
  if (path_string(user).empty())
    return misuse(XR_ERROR_PATH_INVALID, "xrGetCurrentInteractionProfile: no such path");
  if (!is_top_level(path_string(user)))
    return misuse(XR_ERROR_PATH_UNSUPPORTED,
                  "xrGetCurrentInteractionProfile: " + path_string(user) + " is not a hand of the user");
  state->interactionProfile = XR_NULL_PATH;
  if (!found->profile.empty()) take_path(found->profile, state->interactionProfile);
  return success(*found);
}

XrResult xrSyncActions(XrSession session, const XrActionsSyncInfo* info) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrSyncActions")) return *refused;
  if (!info || info->type != XR_TYPE_ACTIONS_SYNC_INFO)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrSyncActions: not an XrActionsSyncInfo");
  for (uint32_t i = 0; i < info->countActiveActionSets; ++i) {
    const auto set = the_instance().sets.find(info->activeActionSets[i].actionSet);
    if (set == the_instance().sets.end())
      return misuse(XR_ERROR_HANDLE_INVALID, "xrSyncActions: no such set");
    if (!set->second.attached)
      return misuse(XR_ERROR_ACTIONSET_NOT_ATTACHED,
                    "xrSyncActions: " + set->second.name + " is not attached");
  }
  use_profile(*found);
  read_inputs(*found);
  if (found->state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
  return success(*found);
}

XrResult xrGetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info,
                                 XrActionStateBoolean* read) {
  std::lock_guard lock(runtime().mutex);
  InputState state;
  const XrResult result =
      look_up(session, info, XR_ACTION_TYPE_BOOLEAN_INPUT, "xrGetActionStateBoolean", state);
  if (XR_FAILED(result)) return result;
  read->currentState = state.value > 0.5f;
  read->changedSinceLastSync = state.changed;
  read->lastChangeTime = state.changed_at;
  read->isActive = state.known;
  return result;
}

XrResult xrGetActionStateFloat(XrSession session, const XrActionStateGetInfo* info,
                               XrActionStateFloat* read) {
  std::lock_guard lock(runtime().mutex);
  InputState state;
  const XrResult result = look_up(session, info, XR_ACTION_TYPE_FLOAT_INPUT, "xrGetActionStateFloat", state);
  if (XR_FAILED(result)) return result;
  read->currentState = state.value;
  read->changedSinceLastSync = state.changed;
  read->lastChangeTime = state.changed_at;
  read->isActive = state.known;
  return result;
}

XrResult xrGetActionStateVector2f(XrSession session, const XrActionStateGetInfo* info,
                                  XrActionStateVector2f* read) {
  std::lock_guard lock(runtime().mutex);
  InputState state;
  const XrResult result =
      look_up(session, info, XR_ACTION_TYPE_VECTOR2F_INPUT, "xrGetActionStateVector2f", state);
  if (XR_FAILED(result)) return result;
  read->currentState = {0, 0};
  read->changedSinceLastSync = XR_FALSE;
  read->isActive = XR_FALSE;
  return result;
}

XrResult xrGetActionStatePose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* read) {
  std::lock_guard lock(runtime().mutex);
  InputState state;
  const XrResult result = look_up(session, info, XR_ACTION_TYPE_POSE_INPUT, "xrGetActionStatePose", state);
  if (XR_FAILED(result)) return result;
  read->isActive = state.known;
  return result;
}

XrResult xrEnumerateBoundSourcesForAction(XrSession session, const XrBoundSourcesForActionEnumerateInfo* info,
                                          uint32_t capacity, uint32_t* count, XrPath* sources) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse(found, "xrEnumerateBoundSourcesForAction")) return *refused;
  if (!found->attached)
    return misuse(XR_ERROR_ACTIONSET_NOT_ATTACHED, "xrEnumerateBoundSourcesForAction: no set is attached");
  if (!the_instance().actions.contains(info->action))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrEnumerateBoundSourcesForAction: no such action");
  std::vector<XrPath> paths;
  for (const Binding& binding : the_instance().suggested[found->profile]) {
    if (binding.action == info->action) take_path(binding.path, paths.emplace_back());
  }
  return fill(capacity, count, sources, paths);
}

XrResult xrGetInputSourceLocalizedName(XrSession session, const XrInputSourceLocalizedNameGetInfo* info,
                                       uint32_t capacity, uint32_t* count, char* text) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse(find(session), "xrGetInputSourceLocalizedName")) return *refused;
  const std::string path = path_string(info->sourcePath);
  if (path.empty()) return misuse(XR_ERROR_PATH_INVALID, "xrGetInputSourceLocalizedName: no such path");
  return fill(capacity, count, text, path + '\0');
}

XrResult xrApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info,
                               const XrHapticBaseHeader* feedback) {
  std::lock_guard lock(runtime().mutex);
  Session* found = find(session);
  if (const auto refused = refuse_output(found, info, "xrApplyHapticFeedback")) return *refused;
  if (!feedback || feedback->type != XR_TYPE_HAPTIC_VIBRATION)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrApplyHapticFeedback: no vibration");
  const auto& vibration = *reinterpret_cast<const XrHapticVibration*>(feedback);
  if (!(vibration.amplitude >= 0 && vibration.amplitude <= 1))
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrApplyHapticFeedback: the amplitude is not in 0 to 1");
  if (found->state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
  runtime().record->haptic(timeline_s(now()), path_string(info->subactionPath), vibration);
  return success(*found);
}

XrResult xrStopHapticFeedback(XrSession session, const XrHapticActionInfo* info) {
  std::lock_guard lock(runtime().mutex);
  if (const auto refused = refuse_output(find(session), info, "xrStopHapticFeedback")) return *refused;
  return XR_SUCCESS;
}
