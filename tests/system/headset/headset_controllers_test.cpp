// SPDX-License-Identifier: Apache-2.0
// Grab, pull and shoot with each supported controller profile.
#include <algorithm>

#include "system/headset/headset_session.h"

namespace livegs {
namespace {

struct Controllers {
  const char* profile;   // last part of its path
  const char* shooting;  // timeline input that shoots
  bool grabs;            // simple controllers have no squeeze
};

class HeadsetControllers : public HeadsetSession, public ::testing::WithParamInterface<Controllers> {};

TEST_P(HeadsetControllers, GrabPullAndShoot) {
  const Controllers& one = GetParam();
  const std::string shooting = one.shooting;
  const auto done =
      run(floating({{"taken", {0, 0, 0}}, {"pulled", {-0.35, 0, 0}}, {"target", {0.4, 0, 0}}}), R"(
0    pose head   0 1.6 0         1 0 0 0
0    pose left   -0.35 1.6 -0.3  1 0 0 0
0    pose right  0 1.6 -1        1 0 0 0
0.6  input right.squeeze 1
0.8  pose right  0 1.6 -1        1 0 0 0
1.4  pose right  0 1.8 -1        1 0 0 0
1.8  input right.squeeze 0
0.6  input left.trigger 1
0.8  pose left   -0.35 1.6 -0.3  1 0 0 0
1.4  pose left   -0.35 1.8 -0.3  1 0 0 0
2.0  input left.trigger 0
2.1  pose left   -0.35 1.8 -0.3  1 0 0 0
2.3  pose left   0.4 1.6 -0.3    1 0 0 0
2.5  input left.)" + shooting + R"( 1
2.9  input left.)" + shooting + R"( 0
3.3  do exit
)",
          {.eye_size = "64x72", .renderer = RendererChoice::Cpu, .controllers = one.profile});
  ASSERT_TRUE(done) << done.error().message;
  expect_no_complaints();
  const auto profiles = rows(folder_ / "profiles.csv");
  ASSERT_EQ(profiles.size(), 1u);
  EXPECT_TRUE(profiles[0].at(1).ends_with(std::string("/") + one.profile)) << profiles[0][1];
  double taken_up_m = 0, pulled_up_m = 0, target_m_s = 0;
  for (const Seen& tick : seen_) {
    taken_up_m = std::max(taken_up_m, tick.bodies.at("taken").world_from_body.position_m.y());
    pulled_up_m = std::max(pulled_up_m, tick.bodies.at("pulled").world_from_body.position_m.y());
    target_m_s = std::max(target_m_s, -tick.bodies.at("target").velocity_m_s.z());
  }
  std::printf("%s: lifted by %.2f m, pulled up by %.2f m, shot to %.2f m/s\n", one.profile, taken_up_m,
              pulled_up_m, target_m_s);
  if (one.grabs) {
    EXPECT_GT(taken_up_m, 0.1);
  } else {
    EXPECT_LT(taken_up_m, 0.01);
  }
  EXPECT_GT(pulled_up_m, 0.05);
  EXPECT_GT(target_m_s, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Profiles, HeadsetControllers,
                         ::testing::Values(Controllers{"touch_controller_plus", "primary", true},
                                           Controllers{"touch_controller", "primary", true},
                                           Controllers{"simple_controller", "menu", false}),
                         [](const auto& tested) { return std::string(tested.param.profile); });

}  // namespace
}  // namespace livegs
