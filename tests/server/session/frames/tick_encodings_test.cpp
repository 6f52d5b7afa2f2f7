// SPDX-License-Identifier: Apache-2.0
#include "session/frames/tick_encodings.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

DriverFrame swinging(uint64_t tick) {
  DriverFrame frame;
  frame.tick = tick;
  ObjectDrivers& object = frame.objects.emplace_back();
  object.object_id = 1;
  object.kind = DriverKind::Lattice;
  for (int i = 0; i < 100; ++i) {
    object.positions_m.emplace_back(0.01 * i, 0.1 * std::sin(0.1 * static_cast<double>(tick) + i), 0);
  }
  return frame;
}

// A client that misses a frame gets its own encodings until it has the common baseline again.
TEST(TickEncodings, EncodesOncePerBaseline) {
  const auto record = std::make_shared<EncodingRecord>();
  StreamBaselinePtr quick, quick_too, slow;
  for (uint64_t tick = 1; tick <= 100; ++tick) {
    const TickEncodings published(swinging(tick), record);
    quick = published.against(quick).next;
    quick_too = published.against(quick_too).next;
    if (tick % 20 != 10) slow = published.against(slow).next;
    EXPECT_EQ(quick, quick_too);
  }
  EXPECT_EQ(quick, slow);
  // One hundred, plus three for each of the five missed frames: prediction uses three earlier frames.
  EXPECT_EQ(record->summary().encoded, 115u);
}

// Two objects on opposite sides; each client looks at one of them.
class LookingApart {
 public:
  explicit LookingApart(bool uncongested) {
    for (ClientView* who : {&left_, &right_}) who->uncongested = uncongested;
    left_.view = ViewCone{{0, 0, 0}, {-1, 0, 0}, 0.7};
    right_.view = ViewCone{{0, 0, 0}, {1, 0, 0}, 0.7};
  }
  // Number of encodings of a tick; `asleep`: nothing moves.
  uint64_t tick(bool asleep) {
    DriverFrame frame;
    frame.tick = ++tick_;
    if (!asleep) moved_ += 0.01f;
    for (const float side : {-5.0f, 5.0f}) {
      ObjectDrivers& object = frame.objects.emplace_back();
      object.object_id = side < 0 ? 1 : 2;
      object.kind = DriverKind::Lattice;
      object.asleep = asleep;
      object.positions_m = {{side, moved_, 0}, {side, moved_, 1}};
    }
    const uint64_t before = record_->summary().encoded;
    TickEncodings published(frame, record_);
    published.reaches = reaches_;
    has_left_ = published.for_client(has_left_, left_).next;
    has_right_ = published.for_client(has_right_, right_).next;
    return record_->summary().encoded - before;
  }
  bool alike() const { return same_state(*has_left_, *has_right_); }

 private:
  const std::shared_ptr<EncodingRecord> record_ = std::make_shared<EncodingRecord>();
  const std::shared_ptr<const ObjectReaches> reaches_ =
      std::make_shared<ObjectReaches>(ObjectReaches{{1, 0.1}, {2, 0.1}});
  ClientView left_, right_;
  StreamBaselinePtr has_left_, has_right_;
  uint64_t tick_ = 0;
  float moved_ = 0;
};

TEST(TickEncodings, UncongestedClientsShareAcrossViews) {
  LookingApart uncongested(true), narrow(false);
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(uncongested.tick(false), 1u);
    EXPECT_EQ(narrow.tick(false), i == 0 ? 1u : 2u);  // the keyframe is complete
  }
}

// An uncapped slow client gets its own encoding only while there are few of them. With many, separate
// encodings would cause the delay. Capped clients always get their own.
TEST(TickEncodings, ManySlowClientsMostlyShare) {
  constexpr int kClients = 24;
  const auto record = std::make_shared<EncodingRecord>();
  auto reaches = std::make_shared<ObjectReaches>();
  std::vector<ClientView> clients(kClients);
  std::vector<Eigen::Vector3f> places_m;
  for (int c = 0; c < kClients; ++c) {
    const double angle = 2 * M_PI * c / kClients;
    const Eigen::Vector3d ahead(std::cos(angle), 0, std::sin(angle));
    places_m.push_back((10 * ahead).cast<float>());
    clients[c].view = ViewCone{{0, 0, 0}, ahead, 0.05};  // at one object each
    (*reaches)[c + 1] = 0.1;
  }
  uint64_t number = 0;
  const auto frame = [&] {
    DriverFrame moved;
    moved.tick = ++number;
    for (int c = 0; c < kClients; ++c) {
      ObjectDrivers& object = moved.objects.emplace_back();
      object.object_id = static_cast<uint32_t>(c + 1);
      object.kind = DriverKind::Lattice;
      const Eigen::Vector3f up(0, 0.01f * static_cast<float>(number), 0);
      object.positions_m = {places_m[c] + up, places_m[c] + 2 * up};
    }
    return moved;
  };
  for (const bool capped : {false, true}) {
    const auto first = std::make_shared<TickEncodings>(frame(), record);
    const StreamBaselinePtr has = first->against(nullptr).next;
    const uint64_t before = record->summary().encoded;
    TickEncodings tick(frame(), record);
    tick.reaches = reaches;
    for (const ClientView& who : clients) {
      if (capped)
        (void)tick.for_client(has, who, 1e6);
      else
        (void)tick.for_client(has, who);
    }
    const uint64_t encoded = record->summary().encoded - before;
    if (capped)
      EXPECT_GT(encoded, 20u);  // clients whose object is due in this tick share
    else
      EXPECT_EQ(encoded, 9u);
  }
}

// Sleeping objects are never omitted. If everything sleeps, congested clients share too, once the predictions
// have decayed.
TEST(TickEncodings, AllClientsShareWhenEverythingSleeps) {
  LookingApart narrow(false);
  for (int i = 0; i < 40; ++i) narrow.tick(false);
  for (int i = 0; i < 20; ++i) narrow.tick(true);
  EXPECT_TRUE(narrow.alike());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(narrow.tick(true), 1u);
}

}  // namespace
}  // namespace livegs
