// SPDX-License-Identifier: Apache-2.0
#include "wire/coding/quantised_box.h"

#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

TEST(QuantisedBox, ContainsPointsWithinHalfAStep) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const double size = std::pow(10.0, uniform(random, -6.0, 4.0)),
                 where = std::pow(10.0, uniform(random, -3.0, 4.0));
    const Eigen::Vector3d centre = uniform3(random, -where, where);
    const Eigen::Vector3d a = centre + uniform3(random, -size, size),
                          b = centre + uniform3(random, -size, size);
    const QuantisedBox box = box_around(a.cwiseMin(b), a.cwiseMax(b));
    ASSERT_TRUE(box.is_valid());
    const Eigen::Vector3d low = box.min_m.cast<double>(), high = low + box.edge_m.cast<double>();
    EXPECT_TRUE((low.array() <= a.cwiseMin(b).array()).all() &&
                (high.array() >= a.cwiseMax(b).array()).all());
    for (const int bits : {16, 21}) {
      for (const Eigen::Vector3d& point : {a, b, Eigen::Vector3d(0.5 * (a + b))}) {
        const Eigen::Array3d half_step = box.edge_m.cast<double>().array() / ((1 << bits) - 1) / 2.0;
        const Eigen::Array3d off = (box.position_m(box.quantise(point, bits), bits) - point).array().abs();
        // Above half a step, only the rounding of doubles at the magnitude of the point.
        EXPECT_TRUE((off <= half_step * (1.0 + 1e-9) + 4e-16 * (where + size)).all()) << off << half_step;
      }
    }
  }
}

TEST(QuantisedBox, CornersAreExact) {
  const QuantisedBox box = box_around({-1.0, 0.25, 3.0}, {1.0, 0.25, 3.5});
  EXPECT_EQ(box.position_m(box.quantise({-1.0, 0.25, 3.0}, 16), 16), Eigen::Vector3d(-1.0, 0.25, 3.0));
  EXPECT_EQ(box.position_m(box.quantise({1.0, 0.25, 3.5}, 16), 16), Eigen::Vector3d(1.0, 0.25, 3.5));
}

}  // namespace
}  // namespace livegs
