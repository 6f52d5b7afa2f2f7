// SPDX-License-Identifier: Apache-2.0
#include "skin/shape_sample.h"

#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

using namespace livegs::testing;

constexpr size_t kKernels = 9000;

struct Sampled {
  RestBody rest;
  ObjectDrivers drivers;
  GaussianAsset asset;
  KernelBindings bindings;
  ShapeSample sample;
};

Sampled sampled(DriverKind kind) {
  std::mt19937_64 random(4);
  Sampled made;
  made.rest = ragged_body(6, 5, 4, 0.03, 2);
  made.rest.kind = kind;
  for (int p = 0; p < 300; ++p) made.rest.particles_m.push_back(uniform3(random, 0.0, 0.18).cast<float>());
  for (int b = 0; b < 5; ++b)
    made.rest.bodies.push_back({uniform3(random, 0.0, 0.18), random_rotation(random)});
  if (kind == DriverKind::Rigid) {
    made.drivers.poses.assign(5, Pose{uniform3(random, -1, 1), random_rotation(random)});
  } else {
    made.drivers = moved_drivers(made.rest, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
      return x + Eigen::Vector3d(0.03 * std::sin(20 * x[1]), 0.02 * x[2], 0.01 * std::cos(30 * x[0]));
    });
  }
  std::vector<Eigen::Vector3d> points;
  for (size_t k = 0; k < kKernels; ++k) points.push_back(uniform3(random, -0.02, 0.2));
  made.asset = kernels_at(made.rest, points, 3);
  for (size_t k = 0; k < kKernels; ++k)
    made.asset.opacity_logits[k] = static_cast<float>(uniform(random, -4, 6));
  made.bindings = bind_kernels(made.asset, made.rest).value();
  made.sample = ShapeSample(made.asset, made.bindings);
  return made;
}

TEST(ShapeSample, KernelsHaveThePosesOfSkinning) {
  for (const DriverKind kind : {DriverKind::Rigid, DriverKind::Lattice, DriverKind::Particles}) {
    SCOPED_TRACE(static_cast<int>(kind));
    const Sampled made = sampled(kind);
    PosedKernels all, some;
    skin_kernels(made.asset, made.rest, made.bindings, made.drivers, all);
    made.sample.pose(made.rest, made.drivers, some);
    ASSERT_EQ(made.sample.size(), ShapeSample::kMaxKernels);
    ASSERT_EQ(some.positions_m.size(), made.sample.size());
    ObjectDrivers streamed;
    streamed.kernels = std::make_shared<PosedKernels>(all);
    PosedKernels copied;
    made.sample.pose(made.rest, streamed, copied);
    for (size_t i = 0; i < made.sample.size(); ++i) {
      const uint32_t k = made.sample.kernels()[i];
      ASSERT_EQ(some.positions_m[i], all.positions_m[k]);
      ASSERT_EQ(some.covariances_m2[i], all.covariances_m2[k]);
      ASSERT_EQ(copied.positions_m[i], all.positions_m[k]);
      ASSERT_EQ(made.sample.bodies()[i],
                kind == DriverKind::Rigid ? made.bindings.kernels[k].drivers[0] : 0u);
    }
  }
}

// Haze is left out; the weights stand for all opaque kernels, to the noise of a sample of 2048.
TEST(ShapeSample, WeightsStandForTheOpaqueKernels) {
  const Sampled made = sampled(DriverKind::Rigid);
  double opaque = 0, weights = 0;
  for (const float logit : made.asset.opacity_logits) {
    if (opacity_of_logit(logit) >= 0.3) opaque += static_cast<double>(opacity_of_logit(logit));
  }
  for (const float weight : made.sample.weights()) weights += static_cast<double>(weight);
  EXPECT_NEAR(weights / opaque, 1.0, 0.02);
  for (const uint32_t k : made.sample.kernels())
    ASSERT_GE(opacity_of_logit(made.asset.opacity_logits[k]), 0.3f);
  EXPECT_EQ(ShapeSample(GaussianAsset(), KernelBindings()).size(), 0u);
}

}  // namespace
}  // namespace livegs
