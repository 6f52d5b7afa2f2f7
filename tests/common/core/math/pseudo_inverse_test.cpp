// SPDX-License-Identifier: Apache-2.0
#include "core/math/pseudo_inverse.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace livegs {
namespace {

using Eigen::Matrix3d;

// The four conditions of Penrose (1955) for spreads of points in space, in a plane, on a line and at one
// place.
TEST(PseudoInverse, MeetsPenrosesConditions) {
  std::mt19937 random(1);
  std::normal_distribution<double> value;
  for (const double scale : {1e-6, 1.0, 1e3}) {
    for (int rank = 0; rank <= 3; ++rank) {
      std::vector<Eigen::Vector3d> axes(3);
      for (auto& axis : axes) axis = scale * Eigen::Vector3d(value(random), value(random), value(random));
      Matrix3d a = Matrix3d::Zero();
      for (int k = 0; k < rank; ++k) a += axes[k] * axes[k].transpose();
      const Matrix3d p = pseudo_inverse(a);
      const double large = 1e-12 * (1.0 + a.norm() * p.norm());
      EXPECT_LT((a * p * a - a).norm(), large * a.norm() + 1e-300) << rank;
      EXPECT_LT((p * a * p - p).norm(), large * p.norm() + 1e-300) << rank;
      EXPECT_LT((a * p - (a * p).transpose()).norm(), large) << rank;
      EXPECT_LT((p * a - (p * a).transpose()).norm(), large) << rank;
      EXPECT_NEAR((a * p).trace(), rank, 1e-9);
    }
  }
}

// Points in a thin sheet have a small spread across it, which counts.
TEST(PseudoInverse, KeepsThinSheets) {
  const Matrix3d spread = Eigen::Vector3d(1.0, 0.5, 1e-8).asDiagonal();
  EXPECT_NEAR(pseudo_inverse(spread)(2, 2) * 1e-8, 1.0, 1e-9);
}

}  // namespace
}  // namespace livegs
