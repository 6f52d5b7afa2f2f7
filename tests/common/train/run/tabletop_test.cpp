// SPDX-License-Identifier: Apache-2.0
// Trains the table top of ../shared/data, 49 photos of 320 x 240 and 7 held out. Nightly.
#include <gtest/gtest.h>

#include "train/trainer.h"

namespace livegs {
namespace {

Result<HeldOutScore> score_of(ShapeLoss shape) {
  const auto capture = read_capture(LIVEGS_SHARED_DATA_DIR "/multiview/ycb_tabletop");
  if (!capture) return capture.error();
  TrainOptions options;
  options.steps = 2000;
  options.max_kernels = 20'000;
  options.longest_px = 320;
  options.shape.loss = shape;
  auto trainer = Trainer::start(*capture, options);
  if (!trainer) return trainer.error();
  while (!trainer->done()) {
    if (auto stepped = trainer->step(); !stepped) return stepped.error();
  }
  return trainer->score();
}

bool has_table_top() {
  return std::filesystem::exists(LIVEGS_SHARED_DATA_DIR "/multiview/ycb_tabletop/transforms.json");
}

}  // namespace

TEST(TableTop, ShortRunsReachTheirQuality) {
  if (!has_table_top()) GTEST_SKIP() << "../shared/data/multiview/ycb_tabletop is missing";
  const auto plain = score_of(ShapeLoss::None);
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->views, 7u);
  EXPECT_GE(plain->psnr_db, 29.5);
  EXPECT_GE(plain->ssim, 0.91);
  const auto needle = score_of(ShapeLoss::Needle);
  ASSERT_TRUE(needle) << needle.error().message;
  EXPECT_GE(needle->psnr_db, plain->psnr_db - 0.4);
}

}  // namespace livegs
