// SPDX-License-Identifier: Apache-2.0
// Updates of a stream while assets are loading; the renderer never waits.
#include "viewer/live/frame_queue.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <set>
#include <thread>

#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// An asset source that delivers on command.
class HeldAssets {
 public:
  // A row of kernels along x; objects differ by their number of kernels.
  StreamedObject object(uint32_t id, size_t kernels, uint32_t revision = 0) {
    GaussianAsset asset;
    for (size_t i = 0; i < kernels; ++i) {
      asset.positions.emplace_back(0.01f * static_cast<float>(i), 0.0f, 0.0f);
      asset.log_scales.push_back(Eigen::Vector3f::Constant(-4));
      asset.rotations.push_back(Eigen::Quaternionf::Identity());
      asset.opacity_logits.push_back(4);
      asset.sh_dc.push_back({1, 0, 0});
    }
    StreamedObject made;
    made.id = id;
    made.name = "object " + std::to_string(id);
    const std::vector<std::byte> bytes = encode_progressive(asset);
    made.asset_hash = content_hash(encode_ply(asset));
    made.kernel_count = static_cast<uint32_t>(kernels);
    made.asset_bytes = bytes.size();
    made.rest.bodies = {Pose{}};
    if (revision > 0) made.rest.bodies.push_back(Pose{});  // two bodies
    made.rest.revision = revision;
    const auto half = static_cast<uint32_t>(kernels / 2);
    made.rest.kernel_runs = {{0, revision > 0 ? half : static_cast<uint32_t>(kernels)}};
    if (revision > 0) made.rest.kernel_runs.push_back({1, static_cast<uint32_t>(kernels) - half});
    std::lock_guard lock(mutex_);
    bytes_[made.asset_hash] = bytes;
    return made;
  }
  void give(const StreamedObject& object) {
    {
      std::lock_guard lock(mutex_);
      given_.insert(object.asset_hash);
    }
    changed_.notify_all();
  }
  // Delivers the first `share` of the bytes.
  void give_first(const StreamedObject& object, double share) {
    {
      std::lock_guard lock(mutex_);
      begun_[object.asset_hash] = static_cast<size_t>(share * static_cast<double>(object.asset_bytes));
    }
    changed_.notify_all();
  }
  ~HeldAssets() {  // after a failed test
    for (const auto& [hash, bytes] : bytes_) given_.insert(hash);
    changed_.notify_all();
  }
  Result<void> fetch(const std::string& hash, const TakeChunk& take) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return given_.contains(hash) || begun_.contains(hash); });
    const std::span<const std::byte> bytes = bytes_.at(hash);
    const size_t first = begun_.contains(hash) ? begun_.at(hash) : 0;
    if (first > 0) {
      if (auto taken = take(0, bytes.size(), bytes.first(first)); !taken) return taken;
      changed_.wait(lock, [&] { return given_.contains(hash); });
    }
    return take(first, bytes.size(), bytes.subspan(first));
  }

 private:
  std::mutex mutex_;  // guards the others
  std::condition_variable changed_;
  std::map<std::string, std::vector<std::byte>> bytes_;
  std::set<std::string> given_;
  std::map<std::string, size_t> begun_;
};

ReceivedFrame frame_of(uint64_t tick, std::initializer_list<std::tuple<uint32_t, uint32_t, double>> objects) {
  DriverFrame drivers;
  drivers.tick = tick;
  drivers.simulated_ns = static_cast<int64_t>(tick) * 10'000'000;
  for (const auto& [id, revision, x_m] : objects) {
    ObjectDrivers one;
    one.object_id = id;
    one.revision = revision;
    one.poses.assign(revision > 0 ? 2 : 1, {{x_m, 0, 0}, Eigen::Quaterniond::Identity()});
    drivers.objects.push_back(one);
  }
  ReceivedFrame frame;
  frame.tick = tick;
  frame.drivers = std::make_shared<const DriverFrame>(std::move(drivers));
  return frame;
}

class FrameQueueTest : public ::testing::Test {
 protected:
  // The renderer's work for one picture.
  FrameQueue::StreamUpdate picture() {
    auto update = stream_.take(view_);
    EXPECT_TRUE(update) << update.error().message;
    if (!update) return {};
    if (!update->frames.empty()) drivers_ = update->frames.back().drivers;
    if (drivers_) {
      const auto posed = view_.pose(*drivers_);
      EXPECT_TRUE(posed) << posed.error().message;
    }
    return std::move(*update);
  }
  // Draws pictures until an added or changed object is available.
  FrameQueue::StreamUpdate picture_with_news() {
    for (;;) {
      auto update = picture();
      if (!update.described.empty() || update.server_restarted || HasFailure()) return update;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  double middle_m(uint32_t id) { return view_.bounds(id).center().x(); }

  ScratchFolder folder_;
  AssetCache cache_{folder_ / "cache"};
  HeldAssets held_;
  AssetLibrary assets_{[this](const std::string& hash, uint64_t, uint64_t, const TakeChunk& take) {
                         return held_.fetch(hash, take);
                       },
                       cache_};
  SceneView view_;
  ProgressiveObjects objects_{assets_};
  FrameQueue stream_{objects_};
  std::shared_ptr<const DriverFrame> drivers_;
};

TEST_F(FrameQueueTest, FracturedObjectKeepsPoseUntilBound) {
  const StreamedObject whole = held_.object(1, 10), other = held_.object(2, 12),
                       broken = held_.object(1, 14, 1);
  held_.give(whole);
  held_.give(other);
  stream_.on_object_added(whole);
  stream_.on_object_added(other);
  stream_.on_frame(frame_of(1, {{1, 0, 5.0}, {2, 0, 20.0}}));
  for (size_t described = 0; described < 2;) described += picture_with_news().described.size();
  EXPECT_NEAR(middle_m(1), 5.04, 1e-3);

  stream_.on_object_changed(broken);
  stream_.on_frame(frame_of(2, {{1, 1, 7.0}, {2, 0, 21.0}}));
  for (int i = 0; i < 20; ++i) {
    const auto update = picture();  // after a reconnect
    EXPECT_EQ(update.frames.size(), i == 0 ? 1u : 0u);
    EXPECT_TRUE(update.described.empty());
    EXPECT_NEAR(middle_m(1), 5.04, 1e-3);   // unchanged
    EXPECT_NEAR(middle_m(2), 21.05, 1e-3);  // other objects continue
  }
  held_.give(broken);
  const auto update = picture_with_news();
  ASSERT_EQ(update.described.size(), 1u);
  EXPECT_EQ(update.described[0].rest.revision, 1u);
  (void)picture();
  EXPECT_NEAR(middle_m(1), 7.06, 1e-3);
}

TEST_F(FrameQueueTest, NewObjectDoesNotDelayOthers) {
  const StreamedObject slow = held_.object(1, 10), quick = held_.object(2, 12);
  held_.give(quick);
  stream_.on_object_added(slow);
  stream_.on_object_added(quick);
  stream_.on_frame(frame_of(1, {{1, 0, 5.0}, {2, 0, 20.0}}));
  const auto first = picture_with_news();
  ASSERT_EQ(first.described.size(), 1u);
  EXPECT_EQ(first.described[0].id, 2u);
  (void)picture();
  EXPECT_TRUE(view_.bounds(1).isEmpty());
  EXPECT_NEAR(middle_m(2), 20.05, 1e-3);
  held_.give(slow);
  EXPECT_EQ(picture_with_news().described.at(0).id, 1u);
  (void)picture();
  EXPECT_NEAR(middle_m(1), 5.04, 1e-3);
}

// Coarse at first: other updates do not affect the refinement, and it needs no new frame.
TEST_F(FrameQueueTest, ObjectIsRefinedUntilComplete) {
  assets_.show_parts();
  StreamedObject object = held_.object(1, 8192);
  held_.give_first(object, 0.5);
  stream_.on_object_added(object);
  stream_.on_frame(frame_of(1, {{1, 0, 5.0}}));
  ASSERT_EQ(picture_with_news().described.size(), 1u);
  (void)picture();
  EXPECT_EQ(objects_.progress().objects, 1u);
  EXPECT_GT(objects_.progress().kernels_shown, 1000u);
  EXPECT_LT(objects_.progress().kernels_shown, 8192u);
  EXPECT_FALSE(view_.bounds(1).isEmpty());
  EXPECT_LT(middle_m(1), 40);
  object.mass_kg = 2;
  stream_.on_object_changed(object);
  const auto changed = picture();
  EXPECT_EQ(changed.described.size(), 1u);
  EXPECT_TRUE(changed.refined.empty());
  EXPECT_EQ(objects_.progress().objects, 1u);
  held_.give(object);
  std::vector<uint32_t> refined;
  while (objects_.progress().objects > 0 && !HasFailure()) {
    for (const uint32_t id : picture().refined) refined.push_back(id);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(refined, (std::vector<uint32_t>{1}));
  EXPECT_NEAR(middle_m(1), 5 + 40.95, 1e-2);
}

// A ball that was removed before its asset arrived.
TEST_F(FrameQueueTest, RemovedObjectNeverAppears) {
  const StreamedObject ball = held_.object(1, 10), other = held_.object(2, 12);
  stream_.on_object_added(ball);
  stream_.on_object_removed(1);
  const auto update = picture();
  ASSERT_EQ(update.removed, (std::vector<uint32_t>{1}));
  held_.give(ball);
  held_.give(other);
  stream_.on_object_added(other);
  EXPECT_EQ(picture_with_news().described.at(0).id, 2u);
  stream_.on_frame(frame_of(1, {{1, 0, 5.0}, {2, 0, 20.0}}));
  (void)picture();
  EXPECT_TRUE(view_.bounds(1).isEmpty());
}

// A changed mass comes with a description whose kernels are already loaded.
TEST_F(FrameQueueTest, DescriptionUpdateIsImmediateAndOrdered) {
  StreamedObject object = held_.object(1, 10);
  held_.give(object);
  stream_.on_object_added(object);
  (void)picture_with_news();
  object.mass_kg = 2;
  stream_.on_object_changed(object);
  object.mass_kg = 3;
  stream_.on_object_changed(object);
  const auto update = picture();
  ASSERT_EQ(update.described.size(), 2u);
  EXPECT_EQ(update.described.back().mass_kg, 3);
}

// The id belongs to another object on the new server: it is shown only once everything is loaded.
TEST_F(FrameQueueTest, RestartedServerAppearsOnceComplete) {
  const StreamedObject before = held_.object(1, 10), one = held_.object(1, 16, 1), two = held_.object(2, 12);
  held_.give(before);
  stream_.on_object_added(before);
  stream_.on_frame(frame_of(9, {{1, 0, 5.0}}));
  (void)picture_with_news();
  stream_.on_lost("gone");
  stream_.on_resumed({.same_server = false, .outage_s = 1});
  stream_.on_object_added(one);
  stream_.on_object_added(two);
  const auto lost = picture();
  EXPECT_TRUE(lost.lost);
  stream_.on_frame(frame_of(1, {{1, 1, 7.0}, {2, 0, 8.0}}));
  held_.give(one);
  for (int i = 0; i < 20; ++i) {
    const auto update = picture();
    EXPECT_TRUE(update.frames.empty());
    EXPECT_FALSE(update.back);
    EXPECT_NEAR(middle_m(1), 5.04, 1e-3);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  held_.give(two);
  const auto update = picture_with_news();
  EXPECT_TRUE(update.server_restarted);
  EXPECT_TRUE(update.back);
  EXPECT_EQ(update.described.size(), 2u);
  EXPECT_NEAR(middle_m(1), 7.07, 1e-3);
  EXPECT_NEAR(middle_m(2), 8.05, 1e-3);
}

}  // namespace
}  // namespace livegs
