// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>

#include "common/skin/kernels/rest_bodies.h"
#include "core/parallel_for.h"

namespace livegs {
namespace {

using namespace livegs::testing;

// FNV-1a over the bits that drawing reads.
uint64_t hash_of(const PosedKernels& kernels, const std::vector<Eigen::Matrix3f>& gradients) {
  uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&hash](float value) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * 0x100000001b3u;
  };
  for (size_t k = 0; k < kernels.positions_m.size(); ++k) {
    for (int i = 0; i < 3; ++i) add(kernels.positions_m[k][i]);
    for (float entry : kernels.covariances_m2[k]) add(entry);
    for (int i = 0; i < 4; ++i) add(kernels.world_from_asset[k].coeffs()[i]);
    for (int i = 0; i < 9; ++i) add(gradients[k].data()[i]);
  }
  return hash;
}

TEST(SkinKernels, AreIndependentOfThreadCount) {
  std::mt19937_64 random(1);
  RestBody lattice = ragged_body(12, 11, 10, 0.02, 2);
  RestBody particles = lattice;
  particles.kind = DriverKind::Particles;
  for (int p = 0; p < 800; ++p) particles.particles_m.push_back(uniform3(random, 0.0, 0.22).cast<float>());
  RestBody rigid = lattice;
  rigid.kind = DriverKind::Rigid;
  for (int b = 0; b < 5; ++b) rigid.bodies.push_back({uniform3(random, 0.0, 0.22), random_rotation(random)});
  const auto motion = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return x + Eigen::Vector3d(0.03 * std::sin(20 * x[1]), 0.02 * std::sin(25 * x[2]),
                               0.01 * std::cos(30 * x[0]));
  };
  for (const RestBody& rest : {lattice, particles, rigid}) {
    ObjectDrivers drivers;
    if (rest.kind == DriverKind::Rigid) {
      drivers.poses.assign(5, Pose{uniform3(random, -1, 1), random_rotation(random)});
    } else {
      drivers = moved_drivers(rest, motion);
    }
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 20000; ++k) points.push_back(uniform3(random, -0.02, 0.24));
    const GaussianAsset asset = kernels_at(rest, points, 3);
    std::vector<uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
      set_thread_count(threads);
      const Result<KernelBindings> bindings = bind_kernels(asset, rest);
      ASSERT_TRUE(bindings);
      PosedKernels kernels;
      std::vector<Eigen::Matrix3f> gradients;
      skin_kernels(asset, rest, *bindings, drivers, kernels, &gradients);
      hashes.push_back(hash_of(kernels, gradients));
    }
    set_thread_count(0);
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
  }
}

}  // namespace
}  // namespace livegs
