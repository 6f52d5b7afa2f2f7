// SPDX-License-Identifier: Apache-2.0
#include "wire/frame_codec.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "common/skin/kernels/rest_bodies.h"
#include "common/wire/mutations.h"

namespace livegs {
namespace {

using namespace livegs::testing;

DriverFrame busy_frame(uint64_t seed) {
  std::mt19937_64 random(seed);
  DriverFrame frame;
  frame.tick = 123456789012345u;
  frame.simulated_ns = -5;
  for (uint32_t i = 0; i < 6; ++i) {
    ObjectDrivers object;
    object.object_id = 10 + i;
    object.kind = static_cast<DriverKind>(1 + i % 3);
    object.asleep = i % 2 == 0;
    if (object.kind == DriverKind::Rigid) object.revision = 85 * i;  // 0 and 255
    const int count = 1 + static_cast<int>(random() % 12);
    for (int d = 0; d < count; ++d) {
      const Eigen::Vector3d at = uniform3(random, -2.0, 3.0);
      if (object.kind == DriverKind::Rigid) {
        object.poses.push_back({at, random_rotation(random)});
      } else {
        object.positions_m.push_back(at.cast<float>());
        if (object.kind == DriverKind::Particles)
          object.rotations.push_back(random_rotation(random).cast<float>());
      }
    }
    frame.objects.push_back(object);
  }
  return frame;
}

void expect_finite(const DriverFrame& frame) {
  for (const ObjectDrivers& object : frame.objects) {
    for (const Pose& pose : object.poses) {
      EXPECT_TRUE(pose.position_m.allFinite());
      EXPECT_NEAR(pose.orientation.norm(), 1.0, 1e-12);
    }
    for (const Eigen::Vector3f& position : object.positions_m) EXPECT_TRUE(position.allFinite());
    for (const Eigen::Quaternionf& rotation : object.rotations) EXPECT_NEAR(rotation.norm(), 1.0f, 1e-6f);
  }
}

TEST(FrameCodec, RoundTripIsWithinTheQuantiserBounds) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const DriverFrame frame = busy_frame(seed);
    const Result<DriverFrame> decoded = decode_frame(encode_frame(frame));
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->tick, frame.tick);
    EXPECT_EQ(decoded->simulated_ns, frame.simulated_ns);
    ASSERT_EQ(decoded->objects.size(), frame.objects.size());
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
    for (const ObjectDrivers& object : frame.objects) {
      for (const Pose& pose : object.poses)
        low = low.cwiseMin(pose.position_m), high = high.cwiseMax(pose.position_m);
    }
    for (size_t i = 0; i < frame.objects.size(); ++i) {
      const ObjectDrivers &was = frame.objects[i], &is = decoded->objects[i];
      EXPECT_EQ(is.object_id, was.object_id);
      EXPECT_EQ(is.kind, was.kind);
      EXPECT_EQ(is.asleep, was.asleep);
      EXPECT_EQ(is.revision, was.revision);
      ASSERT_EQ(is.poses.size(), was.poses.size());
      ASSERT_EQ(is.positions_m.size(), was.positions_m.size());
      ASSERT_EQ(is.rotations.size(), was.rotations.size());
      for (size_t d = 0; d < was.poses.size(); ++d) {
        // Half a step of a box that is at most two float roundings larger than the extent of the poses.
        const Eigen::Array3d bound = ((high - low).array() * (1.0 + 3e-7) + 5e-7) / 2097151.0 / 2.0 + 1e-15;
        EXPECT_TRUE(((is.poses[d].position_m - was.poses[d].position_m).array().abs() <= bound).all());
        EXPECT_LE(angle_between(is.poses[d].orientation, was.poses[d].orientation), 0.0003 * M_PI / 180.0);
      }
      Eigen::Vector3f box_low = Eigen::Vector3f::Constant(1e9f), box_high = -box_low;
      for (const Eigen::Vector3f& x : was.positions_m)
        box_low = box_low.cwiseMin(x), box_high = box_high.cwiseMax(x);
      for (size_t d = 0; d < was.positions_m.size(); ++d) {
        // Half a step, plus the rounding of the result to float (3 m: 1.2e-7).
        const Eigen::Array3f bound =
            (box_high - box_low).array() * (1.0f + 2e-7f) / 65535.0f / 2.0f + 1.3e-7f;
        EXPECT_TRUE(((is.positions_m[d] - was.positions_m[d]).array().abs() <= bound).all());
      }
      for (size_t d = 0; d < was.rotations.size(); ++d) {
        EXPECT_LE(angle_between(is.rotations[d].cast<double>(), was.rotations[d].cast<double>()),
                  0.07 * M_PI / 180.0);
      }
    }
  }
}

TEST(FrameCodec, RawDriversAreLossless) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const DriverFrame frame = busy_frame(seed);
    const std::vector<std::byte> bytes = encode_frame(frame, DriverEncoding::Raw);
    const Result<DriverFrame> decoded = decode_frame(bytes);
    ASSERT_TRUE(decoded) << decoded.error().message;
    ASSERT_EQ(decoded->objects.size(), frame.objects.size());
    size_t payload = 0;
    for (size_t i = 0; i < frame.objects.size(); ++i) {
      const ObjectDrivers &was = frame.objects[i], &is = decoded->objects[i];
      EXPECT_EQ(is.positions_m, was.positions_m);
      ASSERT_EQ(is.poses.size(), was.poses.size());
      ASSERT_EQ(is.rotations.size(), was.rotations.size());
      for (size_t d = 0; d < was.poses.size(); ++d) {
        EXPECT_EQ(is.poses[d].position_m, was.poses[d].position_m.cast<float>().cast<double>());
        EXPECT_LE(angle_between(is.poses[d].orientation, was.poses[d].orientation), 3e-7);
      }
      for (size_t d = 0; d < was.rotations.size(); ++d)
        EXPECT_LE(angle_between(is.rotations[d].cast<double>(), was.rotations[d].cast<double>()), 1e-6);
      payload += 12 * is.positions_m.size() + 16 * is.rotations.size() + 28 * is.poses.size();
    }
    EXPECT_EQ(bytes.size(), 52 + 12 * frame.objects.size() + payload);
    for (size_t length = 0; length < bytes.size(); ++length)
      EXPECT_FALSE(decode_frame(std::span(bytes).first(length))) << length;
    for_each_mutation(bytes, 200, seed, [](std::span<const std::byte> spoilt) {
      if (const auto read = decode_frame(spoilt)) expect_finite(*read);
    });
  }
}

TEST(FrameCodec, EncodingAgainDoesNotDrift) {
  const Result<DriverFrame> once = decode_frame(encode_frame(busy_frame(1)));
  ASSERT_TRUE(once);
  const Result<DriverFrame> twice = decode_frame(encode_frame(*once));
  ASSERT_TRUE(twice);
  for (size_t i = 0; i < once->objects.size(); ++i) {
    for (size_t d = 0; d < once->objects[i].positions_m.size(); ++d) {
      // The corners of the box are on steps, so points return to theirs within a float rounding.
      EXPECT_NEAR((once->objects[i].positions_m[d] - twice->objects[i].positions_m[d]).norm(), 0.0f, 5e-7f);
    }
  }
}

TEST(FrameCodec, IdentityRotationIsExact) {
  DriverFrame frame;
  frame.objects.resize(2);
  frame.objects[0].poses = {Pose{{0.1, 0.2, 0.3}, Eigen::Quaterniond::Identity()},
                            Pose{{1, 1, 1}, Eigen::Quaterniond(-1, 0, 0, 0)}};
  frame.objects[1].kind = DriverKind::Particles;
  frame.objects[1].positions_m = {{0, 0, 0}};
  frame.objects[1].rotations = {Eigen::Quaternionf::Identity()};
  const Result<DriverFrame> decoded = decode_frame(encode_frame(frame));
  ASSERT_TRUE(decoded);
  for (const Pose& pose : decoded->objects[0].poses) {
    EXPECT_EQ(pose.orientation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  }
  EXPECT_EQ(decoded->objects[1].rotations[0].coeffs(), Eigen::Quaternionf::Identity().coeffs());
}

// The hexadecimal block of the format page: indented lines of byte pairs, up to the comment.
std::vector<std::byte> bytes_of_the_page() {
  std::ifstream page(std::string(LIVEGS_TESTS_DIR) + "/../proto/frame_format.md");
  std::vector<std::byte> bytes;
  bool in_example = false;
  for (std::string line; std::getline(page, line);) {
    if (line.rfind("## ", 0) == 0) in_example = line == "## Worked example";
    if (!in_example || line.rfind("    ", 0) != 0) continue;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      if (word.size() != 2 || word.find_first_not_of("0123456789ABCDEF") != std::string::npos) break;
      bytes.push_back(static_cast<std::byte>(std::stoi(word, nullptr, 16)));
    }
  }
  return bytes;
}

DriverFrame frame_of_the_page() {
  DriverFrame frame;
  frame.tick = 7;
  frame.simulated_ns = 77777777;
  frame.objects.resize(3);
  frame.objects[0].object_id = 1;
  frame.objects[0].asleep = true;
  frame.objects[0].poses = {Pose{{1, 2, 3}, Eigen::Quaterniond::Identity()}};
  frame.objects[1].object_id = 2;
  frame.objects[1].kind = DriverKind::Lattice;
  frame.objects[1].positions_m = {{0, 0, 0}, {0.5f, 1, 2}, {0.25f, 0.5f, 1}};
  frame.objects[2].object_id = 3;
  frame.objects[2].kind = DriverKind::Particles;
  frame.objects[2].positions_m = {{-1, 0, 1}};
  frame.objects[2].rotations = {Eigen::Quaternionf(0.70710678f, 0, 0.70710678f, 0)};
  return frame;
}

TEST(FrameCodec, MatchesTheWorkedExample) {
  const std::vector<std::byte> page = bytes_of_the_page();
  ASSERT_EQ(page.size(), 52u + 28u + 12u + 24u + 18u + 12u + 24u + 11u);
  EXPECT_EQ(encode_frame(frame_of_the_page()), page);

  const Result<DriverFrame> decoded = decode_frame(page);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->tick, 7u);
  EXPECT_EQ(decoded->simulated_ns, 77777777);
  ASSERT_EQ(decoded->objects.size(), 3u);
  EXPECT_TRUE(decoded->objects[0].asleep);
  EXPECT_EQ(decoded->objects[0].poses.at(0).position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(decoded->objects[0].poses.at(0).orientation.coeffs(), Eigen::Vector4d(0, 0, 0, 1));
  EXPECT_FALSE(decoded->objects[1].asleep);
  EXPECT_EQ(decoded->objects[1].positions_m.at(0), Eigen::Vector3f(0, 0, 0));
  EXPECT_EQ(decoded->objects[1].positions_m.at(1), Eigen::Vector3f(0.5f, 1, 2));
  const Eigen::Vector3f half = Eigen::Vector3f(0.5f, 1, 2) * (32768.0f / 65535.0f);
  EXPECT_NEAR((decoded->objects[1].positions_m.at(2) - half).norm(), 0.0f, 2e-7f);
  EXPECT_EQ(decoded->objects[2].positions_m.at(0), Eigen::Vector3f(-1, 0, 1));
  EXPECT_NEAR(decoded->objects[2].rotations.at(0).y(), std::sqrt(0.5), 1e-7);
  EXPECT_EQ(decoded->objects[2].rotations.at(0).x(), 0.0f);
}

TEST(FrameCodec, BytesPerDriverMatchThePage) {
  const auto size_with = [](DriverKind kind, size_t count) {
    DriverFrame frame;
    frame.objects.resize(1);
    frame.objects[0].kind = kind;
    if (kind == DriverKind::Rigid) frame.objects[0].poses.resize(count);
    if (kind != DriverKind::Rigid) frame.objects[0].positions_m.resize(count, Eigen::Vector3f::Zero());
    if (kind == DriverKind::Particles)
      frame.objects[0].rotations.resize(count, Eigen::Quaternionf::Identity());
    return encode_frame(frame).size();
  };
  EXPECT_EQ(encode_frame(DriverFrame{}).size(), 52u);
  EXPECT_EQ(size_with(DriverKind::Rigid, 10), 52u + 12u + 160u);
  EXPECT_EQ(size_with(DriverKind::Lattice, 10), 52u + 12u + 24u + 60u);
  EXPECT_EQ(size_with(DriverKind::Particles, 10), 52u + 12u + 24u + 110u);
  EXPECT_EQ(size_with(DriverKind::Particles, 0), 52u + 12u);
}

TEST(FrameCodec, RejectsEveryTruncation) {
  const std::vector<std::byte> bytes = encode_frame(busy_frame(2));
  for (size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_FALSE(decode_frame(cut)) << length;
  }
}

TEST(FrameCodec, MutationsGiveErrorsOrFiniteFrames) {
  int accepted = 0, refused = 0;
  for_each_mutation(encode_frame(busy_frame(3)), 20000, 4, [&](std::span<const std::byte> bytes) {
    const Result<DriverFrame> decoded = decode_frame(bytes);
    (decoded ? accepted : refused) += 1;
    if (decoded) expect_finite(*decoded);
  });
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 100);
}

std::string refusal(std::vector<std::byte> bytes, size_t at, uint8_t value) {
  bytes.at(at) = static_cast<std::byte>(value);
  const Result<DriverFrame> decoded = decode_frame(bytes);
  return decoded ? "" : decoded.error().message;
}

TEST(FrameCodec, ReportsEachInvalidField) {
  const std::vector<std::byte> page = bytes_of_the_page();
  EXPECT_NE(refusal(page, 0, 0).find("LVGF"), std::string::npos);
  EXPECT_NE(refusal(page, 4, 2).find("has version 2, expected 1"), std::string::npos);
  EXPECT_NE(refusal(page, 6, 9).find("unknown encoding 9"), std::string::npos);
  EXPECT_NE(refusal(page, 7, 1).find("reserved"), std::string::npos);
  EXPECT_NE(refusal(page, 27, 0xFF).find("objects but is truncated"), std::string::npos);
  EXPECT_NE(refusal(page, 24, 2).find("left over"), std::string::npos);
  EXPECT_NE(refusal(page, 56, 4).find("unknown kind 4"), std::string::npos);
  EXPECT_NE(refusal(page, 57, 3).find("reserved bit"), std::string::npos);
  EXPECT_NE(refusal(page, 58, 2).find("object 0 (id 1) has unknown encoding 2"), std::string::npos);
  EXPECT_NE(refusal(page, 63, 0xFF).find("claims"), std::string::npos);
  EXPECT_NE(refusal(page, 71, 0x80).find("spare bit of pose 0"), std::string::npos);
  EXPECT_NE(refusal(page, 79, 0x78).find("spare bit of pose 0"), std::string::npos);
  EXPECT_NE(refusal(page, page.size() - 1, 0x78).find("spare bit of rotation 0"), std::string::npos);
}

TEST(FrameCodec, RejectsInvalidBoxes) {
  std::vector<std::byte> bytes = bytes_of_the_page();
  const auto with_float = [&bytes](size_t at, uint32_t bits) {
    std::vector<std::byte> changed = bytes;
    for (size_t i = 0; i < 4; ++i) changed[at + i] = static_cast<std::byte>(bits >> (8 * i));
    const Result<DriverFrame> decoded = decode_frame(changed);
    return decoded ? "" : decoded.error().message;
  };
  const size_t lattice_box = 52 + 28 + 12;
  for (const size_t box : {size_t{28}, lattice_box}) {
    EXPECT_NE(with_float(box, 0x7F800000).find("box"), std::string::npos);       // min is infinite
    EXPECT_NE(with_float(box + 4, 0x7FC00000).find("box"), std::string::npos);   // min is not a number
    EXPECT_NE(with_float(box + 12, 0xBF800000).find("box"), std::string::npos);  // edge is -1
    EXPECT_NE(with_float(box + 16, 0x7F800000).find("box"), std::string::npos);  // edge is infinite
  }
  // The largest float at both ends: each is finite, their sum is not.
  bytes[lattice_box] = bytes[lattice_box + 1] = std::byte{0xFF};
  bytes[lattice_box + 2] = std::byte{0x7F};
  bytes[lattice_box + 3] = std::byte{0x7F};
  EXPECT_NE(with_float(lattice_box + 12, 0x7F7FFFFF).find("box"), std::string::npos);
}

TEST(FrameCodec, RejectsOversizedFramesUnread) {
  const std::vector<std::byte> bytes(kMaxFrameBytes + 1);
  const Result<DriverFrame> decoded = decode_frame(bytes);
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::TooLarge);
}

TEST(FrameCodec, ExtremeFiniteValuesSurvive) {
  DriverFrame frame;
  frame.objects.resize(1);
  frame.objects[0].kind = DriverKind::Lattice;
  frame.objects[0].positions_m = {{-1e30f, 1e-40f, 1e5f}, {1e30f, 0.0f, 1e5f}, {0.0f, 1e-38f, 1e5f}};
  const Result<DriverFrame> decoded = decode_frame(encode_frame(frame));
  ASSERT_TRUE(decoded) << decoded.error().message;
  expect_finite(*decoded);
  for (const Eigen::Vector3f& position : decoded->objects[0].positions_m) EXPECT_EQ(position[2], 1e5f);
}

}  // namespace
}  // namespace livegs
