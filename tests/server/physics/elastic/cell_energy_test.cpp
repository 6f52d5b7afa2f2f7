// SPDX-License-Identifier: Apache-2.0
// Stored energy of eight full or cut cells, evaluated in single precision and in SIMD lanes, compared with a
// double-precision reference for each cell.
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <random>
#include <vector>

#include "physics/elastic/cells/kernels/cell_kernels.h"
#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/motion/free_rotation.h"

namespace livegs::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kWidth_m = 0.02;
constexpr int kUsed = 7;  // the eighth lane holds a cell on massless nodes

LatticeCell full_cell() {
  LatticeCell cell;
  cell.volume_m3 = kWidth_m * kWidth_m * kWidth_m;
  cell.centroid.setZero();
  cell.spread.setOnes();
  return cell;
}

Vector3d corner_m(int c) {
  return 0.5 * kWidth_m * Vector3d(c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0);
}

// Reference energy of one cell. The rotation comes from a singular value decomposition and shares no code
// with the kernels under test.
double energy_of(const LatticeCell& cell, const std::array<Vector3d, 8>& corners,
                 const IsotropicMaterial& material) {
  const auto gradients = trilinear_gradients(cell.centroid, kWidth_m);
  Matrix3d f = Matrix3d::Zero();
  std::array<Vector3d, kModeCount> modes;
  modes.fill(Vector3d::Zero());
  for (int c = 0; c < 8; ++c) {
    f += corners[c] * gradients[c].transpose();
    for (int j = 0; j < kModeCount; ++j) modes[j] += 0.125 * mode_sign(j, c) * corners[c];
  }
  const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d r = svd.matrixU() * svd.matrixV().transpose(), s = r.transpose() * f;
  for (Vector3d& mode : modes) mode = r.transpose() * mode;
  return cell_energy(cell, kWidth_m, material, 0.5 * (s + s.transpose()) - Matrix3d::Identity(),
                     f.determinant(), modes);
}

TEST(CellEnergy, FullCellLanesMatchSingleCells) {
  const IsotropicMaterial material{1e4, 0.3};
  FullModuli moduli;
  const LatticeCell cell = full_cell();
  moduli.shear_j = static_cast<float>(cell.volume_m3 * material.shear_modulus_pa());
  moduli.lambda_j = static_cast<float>(cell.volume_m3 * material.lame_lambda_pa());
  const auto stiffness = mode_stiffness(cell, kWidth_m, material);
  for (int j = 0; j < kModeCount; ++j) {
    for (int d = 0; d < 3; ++d) moduli.mode_n_m[j][d] = static_cast<float>(stiffness[j][d]);
  }
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const double strain : {0.01, 0.1, 0.3}) {
    std::vector<NodeLanes> nodes;
    FullCells cells{};
    double sum_j = 0.0;
    for (int lane = 0; lane < 8; ++lane) {
      const Vector3d turn = Vector3d(normal(random), normal(random), normal(random));
      const Matrix3d rotation = rotation_exp(turn).toRotationMatrix();
      Matrix3d stretch = Matrix3d::Identity();
      for (double& value : stretch.reshaped()) value += strain * 0.3 * normal(random);
      std::array<Vector3d, 8> corners;
      for (int c = 0; c < 8; ++c) {
        const Vector3d noise(normal(random), normal(random), normal(random));
        corners[c] =
            Vector3d(0.1, -0.2, 0.05) + rotation * (stretch * corner_m(c) + 0.1 * strain * kWidth_m * noise);
        cells.nodes[c][lane] = static_cast<uint32_t>(nodes.size());
        nodes.push_back(NodeLanes{static_cast<float>(corners[c].x()), static_cast<float>(corners[c].y()),
                                  static_cast<float>(corners[c].z()), lane < kUsed ? 5.0f : 0.0f});
      }
      // The rotation kept from the previous step, slightly off.
      const Eigen::Quaterniond kept = rotation_exp(turn + Vector3d::Constant(0.02));
      const double q[4] = {kept.w(), kept.x(), kept.y(), kept.z()};
      for (int k = 0; k < 4; ++k) cells.rotation[k][lane] = static_cast<float>(q[k]);
      if (lane < kUsed) sum_j += energy_of(full_cell(), corners, material);
    }
    const double found_j =
        full_cell_energy(&cells, &cells + 1, nodes.data(), moduli, static_cast<float>(0.25 / kWidth_m));
    // Coordinates of 0.2 m have a resolution of 1.5e-8 m, a strain error of 1e-6. The energy error is twice
    // that over the strain.
    EXPECT_NEAR(found_j / sum_j, 1.0, 3e-6 / strain + 1e-5) << strain;
  }
}

// Each cell has its own volume, centroid and material.
TEST(CellEnergy, CutCellLanesMatchSingleCells) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (const double strain : {0.01, 0.1, 0.3}) {
    std::vector<NodeLanes> nodes;
    CutCells cells{};
    CutModuli moduli{};
    double sum_j = 0.0;
    for (int lane = 0; lane < 8; ++lane) {
      const IsotropicMaterial material{1e4 * (1.0 + any(random)), 0.45 * any(random)};
      LatticeCell cell = full_cell();
      cell.volume_m3 *= 0.1 + 0.9 * any(random);
      for (int d = 0; d < 3; ++d) {
        cell.centroid[d] = any(random) - 0.5;
        cell.spread[d] = 0.2 + 0.8 * any(random);
      }
      const Vector3d turn(normal(random), normal(random), normal(random));
      Matrix3d stretch = Matrix3d::Identity();
      for (double& value : stretch.reshaped()) value += strain * 0.3 * normal(random);
      std::array<Vector3d, 8> corners;
      for (int c = 0; c < 8; ++c) {
        const Vector3d noise(normal(random), normal(random), normal(random));
        corners[c] = Vector3d(0.1, -0.2, 0.05) +
                     rotation_exp(turn) * (stretch * corner_m(c) + 0.1 * strain * kWidth_m * noise);
        cells.nodes[c][lane] = static_cast<uint32_t>(nodes.size());
        nodes.push_back(NodeLanes{static_cast<float>(corners[c].x()), static_cast<float>(corners[c].y()),
                                  static_cast<float>(corners[c].z()), 5.0f});
      }
      const Eigen::Quaterniond kept = rotation_exp(turn + Vector3d::Constant(0.02));
      const double q[4] = {kept.w(), kept.x(), kept.y(), kept.z()};
      for (int k = 0; k < 4; ++k) cells.rotation[k][lane] = static_cast<float>(q[k]);
      for (int d = 0; d < 3; ++d) cells.centroid[d][lane] = static_cast<float>(cell.centroid[d]);
      if (lane >= kUsed) continue;  // without moduli it stores no energy
      moduli.shear_j[lane] = static_cast<float>(cell.volume_m3 * material.shear_modulus_pa());
      moduli.lambda_j[lane] = static_cast<float>(cell.volume_m3 * material.lame_lambda_pa());
      const auto stiffness = mode_stiffness(cell, kWidth_m, material);
      for (int j = 0; j < kModeCount; ++j) {
        for (int d = 0; d < 3; ++d) moduli.mode_n_m[j][d][lane] = static_cast<float>(stiffness[j][d]);
      }
      sum_j += energy_of(cell, corners, material);
    }
    const double found_j = cut_cell_energy(cells, nodes.data(), moduli, static_cast<float>(0.25 / kWidth_m));
    EXPECT_NEAR(found_j / sum_j, 1.0, 3e-6 / strain + 1e-5) << strain;  // as above
  }
}

}  // namespace
}  // namespace livegs::test
