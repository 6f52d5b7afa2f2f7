// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

RestBody rigid_body(const std::vector<Pose>& bodies) {
  RestBody rest;
  rest.kind = DriverKind::Rigid;
  place(rest, 1);
  rest.bodies = bodies;
  return rest;
}

TEST(SkinRigid, KernelsFollowARotatedBody) {
  std::mt19937_64 random(2);
  const RestBody rest = rigid_body({Pose{uniform3(random, -0.2, 0.2), random_rotation(random)}});
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 200; ++i) points.push_back(uniform3(random, -0.3, 0.3));
  const GaussianAsset asset = kernels_at(rest, points, 3);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  const Pose world_from_object{uniform3(random, -0.5, 0.5), random_rotation(random)};
  ObjectDrivers drivers;
  drivers.poses = {world_from_object * rest.bodies[0]};
  PosedKernels kernels;
  std::vector<Eigen::Matrix3f> gradients;
  skin_kernels(asset, rest, *bindings, drivers, kernels, &gradients);
  const Eigen::Matrix3d turn = world_from_object.orientation.toRotationMatrix();
  for (size_t k = 0; k < asset.size(); ++k) {
    // Float arithmetic on values below 1: a few units of 6e-8.
    EXPECT_NEAR(
        (kernels.positions_m[k].cast<double>() - world_from_object * rest_position_m(asset, rest, k)).norm(),
        0.0, 1e-6);
    const Eigen::Matrix3d covariance = turn * rest_covariance_m2(asset, rest, k) * turn.transpose();
    EXPECT_NEAR((matrix_of(kernels.covariances_m2[k]) - covariance).norm() / covariance.norm(), 0.0, 2e-6);
    EXPECT_NEAR((gradients[k].cast<double>() - turn).norm(), 0.0, 1e-6);
    EXPECT_NEAR(angle_between(kernels.world_from_asset[k].cast<double>(),
                              world_from_object.orientation * rest.object_from_asset.rotation),
                0.0, 1e-6);
  }
}

TEST(SkinRigid, KernelsBindToTheNearestFragment) {
  const RestBody rest = rigid_body({Pose{{-0.1, 0, 0}, Eigen::Quaterniond::Identity()},
                                    Pose{{0.1, 0, 0}, Eigen::Quaterniond::Identity()}});
  const GaussianAsset asset = kernels_at(rest, {{-0.02, 0, 0}, {0.03, 0.1, 0}}, 4);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  ObjectDrivers drivers;
  drivers.poses = rest.bodies;
  drivers.poses[1].position_m += Eigen::Vector3d(0, 1, 0);
  PosedKernels kernels;
  skin_kernels(asset, rest, *bindings, drivers, kernels);
  EXPECT_NEAR(kernels.positions_m[0][1], 0.0f, 1e-6f);
  EXPECT_NEAR(kernels.positions_m[1][1], 1.1f, 1e-6f);
}

TEST(SkinRigid, AnObjectWithoutABodyIsAnError) {
  const RestBody rest = rigid_body({});
  EXPECT_FALSE(bind_kernels(kernels_at(rest, {{0, 0, 0}}, 5), rest));
}

TEST(SkinRigid, KernelRunsOverrideTheNearestBody) {
  RestBody rest = rigid_body({Pose{}, Pose{{1, 0, 0}, Eigen::Quaterniond::Identity()}});
  const GaussianAsset asset = kernels_at(rest, {{0.9, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}}, 5);
  rest.kernel_runs = {{0, 1}, {1, 2}};
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  EXPECT_EQ(bindings->kernels[0].drivers[0], 0u);  // not its nearest body
  EXPECT_EQ(bindings->kernels[1].drivers[0], 1u);
  EXPECT_EQ(bindings->kernels[2].drivers[0], 1u);
  for (const auto& [runs, what] : std::vector<std::pair<std::vector<RestBody::KernelRun>, const char*>>{
           {{{0, 1}}, "1 of the 3"},
           {{{0, 4}}, "more than"},
           {{{2, 3}}, "body 2 of 2"},
           {{{0, ~0u}, {1, ~0u}}, "more than"}}) {
    rest.kernel_runs = runs;
    const Result<KernelBindings> refused = bind_kernels(asset, rest);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(what), std::string::npos) << refused.error().message;
  }
}

TEST(SkinRigid, AcceptsAnAssetWithoutKernels) {
  const RestBody rest = rigid_body({Pose{}});
  const GaussianAsset asset;
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  ObjectDrivers drivers;
  drivers.poses = rest.bodies;
  PosedKernels kernels;
  skin_kernels(asset, rest, *bindings, drivers, kernels);
  EXPECT_TRUE(kernels.positions_m.empty());
}

TEST(SkinRigid, AnInfiniteKernelStaysFinite) {
  const RestBody rest = rigid_body({Pose{}});
  GaussianAsset asset = kernels_at(rest, {{0, 0, 0}}, 6);
  asset.log_scales[0] = Eigen::Vector3f(500.0f, -500.0f, 0.0f);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  for (float entry : bindings->rest_covariances_m2[0]) EXPECT_TRUE(std::isfinite(entry));
}

}  // namespace
}  // namespace livegs
