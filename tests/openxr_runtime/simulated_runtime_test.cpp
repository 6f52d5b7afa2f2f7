// SPDX-License-Identifier: Apache-2.0
// The simulated runtime with independent programs: Debian's hello_xr, the core validation layer between both,
// and a direct caller of invalid functions.
#include <gtest/gtest.h>
#include <openxr/openxr.h>

#include <filesystem>
#include <set>

#include "core/sanitizers.h"
#include "openxr_runtime/record_files.h"
#include "scratch_folder.h"
#include "system/support/program.h"

namespace livegs {
namespace {

template <class T>
T of(XrStructureType type) {
  T made{};
  made.type = type;
  return made;
}

class HelloXr : public ::testing::Test {
 protected:
  void SetUp() override {
    if (LIVEGS_ADDRESS_SANITIZER || LIVEGS_THREAD_SANITIZER)
      GTEST_SKIP() << "hello_xr: cannot load a runtime with sanitizers";
    if (!std::filesystem::exists("/usr/bin/hello_xr"))
      GTEST_SKIP() << "hello_xr: not installed; install libopenxr-utils";
  }
  // hello_xr ends when its standard input ends, so the test keeps the input open.
  std::unique_ptr<Program> run(const std::string& timeline, std::vector<std::string> variables = {}) {
    std::vector<std::string> words = {
        "/usr/bin/env", std::string("XR_RUNTIME_JSON=") + LIVEGS_SIMULATED_OPENXR,
        "LIVEGS_XR_TIMELINE=" + folder_.write("timeline.txt", timeline).string(),
        "LIVEGS_XR_OUTPUT=" + (folder_ / "").string()};
    words.insert(words.end(), variables.begin(), variables.end());
    words.insert(words.end(), {"/bin/sh", "-c", "tail -f /dev/null --pid=$$ | /usr/bin/hello_xr -g Vulkan2"});
    return std::make_unique<Program>(words);
  }
  ScratchFolder folder_;
};

constexpr const char* kTimeline = R"(# head turns, squeeze, system menu, exit
0    pose head  0 1.6 0  1 0 0 0
1.5  pose head  0.1 1.6 0  0.966 0 0.259 0
0    pose left  -0.2 1.3 -0.4  1 0 0 0
0    pose right  0.2 1.3 -0.4  1 0 0 0
0.5  input left.squeeze 1
0.6  do take-focus
0.9  do give-focus
1.0  do refresh 72
1.0  do picture
1.1  do recentre 0 1.6 0.5 10
1.6  do exit
)";

TEST_F(HelloXr, RunsToItsEndUnderBothValidationLayers) {
  const auto hello =
      run(kTimeline,
          {"XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation", "XR_CORE_VALIDATION_EXPORT_TYPE=text",
           "XR_CORE_VALIDATION_FILE_NAME=" + (folder_ / "core.txt").string(),
           "VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation",
           "VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT"});
  EXPECT_EQ(hello->wait(), 0) << hello->err();
  const std::string said = hello->out() + hello->err();
  EXPECT_EQ(text(folder_ / "misuse.txt"), "");
  // The layer writes its start-up line and no errors.
  EXPECT_NE(said.find("Core Validation output type: text"), std::string::npos) << said.substr(0, 4000);
  EXPECT_EQ(text(folder_ / "core.txt").find("VUID"), std::string::npos)
      << text(folder_ / "core.txt").substr(0, 2000);
  EXPECT_EQ(said.find("Validation Error"), std::string::npos) << said.substr(0, 4000);
  EXPECT_EQ(said.find("VUID"), std::string::npos) << said.substr(0, 4000);

  std::vector<std::string> states;
  for (const auto& row : rows(folder_ / "states.csv")) states.push_back(row.at(1));
  EXPECT_EQ(states,
            (std::vector<std::string>{"idle", "ready", "synchronized", "visible", "focused", "visible",
                                      "focused", "visible", "synchronized", "stopping", "idle", "exiting"}));
  // The eyes' pictures differ, and pictures change when the head turns.
  std::map<std::string, std::vector<std::string>> hashes;
  std::set<std::string> kept;
  for (const auto& row : rows(folder_ / "frames.csv")) {
    if (row.size() < 6 || row[4].empty()) continue;
    hashes[row[4]].push_back(row[5]);
    if (row.size() == 18) kept.insert(row[17]);
  }
  ASSERT_GE(hashes["0"].size(), 5u);
  ASSERT_EQ(hashes["0"].size(), hashes["1"].size());
  EXPECT_NE(hashes["0"].back(), hashes["1"].back());
  EXPECT_GT(std::set<std::string>(hashes["0"].begin(), hashes["0"].end()).size(), 3u);
  ASSERT_EQ(kept.size(), 2u);
  for (const std::string& name : kept) EXPECT_GT(std::filesystem::file_size(folder_ / name), 100u);
  // hello_xr vibrates in response to a squeeze.
  const auto haptics = rows(folder_ / "haptics.csv");
  ASSERT_FALSE(haptics.empty());
  EXPECT_EQ(haptics[0].at(1), "/user/hand/left");
}

TEST_F(HelloXr, ReportsLineOfInvalidTimeline) {
  const auto hello = run("0 pose head 1 2 3\n");
  EXPECT_NE(hello->wait(), -1);
  EXPECT_NE(hello->err().find("timeline.txt:1: expected 7 numbers"), std::string::npos) << hello->err();
}

// Calls that need no session.
TEST(SimulatedRuntime, RefusesInvalidCallsWithoutSession) {
  ::setenv("XR_RUNTIME_JSON", LIVEGS_SIMULATED_OPENXR, 1);
  auto info = of<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::snprintf(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE, "test");
  info.applicationInfo.apiVersion = XR_CURRENT_API_VERSION;
  const char* unknown = "XR_NOBODY_has_this";
  info.enabledExtensionCount = 1;
  info.enabledExtensionNames = &unknown;
  XrInstance instance = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateInstance(&info, &instance), XR_ERROR_EXTENSION_NOT_PRESENT);
  const char* vulkan = "XR_KHR_vulkan_enable2";
  info.enabledExtensionNames = &vulkan;
  ASSERT_EQ(xrCreateInstance(&info, &instance), XR_SUCCESS);

  XrSystemGetInfo get{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HANDHELD_DISPLAY};
  XrSystemId system = 0;
  EXPECT_EQ(xrGetSystem(instance, &get, &system), XR_ERROR_FORM_FACTOR_UNSUPPORTED);
  get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  ASSERT_EQ(xrGetSystem(instance, &get, &system), XR_SUCCESS);
  uint32_t count = 0;
  EXPECT_EQ(xrEnumerateViewConfigurations(instance, system + 1, 0, &count, nullptr), XR_ERROR_SYSTEM_INVALID);
  XrPath path = 0;
  for (const char* wrong : {"user", "/user/", "/User/hand", "/user//hand", ""}) {
    EXPECT_EQ(xrStringToPath(instance, wrong, &path), XR_ERROR_PATH_FORMAT_INVALID) << wrong;
  }
  auto create = of<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  create.systemId = system;
  XrSession session = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateSession(instance, &create, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);

  auto set_info = of<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
  XrActionSet set = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateActionSet(instance, &set_info, &set), XR_ERROR_NAME_INVALID);
  std::snprintf(set_info.actionSetName, XR_MAX_ACTION_SET_NAME_SIZE, "hands");
  std::snprintf(set_info.localizedActionSetName, XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE, "Hands");
  ASSERT_EQ(xrCreateActionSet(instance, &set_info, &set), XR_SUCCESS);
  XrActionSet twice = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateActionSet(instance, &set_info, &twice), XR_ERROR_NAME_DUPLICATED);
  auto action_info = of<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
  action_info.actionType = XR_ACTION_TYPE_BOOLEAN_INPUT;
  std::snprintf(action_info.actionName, XR_MAX_ACTION_NAME_SIZE, "shoot");
  std::snprintf(action_info.localizedActionName, XR_MAX_LOCALIZED_ACTION_NAME_SIZE, "Shoot");
  XrAction action = XR_NULL_HANDLE;
  ASSERT_EQ(xrCreateAction(set, &action_info, &action), XR_SUCCESS);
  const auto suggest = [&](const char* profile, const char* bound) {
    XrActionSuggestedBinding binding{action, XR_NULL_PATH};
    auto suggested = of<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
    EXPECT_EQ(xrStringToPath(instance, profile, &suggested.interactionProfile), XR_SUCCESS);
    EXPECT_EQ(xrStringToPath(instance, bound, &binding.binding), XR_SUCCESS);
    suggested.countSuggestedBindings = 1;
    suggested.suggestedBindings = &binding;
    return xrSuggestInteractionProfileBindings(instance, &suggested);
  };
  const char* touch = "/interaction_profiles/oculus/touch_controller";
  EXPECT_EQ(suggest(touch, "/user/hand/right/input/a/click"), XR_SUCCESS);
  EXPECT_EQ(suggest(touch, "/user/hand/right/input/a"), XR_SUCCESS);  // the component is optional
  EXPECT_EQ(suggest(touch, "/user/hand/left/input/a/click"), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(suggest(touch, "/user/hand/right/input/grip/pose"),
            XR_ERROR_PATH_UNSUPPORTED);  // of a different type
  EXPECT_EQ(suggest("/interaction_profiles/nobody/has_this", "/user/hand/right/input/a/click"),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(suggest("/interaction_profiles/meta/touch_controller_plus", "/user/hand/right/input/a/click"),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(xrDestroyInstance(instance), XR_SUCCESS);
}

}  // namespace
}  // namespace livegs
