// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

RestBody particle_body(size_t count, uint64_t seed) {
  RestBody rest;
  rest.kind = DriverKind::Particles;
  place(rest, seed);
  std::mt19937_64 random(seed + 1);
  for (size_t p = 0; p < count; ++p) rest.particles_m.push_back(uniform3(random, -0.2, 0.2).cast<float>());
  return rest;
}

GaussianAsset kernels_around(const RestBody& rest, size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  for (size_t k = 0; k < count; ++k) points.push_back(uniform3(random, -0.3, 0.3));
  return kernels_at(rest, points, seed + 1);
}

TEST(SkinParticles, WeightsAreInverseDistanceAndSumToOne) {
  const RestBody rest = particle_body(500, 1);
  const GaussianAsset asset = kernels_around(rest, 1000, 2);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  for (size_t k = 0; k < asset.size(); ++k) {
    const KernelBinding& binding = bindings->kernels[k];
    // Four float divisions by the same sum, each within 6e-8.
    EXPECT_NEAR(binding.weights[0] + binding.weights[1] + binding.weights[2] + binding.weights[3], 1.0f,
                3e-7f);
    const Eigen::Vector3f x = rest_position_m(asset, rest, k).cast<float>();
    std::vector<float> distances_m;
    for (const Eigen::Vector3f& particle : rest.particles_m) distances_m.push_back((particle - x).norm());
    const float nearest_m = (rest.particles_m[binding.drivers[0]] - x).norm();
    for (int i = 0; i < 4; ++i) {
      const float distance_m = (rest.particles_m[binding.drivers[i]] - x).norm();
      EXPECT_NEAR(binding.weights[i] * distance_m, binding.weights[0] * nearest_m,
                  1e-6f);  // inverse distance
    }
    std::nth_element(distances_m.begin(), distances_m.begin() + 3, distances_m.end());
    EXPECT_NEAR((rest.particles_m[binding.drivers[3]] - x).norm(), distances_m[3], 1e-6f);
  }
}

TEST(SkinParticles, RigidMotionIsExact) {
  std::mt19937_64 random(3);
  const RestBody rest = particle_body(300, 4);
  const GaussianAsset asset = kernels_around(rest, 300, 5);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  for (const Pose& pose : {Pose{}, Pose{uniform3(random, -0.5, 0.5), random_rotation(random)}}) {
    ObjectDrivers drivers = moved_drivers(
        rest, [&](const Eigen::Vector3d& x) { return pose * x; }, pose.orientation);
    for (size_t p = 0; p < drivers.rotations.size(); p += 2)
      drivers.rotations[p].coeffs() *= -1.0f;  // the same rotation
    PosedKernels kernels;
    std::vector<Eigen::Matrix3f> gradients;
    skin_kernels(asset, rest, *bindings, drivers, kernels, &gradients);
    const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
    for (size_t k = 0; k < asset.size(); ++k) {
      EXPECT_NEAR((kernels.positions_m[k].cast<double>() - pose * rest_position_m(asset, rest, k)).norm(),
                  0.0, 1e-6);
      const Eigen::Matrix3d covariance = turn * rest_covariance_m2(asset, rest, k) * turn.transpose();
      EXPECT_NEAR((matrix_of(kernels.covariances_m2[k]) - covariance).norm() / covariance.norm(), 0.0, 3e-6);
      EXPECT_NEAR((gradients[k].cast<double>() - turn).norm(), 0.0, 2e-6);
      EXPECT_NEAR(angle_between(kernels.world_from_asset[k].cast<double>(),
                                pose.orientation * rest.object_from_asset.rotation),
                  0.0, 2e-6);
    }
  }
}

TEST(SkinParticles, ABodyOfOneParticleIsRigid) {
  std::mt19937_64 random(6);
  const RestBody rest = particle_body(1, 7);
  const GaussianAsset asset = kernels_around(rest, 20, 8);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  const Pose pose{uniform3(random, -0.5, 0.5), random_rotation(random)};
  PosedKernels kernels;
  skin_kernels(asset, rest, *bindings,
               moved_drivers(
                   rest, [&](const Eigen::Vector3d& x) { return pose * x; }, pose.orientation),
               kernels);
  for (size_t k = 0; k < asset.size(); ++k) {
    EXPECT_EQ(bindings->kernels[k].weights[0], 1.0f);
    EXPECT_NEAR((kernels.positions_m[k].cast<double>() - pose * rest_position_m(asset, rest, k)).norm(), 0.0,
                1e-6);
  }
}

TEST(SkinParticles, MatchesThePaperWithRecursiveSlerp) {
  // Equations 3 to 6 as printed, in doubles, with Eigen's slerp; rotations from a few degrees to half a turn.
  std::mt19937_64 random(9);
  const RestBody rest = particle_body(50, 10);
  const GaussianAsset asset = kernels_around(rest, 200, 11);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  for (const double largest_rad : {0.02, 0.4, 1.5}) {
    ObjectDrivers drivers = rest_drivers(rest);
    for (size_t p = 0; p < rest.particles_m.size(); ++p) {
      drivers.positions_m[p] += uniform3(random, -0.05, 0.05).cast<float>();
      drivers.rotations[p] =
          Eigen::Quaternionf(Eigen::AngleAxisf(static_cast<float>(uniform(random, 0.0, largest_rad)),
                                               uniform3(random, -1, 1).normalized().cast<float>()));
    }
    PosedKernels kernels;
    skin_kernels(asset, rest, *bindings, drivers, kernels);
    for (size_t k = 0; k < asset.size(); ++k) {
      const KernelBinding& binding = bindings->kernels[k];
      const Eigen::Vector3d x0 = rest_position_m(asset, rest, k);
      Eigen::Vector3d x = x0;
      Eigen::Quaterniond r = drivers.rotations[binding.drivers[0]].cast<double>();
      double so_far = binding.weights[0];
      for (int i = 0; i < 4; ++i) {
        const uint32_t p = binding.drivers[i];
        const Eigen::Quaterniond dq = drivers.rotations[p].cast<double>();
        const Eigen::Vector3d t = x0 - rest.particles_m[p].cast<double>();
        x += binding.weights[i] * (drivers.positions_m[p] - rest.particles_m[p]).cast<double>();
        x += binding.weights[i] * (dq * t - t);
        if (i > 0) {
          so_far += binding.weights[i];
          r = r.slerp(binding.weights[i] / so_far, dq);
        }
      }
      EXPECT_NEAR((kernels.positions_m[k].cast<double>() - x).norm(), 0.0, 1e-6);
      // Three float slerps, each accurate to a few 1e-7.
      EXPECT_NEAR(
          angle_between(kernels.world_from_asset[k].cast<double>(), r * rest.object_from_asset.rotation), 0.0,
          5e-6);
    }
  }
}

TEST(SkinParticles, ACoincidentKernelFollowsOneParticle) {
  RestBody rest = particle_body(20, 12);
  rest.object_from_asset = Similarity{};
  const GaussianAsset asset = kernels_at(rest, {rest.particles_m[7].cast<double>()}, 13);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  EXPECT_EQ(bindings->kernels[0].drivers[0], 7u);
  EXPECT_EQ(bindings->kernels[0].weights[0], 1.0f);
  EXPECT_EQ(bindings->kernels[0].weights[1], 0.0f);
}

TEST(SkinParticles, ABodyWithoutParticlesIsAnError) {
  const RestBody rest = particle_body(0, 14);
  const Result<KernelBindings> bindings = bind_kernels(kernels_around(rest, 3, 15), rest);
  ASSERT_FALSE(bindings);
  EXPECT_NE(bindings.error().message.find("no particles"), std::string::npos);
}

}  // namespace
}  // namespace livegs
