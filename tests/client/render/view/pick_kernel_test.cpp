// SPDX-License-Identifier: Apache-2.0
#include "render/view/pick_kernel.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

// Kernels on the z axis, each 0.1 m wide and 0.2 m along z.
struct Row {
  explicit Row(const std::vector<std::pair<float, float>>& z_and_opacity) {
    asset.resize(z_and_opacity.size());
    kernels.resize(z_and_opacity.size());
    for (size_t i = 0; i < z_and_opacity.size(); ++i) {
      const auto [z, opacity] = z_and_opacity[i];
      kernels.positions_m[i] = {0, 0, z};
      kernels.covariances_m2[i] = {0.01f, 0, 0, 0.01f, 0, 0.04f};
      asset.opacity_logits[i] = std::log(opacity / (1 - opacity));
    }
  }
  std::optional<PickedKernel> pick(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
    const DrawnObject drawn{&asset, &kernels, 1};
    return pick_kernel({&drawn, 1}, from, direction.normalized());
  }
  GaussianAsset asset;
  PosedKernels kernels;
};

TEST(PickKernel, PicksMedianDepth) {
  const Row row({{-3, 0.9f}, {-1, 0.2f}, {-2, 0.3f}});  // transmittance 0.8, then 0.56, then 0.056
  const auto met = row.pick({0, 0, 0}, {0, 0, -1});
  ASSERT_TRUE(met);
  EXPECT_EQ(met->kernel, 0u);
  EXPECT_NEAR(met->distance_m, 3, 1e-5);
  // From behind the other kernel is hit.
  const auto behind = row.pick({0, 0, -5}, {0, 0, 1});
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->distance_m, 2, 1e-5);
}

TEST(PickKernel, IgnoresHazeAndKernelsBehind) {
  EXPECT_FALSE(Row({{-1, 0.2f}, {-2, 0.3f}}).pick({0, 0, 0}, {0, 0, -1}));  // transmittance 0.56
  EXPECT_FALSE(Row({{1, 0.9f}}).pick({0, 0, 0}, {0, 0, -1}));
  EXPECT_FALSE(Row({{-0.04f, 0.9f}}).pick({0, 0, 0}, {0, 0, -1}));  // in front of the near plane
}

// Off-centre, absorption falls by exp(-x² / 2σ²): 0.9 falls to one half at 1.0842 σ.
TEST(PickKernel, OpacityFallsOffFromCentre) {
  const Row row({{-3, 0.9f}});
  EXPECT_TRUE(row.pick({0.108, 0, 0}, {0, 0, -1}));
  EXPECT_FALSE(row.pick({0.109, 0, 0}, {0, 0, -1}));
}

// A ray at 45 degrees in the x-z plane has its highest density in Σ = diag(0.01, ., 0.04) at t = dᵀ Σ⁻¹ p /
// dᵀ Σ⁻¹ d.
TEST(PickKernel, DepthIsAtHighestDensity) {
  const Row row({{-3, 0.99f}});
  const Eigen::Vector3d from(-3.05, 0, 0), along = Eigen::Vector3d(1, 0, -1).normalized(), to(3.05, 0, -3);
  const Eigen::Vector3d inverse(100, 100, 25);
  const double closed = along.dot(inverse.cwiseProduct(to)) / along.dot(inverse.cwiseProduct(along));
  const auto met = row.pick(from, along);
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->distance_m, closed,
              1e-4);  // single precision, and the regularisation by 1e-6 of the trace
}

}  // namespace
}  // namespace livegs
