// SPDX-License-Identifier: Apache-2.0
#include "skin/kernels/kernel_reach.h"

#include <gtest/gtest.h>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

// For any drivers, all kernels and three of their standard deviations are inside the box.
void expect_all_inside(const RestBody& rest, const ObjectDrivers& drivers, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 500; ++i) points.push_back(uniform3(random, -0.3, 0.3));
  const GaussianAsset asset = kernels_at(rest, points, seed + 1);
  const auto bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings) << bindings.error().message;
  PosedKernels kernels;
  skin_kernels(asset, rest, *bindings, drivers, kernels);
  const Eigen::AlignedBox3f box = box_of_kernels(kernel_reach(rest, *bindings), drivers);
  Eigen::AlignedBox3f middles;
  for (size_t k = 0; k < asset.size(); ++k) {
    const Symmetric3f& s = kernels.covariances_m2[k];
    const Eigen::Vector3f wide = 3 * Eigen::Vector3f(s[0], s[3], s[5]).cwiseSqrt();
    const Eigen::Vector3f& x = kernels.positions_m[k];
    middles.extend(x);
    ASSERT_TRUE(box.contains(Eigen::AlignedBox3f(x - wide, x + wide))) << k;
  }
  // The box is also tight: an order of magnitude around a torn body, less around others.
  EXPECT_LT(box.sizes().maxCoeff(), 12 * middles.sizes().maxCoeff());
}

TEST(KernelReach, ContainsEveryKernelOfATornLattice) {
  RestBody rest = ragged_body(5, 4, 3, 0.05, 1);
  place(rest, 2);
  std::mt19937_64 random(3);
  for (const double amplitude : {0.0, 0.02, 0.2}) {
    ObjectDrivers drivers = rest_drivers(rest);
    for (Eigen::Vector3f& position : drivers.positions_m)
      position += (amplitude * uniform3(random, -1, 1)).cast<float>();
    expect_all_inside(rest, drivers, 4);
  }
}

TEST(KernelReach, ContainsEveryKernelOfBodiesAndParticles) {
  std::mt19937_64 random(5);
  RestBody rigid, particles;
  for (int b = 0; b < 4; ++b) rigid.bodies.push_back({uniform3(random, -0.2, 0.2), random_rotation(random)});
  ObjectDrivers thrown;
  for (int b = 0; b < 4; ++b) thrown.poses.push_back({uniform3(random, -1, 1), random_rotation(random)});
  expect_all_inside(rigid, thrown, 6);
  particles.kind = DriverKind::Particles;
  for (int p = 0; p < 60; ++p) particles.particles_m.push_back(uniform3(random, -0.2, 0.2).cast<float>());
  ObjectDrivers strewn = rest_drivers(particles);
  for (size_t p = 0; p < 60; ++p) {
    strewn.positions_m[p] += uniform3(random, -0.3, 0.3).cast<float>();
    strewn.rotations[p] = random_rotation(random).cast<float>();
  }
  expect_all_inside(particles, strewn, 7);
}

}  // namespace
}  // namespace livegs
