// SPDX-License-Identifier: Apache-2.0
#include "wire/kernel_codec.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "common/skin/kernels/rest_bodies.h"
#include "common/wire/mutations.h"
#include "skin/kernels/driver_skinning.h"
#include "wire/frame_codec.h"
#include "wire/rest_body_codec.h"

namespace livegs::testing {
namespace {

// Needles, discs and balls of 0.1 mm to 0.3 m with random rotations.
PosedKernels random_kernels(std::mt19937_64& random, size_t count) {
  PosedKernels kernels;
  kernels.resize(count);
  for (size_t k = 0; k < count; ++k) {
    kernels.positions_m[k] = uniform3(random, -1.0, 2.0).cast<float>();
    const Eigen::Matrix3d turn = random_rotation(random).toRotationMatrix();
    Eigen::Vector3d deviations;
    for (int d = 0; d < 3; ++d) deviations[d] = 1e-4 * std::pow(3000.0, uniform(random, 0.0, 1.0));
    const Eigen::Matrix3d m = turn * deviations.array().square().matrix().asDiagonal() * turn.transpose();
    kernels.covariances_m2[k] = symmetric_of(m.cast<float>());
    kernels.world_from_asset[k] = random_rotation(random).cast<float>();
  }
  return kernels;
}

KernelFrame frame_of(uint64_t seed, size_t count) {
  std::mt19937_64 random(seed);
  return {17,
          -3,
          {{4, 1, random_kernels(random, count)}, {5, 0, {}}, {9, kMaxRevision, random_kernels(random, 3)}}};
}

Eigen::Matrix3d matrix_of(const Symmetric3f& s) {
  Eigen::Matrix3d m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return m;
}

TEST(KernelCodec, ExactKernelsAreLossless) {
  const KernelFrame frame = frame_of(1, 200);
  const std::vector<std::byte> bytes = encode_kernels(frame, KernelEncoding::Exact);
  EXPECT_EQ(bytes.size(), 24 + 3 * 9 + 52 * 203u);
  const auto read = decode_kernels(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->tick, 17u);
  EXPECT_EQ(read->simulated_ns, -3);
  ASSERT_EQ(read->objects.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const PosedKernels &was = frame.objects[i].kernels, &is = read->objects[i].kernels;
    EXPECT_EQ(read->objects[i].object_id, frame.objects[i].object_id);
    EXPECT_EQ(read->objects[i].revision, frame.objects[i].revision);
    EXPECT_EQ(is.positions_m, was.positions_m);
    EXPECT_EQ(is.covariances_m2, was.covariances_m2);
    ASSERT_EQ(is.world_from_asset.size(), was.world_from_asset.size());
    for (size_t k = 0; k < was.world_from_asset.size(); ++k)
      EXPECT_EQ(is.world_from_asset[k].coeffs(), was.world_from_asset[k].coeffs());
  }
}

// Errors of a quantised shape: half a step of 24/1023 octaves for deviations and 0.07 degrees for axes, which
// matters most for long needles.
TEST(KernelCodec, QuantisedKernelsAreWithinTheirSteps) {
  const KernelFrame frame = frame_of(2, 2000);
  const std::vector<std::byte> bytes = encode_kernels(frame, KernelEncoding::Quantised);
  EXPECT_EQ(bytes.size(), 24 + 3 * 9 + 2 * 24 + 20 * 2003u);
  const auto read = decode_kernels(bytes);
  ASSERT_TRUE(read) << read.error().message;
  const PosedKernels &was = frame.objects[0].kernels, &is = read->objects[0].kernels;
  for (size_t k = 0; k < was.positions_m.size(); ++k) {
    EXPECT_LE((is.positions_m[k] - was.positions_m[k]).cwiseAbs().maxCoeff(), 3.0f / 65535 / 2 * 1.02f);
    EXPECT_LE(is.world_from_asset[k].angularDistance(was.world_from_asset[k]),
              0.07f * static_cast<float>(M_PI) / 180);
    const Eigen::Matrix3d a = matrix_of(was.covariances_m2[k]), b = matrix_of(is.covariances_m2[k]);
    const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(a).eigenvalues()[2];
    EXPECT_LE((a - b).norm(), 0.022 * largest);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(b).eigenvalues()[0], -1e-6 * largest);
  }
}

// The example of proto/frame_format.md, byte by byte.
TEST(KernelCodec, WritesTheWorkedExample) {
  KernelFrame frame{1, 11111111, {}};
  ObjectKernels& object = frame.objects.emplace_back();
  object.object_id = 7;
  object.revision = 2;
  object.kernels.positions_m = {{1, 2, 3}};
  object.kernels.covariances_m2 = {{1 / 256.0f, 0, 0, 1 / 256.0f, 0, 1 / 256.0f}};
  object.kernels.world_from_asset = {Eigen::Quaternionf::Identity()};
  const std::vector<int> expected = {
      0xD8, 2,    1,    0,    1,    0,    0,    0,    0,    0,    0, 0,
      0xC7, 0x8A, 0xA9, 0,    0,    0,    0,    0,    1,    0,    0, 0,  // head
      7,    0,    0,    0,    2,    1,    0,    0,    0,    0,    0, 0x80,
      0x3F, 0,    0,    0,    0x40, 0,    0,    0x40, 0x40,  // object, box
      0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0, 0,
      0,    0,    0,    0,    0,    0,    0xAA, 0xAA, 0xAA, 0x2A,   // edge; position, deviations
      0x00, 0x08, 0x80, 0x00, 0x38, 0x00, 0x08, 0x80, 0x00, 0x38};  // axes, rotation
  std::vector<int> bytes;
  for (const std::byte byte : encode_kernels(frame, KernelEncoding::Quantised))
    bytes.push_back(std::to_integer<int>(byte));
  EXPECT_EQ(bytes, expected);
}

TEST(KernelCodec, MutationsAreRejectedOrRead) {
  for (const KernelEncoding encoding : {KernelEncoding::Exact, KernelEncoding::Quantised}) {
    const std::vector<std::byte> bytes = encode_kernels(frame_of(3, 5), encoding);
    for (size_t length = 0; length < bytes.size(); ++length)
      EXPECT_FALSE(decode_kernels(std::span(bytes).first(length))) << length;
    int read = 0;
    for_each_mutation(bytes, 4000, 5, [&](std::span<const std::byte> spoilt) {
      const auto frame = decode_kernels(spoilt);
      if (!frame) return;
      ++read;
      for (const ObjectKernels& object : frame->objects) {
        for (size_t k = 0; k < object.kernels.positions_m.size(); ++k) {
          ASSERT_TRUE(object.kernels.positions_m[k].allFinite());
          ASSERT_TRUE(matrix_of(object.kernels.covariances_m2[k]).allFinite());
          ASSERT_TRUE(object.kernels.world_from_asset[k].coeffs().allFinite());
        }
      }
    });
    EXPECT_GT(read, 100);
  }
}

}  // namespace
}  // namespace livegs::testing
