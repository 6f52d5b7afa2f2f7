// SPDX-License-Identifier: Apache-2.0
#include "core/math/nearest_rotation.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <random>

namespace livegs {
namespace {

using Eigen::Matrix3d;

Matrix3d any_rotation(std::mt19937& random) {
  std::normal_distribution<double> value;
  return Eigen::Quaterniond(value(random), value(random), value(random), value(random))
      .normalized()
      .toRotationMatrix();
}

TEST(NearestRotation, IsTheRotationOfAStretch) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Matrix3d rotation = any_rotation(random), axes = any_rotation(random);
    const Matrix3d stretch = axes * Eigen::Vector3d(0.3, 1.0, 2.5).asDiagonal() * axes.transpose();
    EXPECT_LT((nearest_rotation(rotation * stretch) - rotation).norm(), 1e-13);
  }
}

// No other rotation is nearer, also to mirrored, flat and slender matrices.
TEST(NearestRotation, NoOtherIsNearer) {
  std::mt19937 random(2);
  std::normal_distribution<double> value;
  for (const Eigen::Vector3d& sizes :
       {Eigen::Vector3d(1, 0.7, -0.4), Eigen::Vector3d(1, 0.7, 0), Eigen::Vector3d(1, 0, 0)}) {
    for (int i = 0; i < 50; ++i) {
      const Matrix3d matrix = any_rotation(random) * sizes.asDiagonal() * any_rotation(random);
      const Matrix3d nearest = nearest_rotation(matrix);
      EXPECT_NEAR(nearest.determinant(), 1.0, 1e-13);
      EXPECT_LT((nearest * nearest.transpose() - Matrix3d::Identity()).norm(), 1e-13);
      for (int k = 0; k < 20; ++k) {
        const Eigen::Vector3d turn(value(random), value(random), value(random));
        const Matrix3d other = Eigen::AngleAxisd(0.1 * turn.norm(), turn.normalized()) * nearest;
        EXPECT_GE((other - matrix).norm(), (nearest - matrix).norm() - 1e-13);
      }
    }
  }
}

}  // namespace
}  // namespace livegs
