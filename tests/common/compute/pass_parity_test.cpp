// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "common/compute/backends.h"
#include "skin/pose_rigid_kernels.h"

namespace livegs {
namespace {

using PassParity = OnEveryBackend;
INSTANTIATE_TEST_SUITE_P(Pass, PassParity, testing::Values("cpu", "vulkan"), backend_name);

// One policy for every pass whose values are of order one: |a - b| <= 1e-6 + 1e-5 |b|. A device may fuse or
// reorder multiply-adds, so a sum of some ten terms of order one differs by some roundings of 6e-8 each,
// which the absolute part covers where terms cancel; the relative part covers long chains of them.
void expect_close(float value, float expected, const char* what, size_t index) {
  ASSERT_TRUE(std::abs(value - expected) <= 1e-6f + 1e-5f * std::abs(expected))
      << what << " of item " << index << ": " << value << ", expected " << expected;
}

constexpr uint32_t kBodies = 37;

float uniform(std::mt19937_64& random, float low, float high) {
  return low + (high - low) * (static_cast<float>(random() >> 40) * 0x1p-24f);
}

// Rotations from unit quaternions, positions within a metre.
std::vector<RigidPoseRows> random_poses(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<RigidPoseRows> poses(kBodies);
  for (RigidPoseRows& p : poses) {
    float q[4];
    float length = 0.0f;
    do {
      for (float& part : q) part = uniform(random, -1.0f, 1.0f);
      length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    } while (length < 0.1f);
    const float w = q[0] / length, x = q[1] / length, y = q[2] / length, z = q[3] / length;
    p = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     uniform(random, -1, 1),
         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     uniform(random, -1, 1),
         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), uniform(random, -1, 1)};
  }
  return poses;
}

// Positions within a metre and covariances A Aᵀ, large ones so that the tolerance bites.
std::vector<RigidKernelRow> random_kernels(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<RigidKernelRow> kernels(count);
  for (RigidKernelRow& k : kernels) {
    float a[3][3];
    for (auto& row : a) {
      for (float& entry : row) entry = uniform(random, -0.5f, 0.5f);
    }
    const auto s = [&](int i, int j) { return a[i][0] * a[j][0] + a[i][1] * a[j][1] + a[i][2] * a[j][2]; };
    k = {uniform(random, -1, 1),
         uniform(random, -1, 1),
         uniform(random, -1, 1),
         static_cast<uint32_t>(random() % kBodies),
         s(0, 0),
         s(0, 1),
         s(0, 2),
         s(1, 1),
         s(1, 2),
         s(2, 2),
         0.0f,
         0.0f};
  }
  return kernels;
}

// The formula in double, from its definition: x' = R x + t, S' = R S Rᵀ.
std::array<double, 9> formula(const RigidKernelRow& k, const RigidPoseRows& p) {
  const double r[3][3] = {{p.r00, p.r01, p.r02}, {p.r10, p.r11, p.r12}, {p.r20, p.r21, p.r22}};
  const double s[3][3] = {
      {k.sxx_m2, k.sxy_m2, k.sxz_m2}, {k.sxy_m2, k.syy_m2, k.syz_m2}, {k.sxz_m2, k.syz_m2, k.szz_m2}};
  const double x[3] = {k.x_m, k.y_m, k.z_m};
  const double t[3] = {p.x_m, p.y_m, p.z_m};
  std::array<double, 9> out{};
  double turned[3][3] = {};
  for (int i = 0; i < 3; ++i) {
    out[i] = t[i];
    for (int j = 0; j < 3; ++j) {
      out[i] += r[i][j] * x[j];
      for (int m = 0; m < 3; ++m) {
        for (int n = 0; n < 3; ++n) turned[i][j] += r[i][m] * s[m][n] * r[j][n];
      }
    }
  }
  const int entries[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
  for (int e = 0; e < 6; ++e) out[3 + e] = turned[entries[e][0]][entries[e][1]];
  return out;
}

std::array<float, 9> values(const RigidKernelRow& k) {
  return {k.x_m, k.y_m, k.z_m, k.sxx_m2, k.sxy_m2, k.sxz_m2, k.syy_m2, k.syz_m2, k.szz_m2};
}

// What the CPU twin alone makes of the same buffers.
std::vector<RigidKernelRow> twin(std::vector<RigidKernelRow> kernels, std::vector<RigidPoseRows> poses) {
  const PoseRigidKernelsConstants constants{static_cast<uint32_t>(kernels.size()),
                                            static_cast<uint32_t>(poses.size())};
  std::vector<RigidKernelRow> posed(kernels.size());
  const std::array<std::span<std::byte>, 3> buffers{std::as_writable_bytes(std::span(kernels)),
                                                    std::as_writable_bytes(std::span(poses)),
                                                    std::as_writable_bytes(std::span(posed))};
  pose_rigid_kernels_pass().run({buffers, std::as_bytes(std::span(&constants, 1))}, 0, kernels.size());
  return posed;
}

void expect_rows_close(const std::vector<RigidKernelRow>& rows, const std::vector<RigidKernelRow>& expected) {
  static constexpr const char* kNames[9] = {"x", "y", "z", "sxx", "sxy", "sxz", "syy", "syz", "szz"};
  ASSERT_EQ(rows.size(), expected.size());
  for (size_t k = 0; k < rows.size(); ++k) {
    const auto a = values(rows[k]);
    const auto b = values(expected[k]);
    for (int i = 0; i < 9; ++i) ASSERT_NO_FATAL_FAILURE(expect_close(a[i], b[i], kNames[i], k));
    ASSERT_EQ(rows[k].body, expected[k].body);
    ASSERT_EQ(rows[k].spare0, 0.0f);
    ASSERT_EQ(rows[k].spare1, 0.0f);
  }
}

TEST_P(PassParity, RigidPosingIsTheTwinAndItsFormula) {
  const uint32_t group = pose_rigid_kernels_pass().group_size;
  for (const uint32_t count : {1u, group - 1, group, group + 1, 100000u}) {
    SCOPED_TRACE(count);
    const auto kernels = random_kernels(count, count);
    const auto poses = random_poses(count + 1);
    const BufferId rest = make_buffer_of(kernels);
    const BufferId bodies = make_buffer_of(poses);
    const BufferId posed = make_buffer(count * sizeof(RigidKernelRow));
    const auto done = dispatch_pose_rigid_kernels(*backend_, {rest, bodies, posed, count, kBodies});
    ASSERT_TRUE(done) << done.error().message;
    const auto rows = read_all<RigidKernelRow>(posed, count);
    ASSERT_NO_FATAL_FAILURE(expect_rows_close(rows, twin(kernels, poses)));
    for (size_t k = 0; k < count; ++k) {
      const auto expected = formula(kernels[k], poses[kernels[k].body]);
      const auto made = values(rows[k]);
      for (int i = 0; i < 9; ++i) {
        ASSERT_NO_FATAL_FAILURE(expect_close(made[i], static_cast<float>(expected[i]), "formula", k));
      }
    }
    for (const BufferId buffer : {rest, bodies, posed}) ASSERT_TRUE(backend_->destroy_buffer(buffer));
  }
}

TEST_P(PassParity, ItemsPastTheCountAreLeftAlone) {
  const uint32_t count = pose_rigid_kernels_pass().group_size + 1;
  const auto kernels = random_kernels(2 * count, 3);
  const auto poses = random_poses(4);
  std::vector<RigidKernelRow> before(2 * count);
  for (RigidKernelRow& row : before) row.x_m = 123.0f;
  const BufferId posed = make_buffer_of(before);
  ASSERT_TRUE(dispatch_pose_rigid_kernels(
      *backend_, {make_buffer_of(kernels), make_buffer_of(poses), posed, count, kBodies}));
  const auto rows = read_all<RigidKernelRow>(posed, 2 * count);
  EXPECT_NE(rows[count - 1].x_m, 123.0f);
  EXPECT_EQ(std::memcmp(&rows[count], &before[count], count * sizeof(RigidKernelRow)), 0);
}

TEST_P(PassParity, BodiesPastTheEndMoveWithTheLast) {
  auto kernels = random_kernels(100, 5);
  const auto poses = random_poses(6);
  auto expected = kernels;
  for (size_t k = 0; k < kernels.size(); ++k) {
    kernels[k].body = k % 2 ? kBodies : UINT32_MAX;
    expected[k].body = kBodies - 1;
  }
  const BufferId posed = make_buffer(kernels.size() * sizeof(RigidKernelRow));
  ASSERT_TRUE(dispatch_pose_rigid_kernels(
      *backend_, {make_buffer_of(kernels), make_buffer_of(poses), posed, 100, kBodies}));
  auto rows = read_all<RigidKernelRow>(posed, kernels.size());
  auto wanted = twin(expected, poses);
  for (size_t k = 0; k < kernels.size(); ++k) wanted[k].body = kernels[k].body;
  expect_rows_close(rows, wanted);
}

// Each dispatch reads what the one before wrote, more of them than one command buffer holds; there and back
// again, so that the kernels end where they began. A barrier left out is a data race, which the layer reports
// as well.
TEST_P(PassParity, DispatchesSeeWhatTheOnesBeforeWrote) {
  constexpr int kRounds = 150;  // 300 dispatches; a command buffer takes 256
  const auto kernels = random_kernels(1000, 8);
  std::vector<RigidPoseRows> there(1, {0, -1, 0, 0.5f, 1, 0, 0, 0, 0, 0, 1, 0});
  std::vector<RigidPoseRows> back(1, {0, 1, 0, 0, -1, 0, 0, 0.5f, 0, 0, 1, 0});
  const BufferId a = make_buffer_of(kernels);
  const BufferId b = make_buffer(kernels.size() * sizeof(RigidKernelRow));
  const BufferId there_pose = make_buffer_of(there);
  const BufferId back_pose = make_buffer_of(back);
  for (int round = 0; round < kRounds; ++round) {
    ASSERT_TRUE(dispatch_pose_rigid_kernels(*backend_, {a, there_pose, b, 1000, 1}));
    ASSERT_TRUE(dispatch_pose_rigid_kernels(*backend_, {b, back_pose, a, 1000, 1}));
  }
  ASSERT_TRUE(backend_->submit());
  const auto rows = read_all<RigidKernelRow>(a, kernels.size());
  for (size_t k = 0; k < rows.size(); ++k) {
    // Exact: quarter turns only move entries, and positions are multiples of 2^-23 m within 1.5 m, as
    // random_kernels makes them, so half a metre is added and taken away without rounding.
    ASSERT_EQ(rows[k].x_m, kernels[k].x_m);
    ASSERT_EQ(rows[k].y_m, kernels[k].y_m);
    ASSERT_EQ(rows[k].z_m, kernels[k].z_m);
    ASSERT_EQ(rows[k].sxy_m2, kernels[k].sxy_m2);
    ASSERT_EQ(rows[k].syy_m2, kernels[k].syy_m2);
  }
}

}  // namespace
}  // namespace livegs
