// SPDX-License-Identifier: Apache-2.0
// Runs `livegs capture` as a program: photos to a scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include "capture/capture.h"
#include "capture/level.h"
#include "common/train/run/small_capture.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "parts/views/room_view.h"
#include "sample/made_room.h"
#include "scratch_folder.h"
#include "server/parts/part_scores.h"
#include "splat/image.h"
#include "splat/rasterise.h"
#include "system/support/program.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr size_t kPhotos = 16, kPoints = 3000;

// Photos of a room made in code, drawn by the product's rasteriser, with their poses.
Capture write_room_photos(const fs::path& folder) {
  MadeRoomOptions options;
  options.spacing_m = 0.007;
  const MadeRoom room = make_room(RoomKind::Apart, options);
  const PosedKernels posed = pose_in_place(room.asset);
  const DrawnObject object{&room.asset, &posed, 1};
  fs::create_directories(folder / "images");
  Capture capture;
  for (const Camera& camera : orbit(room.middle_m, {0, -1, 0}, 1.1, kPhotos, 160, 0.0, 2 * M_PI)) {
    RasterisedView view;
    Rasteriser().draw(std::span(&object, 1), camera, {}, view);
    CapturedView photo;
    photo.name = "v" + std::to_string(capture.views.size()) + ".png";
    photo.picture = folder / "images" / photo.name;
    photo.camera = camera;
    EXPECT_TRUE(write_png(photo.picture, view.image));
    capture.views.push_back(photo);
  }
  for (size_t k = 0; k < room.asset.size(); k += room.asset.size() / kPoints)
    capture.points.push_back(room.asset.positions[k]);
  return capture;
}

// A COLMAP text model of the capture, as the program colmap writes it.
void write_text_model(const fs::path& folder, const Capture& capture) {
  fs::create_directories(folder);
  const Camera& camera = capture.views.front().camera;
  std::ofstream(folder / "cameras.txt")
      << "1 OPENCV " << camera.width << " " << camera.height << " " << camera.focal_x_px << " "
      << camera.focal_y_px << " " << camera.centre_x_px << " " << camera.centre_y_px << " 0 0 0 0\n";
  std::ofstream images(folder / "images.txt");
  images.precision(12);
  for (size_t i = 0; i < capture.views.size(); ++i) {
    // COLMAP's camera looks along +z with y down.
    const Pose& pose = capture.views[i].camera.world_from_camera;
    const Eigen::Quaterniond down(0, 1, 0, 0);
    const Eigen::Quaterniond camera_from_world = (pose.orientation * down).conjugate();
    const Eigen::Vector3d t = -(camera_from_world * pose.position_m);
    images << i + 1 << " " << camera_from_world.w() << " " << camera_from_world.x() << " "
           << camera_from_world.y() << " " << camera_from_world.z() << " " << t.x() << " " << t.y() << " "
           << t.z() << " 1 " << capture.views[i].name << "\n\n";
  }
  std::ofstream list(folder / "points3D.txt");
  for (size_t k = 0; k < capture.points.size(); ++k)
    list << k + 1 << " " << capture.points[k].transpose() << " 128 128 128 0.5\n";
}

class CaptureCommand : public testing::Test {
 protected:
  // `path` has the program colmap.
  Program capture(std::vector<std::string> more = {}, std::string path = "") {
    if (path.empty()) path = (folder / "bin").string() + ":/usr/bin:/bin";
    std::vector<std::string> words{"PATH=" + path, LIVEGS_TOOL,
                                   "capture",      (folder / "photos").string(),
                                   "-o",           (folder / "desk").string(),
                                   "--device",     "cpu"};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.begin(), "/usr/bin/env");
    return Program(words);
  }
  // A program named colmap that does what the shell script says at its last step and succeeds before.
  void write_colmap(const std::string& mapper) {
    fs::create_directories(folder / "bin");
    std::ofstream(folder / "bin" / "colmap") << "#!/bin/sh\n[ \"$1\" = mapper ] || exit 0\n"
                                             << mapper << "\n";
    fs::permissions(folder / "bin" / "colmap", fs::perms::owner_all);
  }
  void expect_refused(Program program, const std::string& words) {
    EXPECT_EQ(program.wait(), 2);
    const std::string said = program.err();
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_FALSE(fs::exists(folder / "desk"));
    EXPECT_FALSE(fs::exists(folder / "desk.work"));
  }
  ScratchFolder folder;
};

TEST_F(CaptureCommand, MakesASceneFromPhotosWithPoses) {
  const Capture photos = write_room_photos(folder / "photos");
  write_text_model(folder / "photos" / "sparse" / "0", photos);
  Program program = capture({"--steps", "400", "--kernels", "6000"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  for (const char* name : {"captured.ply", "captured.png", "transforms.json", "room.ply", "room.scene.json",
                           "README.md", "part_01.ply"})
    EXPECT_TRUE(fs::exists(folder / "desk" / name)) << name;
  EXPECT_FALSE(fs::exists(folder / "desk.work"));
  EXPECT_NE(program.out().find("run livegs-server "), std::string::npos) << program.out();
  // The poses that are written are those that were read.
  const auto again = read_capture(folder / "desk" / "transforms.json");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->views.size(), kPhotos);
  for (const CapturedView& view : again->views) {
    const auto same = std::find_if(photos.views.begin(), photos.views.end(), [&](const CapturedView& one) {
      return one.picture.filename() == view.picture.filename();
    });
    ASSERT_NE(same, photos.views.end());
    EXPECT_LT((view.camera.world_from_camera.position_m - same->camera.world_from_camera.position_m).norm(),
              1e-9);
  }
}

TEST_F(CaptureCommand, PlacesAndLevelsPhotosWithoutPoses) {
  Capture photos = write_room_photos(folder / "photos");
  // Structure from motion gives any frame: turned, and four units a metre.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()));
  constexpr double kUnitsPerMetre = 4;
  Capture model = photos;
  for (CapturedView& view : model.views) {
    Pose& pose = view.camera.world_from_camera;
    pose = {kUnitsPerMetre * (turn * pose.position_m), turn * pose.orientation};
  }
  for (Eigen::Vector3f& point : model.points)
    point = (kUnitsPerMetre * (turn * point.cast<double>())).cast<float>();
  write_text_model(folder / "model", model);
  write_colmap("for a; do l=\"$a\"; done; cp -r " + (folder / "model").string() + " \"$l/0\"");
  Program program = capture({"--steps", "400", "--kernels", "6000"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_NE(program.err().find("scale: unknown"), std::string::npos) << program.err();
  const auto placed = read_capture(folder / "desk" / "transforms.json");
  ASSERT_TRUE(placed) << placed.error().message;
  EXPECT_GT(photo_up(*placed).y(), 0.9999);
  std::string scene;
  ASSERT_TRUE(fs::exists(folder / "desk" / "room.scene.json"));
  if (auto text = read_text_file(folder / "desk" / "room.scene.json")) scene = *text;
  EXPECT_NE(scene.find("\"up\": \"y\""), std::string::npos) << scene;
}

TEST_F(CaptureCommand, RefusesPhotosThatCannotBeUsed) {
  fs::create_directories(folder / "photos");
  write_colmap("exit 1");
  expect_refused(capture(), "has no photos");
  const auto photo = [&](int i) {
    EXPECT_TRUE(
        write_png(folder / "photos" / (std::to_string(i) + ".png"), Image{8, 8, std::vector<float>(256)}));
  };
  photo(0), photo(1);
  expect_refused(capture({"--quiet"}), "has 2 photos; give 3");
  for (int i = 2; i < 8; ++i) photo(i);
  expect_refused(capture({"--quiet"}), "no photos could be placed");  // black
  // Two places: the larger model has three photos of eight.
  Capture few;
  for (const Camera& camera : orbit({0, 0, 0}, {0, -1, 0}, 1.0, 3, 8, 0.0, 1.0)) {
    CapturedView view;
    view.name = std::to_string(few.views.size()) + ".png";
    view.camera = camera;
    few.views.push_back(view);
  }
  write_text_model(folder / "model", few);
  write_colmap("for a; do l=\"$a\"; done; cp -r " + (folder / "model").string() + " \"$l/0\"");
  expect_refused(capture({"--quiet"}), "only 3 of 8 photos could be placed together");
  // Poses of photos that are gone are no reason to look for others.
  write_text_model(folder / "photos" / "sparse" / "0", few);
  for (int i = 0; i < 3; ++i) fs::remove(folder / "photos" / (std::to_string(i) + ".png"));
  expect_refused(capture({"--quiet"}), "none of the 3 photos exists");
  fs::remove_all(folder / "photos" / "sparse");
  expect_refused(capture({"--quiet"}, "/nowhere"), "colmap: cannot be started; install it");
}

TEST_F(CaptureCommand, AnInterruptedRunContinues) {
  write_small_capture(folder / "photos");
  Program stopped = capture({"--steps", "100000"});
  ASSERT_TRUE(stopped.says_often(" held-out photos, ", 1)) << stopped.err();
  stopped.send(SIGINT);
  EXPECT_EQ(stopped.wait(), 128 + SIGINT);
  EXPECT_TRUE(fs::exists(folder / "desk.work" / "captured.checkpoint"));
  Program again = capture();
  EXPECT_EQ(again.wait(), 2);
  EXPECT_NE(again.err().find("--resume"), std::string::npos) << again.err();
  Program resumed = capture({"--steps", "100000", "--resume"});
  ASSERT_TRUE(resumed.says_often("step ", 1)) << resumed.err();
  resumed.send(SIGINT);
  EXPECT_EQ(resumed.wait(), 128 + SIGINT);
  EXPECT_TRUE(read_asset(folder / "desk.work" / "captured.ply"));
}

}  // namespace
}  // namespace livegs
