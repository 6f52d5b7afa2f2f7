// SPDX-License-Identifier: Apache-2.0
#include "server/physics/soft/settled_block.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <vector>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSide_m = 0.2, kHeight_m = 0.1, kMass_kg = 4.0, kModulus_pa = 2e4, kPoisson = 0.3;
constexpr double kRadius_m = 0.05, kSphere_kg = 1.0, kGravity_m_s2 = 9.81;
constexpr double kHeld_n_m = 1e9,
                 // stiffness of the tie of a floor node: fixed, or only kept from drifting
    kSliding_n_m = 30.0;

using Stiffness = Eigen::Matrix<double, 24, 24>;

// Stiffness of one cubic element by 2 x 2 x 2 Gauss points.
Stiffness stiffness_of(double edge_m) {
  const double lambda = kModulus_pa * kPoisson / ((1 + kPoisson) * (1 - 2 * kPoisson)),
               mu = kModulus_pa / (2 * (1 + kPoisson));
  Eigen::Matrix<double, 6, 6> law = Eigen::Matrix<double, 6, 6>::Zero();
  law.topLeftCorner<3, 3>().setConstant(lambda);
  for (int d = 0; d < 3; ++d) {
    law(d, d) += 2 * mu;
    law(d + 3, d + 3) = mu;
  }
  Stiffness sum = Stiffness::Zero();
  for (int point = 0; point < 8; ++point) {
    Eigen::Matrix<double, 6, 24> strain = Eigen::Matrix<double, 6, 24>::Zero();
    for (int a = 0; a < 8; ++a) {
      Vector3d slope = Vector3d::Constant(0.25 / edge_m);
      for (int d = 0; d < 3; ++d) {
        const double sign = a & 1 << d ? 1 : -1, at = (point & 1 << d ? 1 : -1) / std::sqrt(3.0);
        for (int other = 0; other < 3; ++other) slope[other] *= other == d ? sign : 1 + sign * at;
      }
      for (int d = 0; d < 3; ++d) {
        const int next = (d + 1) % 3;
        strain(d, 3 * a + d) = slope[d];
        strain(3 + d, 3 * a + d) = slope[next];
        strain(3 + d, 3 * a + next) = slope[d];
      }
    }
    sum += edge_m * edge_m * edge_m / 8 * strain.transpose() * law * strain;
  }
  return sum;
}

struct TopPoint {
  Vector3d rest_m;
  std::array<int, 4> nodes;
  std::array<double, 4> weights;
};

class Block {
 public:
  explicit Block(const SettledBlock& block) : edge_m_(block.element_m) {
    along_ = static_cast<int>(std::lround(kSide_m / edge_m_));
    up_ = static_cast<int>(std::lround(kHeight_m / edge_m_));
    const int count = 3 * (along_ + 1) * (up_ + 1) * (along_ + 1);
    const Stiffness cube = stiffness_of(edge_m_);
    std::vector<Eigen::Triplet<double>> entries;
    VectorXd weight = VectorXd::Zero(count);
    for (int i = 0; i < along_; ++i) {
      for (int j = 0; j < up_; ++j) {
        for (int k = 0; k < along_; ++k) add_cube(cube, i, j, k, entries, weight);
      }
    }
    for (int i = 0; i <= along_; ++i) {
      for (int k = 0; k <= along_; ++k) {
        for (int d = 0; d < 3; ++d) {
          const int row = 3 * node(i, 0, k) + d;
          entries.push_back({row, row, d == 1 || block.glued ? kHeld_n_m : kSliding_n_m});
        }
      }
    }
    Eigen::SparseMatrix<double> stiffness(count, count);
    stiffness.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(stiffness);
    add_points(block.point_m);
    sunk_m_ = at_points(solver_.solve(weight));
    compliance_.resize(3 * static_cast<Eigen::Index>(points_.size()),
                       3 * static_cast<Eigen::Index>(points_.size()));
    for (Eigen::Index row = 0; row < compliance_.cols(); ++row) {
      const TopPoint& point = points_[static_cast<size_t>(row / 3)];
      VectorXd load = VectorXd::Zero(count);
      for (int a = 0; a < 4; ++a) load[3 * point.nodes[a] + row % 3] += point.weights[a];
      compliance_.col(row) = at_points(solver_.solve(load));
    }
  }

  // Upward force on the sphere held at `depth_m`: projected Gauss-Seidel on the contact forces, which point
  // away from its centre.
  double upward_n(double depth_m) const {
    const Vector3d middle(0.5 * kSide_m, kHeight_m - depth_m + kRadius_m, 0.5 * kSide_m);
    VectorXd moved = sunk_m_, force = VectorXd::Zero(sunk_m_.size());
    double change = 1;
    for (int sweep = 0; sweep < 5000 && change > 1e-6; ++sweep) {
      change = 0;
      for (Eigen::Index p = 0; p < std::ssize(points_); ++p) {
        const Vector3d arm = points_[static_cast<size_t>(p)].rest_m + moved.segment<3>(3 * p) - middle,
                       normal = arm.normalized();
        const Vector3d before = force.segment<3>(3 * p);
        const double needed =
            (kRadius_m - arm.norm()) / normal.dot(compliance_.block<3, 3>(3 * p, 3 * p) * normal);
        const Vector3d step = 0.7 * (std::max(0.0, before.dot(normal) + needed) * normal - before);
        force.segment<3>(3 * p) += step;
        moved += compliance_.middleCols<3>(3 * p) * step;
        change = std::max(change, step.norm());
      }
    }
    double sum = 0;
    for (Eigen::Index p = 0; p < std::ssize(points_); ++p) sum -= force[3 * p + 1];
    return sum;
  }

 private:
  int node(int i, int j, int k) const { return (i * (up_ + 1) + j) * (along_ + 1) + k; }

  void add_cube(const Stiffness& cube, int i, int j, int k, std::vector<Eigen::Triplet<double>>& entries,
                VectorXd& weight) const {
    const double share_n = kMass_kg * kGravity_m_s2 / (along_ * up_ * along_ * 8);
    std::array<int, 8> nodes;
    for (int a = 0; a < 8; ++a) nodes[a] = node(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2 & 1));
    for (int a = 0; a < 24; ++a) {
      if (a % 3 == 1) weight[3 * nodes[a / 3] + 1] -= share_n;
      for (int b = 0; b < 24; ++b)
        entries.push_back({3 * nodes[a / 3] + a % 3, 3 * nodes[b / 3] + b % 3, cube(a, b)});
    }
  }

  // Adds points of the top face within reach of the sphere.
  void add_points(double apart_m) {
    const int count = static_cast<int>(std::lround(kSide_m / apart_m));
    for (int a = 0; a <= count; ++a) {
      for (int b = 0; b <= count; ++b) {
        const double x = kSide_m * a / count, z = kSide_m * b / count;
        if (std::hypot(x - 0.5 * kSide_m, z - 0.5 * kSide_m) > 0.9 * kRadius_m) continue;
        const int i = std::min(along_ - 1, static_cast<int>(x / edge_m_)),
                  k = std::min(along_ - 1, static_cast<int>(z / edge_m_));
        const double s = x / edge_m_ - i, t = z / edge_m_ - k;
        points_.push_back(
            {{x, kHeight_m, z},
             {node(i, up_, k), node(i + 1, up_, k), node(i, up_, k + 1), node(i + 1, up_, k + 1)},
             {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t}});
      }
    }
  }

  VectorXd at_points(const VectorXd& nodes_m) const {
    VectorXd places(3 * std::ssize(points_));
    for (Eigen::Index p = 0; p < std::ssize(points_); ++p) {
      const TopPoint& point = points_[static_cast<size_t>(p)];
      Vector3d sum = Vector3d::Zero();
      for (int a = 0; a < 4; ++a) sum += point.weights[a] * nodes_m.segment<3>(3 * point.nodes[a]);
      places.segment<3>(3 * p) = sum;
    }
    return places;
  }

  double edge_m_;
  int along_ = 0, up_ = 0;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  std::vector<TopPoint> points_;
  VectorXd sunk_m_;      // displacements by the block's weight, three per point
  MatrixXd compliance_;  // displacements of points per unit force on points
};

}  // namespace

double settled_depth_m(const SettledBlock& block) {
  const Block solved(block);
  double low_m = 0.0, high_m = 0.6 * kRadius_m;
  while (high_m - low_m > 1e-6) {
    const double middle_m = 0.5 * (low_m + high_m);
    (solved.upward_n(middle_m) > kSphere_kg * kGravity_m_s2 ? high_m : low_m) = middle_m;
  }
  return 0.5 * (low_m + high_m);
}

}  // namespace livegs
