// SPDX-License-Identifier: Apache-2.0
// Frames and events while the encoding of an asset is pending; the test decides when it finishes.
#include "session/publish/frame_publisher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <new>

#include "common/gaussian/synthetic_asset.h"
#include "core/clock.h"
#include "patience.h"
#include "scene/build/fragile_object.h"
#include "scenes/box_scene.h"
#include "server/session/support/no_inputs.h"
#include "session/assets/describe_object.h"

namespace livegs {
namespace {

// A client that reads everything as soon as it is woken.
class Reader final : public SessionWriter {
 public:
  void attach(std::shared_ptr<ClientSession> session) { session_ = std::move(session); }
  void wake() override {
    std::lock_guard lock(mutex_);
    for (auto outgoing = session_->take(1, now_ns()); outgoing; outgoing = session_->take(1, now_ns())) {
      for (v1::SessionEvent& event : outgoing->events) events_.push_back(std::move(event));
      if (!outgoing->tick) continue;
      tick_ = outgoing->tick;
      (void)session_->acknowledge(1, tick_->tick(), now_ns());
    }
    changed_.notify_all();
  }
  void send_keepalive(int64_t) override {}
  void close(const std::string&) override {}
  void end(const Error&) override {}
  void end_without_session() override {}
  void abort() override {}

  struct Read {
    std::shared_ptr<const TickEncodings> tick;
    std::vector<v1::SessionEvent> events;  // since the last read
  };
  Read wait(uint64_t tick) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPatience, [&] { return tick_ && tick_->tick() >= tick; });
    return {tick_, std::exchange(events_, {})};
  }

 private:
  std::shared_ptr<ClientSession> session_;
  std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::shared_ptr<const TickEncodings> tick_;
  std::vector<v1::SessionEvent> events_;
};

class SlowAssetTest : public ::testing::Test {
 protected:
  SlowAssetTest() : scene_(box_scene()) {
    std::vector<const SceneObject*> objects;
    std::vector<SessionTable::Object> described;
    for (const SceneObject& object : scene_.objects()) {
      objects.push_back(&object);
      described.push_back(std::make_shared<const v1::ObjectDescription>(describe_object(object, assets_)));
    }
    publisher_.begin_with(objects);
    table_.open("boxes", 90, std::move(described), inputs_);
    const auto joined = table_.join();
    EXPECT_TRUE(joined);
    reader_->attach(joined->session);
    EXPECT_TRUE(joined->session->attach(reader_));
  }
  ~SlowAssetTest() override { let_go(); }

  const SceneObject& object(std::string_view name) const {
    return *std::find_if(scene_.objects().begin(), scene_.objects().end(),
                         [&](const SceneObject& one) { return one.name == name; });
  }
  // The box in two fragments, with kernels that are not encoded yet.
  SceneObject broken_box() const {
    SceneObject box = object("box");
    box.asset = slow_;
    box.rest.revision = 1;
    return box;
  }
  // The objects move 1 cm a tick, so that positions identify the tick.
  TickResult tick(std::vector<SceneObject> changed = {}) {
    TickResult stepped;
    stepped.drivers = scene_.world().drivers();
    stepped.drivers.tick = ++number_;
    for (ObjectDrivers& one : stepped.drivers.objects) {
      one.asleep = false;
      for (Pose& pose : one.poses) pose.position_m.y() = height(number_);
      for (Eigen::Vector3f& position : one.positions_m) position.y() += static_cast<float>(height(number_));
      if (one.object_id == object("box").id) one.revision = revision_;
    }
    stepped.stepped_ns = now_ns();
    stepped.changed = std::move(changed);
    return stepped;
  }
  static double height(uint64_t number) { return 0.01 * static_cast<double>(number); }
  Reader::Read publish(TickResult stepped) {
    const uint64_t number = stepped.drivers.tick;
    publisher_.publish(std::move(stepped));
    return reader_->wait(number);
  }
  // Publishes ticks until an event arrives.
  Reader::Read publish_until_event() {
    Reader::Read read;
    for (const int64_t give_up_ns = now_ns() + std::chrono::nanoseconds(kPatience).count();
         read.events.empty() && now_ns() < give_up_ns;)
      read = publish(tick());
    return read;
  }
  static const ObjectDrivers* find(const Reader::Read& read, uint32_t id) {
    if (!read.tick) return nullptr;
    for (const ObjectDrivers& one : read.tick->drivers().objects) {
      if (one.object_id == id) return &one;
    }
    return nullptr;
  }
  void let_go() {
    std::lock_guard lock(mutex_);
    go_ = true;
    let_go_.notify_all();
  }

  Scene scene_;
  const std::shared_ptr<const GaussianAsset> slow_ =
      std::make_shared<const GaussianAsset>(synthetic_asset(50, 0, 1));
  std::mutex mutex_;  // guards go_
  std::condition_variable let_go_;
  bool go_ = false;
  std::atomic<int> slow_encodings_{0};
  NoInputs inputs_;
  SessionTable table_;
  AssetStore assets_{[this](const GaussianAsset& asset) {
    if (&asset == slow_.get()) {
      ++slow_encodings_;
      std::unique_lock lock(mutex_);
      let_go_.wait(lock, [&] { return go_; });
    }
    return encode_asset(asset);
  }};
  const std::shared_ptr<Reader> reader_ = std::make_shared<Reader>();
  uint64_t number_ = 0;
  uint32_t revision_ = 0;
  FramePublisher publisher_{table_, assets_};
};

TEST_F(SlowAssetTest, FracturedObjectFreezesUntilEncoded) {
  const uint32_t box = object("box").id;
  publish(tick());
  revision_ = 1;
  EXPECT_TRUE(publish(tick({broken_box()})).events.empty());
  for (int i = 0; i < 30; ++i) {
    const Reader::Read read = publish(tick());
    EXPECT_TRUE(read.events.empty());
    ASSERT_TRUE(read.tick);
    ASSERT_EQ(read.tick->tick(), number_) << "frames wait for the encoding";
    const ObjectDrivers* held = find(read, box);
    ASSERT_TRUE(held);
    EXPECT_EQ(held->revision, 0u);
    EXPECT_DOUBLE_EQ(held->poses.at(0).position_m.y(), height(1));
    const DriverFrame rest = scene_.world().drivers();
    for (const ObjectDrivers& one : rest.objects) {
      if (one.positions_m.empty()) continue;
      ASSERT_TRUE(find(read, one.object_id));
      EXPECT_FLOAT_EQ(find(read, one.object_id)->positions_m.at(0).y(),
                      one.positions_m.at(0).y() + static_cast<float>(height(number_)));
    }
  }
  // A client that joins now gets the state that frames show.
  const auto late = table_.join();
  ASSERT_TRUE(late);
  const auto described = std::find_if(late->objects.begin(), late->objects.end(),
                                      [&](const auto& one) { return one->object_id() == box; });
  ASSERT_NE(described, late->objects.end());
  EXPECT_EQ((*described)->asset_hash(), assets_.add(object("box").asset)->hash);
  let_go();
  const Reader::Read announced = publish_until_event();
  ASSERT_EQ(announced.events.size(), 1u);
  EXPECT_EQ(announced.events[0].object_changed().object_id(), box);
  EXPECT_EQ(announced.events[0].object_changed().asset_hash(), assets_.add(slow_)->hash);
  ASSERT_TRUE(find(announced, box));
  EXPECT_EQ(find(announced, box)->revision, 1u);
  EXPECT_DOUBLE_EQ(find(announced, box)->poses.at(0).position_m.y(), height(number_));
  EXPECT_EQ(slow_encodings_, 1);
}

// A change of physics during the wait is part of the later announcement.
TEST_F(SlowAssetTest, AnnouncesTheStateAfterTheWait) {
  publish(tick());
  revision_ = 1;
  publish(tick({broken_box()}));
  SceneObject heavier = broken_box();
  heavier.mass_kg = 7;
  EXPECT_TRUE(publish(tick({heavier})).events.empty());
  let_go();
  const Reader::Read announced = publish_until_event();
  ASSERT_EQ(announced.events.size(), 1u);
  EXPECT_EQ(announced.events[0].object_changed().mass_kg(), 7);
  EXPECT_EQ(slow_encodings_, 1);
}

TEST_F(SlowAssetTest, NewObjectsAreHiddenUntilAnnounced) {
  publish(tick());
  constexpr uint32_t kStays = 70, kGoes = 71;
  const auto with_both = [&](bool goes_too) {
    TickResult stepped = tick();
    ObjectDrivers drivers = stepped.drivers.objects.back();
    for (const uint32_t id : {kStays, kGoes}) {
      if (id == kGoes && !goes_too) break;
      drivers.object_id = id;
      stepped.drivers.objects.push_back(drivers);
    }
    return stepped;
  };
  TickResult first = with_both(true);
  for (const uint32_t id : {kStays, kGoes}) {
    SceneObject& added = first.added.emplace_back(object("box"));
    added.id = id;
    added.asset = slow_;
  }
  Reader::Read read = publish(std::move(first));
  EXPECT_TRUE(read.events.empty());
  EXPECT_FALSE(find(read, kStays));
  TickResult second = with_both(false);
  second.removed = {kGoes};
  read = publish(std::move(second));
  EXPECT_TRUE(read.events.empty());
  EXPECT_FALSE(find(read, kStays));
  let_go();
  for (const int64_t give_up_ns = now_ns() + std::chrono::nanoseconds(kPatience).count();
       read.events.empty() && now_ns() < give_up_ns;) {
    read = publish(with_both(false));
    EXPECT_EQ(read.events.empty(), find(read, kStays) == nullptr);
  }
  ASSERT_EQ(read.events.size(), 1u);
  EXPECT_EQ(read.events[0].object_added().object_id(), kStays);
}

// A thing that is taken out of a room replaces the room. Clients have a room in every frame.
TEST_F(SlowAssetTest, RoomStaysUntilTheNextOneIsEncoded) {
  const SceneObject room = object("environment");
  constexpr uint32_t kSecond = 1000, kThird = 1001, kNone = 0;
  const auto with = [&](uint32_t id) {
    TickResult stepped = tick();
    const auto drivers = std::find_if(stepped.drivers.objects.begin(), stepped.drivers.objects.end(),
                                      [&](const ObjectDrivers& one) { return one.object_id == room.id; });
    id == kNone ? void(stepped.drivers.objects.erase(drivers)) : void(drivers->object_id = id);
    return stepped;
  };
  const auto replaced = [&](uint32_t by, uint32_t removed) {
    TickResult stepped = with(by);
    stepped.removed = {removed};
    if (by == kNone) return stepped;
    SceneObject& next = stepped.added.emplace_back(room);
    next.id = by;
    next.asset = slow_;
    return stepped;
  };
  publish(tick());
  const auto pending = [&](TickResult stepped, uint32_t id) {
    const Reader::Read read = publish(std::move(stepped));
    EXPECT_TRUE(read.events.empty());
    EXPECT_TRUE(find(read, room.id));
    EXPECT_FALSE(find(read, id));
  };
  pending(replaced(kSecond, room.id), kSecond);
  pending(with(kSecond), kSecond);
  pending(replaced(kThird, kSecond), kThird);
  let_go();
  Reader::Read read;
  for (const int64_t give_up_ns = now_ns() + std::chrono::nanoseconds(kPatience).count();
       read.events.empty() && now_ns() < give_up_ns;) {
    read = publish(with(kThird));
    EXPECT_EQ(read.events.empty(), find(read, kThird) == nullptr);
    EXPECT_EQ(read.events.empty(), find(read, room.id) != nullptr);
  }
  ASSERT_EQ(read.events.size(), 2u);
  EXPECT_EQ(read.events[0].object_added().object_id(), kThird);
  EXPECT_EQ(read.events[1].object_removed().object_id(), room.id);
  // A room that is removed without another one is removed at once.
  read = publish(replaced(kNone, kThird));
  ASSERT_EQ(read.events.size(), 1u);
  EXPECT_EQ(read.events[0].object_removed().object_id(), kThird);
}

// A cut is announced when the fragments are encoded; other changes of the object are announced at once.
TEST_F(SlowAssetTest, CutIsAnnouncedWhenItsFragmentsAreEncoded) {
  publish(tick());
  SceneObject cut = object("box");
  auto broken = std::make_shared<BrokenAsset>();
  broken->asset = slow_;
  cut.broken = broken;
  EXPECT_TRUE(publish(tick({cut})).events.empty());
  cut.mass_kg = 7;
  Reader::Read read = publish(tick({cut}));
  ASSERT_EQ(read.events.size(), 1u);
  EXPECT_EQ(read.events[0].object_changed().mass_kg(), 7);
  EXPECT_TRUE(read.events[0].object_changed().broken_asset_hash().empty());
  let_go();
  read = publish_until_event();
  ASSERT_EQ(read.events.size(), 1u);
  EXPECT_EQ(read.events[0].object_changed().mass_kg(), 7);
  EXPECT_EQ(read.events[0].object_changed().broken_asset_hash(), assets_.add(slow_)->hash);
  EXPECT_EQ(slow_encodings_, 1);
}

}  // namespace
}  // namespace livegs
