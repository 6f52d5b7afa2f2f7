// SPDX-License-Identifier: Apache-2.0
// The colour of a rotated kernel by the reference, compared with closed forms, separately for each
// coefficient of each band.
#include <gtest/gtest.h>

#include "common/splat/project/real_harmonics.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

// Computed by hand from the definition, to verify signs and order of the formula used below.
TEST(HarmonicsRotation, FormulaHasTheSignsOfTrainedFiles) {
  const Eigen::Vector3d d = Eigen::Vector3d(0.3, -0.5, 0.7).normalized();
  EXPECT_NEAR(synthetic::real_harmonic(0, d), -std::sqrt(3 / (4 * M_PI)) * d.y(), 1e-12);
  EXPECT_NEAR(synthetic::real_harmonic(1, d), std::sqrt(3 / (4 * M_PI)) * d.z(), 1e-12);
  EXPECT_NEAR(synthetic::real_harmonic(2, d), -std::sqrt(3 / (4 * M_PI)) * d.x(), 1e-12);
  EXPECT_NEAR(synthetic::real_harmonic(3, d), std::sqrt(15 / (4 * M_PI)) * d.x() * d.y(), 1e-12);
  EXPECT_NEAR(synthetic::real_harmonic(7, d), std::sqrt(15 / (16 * M_PI)) * (d.x() * d.x() - d.y() * d.y()),
              1e-12);
  EXPECT_NEAR(synthetic::real_harmonic(9, d), std::sqrt(105 / (4 * M_PI)) * d.x() * d.y() * d.z(), 1e-12);
}

TEST(HarmonicsRotation, CoefficientsRotateWithTheAsset) {
  synthetic::Random random(21);
  int clamped = 0;
  double widest = 0;  // largest colour change by a rotation
  for (int k = 0; k < synthetic::kBandCoefficients; ++k) {
    for (int turn = 0; turn < 8; ++turn) {
      const Eigen::Quaterniond world_from_asset =
          turn == 0 ? Eigen::Quaterniond::Identity() : random.rotation();
      const Eigen::Vector3d towards = random.rotation() * Eigen::Vector3d::UnitZ();
      synthetic::Object object;
      object.asset = synthetic::one_harmonic(k);
      object.posed.positions_m = {Eigen::Vector3f::Zero()};
      object.posed.covariances_m2 = {
          synthetic::covariance(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Constant(0.3))};
      object.posed.world_from_asset = {world_from_asset.cast<float>()};
      const DrawnObject drawn = object.drawn();
      RasterisedView view;
      Rasteriser().draw({&drawn, 1}, synthetic::eye_towards({0, 0, 0}, towards), {}, view);
      const Eigen::Vector3d expected = synthetic::one_harmonic_shows(k, world_from_asset, towards);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(view.image.at(16, 12)[c], expected[c], 1e-4)
            << "coefficient " << k << ", turn " << turn << ", channel " << c;
        clamped += expected[c] == 0;
      }
      const Eigen::Vector3d unturned =
          synthetic::one_harmonic_shows(k, Eigen::Quaterniond::Identity(), towards);
      widest = std::max(widest, (expected - unturned).norm());
    }
  }
  EXPECT_GT(clamped, 5);
  EXPECT_GT(widest, 0.5);
}

}  // namespace
}  // namespace livegs
