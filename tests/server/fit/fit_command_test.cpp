// SPDX-License-Identifier: Apache-2.0
// livegs fit as a program: files and errors.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "hidden_motion.h"
#include "scene/scene.h"
#include "scratch_folder.h"
#include "splat/camera_file.h"
#include "system/support/program.h"

namespace livegs {
namespace {

class FitCommand : public testing::Test {
 protected:
  FitCommand() {
    motion_.truth = scene_of(held_block(5e4, 0.025));
    motion_.request.camera = look_at({0.2, 0.1, 0.9}, {0.03, 0, 0}, Eigen::Vector3d::UnitY(), 0.6, 320, 240);
    motion_.seconds = 0.8;
    scratch_.write("scenes/block.scene.json", held_block(2e5, 0.025));
    EXPECT_TRUE(write_camera_file(scratch_ / "camera.json", motion_.request.camera));
  }
  std::string path(const std::string& name) const { return (scratch_ / name).string(); }
  // Exit code and the last line of the errors.
  std::pair<int, std::string> fit(std::vector<std::string> words) {
    words.insert(words.begin(), {LIVEGS_TOOL, "fit", path("scenes/block.scene.json")});
    Program program(words);
    const int code = program.wait();
    std::string last = program.err();
    while (!last.empty() && last.back() == '\n') last.pop_back();
    return {code, last.substr(last.rfind('\n') + 1)};
  }

  ScratchFolder scratch_;
  HiddenMotion motion_;
};

TEST_F(FitCommand, WritesValuesPathsAndASceneThatRuns) {
  ASSERT_TRUE(write_tracks_file(scratch_ / "paths.csv", exact_tracks(motion_, 40)));
  const auto [code, error] =
      fit({"--tracks", path("paths.csv"), "--camera", path("camera.json"), "-o", path("out/fit")});
  ASSERT_EQ(code, 0) << error;
  nlohmann::json result;
  std::ifstream(scratch_ / "out/fit/fit.json") >> result;
  EXPECT_NEAR(result["values"][0]["best"].get<double>(), 5e4, 0.03 * 5e4);
  for (const char* name : {"paths.png", "measured.csv", "simulated.csv"})
    EXPECT_GT(std::filesystem::file_size(scratch_ / "out/fit" / name), 100u) << name;
  const auto scene = Scene::load(scratch_ / "out/fit/fitted.scene.json", {});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_NEAR(scene->find("block")->physics.youngs_modulus_pa().best(), 5e4, 0.03 * 5e4);
}

TEST_F(FitCommand, MistakesGetOneLine) {
  scratch_.write("paths.csv", "point,time_s,x_px,y_px\n1,0,160,120\n1,0.1,161,120\n1,0.2,162,120\n");
  scratch_.write("no.mp4", "this is no video");
  const std::vector<std::string> rest = {"--camera", path("camera.json"), "-o", path("out")};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), rest.begin(), rest.end());
    return fit(words);
  };
  const std::pair<std::vector<std::string>, std::string> mistakes[] = {
      {{}, "livegs: fit: give --video or --tracks"},
      {{"--video", path("no.mp4")}, "no.mp4: has no pictures that ffmpeg can read; give a video"},
      {{"--video", path("absent.mp4")}, "absent.mp4: is not a file"},
      {{"--tracks", path("paths.csv")}, "tracks: 1 points are on block in the first frame, and 8 are needed"},
      {{"--tracks", path("paths.csv"), "--find", "block=colour"},
       "\"colour\" is unknown; use one or more of youngs_modulus_pa"},
      {{"--tracks", path("paths.csv"), "--find", "=friction"}, "has no object"},
      {{"--tracks", path("paths.csv"), "--find", "block=friction"}, "1 points are on block"},
      {{"--tracks", path("paths.csv"), "--find", "ball"}, "ball: is not an object of the scene"},
  };
  for (const auto& [words, text] : mistakes) {
    const auto [code, error] = with(words);
    EXPECT_EQ(code, 2) << error;
    EXPECT_NE(error.find(text), std::string::npos) << error;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out"));
  const auto [code, error] =
      fit({"--tracks", path("paths.csv"), "--camera", path("camera.json"), "-o", path("paths.csv/fit")});
  EXPECT_EQ(code, 2);
  EXPECT_NE(error.find("paths.csv is a file"), std::string::npos) << error;
}

}  // namespace
}  // namespace livegs
