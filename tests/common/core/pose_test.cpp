// SPDX-License-Identifier: Apache-2.0
#include "core/pose.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(Pose, SupportsInverseAndProduct) {
  const Pose a{{1, 2, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2).normalized()))};
  const Pose b{{-4, 0, 1},
               Eigen::Quaterniond(Eigen::AngleAxisd(-2.1, Eigen::Vector3d(0, 1, 1).normalized()))};
  const Eigen::Vector3d point(0.3, -0.2, 5.0);
  EXPECT_LT((a.inverse() * (a * point) - point).norm(), 1e-14);
  EXPECT_LT(((a * b) * point - a * (b * point)).norm(), 1e-14);
}

}  // namespace
}  // namespace livegs
