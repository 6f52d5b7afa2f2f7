// SPDX-License-Identifier: Apache-2.0
#include "train/trainer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/train/run/small_capture.h"
#include "core/parallel_for.h"
#include "scratch_folder.h"
#include "train/optimise/random_number.h"
#include "train/render/trained_view.h"
#include "train/run/initial_kernels.h"
#include "train/run/scene_extent.h"

namespace livegs {
namespace {

TrainOptions short_options(size_t steps) {
  TrainOptions options;
  options.steps = steps;
  options.max_kernels = 400;
  return options;
}

void take_steps(Trainer& trainer, size_t count) {
  for (size_t i = 0; i < count; ++i) ASSERT_TRUE(trainer.step().has_value());
}

}  // namespace

TEST(Trainer, FitsASmallScene) {
  ScratchFolder folder;
  SmallCapture small;
  small.views = 32;
  write_small_capture(folder.path(), small);
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture) << capture.error().message;
  auto trainer = Trainer::start(*capture, short_options(400));
  ASSERT_TRUE(trainer) << trainer.error().message;
  const double before = trainer->score()->psnr_db;
  take_steps(*trainer, 400);
  EXPECT_TRUE(trainer->done());
  const auto after = trainer->score();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->views, 4u);
  EXPECT_GT(after->psnr_db, before + 5);
  EXPECT_GT(after->psnr_db, 25);
  EXPECT_GT(after->ssim, 0.8);
  EXPECT_LE(trainer->asset().size(), 400u);
}

// Points between the cameras and a floor, as wrong matches give them, one for five right ones. Their kernels
// hide the floor at first; they must be removed instead of being multiplied where they cause errors.
TEST(Trainer, WrongPointsDoNotHideTheScene) {
  ScratchFolder folder;
  SmallCapture small;
  small.views = 32;
  small.width = 96;
  small.height = 72;
  small.kernels = 1500;
  small.floor = true;
  write_small_capture(folder.path(), small);
  auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture) << capture.error().message;
  const size_t right = capture->points.size();
  double scores[2];
  for (const bool wrong : {false, true}) {
    for (size_t i = 0; wrong && i < right / 5; ++i) {
      const auto number = [&](uint64_t stream) { return static_cast<float>(random_share(7, stream, i)); };
      capture->points.push_back({2 * number(1) - 1, 0.2f + 0.9f * number(2), 2 * number(3) - 1});
      capture->point_colours.push_back({number(4), number(5), number(6)});
    }
    TrainOptions options = short_options(300);
    options.max_kernels = 3000;
    auto trainer = Trainer::start(*capture, options);
    ASSERT_TRUE(trainer) << trainer.error().message;
    take_steps(*trainer, options.steps);
    scores[wrong ? 1 : 0] = trainer->score()->psnr_db;
  }
  EXPECT_GT(scores[0], 30);
  EXPECT_GT(scores[1], scores[0] - 3);
}

// Poses that are wrong by half a degree and one per cent of the distance. Errors that all cameras have in
// common are those of the frame and do not count.
TEST(Trainer, PosesAreCorrected) {
  ScratchFolder folder;
  SmallCapture small;
  small.views = 32;
  small.width = 96;
  small.height = 72;
  write_small_capture(folder.path(), small);
  auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture) << capture.error().message;
  const Capture exact = *capture;
  for (size_t i = 0; i < capture->views.size(); ++i) {
    const auto number = [&](uint64_t stream) { return random_share(5, stream, i) - 0.5; };
    Pose& pose = capture->views[i].camera.world_from_camera;
    pose.position_m += 0.04 * Eigen::Vector3d(number(1), number(2), number(3));
    const Eigen::Vector3d axis = Eigen::Vector3d(number(4), number(5), number(6)).normalized();
    pose.orientation = (Eigen::AngleAxisd(0.5 * M_PI / 180, axis) * pose.orientation).normalized();
  }
  // Root mean square of the errors of the place of the origin in the pictures, rad.
  const auto error_rad = [&](const Trainer& trainer) {
    double squares = 0;
    size_t count = 0;
    for (size_t i = 0; i < exact.views.size(); ++i) {
      if (exact.views[i].held_out) continue;
      const Eigen::Vector3d right =
                                exact.views[i].camera.world_from_camera.inverse() * Eigen::Vector3d::Zero(),
                            found = trainer.camera(i).world_from_camera.inverse() * Eigen::Vector3d::Zero();
      squares += (found.normalized() - right.normalized()).squaredNorm();
      ++count;
    }
    return std::sqrt(squares / static_cast<double>(count));
  };
  // Means over three seeds: single runs differ by about a decibel.
  double errors[2] = {}, scores[2] = {};
  for (const bool refines : {false, true}) {
    for (uint64_t seed : {1, 2, 3}) {
      TrainOptions options = short_options(600);
      options.refine_poses = refines;
      options.seed = seed;
      auto trainer = Trainer::start(*capture, options);
      ASSERT_TRUE(trainer) << trainer.error().message;
      take_steps(*trainer, 600);
      errors[refines ? 1 : 0] += error_rad(*trainer) / 3;
      scores[refines ? 1 : 0] += trainer->score()->psnr_db / 3;
    }
  }
  EXPECT_LT(errors[1], 0.6 * errors[0]);
  EXPECT_GT(scores[1], scores[0] + 1);
}

TEST(Trainer, ThreadsDoNotChangeABit) {
  ScratchFolder folder;
  write_small_capture(folder.path());
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  std::vector<std::vector<std::byte>> states;
  for (int threads : {1, 2, 8}) {
    set_thread_count(threads);
    auto trainer = Trainer::start(*capture, short_options(60));
    ASSERT_TRUE(trainer);
    take_steps(*trainer, 60);
    states.push_back(trainer->checkpoint());
  }
  set_thread_count(0);
  EXPECT_TRUE(states[0] == states[1]);
  EXPECT_TRUE(states[0] == states[2]);
}

TEST(Trainer, ResumeContinuesWithTheSameBits) {
  ScratchFolder folder;
  write_small_capture(folder.path());
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  auto whole = Trainer::start(*capture, short_options(60));
  ASSERT_TRUE(whole);
  take_steps(*whole, 33);
  const std::vector<std::byte> middle = whole->checkpoint();
  take_steps(*whole, 27);
  auto resumed = Trainer::start(*capture, short_options(60));
  ASSERT_TRUE(resumed);
  const auto loaded = resumed->resume(middle);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(resumed->steps_done(), 33u);
  take_steps(*resumed, 27);
  EXPECT_TRUE(whole->checkpoint() == resumed->checkpoint());
}

TEST(Trainer, DamagedAndForeignCheckpointsAreRefused) {
  ScratchFolder folder;
  write_small_capture(folder.path());
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  auto trainer = Trainer::start(*capture, short_options(60));
  ASSERT_TRUE(trainer);
  const std::vector<std::byte> good = trainer->checkpoint();
  for (size_t length : {size_t{0}, size_t{10}, size_t{64}, good.size() - 1})
    EXPECT_FALSE(trainer->resume(std::span(good).first(length)));
  std::vector<std::byte> other = good;
  other[0] = std::byte{'x'};
  EXPECT_FALSE(trainer->resume(other));
  other = good;
  other[40] = ~other[40];  // number of kernels
  EXPECT_FALSE(trainer->resume(other));
  auto longer = Trainer::start(*capture, short_options(61));
  ASSERT_TRUE(longer);
  const auto refused = longer->resume(good);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("other photos or options"), std::string::npos);
  EXPECT_TRUE(trainer->checkpoint() == good);
}

// Without a random background and a loss on alpha, the background of the photos becomes part of the object.
TEST(Trainer, TransparentPhotosGiveATransparentBackground) {
  ScratchFolder folder;
  SmallCapture small;
  small.transparent = true;
  small.kernels = 60;
  write_small_capture(folder.path(), small);
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  auto trainer = Trainer::start(*capture, short_options(300));
  ASSERT_TRUE(trainer);
  take_steps(*trainer, 300);
  TrainedView view;
  Camera camera = capture->views[3].camera;
  view.draw(trainer->kernels(), camera, {});
  // The corners show nothing of the scene.
  for (size_t pixel : {size_t{0}, size_t{63}, size_t{47 * 64}, size_t{48 * 64 - 1}})
    EXPECT_LT(view.picture().alpha[pixel], 0.1f);
}

TEST(Trainer, NoAxisIsThinnerThanATenthOfAPixel) {
  ScratchFolder folder;
  write_small_capture(folder.path());
  const auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  TrainOptions options = short_options(200);
  options.scale_rate = 0.05;  // pushes axes to zero quickly
  options.shape.scale_weight = 100;
  auto trainer = Trainer::start(*capture, options);
  ASSERT_TRUE(trainer);
  take_steps(*trainer, 200);
  // The nearest camera is 2 - 0.9 from any kernel at least, its focal length 66 px.
  const double focal = capture->views[0].camera.focal_x_px;
  for (float log_scale : trainer->kernels().of(Family::LogScale))
    EXPECT_GT(std::exp(double{log_scale}), 0.1 * 1.0 / focal);
}

TEST(SceneExtent, OneFarCameraDoesNotCount) {
  std::vector<CapturedView> views(20);
  for (size_t i = 0; i < views.size(); ++i) {
    const double turn = 2 * M_PI * static_cast<double>(i) / 20;
    views[i].camera.world_from_camera.position_m = {std::cos(turn), 0.0, std::sin(turn)};
  }
  EXPECT_NEAR(robust_extent(views), 1.1, 0.01);
  views[7].camera.world_from_camera.position_m = {500, 0, 0};
  // Its place on the circle is free, so the middle moves by half a gap, 0.16.
  EXPECT_NEAR(robust_extent(views), 1.1, 0.18);
  EXPECT_GT(robust_extent(std::vector<CapturedView>(5)), 0);
}

TEST(InitialKernels, NeighbourDistancesAreThoseOfADirectSearch) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 300; ++i)
    points.push_back(Eigen::Vector3f(static_cast<float>(i % 7), static_cast<float>(i * i % 11),
                                     static_cast<float>(i) * 0.01f));
  const std::vector<float> found = neighbour_distances(points);
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<float> squares;
    for (size_t k = 0; k < points.size(); ++k) {
      if (k != i) squares.push_back((points[k] - points[i]).squaredNorm());
    }
    std::sort(squares.begin(), squares.end());
    EXPECT_NEAR(found[i], std::sqrt((squares[0] + squares[1] + squares[2]) / 3), 1e-5f);
  }
}

TEST(InitialKernels, ACaptureWithoutPointsStartsAtRandom) {
  ScratchFolder folder;
  write_small_capture(folder.path());
  auto capture = read_capture(folder.path());
  ASSERT_TRUE(capture);
  capture->points.clear();
  capture->point_colours.clear();
  const KernelParameters kernels = initial_kernels(*capture, 2.0, 1000, 1);
  EXPECT_EQ(kernels.size(), 1000u);
  TrainedView view;
  view.draw(kernels, capture->views[0].camera, {});
  EXPECT_GT(view.visible_count(), 100u);
}

}  // namespace livegs
