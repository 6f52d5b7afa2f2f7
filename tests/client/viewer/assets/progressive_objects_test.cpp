// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/progressive_objects.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <thread>

#include "common/gaussian/synthetic_asset.h"
#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "splat/camera.h"
#include "splat/image.h"

namespace livegs {
namespace {

// A ball of kernels in index order.
GaussianAsset ball(size_t count) {
  GaussianAsset asset = synthetic_asset(count, 1, 11);
  for (size_t i = 0; i < count; ++i) {
    asset.positions[i] *= 0.25f;
    asset.log_scales[i] = asset.log_scales[i].array() * 0.2f - 4.0f;
  }
  return asset;
}

// An asset source that delivers as much as a test allows.
class SlowSource {
 public:
  explicit SlowSource(GaussianAsset all) : asset(std::move(all)), bytes(encode_progressive(asset)) {
    object.id = 7;
    object.name = "ball";
    object.asset_hash = content_hash(encode_ply(asset));
    object.asset_bytes = bytes.size();
    object.kernel_count = static_cast<uint32_t>(asset.size());
    object.rest.bodies = {Pose{}};
  }
  AssetLibrary::FetchAsset fetch() {
    return [this](const std::string&, uint64_t, uint64_t offset, const TakeChunk& take) -> Result<void> {
      for (size_t at = offset; at < bytes.size();) {
        std::unique_lock lock(mutex_);
        moved_.wait(lock, [&] { return let_ > at || broken_; });
        if (broken_) return Error{ErrorCode::Unavailable, "server disconnected"};
        const size_t length = std::min<size_t>(4096, let_ - at);
        if (auto taken = take(at, bytes.size(), std::span(bytes).subspan(at, length)); !taken) return taken;
        at += length;
      }
      return {};
    };
  }
  void let(double share) {
    std::lock_guard lock(mutex_);
    let_ = static_cast<size_t>(share * static_cast<double>(bytes.size()));
    moved_.notify_all();
  }
  void break_off() {
    std::lock_guard lock(mutex_);
    broken_ = true;
    moved_.notify_all();
  }

  const GaussianAsset asset;
  const std::vector<std::byte> bytes;
  StreamedObject object;

 private:
  std::mutex mutex_;
  std::condition_variable moved_;
  size_t let_ = 0;
  bool broken_ = false;
};

class Arriving : public ::testing::Test {
 protected:
  // Waits until refine() reports a change.
  void wait_refined(ProgressiveObjects& objects) {
    for (int i = 0; i < 6000; ++i) {
      const auto refined = objects.refine(view_);
      ASSERT_TRUE(refined) << refined.error().message;
      if (*refined == std::vector<uint32_t>{7}) return;
      ASSERT_TRUE(refined->empty());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    FAIL() << "no refinement arrived";
  }
  Image drawn() {
    DriverFrame frame;
    ObjectDrivers& drivers = frame.objects.emplace_back();
    drivers.object_id = 7;
    drivers.poses = {Pose{}};
    const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 0.9, 96, 96);
    std::vector<Image> images;
    const auto done = view_.draw(frame, std::span(&camera, 1), images);
    EXPECT_TRUE(done) << done.error().message;
    return images.at(0);
  }

  ScratchFolder folder_;
  const AssetCache cache_{folder_ / "cache"};
  SceneView view_;
};

TEST_F(Arriving, ObjectIsRefinedUntilComplete) {
  SlowSource source(ball(20'000));
  AssetLibrary assets(source.fetch(), cache_);
  assets.show_parts();
  ProgressiveObjects objects(assets);
  objects.request(source.object);
  source.let(0.10);
  ASSERT_TRUE(objects.add(source.object, view_));
  const Image coarse = drawn();
  EXPECT_EQ(objects.progress().objects, 1u);
  EXPECT_LT(objects.progress().kernels_shown, 5000u);
  EXPECT_EQ(objects.progress().kernels_total, 20'000u);
  ASSERT_TRUE(view_.pick({0, 0, 2}, {0, 0, -1}));  // it can already be picked
  source.let(0.35);
  while (objects.progress().kernels_shown < 7168) wait_refined(objects);
  const Image finer = drawn();
  EXPECT_LT(objects.progress().kernels_shown, 20'000u);
  source.let(1);
  while (objects.progress().objects > 0) wait_refined(objects);
  const Image whole = drawn();
  const auto refined = objects.refine(view_);
  ASSERT_TRUE(refined);
  EXPECT_TRUE(refined->empty());

  SceneView at_once;
  ASSERT_TRUE(at_once.add(7, std::make_shared<const GaussianAsset>(source.asset), source.object.rest, false));
  std::swap(at_once, view_);
  const Image expected = drawn();
  EXPECT_EQ(whole.pixels, expected.pixels);
  const double coarse_db = psnr_db(coarse, expected), finer_db = psnr_db(finer, expected);
  std::printf("with a tenth of the bytes %.1f dB, with a third %.1f dB\n", coarse_db, finer_db);
  EXPECT_GT(coarse_db, 12);
  EXPECT_GT(finer_db, coarse_db + 2);
}

// A failed fetch is reported once, instead of an object that stays coarse.
TEST_F(Arriving, FailedFetchIsAnError) {
  SlowSource source(ball(20'000));
  AssetLibrary assets(source.fetch(), cache_);
  assets.show_parts();
  ProgressiveObjects objects(assets);
  objects.request(source.object);
  source.let(0.2);
  ASSERT_TRUE(objects.add(source.object, view_));
  source.break_off();
  for (int i = 0; i < 6000; ++i) {
    const auto refined = objects.refine(view_);
    if (!refined) {
      EXPECT_NE(refined.error().message.find("disconnected"), std::string::npos);
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  FAIL() << "the error was not reported";
}

TEST(RestOfPart, KeepsBodyOfEachKernel) {
  RestBody rest;
  rest.revision = 1;
  rest.bodies.resize(3);
  rest.kernel_runs = {{2, 4}, {0, 3}, {2, 2}, {1, 5}};
  const std::vector<uint32_t> indices = {0, 3, 7, 8, 9, 13};
  const RestBody part = rest_of_part(rest, indices);
  std::vector<uint32_t> bodies;
  for (const RestBody::KernelRun& run : part.kernel_runs) bodies.insert(bodies.end(), run.count, run.body);
  EXPECT_EQ(bodies, (std::vector<uint32_t>{2, 2, 2, 2, 1, 1}));
  EXPECT_TRUE(rest_of_part(RestBody{}, indices).kernel_runs.empty());
}

}  // namespace
}  // namespace livegs
