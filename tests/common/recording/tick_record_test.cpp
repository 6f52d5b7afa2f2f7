// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "recording/recording_layout.h"
#include "recording/tick_record.h"

namespace livegs {
namespace {

std::vector<double> values_of(const InputSample& sample) {
  std::vector<double> values;
  for (const HandSample& hand : sample.hands) {
    for (const Pose* pose : {&hand.aim, &hand.grip}) {
      values.insert(values.end(), pose->position_m.data(), pose->position_m.data() + 3);
      values.insert(values.end(), pose->orientation.coeffs().data(), pose->orientation.coeffs().data() + 4);
    }
    values.push_back(hand.trigger);
    values.push_back(hand.squeeze);
    values.push_back(hand.active ? 1 : 0);
    values.push_back(hand.shoot ? 1 : 0);
  }
  return values;
}

// Numbers of any sign and magnitude, exact floats or not.
InputSample any_sample(std::mt19937_64& random, uint64_t sequence, bool floats) {
  std::normal_distribution<double> any(0, 3);
  InputSample sample;
  sample.sequence = sequence;
  sample.sampled_ns = static_cast<int64_t>(random() >> 1);
  sample.for_tick = random() % 4 == 0 ? 0 : random() % 1000;
  const auto value = [&] {
    return floats ? static_cast<double>(static_cast<float>(any(random))) : any(random);
  };
  for (HandSample& hand : sample.hands) {
    hand.active = random() % 2 == 0;
    hand.shoot = random() % 2 == 0;
    for (Pose* pose : {&hand.aim, &hand.grip}) {
      if (random() % 3 == 0) continue;
      for (int k = 0; k < 3; ++k) pose->position_m[k] = value();
      for (int k = 0; k < 4; ++k) pose->orientation.coeffs()[k] = value();
    }
    hand.trigger = static_cast<float>(any(random));
  }
  return sample;
}

TEST(TickRecord, RoundTripsActionsExactly) {
  std::mt19937_64 random(5);
  SamplesBefore writing, reading;
  for (uint64_t tick = 1; tick <= 400; ++tick) {
    TickRecord record;
    record.tick = tick;
    record.key = tick % 100 == 1;
    record.actions.stepped = random() % 5 != 0;
    for (uint64_t session = 1; session < 4; ++session) {
      if (random() % 2 == 0) continue;
      SessionSamples one{session, {}};
      for (size_t i = 0; i < random() % 3; ++i)
        one.samples.push_back(any_sample(random, 3 * tick + i, random() % 4 != 0));
      record.actions.samples.push_back(std::move(one));
    }
    if (random() % 10 == 0) record.actions.over = {3, 1};
    if (random() % 10 == 0) record.actions.released = {2};
    if (random() % 10 == 0) record.actions.cuts = {9, 4};
    if (random() % 10 == 0) record.actions.changes.emplace_back().mutable_force()->set_object("cup");
    if (random() % 50 == 0) record.scene.emplace().set_name("again");
    for (uint32_t id = 1; id < random() % 6; ++id)
      record.hashes.push_back({id * id, static_cast<uint32_t>(random())});
    if (random() % 3 == 0) record.frame.assign(1 + random() % 9, std::byte{0x5A});
    const std::vector<std::byte> bytes = encode_tick(record, writing);
    const auto read = decode_tick(bytes, reading);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->tick, record.tick);
    EXPECT_EQ(read->key, record.key);
    EXPECT_EQ(read->hashes, record.hashes);
    EXPECT_EQ(read->frame, record.frame);
    EXPECT_EQ(read->scene.has_value(), record.scene.has_value());
    EXPECT_EQ(read->actions.stepped, record.actions.stepped);
    EXPECT_EQ(read->actions.over, record.actions.over);
    EXPECT_EQ(read->actions.released, record.actions.released);
    EXPECT_EQ(read->actions.cuts, record.actions.cuts);
    ASSERT_EQ(read->actions.changes.size(), record.actions.changes.size());
    for (size_t i = 0; i < record.actions.changes.size(); ++i)
      EXPECT_EQ(read->actions.changes[i].SerializeAsString(), record.actions.changes[i].SerializeAsString());
    if (record.actions.empty()) continue;
    ASSERT_EQ(read->actions.samples.size(), record.actions.samples.size());
    for (size_t s = 0; s < record.actions.samples.size(); ++s) {
      const SessionSamples &a = read->actions.samples[s], &b = record.actions.samples[s];
      EXPECT_EQ(a.session, b.session);
      ASSERT_EQ(a.samples.size(), b.samples.size());
      for (size_t i = 0; i < a.samples.size(); ++i) {
        EXPECT_EQ(a.samples[i].sequence, b.samples[i].sequence);
        EXPECT_EQ(a.samples[i].sampled_ns, b.samples[i].sampled_ns);
        EXPECT_EQ(a.samples[i].for_tick, b.samples[i].for_tick);
        EXPECT_EQ(values_of(a.samples[i]), values_of(b.samples[i]));
      }
    }
  }
}

// Every truncation is rejected or, if only the frame is shorter, gives a shorter frame.
TEST(TickRecord, RejectsTruncation) {
  std::mt19937_64 random(6);
  TickRecord record;
  record.tick = 70;
  record.actions.samples.push_back({1, {any_sample(random, 1, true), any_sample(random, 2, false)}});
  record.hashes = {{1, 2}, {3, 4}};
  SamplesBefore before;
  const std::vector<std::byte> bytes = encode_tick(record, before);
  for (size_t size = 0; size < bytes.size(); ++size) {
    SamplesBefore none;
    EXPECT_FALSE(decode_tick(std::span(bytes).first(size), none)) << size;
  }
  std::vector<std::byte> more = bytes;
  more.push_back(std::byte{0});
  SamplesBefore none;
  EXPECT_FALSE(decode_tick(more, none));
}

// proto/recording_format.md, "Worked example".
TEST(TickRecord, MatchesTheWorkedExample) {
  TickRecord record;
  record.tick = 3;
  InputSample sample;
  sample.sequence = 9;
  sample.sampled_ns = 1000;
  sample.for_tick = 3;
  sample.hands[1].active = true;
  sample.hands[1].trigger = 1.0f;
  record.actions.samples.push_back({1, {sample}});
  record.hashes = {{2, 0x01020304}};
  std::vector<int> expected{0x03, 0x09, 0x00, 0x00, 0x01, 0x01, 0x01, 0x09,
                            0xD0, 0x0F, 0x00, 0x02, 0x40, 0x20, 0x10, 0x48};
  for (int i = 0; i < 5; ++i) expected.insert(expected.end(), {0x80, 0x80, 0x80, 0xFC, 0x03});
  expected.insert(expected.end(), {0x00, 0x00, 0x01, 0x02, 0x04, 0x03, 0x02, 0x01});
  SamplesBefore before;
  std::vector<int> bytes;
  for (const std::byte byte : encode_tick(record, before)) bytes.push_back(std::to_integer<int>(byte));
  EXPECT_EQ(bytes, expected);
}

// Two hands of a headset at 90 Hz; each value changes slightly in each sample. Measures bytes per hour.
TEST(TickRecord, TwoHandsNeedFewBytes) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> step(0, 1e-3);
  InputSample sample;
  for (HandSample& hand : sample.hands) {
    hand.active = true;
    for (Pose* pose : {&hand.aim, &hand.grip}) pose->position_m = {0.3, 1.2, -0.4};
  }
  SamplesBefore before;
  double bytes = 0;
  constexpr int kTicks = 2000;
  for (int tick = 1; tick <= kTicks; ++tick) {
    for (HandSample& hand : sample.hands) {
      for (Pose* pose : {&hand.aim, &hand.grip}) {
        for (int k = 0; k < 3; ++k)
          pose->position_m[k] = static_cast<float>(pose->position_m[k] + step(random));
        Eigen::Vector4d turned = pose->orientation.coeffs();
        for (int k = 0; k < 4; ++k) turned[k] += step(random);
        turned.normalize();
        for (int k = 0; k < 4; ++k) pose->orientation.coeffs()[k] = static_cast<float>(turned[k]);
      }
    }
    sample.sequence = sample.for_tick = static_cast<uint64_t>(tick);
    sample.sampled_ns += 11'111'111 + static_cast<int64_t>(random() % 1000);
    TickRecord record;
    record.tick = static_cast<uint64_t>(tick);
    record.key = tick % recording_layout::kKeyInterval == 1;
    record.actions.samples.push_back({1, {sample}});
    bytes += static_cast<double>(encode_tick(record, before).size()) + 9;
  }
  const double megabytes_an_hour = bytes / kTicks * 90 * 3600 * 1e-6;
  RecordProperty("megabytes_an_hour", std::to_string(megabytes_an_hour));
  EXPECT_LT(megabytes_an_hour,
            60.0);  // target for a recording of inputs only
}

}  // namespace
}  // namespace livegs
