// SPDX-License-Identifier: Apache-2.0
#include "gaussian/transform_asset.h"

#include <gtest/gtest.h>

#include "common/gaussian/synthetic_asset.h"
#include "core/math/rotation_between.h"
#include "gaussian/spherical_harmonics.h"

namespace livegs {
namespace {

Eigen::Matrix3f covariance(const GaussianAsset& asset, size_t k) {
  const Eigen::Matrix3f axes = asset.rotations[k].toRotationMatrix();
  const Eigen::Array3f variances = (2 * asset.log_scales[k].array()).exp();
  return axes * variances.matrix().asDiagonal() * axes.transpose();
}

Eigen::Vector3f colour(const GaussianAsset& asset, size_t k, const Eigen::Vector3f& direction) {
  const Eigen::Vector3f* rest = asset.sh_rest.data() + k * asset.sh_rest_count();
  return evaluate_sh_colour(asset.sh_dc[k], rest, asset.sh_degree, direction);
}

// Positions and shapes turn and grow; a colour is the same seen from the turned direction.
TEST(TransformAsset, TurnsPositionsShapesAndColours) {
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -0.5).normalized()));
  const Eigen::Matrix3f turn = rotation.toRotationMatrix().cast<float>();
  constexpr double kScale = 2.5;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianAsset before = synthetic_asset(100, degree, 7);
    GaussianAsset after = before;
    transform_asset(after, rotation, kScale);
    for (size_t k = 0; k < before.size(); ++k) {
      EXPECT_LT((after.positions[k] - 2.5f * turn * before.positions[k]).norm(), 1e-5);
      const Eigen::Matrix3f expected = 6.25f * turn * covariance(before, k) * turn.transpose();
      EXPECT_LT((covariance(after, k) - expected).norm(), 1e-4 * expected.norm());
      EXPECT_EQ(after.opacity_logits[k], before.opacity_logits[k]);
      for (int i = 0; i < 5; ++i) {
        const Eigen::Vector3f direction =
            Eigen::Vector3f(std::sin(float(i)), std::cos(2.0f * float(i)), 0.3f * float(i) - 0.5f)
                .normalized();
        EXPECT_LT((colour(after, k, turn * direction) - colour(before, k, direction)).norm(), 1e-4);
      }
    }
  }
}

TEST(TransformAsset, TurningBackGivesTheOriginal) {
  const GaussianAsset before = synthetic_asset(50, 3, 3);
  GaussianAsset after = before;
  const Eigen::Quaterniond up = rotation_between(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY());
  transform_asset(after, up, 4);
  transform_asset(after, up.conjugate(), 0.25);
  for (size_t k = 0; k < before.size(); ++k) {
    EXPECT_LT((after.positions[k] - before.positions[k]).norm(), 1e-6);
    EXPECT_LT((after.log_scales[k] - before.log_scales[k]).norm(), 1e-6);
    for (size_t m = 0; m < before.sh_rest_count(); ++m) {
      const size_t at = k * before.sh_rest_count() + m;
      EXPECT_LT((after.sh_rest[at] - before.sh_rest[at]).norm(), 1e-5);
    }
  }
}

}  // namespace
}  // namespace livegs
