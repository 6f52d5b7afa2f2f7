// SPDX-License-Identifier: Apache-2.0
// Runs `livegs train` as a program.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

#include "common/train/run/small_capture.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "splat/image.h"
#include "system/support/program.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> train_words(const ScratchFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> words{LIVEGS_TOOL, "train", folder / "photos", "-o", folder / "room.ply",
                                 "--kernels", "300"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace

TEST(CliTrain, WritesTheSplatAndAPicture) {
  ScratchFolder folder;
  write_small_capture(folder / "photos");
  Program program(train_words(folder, {"--steps", "40", "--every", "20"}));
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_NE(program.err().find("step 20 of 40: "), std::string::npos) << program.err();
  EXPECT_NE(program.out().find("room.ply: "), std::string::npos);
  const auto asset = read_asset(folder / "room.ply");
  ASSERT_TRUE(asset) << asset.error().message;
  EXPECT_EQ(asset->asset.sh_degree, 3);
  const auto picture = read_png(folder / "room.png");
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width, 2 * picture->height * 64 / 48);
  EXPECT_FALSE(fs::exists(folder / "room.checkpoint"));
}

TEST(CliTrain, AnInterruptedRunContinues) {
  ScratchFolder folder;
  write_small_capture(folder / "photos");
  Program stopped(train_words(folder, {"--steps", "100000", "--every", "10"}));
  ASSERT_TRUE(stopped.says_often(" held-out photos, ", 2)) << stopped.err();
  stopped.send(SIGINT);
  EXPECT_EQ(stopped.wait(), 128 + SIGINT);
  EXPECT_NE(stopped.out().find("--resume continues"), std::string::npos) << stopped.out();
  EXPECT_TRUE(read_asset(folder / "room.ply"));
  EXPECT_TRUE(fs::exists(folder / "room.checkpoint"));
  Program other(train_words(folder, {"--steps", "40", "--resume"}));
  EXPECT_EQ(other.wait(), 2);
  EXPECT_NE(other.err().find("is of other photos or options"), std::string::npos) << other.err();
}

TEST(CliTrain, BadInputIsOneLineAndWritesNothing) {
  ScratchFolder folder;
  fs::create_directories(folder / "photos");
  Program empty(train_words(folder, {}));
  EXPECT_EQ(empty.wait(), 2);
  const std::string said = empty.err();
  EXPECT_NE(said.find("has no poses"), std::string::npos) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  EXPECT_FALSE(fs::exists(folder / "room.ply"));
  Program ending({LIVEGS_TOOL, "train", folder / "photos", "-o", folder / "room.obj"});
  EXPECT_EQ(ending.wait(), 2);
  EXPECT_NE(ending.err().find("use .ply or .spz"), std::string::npos) << ending.err();
}

}  // namespace livegs
