// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <functional>
#include <span>
#include <vector>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/lattice/lattice.h"

// The lattice as linear finite elements: small displacements, solved directly. The Gauss-Seidel passes of the
// solver converge to this solution, so tests of elements and lattices need no time steps.

namespace livegs::test {

using Matrix24 = Eigen::Matrix<double, 24, 24>;
using Vector24 = Eigen::Matrix<double, 24, 1>;

// Stiffness of one cell in lattice axes, corner by corner: the second derivative of cell_energy at rest.
inline Matrix24 cell_matrix(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material) {
  const auto gradients = trilinear_gradients(cell.centroid, cell_width_m);
  const auto energy = [&](const Vector24& u) {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    std::array<Eigen::Vector3d, kModeCount> modes;
    modes.fill(Eigen::Vector3d::Zero());
    for (int c = 0; c < 8; ++c) {
      gradient += u.segment<3>(3 * c) * gradients[c].transpose();
      for (int j = 0; j < kModeCount; ++j) modes[j] += 0.125 * mode_sign(j, c) * u.segment<3>(3 * c);
    }
    return cell_energy(cell, cell_width_m, material, 0.5 * (gradient + gradient.transpose()),
                       1.0 + gradient.trace(), modes);
  };
  // The energy is quadratic, so its differences are exact.
  Matrix24 matrix;
  Vector24 own;
  for (int i = 0; i < 24; ++i) own[i] = energy(Vector24::Unit(i));
  for (int i = 0; i < 24; ++i) {
    matrix(i, i) = 2.0 * own[i];
    for (int j = 0; j < i; ++j) {
      matrix(i, j) = matrix(j, i) = energy(Vector24::Unit(i) + Vector24::Unit(j)) - own[i] - own[j];
    }
  }
  return matrix;
}

struct NodeLoad {
  uint32_t node;
  Eigen::Vector3d force_n;  // lattice axes
};

class LatticeStatics {
 public:
  using CellMatrix = std::function<Matrix24(const LatticeCell&)>;

  // `held` nodes do not move. Every other node is tied to its position by its mass times `tie_per_s2`, which
  // makes a free body under balanced forces solvable.
  LatticeStatics(const Lattice& lattice, double density_kg_m3, const std::vector<bool>& held,
                 const CellMatrix& matrix_of, double tie_per_s2 = 0.0)
      : unknown_(lattice.node_coordinates.size(), -1) {
    for (size_t i = 0; i < unknown_.size(); ++i) {
      if (held[i]) continue;
      unknown_[i] = count_++;
      for (int d = 0; d < 3; ++d) masses_kg_.push_back(density_kg_m3 * lattice.node_volumes_m3[i]);
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (const LatticeCell& cell : lattice.cells) {
      const Matrix24 matrix = matrix_of(cell);
      for (int i = 0; i < 24; ++i) {
        for (int j = 0; j < 24; ++j) {
          const int row = unknown_[cell.nodes[i / 3]], column = unknown_[cell.nodes[j / 3]];
          if (row < 0 || column < 0) continue;
          entries.emplace_back(3 * row + i % 3, 3 * column + j % 3, matrix(i, j));
        }
      }
    }
    for (int i = 0; i < 3 * count_; ++i) entries.emplace_back(i, i, tie_per_s2 * masses_kg_[i]);
    Eigen::SparseMatrix<double> stiffness(3 * count_, 3 * count_);
    stiffness.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(stiffness);
    positive_ = solver_.info() == Eigen::Success && solver_.vectorD().minCoeff() > 0.0;
  }

  bool positive() const { return positive_; }  // no zero-energy motion

  // Displacements of all nodes in lattice axes, m.
  std::vector<Eigen::Vector3d> solve(std::span<const NodeLoad> loads) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * count_);
    for (const NodeLoad& load : loads) {
      if (unknown_[load.node] >= 0) force.segment<3>(3 * unknown_[load.node]) += load.force_n;
    }
    return nodes_of(solver_.solve(force));
  }

  std::vector<Eigen::Vector3d> solve_weight(const Eigen::Vector3d& gravity_m_s2) const {
    Eigen::VectorXd force(3 * count_);
    for (int i = 0; i < 3 * count_; ++i) force[i] = masses_kg_[i] * gravity_m_s2[i % 3];
    return nodes_of(solver_.solve(force));
  }

  // The lowest natural frequency, rad/s, by inverse iteration from a given load.
  double lowest_frequency_rad_s(const Eigen::Vector3d& first_m_s2) const {
    const Eigen::Map<const Eigen::VectorXd> masses(masses_kg_.data(), 3 * count_);
    Eigen::VectorXd shape(3 * count_);
    for (int i = 0; i < 3 * count_; ++i) shape[i] = first_m_s2[i % 3];
    double squared = 0.0;
    for (int k = 0; k < 60; ++k) {
      shape /= std::sqrt(shape.dot(masses.cwiseProduct(shape)));
      const Eigen::VectorXd next = solver_.solve(masses.cwiseProduct(shape));
      squared = 1.0 / shape.dot(masses.cwiseProduct(next));
      shape = next;
    }
    return std::sqrt(squared);
  }

 private:
  std::vector<Eigen::Vector3d> nodes_of(const Eigen::VectorXd& values) const {
    std::vector<Eigen::Vector3d> nodes(unknown_.size(), Eigen::Vector3d::Zero());
    for (size_t i = 0; i < nodes.size(); ++i) {
      if (unknown_[i] >= 0) nodes[i] = values.segment<3>(3 * unknown_[i]);
    }
    return nodes;
  }

  std::vector<int> unknown_;
  int count_ = 0;
  bool positive_ = false;
  std::vector<double> masses_kg_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

inline Eigen::Vector3d moved(const Lattice& lattice, const std::vector<Eigen::Vector3d>& displacements,
                             const Eigen::Vector3d& object_point_m) {
  const EmbeddedPoint point = lattice.embed(object_point_m);
  const auto weights = trilinear_weights(point.local);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int c = 0; c < 8; ++c) sum += weights[c] * displacements[lattice.cells[point.cell].nodes[c]];
  return lattice.object_from_lattice.orientation * sum;
}

}  // namespace livegs::test
