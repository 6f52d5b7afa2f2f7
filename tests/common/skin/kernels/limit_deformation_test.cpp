// SPDX-License-Identifier: Apache-2.0
#include "skin/kernels/limit_deformation.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

struct LimitedDeformation {
  Eigen::Matrix3f gradient;
  Eigen::Quaternionf rotation;
};

// Limits one gradient, in the lane after that of the previous call, together with others that use every code
// path.
LimitedDeformation limit_deformation(const Eigen::Matrix3f& gradient) {
  static size_t lane = 0;
  lane = (lane + 1) % kDeformationLanes;
  LimitedDeformations all;
  for (Eigen::Matrix3f& other : all.gradients) other = Eigen::Matrix3f::Constant(NAN);
  all.gradients[(lane + 1) % kDeformationLanes].setZero();
  all.gradients[(lane + 2) % kDeformationLanes].setIdentity();
  all.gradients[lane] = gradient;
  limit_deformations(all);
  return {all.gradients[lane], all.rotations[lane]};
}

TEST(LimitDeformation, IsThePolarDecompositionWithinLimits) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Matrix3d u = random_rotation(random).toRotationMatrix(),
                          v = random_rotation(random).toRotationMatrix();
    const Eigen::Vector3d sigma = uniform3(random, 0.26, 3.9);
    const Eigen::Matrix3f f = (u * sigma.asDiagonal() * v.transpose()).cast<float>();
    const LimitedDeformation limited = limit_deformation(f);
    // Rotation error: float precision times the condition number, at most 15, plus the rounding of Newton's
    // iteration.
    EXPECT_NEAR(angle_between(limited.rotation.cast<double>(),
                              Eigen::Quaterniond(Eigen::Matrix3d(u * v.transpose()))),
                0.0, 2e-5);
    EXPECT_NEAR((limited.gradient - f).norm(), 0.0f, 2e-6f * f.norm());
  }
}

TEST(LimitDeformation, ClampsSingularValuesAndKeepsDirections) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d u = random_rotation(random).toRotationMatrix(),
                          v = random_rotation(random).toRotationMatrix();
    const Eigen::Vector3d sigma(uniform(random, 5.0, 9.0), uniform(random, 0.5, 2.0),
                                uniform(random, 0.01, 0.2));
    const LimitedDeformation limited =
        limit_deformation((u * sigma.asDiagonal() * v.transpose()).cast<float>());
    const Eigen::Vector3d clamped(kMaxKernelStretch, sigma[1], kMinKernelStretch);
    // The input is rounded to 6e-7 (float at 9); the third direction, of length 0.01 or more, is accurate to
    // 6e-5.
    EXPECT_NEAR((limited.gradient.cast<double>() - u * clamped.asDiagonal() * v.transpose()).norm(), 0.0,
                5e-4);
  }
}

TEST(LimitDeformation, ClampsUniformStretches) {
  // These pass one of the two quick tests and must fail the other.
  for (const auto& [stretch, clamped] :
       {std::pair{6.0f, kMaxKernelStretch}, std::pair{0.1f, kMinKernelStretch}}) {
    const LimitedDeformation limited = limit_deformation(stretch * Eigen::Matrix3f::Identity());
    EXPECT_NEAR((limited.gradient - clamped * Eigen::Matrix3f::Identity()).norm(), 0.0f, 1e-5f);
    EXPECT_NEAR(angle_between(limited.rotation.cast<double>(), Eigen::Quaterniond::Identity()), 0.0, 1e-6);
  }
}

TEST(LimitDeformation, IsContinuousThroughInversion) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d u = random_rotation(random).toRotationMatrix(),
                          v = random_rotation(random).toRotationMatrix();
    const auto limited = [&](double smallest) {
      return limit_deformation(
          (u * Eigen::Vector3d(1.5, 1.0, smallest).asDiagonal() * v.transpose()).cast<float>());
    };
    const LimitedDeformation thin = limited(1e-3), flat = limited(0.0), inverted = limited(-0.5);
    EXPECT_NEAR((thin.gradient - flat.gradient).norm(), 0.0f, 1e-5f);
    EXPECT_NEAR((inverted.gradient - flat.gradient).norm(), 0.0f, 1e-5f);
    EXPECT_NEAR(angle_between(inverted.rotation.cast<double>(), flat.rotation.cast<double>()), 0.0, 1e-5);
  }
}

TEST(LimitDeformation, AcceptsAnyInput) {
  const float huge = 1e30f, infinite = INFINITY;
  std::vector<Eigen::Matrix3f> gradients = {Eigen::Matrix3f::Zero(),
                                            Eigen::Matrix3f::Constant(1.0f),
                                            -Eigen::Matrix3f::Identity(),
                                            Eigen::Matrix3f::Constant(huge),
                                            Eigen::Matrix3f::Constant(infinite),
                                            Eigen::Matrix3f::Constant(NAN),
                                            1e-20f * Eigen::Matrix3f::Identity(),
                                            1e15f * Eigen::Matrix3f::Identity()};
  Eigen::Matrix3f line = Eigen::Matrix3f::Zero();
  line(2, 0) = 1.0f;
  gradients.push_back(line);
  for (const Eigen::Matrix3f& gradient : gradients) {
    const LimitedDeformation limited = limit_deformation(gradient);
    ASSERT_TRUE(limited.gradient.allFinite());
    EXPECT_NEAR(limited.rotation.norm(), 1.0f, 1e-6f);
    const Eigen::Vector3f sigma = Eigen::JacobiSVD<Eigen::Matrix3f>(limited.gradient).singularValues();
    EXPECT_LE(sigma[0], kMaxKernelStretch * 1.00001f);
    EXPECT_GE(sigma[2], kMinKernelStretch * 0.9999f);
  }
}

}  // namespace
}  // namespace livegs
