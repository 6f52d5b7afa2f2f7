// SPDX-License-Identifier: Apache-2.0
#include "wire/coding/packed_quaternion.h"

#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

TEST(PackedQuaternion, ErrorIsWithinTheStatedBound) {
  // Each written component has an error of at most half a step, 1 / (√2 (2^(b-1) - 1)) / 2. The error vector
  // of the three is at most √3 times that. The missing component is at least 1/2; at that value it doubles
  // the error of the unit vector at most. An angle is twice that of the quaternion.
  std::mt19937_64 random(1);
  for (const int bits : {kParticleComponentBits, kPoseComponentBits}) {
    const double half_step = 0.5 / (std::sqrt(2.0) * ((1 << (bits - 1)) - 1));
    const double bound_rad = 2.0 * 2.0 * std::sqrt(3.0) * half_step;
    double largest = 0.0;
    for (int i = 0; i < 50000; ++i) {
      const Eigen::Quaterniond q = random_rotation(random);
      const uint64_t packed = pack_quaternion(q, bits);
      EXPECT_EQ(packed >> (2 + 3 * bits), 0u);
      largest = std::max(largest, angle_between(unpack_quaternion(packed, bits), q));
    }
    EXPECT_LE(largest, bound_rad);
    EXPECT_GE(largest, half_step);  // a smaller error would mean that nothing is quantised
    EXPECT_LE(largest * 180.0 / M_PI, bits == kParticleComponentBits ? 0.07 : 0.0003);
  }
}

TEST(PackedQuaternion, QuarterTurnsAndIdentityAreExact) {
  for (const int bits : {kParticleComponentBits, kPoseComponentBits}) {
    for (int axis = 0; axis < 4; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        Eigen::Quaterniond q(0, 0, 0, 0);
        q.coeffs()[axis] = sign;
        EXPECT_EQ(unpack_quaternion(pack_quaternion(q, bits), bits).coeffs(),
                  Eigen::Vector4d(sign * q.coeffs()));
      }
    }
    const Eigen::Quaterniond quarter(std::sqrt(0.5), 0, std::sqrt(0.5), 0);
    EXPECT_NEAR(angle_between(unpack_quaternion(pack_quaternion(quarter, bits), bits), quarter), 0.0, 1e-7);
  }
}

TEST(PackedQuaternion, AnyBitsGiveAUnitQuaternion) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const uint64_t bits = i == 0 ? 0 : i == 1 ? ~uint64_t{0} : random();
    for (const int component_bits : {kParticleComponentBits, kPoseComponentBits}) {
      EXPECT_NEAR(unpack_quaternion(bits, component_bits).norm(), 1.0, 1e-12);
    }
  }
}

}  // namespace
}  // namespace livegs
