// SPDX-License-Identifier: Apache-2.0
// Lifting, dropping and breaking a cup with the simulated headset.
#include <algorithm>

#include "gaussian/asset_file.h"
#include "sample/sample_scene.h"
#include "system/headset/headset_session.h"

namespace livegs {
namespace {

// The cup breaks above 1.5 m/s, after a fall of 0.11 m.
constexpr double kMass_kg = 0.3, kBreakImpulse_n_s = 0.45;

// The sample's cup, just above a floor.
v1::Scene cup_on_a_floor() {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(R"({ "objects": [
    { "name": "cup", "asset": "cup.ply", "scale": 1, "up": "-y", "pose": { "position_m": [0, -0.05, 0] },
      "physics": { "behavior": "RIGID", "fill": "SOLID", "fragile": true, "fracture_pieces": 12 } },
    { "name": "floor", "shape": { "box": { "size_m": [1.2, 0.1, 1.2] } }, "pose": { "position_m": [0, -0.11, 0] },
      "physics": { "behavior": "STATIC" } } ] })",
                                                                  &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  file.mutable_objects(0)->mutable_physics()->set_mass_kg(kMass_kg);
  file.mutable_objects(0)->mutable_physics()->set_break_impulse_n_s(kBreakImpulse_n_s);
  return file;
}

TEST_F(HeadsetSession, DroppedCupBreaksOnTheFloor) {
  ASSERT_TRUE(write_asset(folder_ / "cup.ply", make_cup()));
  auto scene = Scene::build(cup_on_a_floor(), folder_.path(), "cup on a floor", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const size_t whole_kernels = scene->find("cup")->asset->size();
  const uint32_t cup_id = scene->find("cup")->id;
  std::vector<size_t> drawn_kernels;
  // Vulkan also draws the kept pictures. The session uses the CPU, because a software Vulkan device is too
  // slow for the drop.
  auto device = VulkanDevice::create();
  ASSERT_TRUE(device) << device.error().message;
  const auto vulkan = create_vulkan_renderer(*std::move(device));
  ASSERT_TRUE(vulkan) << vulkan.error().message;
  std::vector<std::vector<Image>> by_vulkan;
  const auto done = run(std::move(*scene), R"(
0    pose head   0 1.75 0.2      1 0 0 0
0    pose left   0 1.6 5         1 0 0 0
0    pose right  0 1.6 -1        1 0 0 0
# The right hand grabs the cup, lifts it by 0.35 m and opens. A slow machine samples hands only a few times per
# second, so the cup falls from a hand at rest: the speed of its impact does not depend on the times of samples.
0.6  input right.squeeze 1
0.7  do picture
2.0  pose right  0 1.6 -1        1 0 0 0
3.2  pose right  0 1.95 -1       1 0 0 0
5.0  input right.squeeze 0
6.6  do picture
7.0  do exit
)",
                        {.eye_size = "64x72",
                         .renderer = RendererChoice::Cpu,
                         .marks = false,
                         .on_kept = [&](const PlannedFrame& picture, const SceneView& view, FaultProxy&) {
                           EXPECT_TRUE(view.draw_again(**vulkan, picture.views, by_vulkan.emplace_back()));
                           if (const auto cup = view.drawn_object(cup_id))
                             drawn_kernels.push_back(cup->asset->size());
                         }});
  ASSERT_TRUE(done) << done.error().message;
  std::printf("%s", summary_text(*done).c_str());
  expect_no_complaints();

  // The cup is whole until it hits the floor.
  size_t bodies = 0;
  double start_m = 0, highest_m = 0, last_m = 0, speed_m_s = 0;
  for (const Seen& tick : seen_) {
    bodies = tick.counts.at("cup");
    if (bodies > 1) continue;
    const BodyState& cup = tick.bodies.at("cup");
    last_m = cup.world_from_body.position_m.y();
    if (&tick == &seen_.front()) start_m = highest_m = last_m;
    highest_m = std::max(highest_m, last_m);
    speed_m_s = -cup.velocity_m_s.y();
  }
  std::printf("%zu bodies; from y = %.3f m lifted to %.3f m; last whole at %.3f m and %.2f m/s\n", bodies,
              start_m, highest_m, last_m, speed_m_s);
  EXPECT_GT(bodies, 1u);
  EXPECT_NEAR(highest_m - start_m, 0.35, 0.05);
  EXPECT_LT(last_m - start_m, 0.1);
  EXPECT_GT(kMass_kg * speed_m_s, kBreakImpulse_n_s);
  // The hand vibrated when it grabbed the cup.
  const auto felt = rows(folder_ / "haptics.csv");
  ASSERT_GE(felt.size(), 1u);
  for (const auto& row : felt) EXPECT_EQ(row.at(1), "/user/hand/right");
  EXPECT_LT(std::stod(felt[0].at(0)), 1.3);

  // The client draws the cup before the break and its fragments afterwards, including cut faces. Both match
  // the reference renderer.
  ASSERT_EQ(kept_.size(), 2u);
  expect_oracle();
  ASSERT_EQ(drawn_kernels.size(), 2u);
  EXPECT_EQ(drawn_kernels[0], whole_kernels);
  EXPECT_GT(drawn_kernels[1], whole_kernels);
  ASSERT_EQ(by_vulkan.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    for (size_t eye = 0; eye < 2; ++eye) {
      std::printf("by vulkan, %s: %.1f dB\n", i == 0 ? "whole" : "broken",
                  psnr_db(by_vulkan[i].at(eye), kept_[i].oracle[eye]));
      EXPECT_GT(psnr_db(by_vulkan[i].at(eye), kept_[i].oracle[eye]), 50.0) << i;
    }
  }
}

}  // namespace
}  // namespace livegs
