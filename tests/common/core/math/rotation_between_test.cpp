// SPDX-License-Identifier: Apache-2.0
#include "core/math/rotation_between.h"

#include <gtest/gtest.h>

#include <random>

namespace livegs {
namespace {

using Eigen::Vector3d;

// The angle of the shortest rotation is that between the directions.
void expect_shortest(const Vector3d& from, const Vector3d& to) {
  const Eigen::Quaterniond q = rotation_between(from, to);
  EXPECT_NEAR(q.norm(), 1.0, 1e-12);
  EXPECT_LT((q * from.normalized() - to.normalized()).norm(), 1e-7)
      << from.transpose() << ", " << to.transpose();
  const double angle = 2.0 * std::atan2(q.vec().norm(), q.w());
  const double between = std::atan2(from.cross(to).norm(), from.dot(to));
  EXPECT_NEAR(angle, between, 1e-7);
}

TEST(RotationBetween, IsTheShortest) {
  std::mt19937 random(1);
  std::normal_distribution<double> value;
  for (int i = 0; i < 1000; ++i)
    expect_shortest({value(random), value(random), value(random)},
                    {value(random), value(random), value(random)});
  expect_shortest(Vector3d(1, 2, 3), Vector3d(2, 4, 6));
}

TEST(RotationBetween, OppositeAndNearlyOppositeDirections) {
  std::mt19937 random(2);
  std::normal_distribution<double> value;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d from(value(random), value(random), value(random));
    expect_shortest(from, -2.0 * from);
    for (const double off : {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3})
      expect_shortest(from, -from + off * Vector3d(value(random), value(random), value(random)));
  }
}

TEST(RotationBetween, OppositeAxesTurnAboutZOrX) {
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, -1, 0)})
    EXPECT_EQ(rotation_between(axis, -axis).vec(), Vector3d(0, 0, 1));
  for (const Vector3d& axis : {Vector3d(0, 0, 1), Vector3d(0, 0, -1)})
    EXPECT_EQ(rotation_between(axis, -axis).vec(), Vector3d(1, 0, 0));
}

}  // namespace
}  // namespace livegs
