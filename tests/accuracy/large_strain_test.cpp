// SPDX-License-Identifier: Apache-2.0
// Scenes 24 and 27, affine boundary motions and two materials. References: closed forms of the material
// (uniaxial.h, plastic_set.h), the matrix of the boundary, and stress divided by E of each part.
#include "accuracy/scene_checks.h"
#include "known_gaps.h"
#include "study/elastic_scenes/plastic_set.h"
#include "study/elastic_scenes/squash.h"
#include "study/elastic_scenes/two_materials.h"
#include "study/harness/affine_ramp.h"

namespace livegs::study {
namespace {

TEST(Squash, MatchesTheVolumeOfTheMaterial) {
  // 30 % between frictionless plates at nu 0.45; bar 1 % at Courant numbers up to 0.28.
  for (const double rate_hz : kRates_hz) {
    for (const study::Setup& setup :
         {setup_of(1e4, 0.45, rate_hz, 8, 0.025), setup_of(1e5, 0.45, rate_hz, 32, 0.025)}) {
      const Outcome outcome = run(squash(setup));
      ASSERT_LE(outcome.accuracy.courant, 0.28);
      EXPECT_NEAR(outcome["volume_ratio"].reference, 0.954, 0.001);
      expect_within_bar(outcome, "volume_ratio", setup);
    }
  }
}

TEST(Squash, VolumeAtTheChosenSubsteps) {
  // A compressed cell is stiffer than at rest, and the residual of a substep grows with the square of its
  // length.
  for (const double rate_hz : kRates_hz) {
    const study::Setup setup = chosen(1e5, 0.45, rate_hz, 0.025);
    const Outcome outcome = run(squash(setup));
    report_gap("squash.volume_at_chosen_substeps", outcome["volume_ratio"].error);
  }
}

TEST(Squash, VolumeInTheChosenCells) {
  // Two layers, with the substeps they need.
  for (const double rate_hz : kRates_hz) {
    const study::Setup setup = chosen(1e5, 0.45, rate_hz, 0.0);
    const Outcome outcome = run(squash(setup));
    EXPECT_LE(outcome["volume_ratio"].error, 0.01) << text_of(setup, outcome);
  }
}

TEST(AffineRamp, ReachesTheInterior) {
  const Eigen::Matrix3d stretch = Eigen::Vector3d(1.5, 1.0, 0.8).asDiagonal();
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 1) = 1.0;
  for (const double rate_hz : kRates_hz) {
    for (const Eigen::Matrix3d& matrix : {stretch, shear}) {
      const study::Setup setup = setup_of(1e4, 0.3, rate_hz, 8, 0.025);
      const Outcome outcome = run(affine_ramp(setup, matrix));
      ASSERT_LE(outcome.accuracy.courant, 0.4);
      expect_within_bar(outcome, "interior", setup);
    }
  }
}

TEST(AffineRamp, ReachesTheInteriorAtTheChosenSubsteps) {
  const Eigen::Matrix3d stretch = Eigen::Vector3d(1.5, 1.0, 0.8).asDiagonal();
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 1) = 1.0;
  for (const double rate_hz : kRates_hz) {
    for (const double youngs_modulus_pa : gate_or_full<double>({1e4, 1e6}, {1e4, 1e5, 1e6})) {
      for (const double cell_width_m : {0.0, 0.025}) {
        for (const Eigen::Matrix3d& matrix : {stretch, shear}) {
          const study::Setup setup = chosen(youngs_modulus_pa, 0.3, rate_hz, cell_width_m);
          const Outcome outcome = run(affine_ramp(setup, matrix));
          EXPECT_LE(outcome.accuracy.courant, 0.4 + 1e-9);
          expect_within_bar(outcome, "interior", setup);
        }
      }
    }
  }
}

TEST(TwoMaterials, ShareTheStrainByTheirModuli) {
  for (const double rate_hz : kRates_hz) {
    for (const double joint_m : {0.0, 0.011}) {  // between cells, and inside cells
      const study::Setup setup = setup_of(1e4, 0.3, rate_hz, 8, 0.025);
      const Outcome outcome = run(two_materials(setup, joint_m));
      expect_within_bar(outcome, "soft_strain", setup);
      expect_within_bar(outcome, "stiff_strain", setup);
    }
  }
}

// Expected plastic strains of set_of_stretch for a block stretched at constant volume. They differ from
// strain minus yield, which is for simple tension (below). At equal axial stretch, the transverse strain is
// larger here: the sides contract by 1/sqrt(l).
TEST(PlasticSet, IsIndependentOfSubstepsAndLoadingRate) {
  for (const double poisson_ratio : gate_or_full<double>({0.0, 0.45}, {0.0, 0.3, 0.45})) {
    for (const double speed : {1.0, 10.0}) {
      for (const double rate_hz : kRates_hz)
        for (const int substeps : {4, 16}) {
          const study::Setup setup = setup_of(1e4, poisson_ratio, rate_hz, substeps, 0.025);
          const Outcome outcome = run(plastic_set(setup, speed));
          expect_within_bar(outcome, "set", setup);
          expect_within_bar(outcome, "volume_ratio", setup);
        }
    }
  }
}

TEST(PlasticSet, IsStrainMinusYieldInTension) {
  // The volume term resists if the plastic strain across is less than along: BarSetsAtStrainMinusYield
  // (return_mapping_test.cpp).
  constexpr double kBar = 0.02;
  for (const double yield : {0.05, 0.1}) {
    for (const double poisson_ratio : gate_or_full<double>({0.0, 0.45}, {0.0, 0.3, 0.45})) {
      const bool missed = yield > 0.09 && poisson_ratio > 0.0;
      for (const double speed : {1.0, 10.0}) {
        for (const double rate_hz : kRates_hz)
          for (const int substeps : {4, 16}) {
            const study::Setup setup = setup_of(1e4, poisson_ratio, rate_hz, substeps, 0.025);
            const Outcome outcome = run(plastic_set_in_tension(setup, speed, yield));
            if (missed) {
              report_gap("plastic.set_in_tension", outcome["set"].error);
            } else {
              EXPECT_LE(outcome["set"].error, kBar) << "yield " << yield << "; " << text_of(setup, outcome);
            }
            expect_within_bar(outcome, "volume_ratio", setup);
          }
      }
    }
  }
}

}  // namespace
}  // namespace livegs::study
