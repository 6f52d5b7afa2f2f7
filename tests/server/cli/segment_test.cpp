// SPDX-License-Identifier: Apache-2.0
// Runs `livegs segment` as a program and checks its files and error messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "capture/capture.h"
#include "capture/read/pose_files.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "sample/made_room.h"
#include "scratch_folder.h"
#include "server/parts/part_scores.h"
#include "splat/image.h"
#include "system/support/program.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

struct Answer {
  int code;
  std::string out, err;
};
Answer run_segment(std::vector<std::string> words) {
  words.insert(words.begin(), LIVEGS_TOOL);
  Program program(words);
  const int code = program.wait();
  return {code, program.out(), program.err()};
}

// Photos that only have poses.
std::string poses_text(const std::vector<Camera>& cameras) {
  Capture capture;
  for (size_t i = 0; i < cameras.size(); ++i) {
    CapturedView view;
    view.picture = "images/v" + std::to_string(i) + ".png";
    view.camera = cameras[i];
    capture.views.push_back(view);
  }
  return transforms_text(capture);
}

class Segment : public testing::Test {
 protected:
  void make(RoomKind kind) {
    MadeRoomOptions options;
    options.spacing_m = 0.007;
    room = make_room(kind, options);
    cameras = orbit(room.middle_m, {0, -1, 0}, 1.1, 10, 240, 0.0, 2 * M_PI);
    ASSERT_TRUE(write_asset(folder / "captured.ply", room.asset));
    ASSERT_TRUE(write_file_atomically(folder / "transforms.json", poses_text(cameras)));
  }
  Answer segment(std::vector<std::string> more = {}) {
    std::vector<std::string> words{
        "segment",   (folder / "captured.ply").string(),    "-o",     (folder / "parts").string(),
        "--cameras", (folder / "transforms.json").string(), "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return run_segment(words);
  }
  ScratchFolder folder;
  MadeRoom room;
  std::vector<Camera> cameras;
};

TEST_F(Segment, WritesASceneInWhichNothingJumps) {
  make(RoomKind::Apart);
  const Answer answer = segment();
  ASSERT_EQ(answer.code, 0) << answer.err;
  for (const char* name :
       {"room.ply", "room.scene.json", "README.md", "labels.u16", "part_01.ply", "part_05.png"})
    EXPECT_TRUE(fs::exists(folder / "parts" / name)) << name;
  EXPECT_FALSE(fs::exists(folder / "parts" / "part_06.ply"));
  EXPECT_EQ(fs::file_size(folder / "parts" / "labels.u16"), 2 * room.asset.size());
  const Answer simulated =
      run_segment({"simulate", (folder / "parts" / "room.scene.json").string(), "--seconds", "0.5",
                   "--output", (folder / "out").string(), "--quiet"});
  ASSERT_EQ(simulated.code, 0) << simulated.err;
  std::ifstream bodies(folder / "out" / "bodies.csv");
  std::string line;
  std::getline(bodies, line);
  std::map<std::string, Eigen::Vector3d> first;
  while (std::getline(bodies, line)) {
    std::istringstream cells(line);
    std::string cell, name;
    std::vector<std::string> row;
    while (std::getline(cells, cell, ',')) row.push_back(cell);
    const Eigen::Vector3d at(std::stod(row[4]), std::stod(row[5]), std::stod(row[6]));
    const auto [start, fresh] = first.try_emplace(row[2], at);
    if (!fresh) EXPECT_LE((at - start->second).norm(), 0.005) << row[2];  // the bar for a thing that is taken
  }
  EXPECT_EQ(first.size(), 5u);
}

TEST_F(Segment, AKnownLengthSetsTheScale) {
  make(RoomKind::Apart);
  const auto longest = [](const std::string& out, const std::string& name) {
    double x = 0, y = 0, z = 0;
    const size_t at = out.find(name + ": ");
    if (at == std::string::npos) return 0.0;
    std::sscanf(out.c_str() + out.find("kernels, ", at), "kernels, %lf x %lf x %lf", &x, &y, &z);
    return std::max({x, y, z});
  };
  const Answer answer = segment({"--known", "part_02=0.5"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  EXPECT_NEAR(longest(answer.out, "part_02"), 0.5, 0.002);  // printed with three digits
  // The scale is that of the true thing.
  const auto scene = read_text_file(folder / "parts" / "room.scene.json").value();
  const double scale = std::atof(scene.c_str() + scene.find("\"scale\":") + 8);
  for (int n = 1; n <= 5; ++n) {
    const std::string name = "part_0" + std::to_string(n);
    const auto part = read_asset(folder / "parts" / (name + ".ply"));
    ASSERT_TRUE(part) << part.error().message;
    const Eigen::Vector3d inside = part->asset.positions[part->asset.size() / 2].cast<double>();
    const auto truth =
        std::min_element(room.bounds_m.begin(), room.bounds_m.end(), [&](const auto& one, const auto& other) {
          return one.squaredExteriorDistance(inside) < other.squaredExteriorDistance(inside);
        });
    // Kernels of the table that a flat thing takes along at its foot widen it.
    EXPECT_NEAR(longest(answer.out, name) / (scale * truth->sizes().maxCoeff()), 1.0, 0.25) << name;
  }
  fs::remove_all(folder / "parts");
  for (const auto& [words, why] :
       {std::pair("part_09=0.5", "is not among the 5 things"), std::pair("part_02=-1", "write part_03=0.21"),
        std::pair("cup=0.1", "write part_03=0.21")}) {
    const Answer wrong = segment({"--known", words});
    EXPECT_EQ(wrong.code, 2);
    EXPECT_NE(wrong.err.find(why), std::string::npos) << wrong.err;
    EXPECT_FALSE(fs::exists(folder / "parts"));
  }
}

TEST_F(Segment, LiftsMasks) {
  make(RoomKind::Touching);
  fs::create_directories(folder / "masks");
  for (size_t v : {size_t{0}, size_t{3}, size_t{6}}) {
    const auto labels = label_picture(room.asset, room.owner, cameras[v]);
    Image mask{cameras[v].width, cameras[v].height, {}};
    for (uint16_t label : labels)
      for (int c = 0; c < 4; ++c) mask.pixels.push_back(c < 3 ? static_cast<float>(label) / 255.0f : 1.0f);
    ASSERT_TRUE(write_png(folder / "masks" / ("v" + std::to_string(v) + ".png"), mask));
  }
  const Answer answer = segment({"--masks", (folder / "masks").string()});
  ASSERT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(fs::exists(folder / "parts" / "part_06.ply"));
  EXPECT_FALSE(fs::exists(folder / "parts" / "part_07.ply"));

  ASSERT_TRUE(write_png(folder / "masks" / "v1.png", Image{10, 10, std::vector<float>(400, 0.0f)}));
  fs::remove_all(folder / "parts");
  const Answer wrong = segment({"--masks", (folder / "masks").string()});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(
      wrong.err,
      "livegs: v1.png: has 10 x 10 pixels, its camera 240 x 180; give masks of the size of the photos\n");
  EXPECT_FALSE(fs::exists(folder / "parts"));
}

TEST_F(Segment, WritesNothingForBadInput) {
  make(RoomKind::Empty);
  const auto expect_line = [&](const Answer& answer, const std::string& words) {
    EXPECT_EQ(answer.code, 2);
    EXPECT_EQ(std::count(answer.err.begin(), answer.err.end(), '\n'), 1) << answer.err;
    EXPECT_NE(answer.err.find(words), std::string::npos) << answer.err;
    EXPECT_FALSE(fs::exists(folder / "parts"));
  };
  expect_line(segment(), "has nothing that stands on a floor");
  expect_line(segment({"--up", "w"}), "--up");
  expect_line(segment({"--masks", (folder / "nowhere").string()}), "is not a folder");

  GaussianAsset one;
  one.resize(1);
  one.positions[0].setZero();
  one.log_scales[0].setConstant(-3);
  one.rotations[0].setIdentity();
  one.opacity_logits[0] = 2;
  one.sh_dc[0].setZero();
  ASSERT_TRUE(write_asset(folder / "captured.ply", one));
  expect_line(segment(), "has 1 kernels, too few");

  // A plane only: the desk and the floor without anything else.
  GaussianAsset plane;
  for (int x = 0; x < 60; ++x)
    for (int z = 0; z < 60; ++z) {
      plane.positions.emplace_back(0.02f * static_cast<float>(x - 30), room.middle_m.cast<float>().y(),
                                   0.02f * static_cast<float>(z - 30));
      plane.log_scales.emplace_back(-4.4f, -8.0f, -4.4f);
      plane.rotations.push_back(Eigen::Quaternionf::Identity());
      plane.opacity_logits.push_back(3);
      plane.sh_dc.emplace_back(0.3f, 0.2f, 0.1f);
    }
  ASSERT_TRUE(write_asset(folder / "captured.ply", plane));
  expect_line(segment(), "has nothing that stands on a floor");

  fs::create_directories(folder / "parts");
  std::ofstream(folder / "parts" / "mine.txt") << "kept";
  const Answer full = segment();
  EXPECT_EQ(full.code, 2);
  EXPECT_NE(full.err.find("is not empty"), std::string::npos) << full.err;
  EXPECT_TRUE(fs::exists(folder / "parts" / "mine.txt"));
}

}  // namespace
}  // namespace livegs
