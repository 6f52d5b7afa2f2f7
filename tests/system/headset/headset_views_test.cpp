// SPDX-License-Identifier: Apache-2.0
// The head pose is queried again after skinning, and this second pose is drawn and submitted.
#include <algorithm>

#include "system/headset/headset_session.h"

namespace livegs {
namespace {

// Prediction error in metres per second of lead, 40 mm per ms. The gain of the second query is then visible
// with pixels of 18 mm.
constexpr double kMisjudged_m_s = 40;
// Minimum distance of two eye positions for which the pictures differ enough to decide from which one was
// drawn, m.
constexpr double kDistinguishable_m = 0.006;

TEST_F(HeadsetSession, PicturesUseTheLatestHeadPose) {
  // The middle of the scene is at (0, 1.6, -1) in the stage; there is no recentre.
  const Pose scene_from_stage{{0, -1.6, 1}, Eigen::Quaterniond::Identity()};
  struct Drawn {
    std::vector<Camera> eyes;
    std::vector<Image> as_first_predicted;
  };
  std::vector<Drawn> drawn;
  const auto eye_row = [&](const std::string& file, int eye) {
    std::vector<std::string> row;
    for (const auto& one : rows(folder_ / file)) {
      if (one.size() > 5 && one[file == "views.csv" ? 1 : 4] == std::to_string(eye)) row = one;  // the newest
    }
    return row;
  };
  const auto point = [](const std::vector<std::string>& row, size_t from) {
    return Eigen::Vector3d(std::stod(row.at(from)), std::stod(row.at(from + 1)), std::stod(row.at(from + 2)));
  };
  const auto done = run(floating({{"a", {0, 0, 0}}, {"b", {-0.35, 0, 0}}, {"c", {0.4, 0.1, 0.2}}}), R"(
0    pose head   0 1.6 0     1 0 0 0
0    pose left   0 1.6 5     1 0 0 0
0    pose right  0 1.6 5     1 0 0 0
0.5  do misjudge 40
0.8  do picture
1.2  do picture
1.6  do picture
2.0  do exit
)",
                        {.on_kept = [&](const PlannedFrame& picture, const SceneView& view, FaultProxy&) {
                          Drawn one{picture.views, {}};
                          std::vector<Camera> early = picture.views;
                          for (int eye = 0; eye < 2; ++eye)
                            early[eye].world_from_camera.position_m =
                                scene_from_stage * point(eye_row("views.csv", eye), 4);
                          const auto cpu = create_cpu_renderer();
                          EXPECT_TRUE(view.draw_again(*cpu, early, one.as_first_predicted));
                          drawn.push_back(std::move(one));
                        }});
  ASSERT_TRUE(done) << done.error().message;
  expect_no_complaints();

  // Each submitted frame: two queries, submitted with the pose of the second, which differs from the first.
  std::map<std::pair<std::string, std::string>, Eigen::Vector3d> submitted_m;  // by frame and eye
  for (const auto& row : rows(folder_ / "frames.csv")) {
    if (row.size() > 8 && !row[4].empty()) submitted_m[{row[0], row[4]}] = point(row, 6);
  }
  double gained_s = 0;
  size_t frames = 0;
  std::map<std::pair<std::string, std::string>, double> moved_m;  // between the two queries, by frame and eye
  for (const auto& row : rows(folder_ / "views.csv")) {
    const Eigen::Vector3d first = point(row, 4), last = point(row, 8),
                          shown = submitted_m.at({row.at(0), row.at(1)});
    const double earlier_s = std::stod(row.at(3)) - std::stod(row.at(7));
    EXPECT_GE(std::stoi(row.at(2)), 2);
    EXPECT_GT(earlier_s, 0.0);
    EXPECT_LT((shown - last).norm(), 1e-5) << "frame " << row[0];
    moved_m[{row.at(0), row.at(1)}] = (first - last).norm();
    if ((first - last).norm() < 1e-6) continue;  // before the prediction error begins
    gained_s += earlier_s;
    ++frames;
    // There is no prediction for past times. Leads are recorded with 1 us resolution, which is 40 um.
    const double predicted_s = std::max(0.0, std::stod(row.at(3))) - std::max(0.0, std::stod(row.at(7)));
    EXPECT_NEAR((first - last).norm(), kMisjudged_m_s * predicted_s, 1e-4) << "frame " << row[0];
  }
  ASSERT_GE(frames, 6u);
  std::printf("the second query is %.2f ms later than the first (mean of %zu)\n",
              1e3 * gained_s / static_cast<double>(frames), frames);

  // Each kept picture matches the reference from the second position, not from the first.
  ASSERT_EQ(kept_.size(), 3u);
  ASSERT_EQ(drawn.size(), 3u);
  expect_oracle();
  int distinguished = 0;
  for (size_t i = 0; i < kept_.size(); ++i) {
    for (int eye = 0; eye < 2; ++eye) {
      const auto shown = read_png(kept_[i].files[eye]);
      ASSERT_TRUE(shown) << shown.error().message;
      const std::string name = kept_[i].files[eye].filename();
      const std::string frame = std::to_string(std::stol(name.substr(6, 5)));
      const Eigen::Vector3d at = scene_from_stage * submitted_m.at({frame, std::to_string(eye)});
      EXPECT_LT((drawn[i].eyes[eye].world_from_camera.position_m - at).norm(), 1e-5) << name;
      if (moved_m.at({frame, std::to_string(eye)}) < kDistinguishable_m) continue;
      ++distinguished;
      EXPECT_LT(psnr_db(*shown, drawn[i].as_first_predicted[eye]), psnr_db(*shown, kept_[i].oracle[eye]) - 6)
          << name;
    }
  }
  std::printf("%d of 6 pictures were drawn from positions far enough apart to distinguish\n", distinguished);
}

}  // namespace
}  // namespace livegs
