// SPDX-License-Identifier: Apache-2.0
#include "wire/frame_stream.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "common/wire/mutations.h"

namespace livegs::testing {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

NodeNeighboursPtr neighbours_of(size_t side) {
  static std::map<size_t, NodeNeighboursPtr> known;
  NodeNeighboursPtr& found = known[side];
  if (found) return found;
  const int n = static_cast<int>(side);
  std::vector<Eigen::Vector3i> coordinates;
  for (int i = 0; i < n * n * n; ++i) coordinates.emplace_back(i % n, i / n % n, i / n / n);
  return found = find_node_neighbours(std::move(coordinates));
}

// A soft block that oscillates and shears, some tumbling rigid bodies, and particles with rotations.
struct Motion {
  size_t side = 6;
  bool neighbours = true;  // send the neighbours of the lattice
  std::set<uint32_t> asleep, absent;
  std::set<uint32_t> broken;

  DriverFrame at(uint64_t tick) const {
    const double t = static_cast<double>(tick) / 90.0;
    DriverFrame frame;
    frame.tick = tick;
    frame.simulated_ns = static_cast<int64_t>(t * 1e9);
    for (uint32_t id = 1; id <= 6; ++id) {
      if (absent.count(id)) continue;
      const double when = asleep.count(id) ? 0.0 : t;
      ObjectDrivers object;
      object.object_id = 7 * id;
      object.asleep = asleep.count(id) > 0;
      if (id <= 2) {
        object.kind = id == 1 ? DriverKind::Lattice : DriverKind::Particles;
        if (id == 1 && neighbours) object.neighbours = neighbours_of(side);
        for (size_t i = 0; i < side * side * side; ++i) {
          const Vector3d rest(0.05 * (i % side), 0.05 * (i / side % side), 0.05 * (i / side / side));
          const double swing = 0.1 * std::sin(9.0 * when + 4.0 * rest.y());
          object.positions_m.push_back(
              (rest + Vector3d(swing, 0.5 * swing * rest.x(), when * 0.3)).cast<float>());
          if (id == 2) {
            object.rotations.push_back(
                Quaterniond(Eigen::AngleAxisd(3.0 * when + rest.z(), Vector3d(1, 2, rest.x()).normalized()))
                    .cast<float>());
          }
        }
      } else {
        object.kind = DriverKind::Rigid;
        object.revision = broken.count(id) ? 1 : 0;
        const size_t bodies = broken.count(id) ? 20 : 1;
        for (size_t i = 0; i < bodies; ++i) {
          const Vector3d axis = Vector3d(1.0 + static_cast<double>(i), id, 0.3).normalized();
          object.poses.push_back(
              {Vector3d(0.2 * id + when, 1.0 - 4.9 * when * when, 0.01 * static_cast<double>(i)),
               Quaterniond(Eigen::AngleAxisd(5.0 * when * id, axis))});
        }
      }
      frame.objects.push_back(object);
    }
    return frame;
  }
};

double step_m(double side_m) {
  return 0.9375 * std::exp2(std::max(-14.0, std::ceil(std::log2(side_m / 65535.0 / 0.9375))));
}

void expect_same(const DriverFrame& a, const DriverFrame& b) {
  ASSERT_EQ(a.tick, b.tick);
  EXPECT_EQ(a.simulated_ns, b.simulated_ns);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    const ObjectDrivers &p = a.objects[i], &q = b.objects[i];
    EXPECT_EQ(p.object_id, q.object_id);
    EXPECT_EQ(p.kind, q.kind);
    EXPECT_EQ(p.revision, q.revision);
    EXPECT_EQ(p.asleep, q.asleep);
    EXPECT_EQ(p.positions_m, q.positions_m);
    ASSERT_EQ(p.poses.size(), q.poses.size());
    for (size_t k = 0; k < p.poses.size(); ++k) {
      EXPECT_EQ(p.poses[k].position_m, q.poses[k].position_m);
      EXPECT_EQ(p.poses[k].orientation.coeffs(), q.poses[k].orientation.coeffs());
    }
    ASSERT_EQ(p.rotations.size(), q.rotations.size());
    for (size_t k = 0; k < p.rotations.size(); ++k)
      EXPECT_EQ(p.rotations[k].coeffs(), q.rotations[k].coeffs());
  }
}

// Tolerance: half a step on each axis. Rotations as by the bits of a component (driver_grid.h), and slightly
// more if a component that is not quite the largest is omitted.
void expect_near(const DriverFrame& sent, const DriverFrame& read) {
  constexpr double kDegree = M_PI / 180.0;
  ASSERT_EQ(sent.objects.size(), read.objects.size());
  for (size_t i = 0; i < sent.objects.size(); ++i) {
    const ObjectDrivers &p = sent.objects[i], &q = read.objects[i];
    for (size_t k = 0; k < p.positions_m.size(); ++k) {
      EXPECT_LE((p.positions_m[k] - q.positions_m[k]).cast<double>().cwiseAbs().maxCoeff(),
                0.5 * step_m(0.6) * (1 + 1e-2));
    }
    for (size_t k = 0; k < p.rotations.size(); ++k) {
      EXPECT_LE(p.rotations[k].angularDistance(q.rotations[k]), 0.08f * static_cast<float>(kDegree));
    }
    for (size_t k = 0; k < p.poses.size(); ++k) {
      EXPECT_LE((p.poses[k].position_m - q.poses[k].position_m).cwiseAbs().maxCoeff(),
                std::exp2(-19) * (1 + 1e-9));
      EXPECT_LE(p.poses[k].orientation.angularDistance(q.poses[k].orientation), 0.0013 * kDegree);
    }
  }
}

TEST(FrameStream, RoundTripsBirthsDeathsSleepAndBreaks) {
  Motion motion;
  motion.absent = {5};
  StreamBaselinePtr baseline;
  StreamReader reader;
  EXPECT_TRUE(reader.needs_keyframe());
  std::mt19937 random(3);
  uint64_t tick = 1;
  for (int frame = 0; frame < 300; ++frame) {
    if (frame == 40) motion.absent = {};
    if (frame == 60) motion.broken = {4};
    if (frame == 80) motion.absent = {3};
    if (frame == 100) motion.asleep = {1, 6};
    if (frame == 160) motion.asleep = {};
    const DriverFrame sent = motion.at(tick);
    const EncodedStreamFrame encoded = encode_stream_frame(sent, baseline);
    const Result<DriverFrame> read = reader.read(encoded.bytes);
    ASSERT_TRUE(read) << frame << ": " << read.error().message;
    EXPECT_FALSE(reader.needs_keyframe());
    expect_same(*read, frame_of(*encoded.next));
    expect_near(sent, *read);
    baseline = encoded.next;
    // Skipped ticks, as for a slow client.
    tick += frame % 7 == 3 ? 1 + random() % 30 : 1;
  }
}

// The example of proto/frame_format.md, byte by byte.
TEST(FrameStream, WritesTheWorkedExample) {
  DriverFrame frame;
  frame.tick = 1;
  frame.simulated_ns = 11111111;
  frame.objects.push_back({7, DriverKind::Lattice, 0, false, {}, {{0, 0, 0}, {0, 0.5f, -0.25f}}, {}});
  const std::vector<int> expected = {0xD6, 0x02, 0x05, 0x01, 0xC7, 0x8A, 0xA9, 0,    0,    0,
                                     0,    0,    0xF2, 0x62, 0x03, 0x9C, 0x23, 0x86, 0x00, 0xF2,
                                     0x15, 0x04, 0x41, 0x00, 0x00, 0x00, 0x40, 0x44, 0x04, 0x00,
                                     0x00, 0x00, 0x00, 0x10, 0x22, 0x02, 0x00, 0x00};
  std::vector<int> bytes;
  for (const std::byte byte : encode_stream_frame(frame, nullptr).bytes)
    bytes.push_back(std::to_integer<int>(byte));
  EXPECT_EQ(bytes, expected);
}

// The same example with the two nodes as neighbours: the second is predicted from the first.
TEST(FrameStream, WritesTheWorkedExampleOfNeighbours) {
  DriverFrame frame;
  StreamBaselinePtr baseline;
  const NodeNeighboursPtr neighbours = find_node_neighbours({{0, 0, 0}, {1, 0, 0}});
  for (int tick = 1; tick <= 4; ++tick) {
    const float z = 15.0f / (1 << 18) * static_cast<float>(tick * tick);  // 1, 4, 9, 16 steps
    frame.tick = static_cast<uint64_t>(tick);
    frame.simulated_ns = 0;
    frame.objects = {{7, DriverKind::Lattice, 0, false, {}, {{0, 0, 0}, {0, 0, z}}, {}, neighbours}};
    StreamOptions options;
    options.hash_interval = 0;
    const EncodedStreamFrame encoded = encode_stream_frame(frame, baseline, options);
    baseline = encoded.next;
    if (tick < 4) continue;
    std::vector<int> bytes;
    for (const std::byte byte : encoded.bytes) bytes.push_back(std::to_integer<int>(byte));
    EXPECT_EQ(bytes, (std::vector<int>{0xD6, 2, 0,    4,    0,    0,    0,    0,    0,    0,   0,
                                       0,    1, 0x23, 0x5E, 0x55, 0x88, 0x40, 0x10, 0x04, 0x13}));
  }
}

// Neighbours cost some bytes once and save bytes in each frame.
TEST(FrameStream, NeighboursMakeFramesSmaller) {
  std::array<size_t, 2> bytes{}, key{};
  for (const bool neighbours : {false, true}) {
    Motion motion;
    motion.side = 12;
    motion.absent = {2, 3, 4, 5, 6};
    motion.neighbours = neighbours;
    StreamBaselinePtr baseline;
    StreamReader reader;
    for (uint64_t tick = 1; tick <= 40; ++tick) {
      // Noise that neighbours share, as in a passing wave.
      DriverFrame frame = motion.at(tick);
      for (size_t i = 0; i < frame.objects[0].positions_m.size(); ++i) {
        Eigen::Vector3f& at = frame.objects[0].positions_m[i];
        at.x() += 0.003f * std::sin(static_cast<float>(tick * tick) + 9.0f * at.y() + 7.0f * at.z());
      }
      const EncodedStreamFrame encoded = encode_stream_frame(frame, baseline);
      const auto read = reader.read(encoded.bytes);
      ASSERT_TRUE(read) << read.error().message;
      expect_same(*read, frame_of(*encoded.next));
      if (tick == 1) key[neighbours] = encoded.bytes.size();
      if (tick > 3) bytes[neighbours] += encoded.bytes.size();
      baseline = encoded.next;
    }
  }
  EXPECT_LE(bytes[true], 0.85 * static_cast<double>(bytes[false]));
  EXPECT_LE(key[true], 1.3 * static_cast<double>(key[false]));
}

TEST(FrameStream, SleepingObjectsTakeNoSpace) {
  Motion motion;
  motion.asleep = {1, 2, 3, 4, 5, 6};
  const EncodedStreamFrame first = encode_stream_frame(motion.at(1), nullptr);
  EXPECT_EQ(first.object_count, 6u);
  StreamOptions options;
  options.hash_interval = 0;
  const EncodedStreamFrame second = encode_stream_frame(motion.at(2), first.next, options);
  EXPECT_EQ(second.object_count, 0u);
  EXPECT_LE(second.bytes.size(), 15u);  // only tick, time and empty lists
}

TEST(FrameStream, DeferredObjectsKeepTheirStateAndCatchUp) {
  const Motion motion;
  StreamReader reader;
  const EncodedStreamFrame first = encode_stream_frame(motion.at(1), nullptr);
  ASSERT_TRUE(reader.read(first.bytes));
  StreamOptions options;
  options.leave_out = [](uint32_t id) { return id == 7; };
  StreamBaselinePtr baseline = first.next;
  for (uint64_t tick = 2; tick < 10; ++tick) {
    const EncodedStreamFrame encoded = encode_stream_frame(motion.at(tick), baseline, options);
    const auto read = reader.read(encoded.bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->objects[0].positions_m, frame_of(*first.next).objects[0].positions_m);
    baseline = encoded.next;
  }
  const auto read = reader.read(encode_stream_frame(motion.at(10), baseline).bytes);
  ASSERT_TRUE(read);
  expect_near(motion.at(10), *read);
}

TEST(FrameStream, ALostFrameRequiresAKeyframe) {
  const Motion motion;
  StreamReader reader;
  const EncodedStreamFrame a = encode_stream_frame(motion.at(1), nullptr);
  const EncodedStreamFrame b = encode_stream_frame(motion.at(2), a.next);
  const EncodedStreamFrame c = encode_stream_frame(motion.at(3), b.next);
  ASSERT_TRUE(reader.read(a.bytes));
  const auto read = reader.read(c.bytes);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("keyframe"), std::string::npos) << read.error().message;
  EXPECT_TRUE(reader.needs_keyframe());
  ASSERT_TRUE(reader.read(encode_stream_frame(motion.at(4), nullptr).bytes));
  EXPECT_FALSE(reader.needs_keyframe());
}

TEST(FrameStream, HashDetectsADivergedReader) {
  const Motion motion;
  Motion other;
  other.asleep = {1};  // another state at the same tick
  StreamReader reader;
  ASSERT_TRUE(reader.read(encode_stream_frame(other.at(1), nullptr).bytes));
  StreamBaselinePtr baseline = encode_stream_frame(motion.at(1), nullptr).next;
  StreamOptions options;
  options.hash_interval = 4;
  int found_out = 0;
  for (uint64_t tick = 2; tick < 8 && !found_out; ++tick) {
    const EncodedStreamFrame encoded = encode_stream_frame(motion.at(tick), baseline, options);
    found_out = reader.read(encoded.bytes) ? 0 : static_cast<int>(tick);
    baseline = encoded.next;
  }
  EXPECT_GT(found_out, 0);
  EXPECT_LE(found_out, 5);
}

// One stream misses a frame. Three frames later both streams have the same state and get the same bytes.
// Objects that fell asleep in the missed frame take as long as linear prediction is permitted.
TEST(FrameStream, StreamsConvergeAfterAMissedFrame) {
  for (const bool falls_asleep : {false, true}) {
    Motion motion;
    StreamBaselinePtr whole, gap;
    StreamReader reader;
    uint64_t alike_at = 0;
    for (uint64_t tick = 1; tick <= 40; ++tick) {
      if (falls_asleep && tick == 11) motion.asleep = {1, 6};
      const DriverFrame frame = motion.at(tick);
      if (tick != 11) {
        const EncodedStreamFrame encoded = encode_stream_frame(frame, gap);
        gap = encoded.next;
        const auto read = reader.read(encoded.bytes);
        ASSERT_TRUE(read) << tick << ": " << read.error().message;
      }
      whole = encode_stream_frame(frame, whole).next;
      if (tick <= 11) continue;
      if (alike_at == 0 && same_state(*whole, *gap)) alike_at = tick;
      if (alike_at == 0) continue;
      // From here on, the reader of one stream gets the frames of the other.
      ASSERT_TRUE(same_state(*whole, *gap)) << tick;
      EXPECT_EQ(encode_stream_frame(motion.at(tick + 1), whole).bytes,
                encode_stream_frame(motion.at(tick + 1), gap).bytes);
      gap = whole;
    }
    EXPECT_GT(alike_at, 12u);
    EXPECT_LE(alike_at, falls_asleep ? 11u + 17 : 15u);
  }
}

TEST(FrameStream, EqualBaselinesGiveEqualBytes) {
  const Motion motion;
  const StreamBaselinePtr baseline = encode_stream_frame(motion.at(1), nullptr).next;
  EXPECT_EQ(encode_stream_frame(motion.at(2), baseline).bytes,
            encode_stream_frame(motion.at(2), baseline).bytes);
}

TEST(FrameStream, SupportsFarLargeAndSmallObjects) {
  for (const double scale : {1e-4, 1e-2, 1.0, 1e3, 1e6}) {
    DriverFrame frame;
    frame.tick = 1;
    ObjectDrivers object{1, DriverKind::Lattice, 0, false, {}, {}, {}};
    for (int i = 0; i < 50; ++i)
      object.positions_m.emplace_back(scale * i, -scale * i * i, scale * (5.0 + i));
    frame.objects.push_back(object);
    frame.objects.push_back({2,
                             DriverKind::Rigid,
                             0,
                             false,
                             {{Vector3d(scale, -1e5, 12 * scale), Quaterniond::Identity()}},
                             {},
                             {}});
    StreamReader reader;
    const auto read = reader.read(encode_stream_frame(frame, nullptr).bytes);
    ASSERT_TRUE(read);
    const double step = step_m(2401.0 * scale);
    for (int i = 0; i < 50; ++i) {
      EXPECT_LE((read->objects[0].positions_m[i] - object.positions_m[i]).norm(), static_cast<float>(step))
          << scale;
    }
    EXPECT_LE((read->objects[1].poses[0].position_m - frame.objects[1].poses[0].position_m).norm(),
              1.2e5 * std::max(1.0, 1.2e-4 * scale) / (1 << 29));
    EXPECT_EQ(read->objects[1].poses[0].orientation.coeffs(),
              Quaterniond::Identity().coeffs());  // zero is exact
  }
}

TEST(FrameStream, MutationsAreRejectedOrRead) {
  Motion motion;
  motion.broken = {4};
  const EncodedStreamFrame first = encode_stream_frame(motion.at(1), nullptr);
  const EncodedStreamFrame second = encode_stream_frame(motion.at(2), first.next);
  const EncodedStreamFrame third = encode_stream_frame(motion.at(3), second.next);
  Motion small;  // small enough to be stored directly, so that mutations reach the later parts
  small.side = 1;
  small.absent = {3, 4, 5};
  const EncodedStreamFrame tiny_first = encode_stream_frame(small.at(1), nullptr);
  const EncodedStreamFrame tiny_second = encode_stream_frame(small.at(2), tiny_first.next);
  int read = 0;
  const auto look_at = [&](const std::vector<std::vector<std::byte>>& before,
                           const std::vector<std::byte>& bytes, uint64_t seed) {
    for_each_mutation(bytes, 4000, seed, [&](std::span<const std::byte> spoilt) {
      StreamReader reader;
      for (const auto& frame : before) ASSERT_TRUE(reader.read(frame));
      const auto frame = reader.read(spoilt);
      if (!frame) return;
      ++read;
      for (const ObjectDrivers& object : frame->objects) {
        for (const Eigen::Vector3f& position : object.positions_m) ASSERT_TRUE(position.allFinite());
        for (const Pose& pose : object.poses) ASSERT_NEAR(pose.orientation.norm(), 1.0, 1e-9);
      }
    });
  };
  look_at({}, first.bytes, 1);
  look_at({first.bytes, second.bytes}, third.bytes, 2);
  look_at({}, tiny_first.bytes, 3);
  look_at({tiny_first.bytes}, tiny_second.bytes, 4);
  EXPECT_GT(read, 100);  // not all mutations are rejected by the header
}

}  // namespace
}  // namespace livegs::testing
