// SPDX-License-Identifier: GPL-3.0-or-later
// Müller et al. 2005, Meshless deformations based on shape matching: clusters, goals, and the paper's blend
// towards them.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "baseline/livegs_v1_body.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d pseudo_inverse(const Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
  Matrix3d inverse = Matrix3d::Zero();
  const double least = 1e-6 * solver.eigenvalues()[2];
  for (int d = 0; d < 3; ++d) {
    if (solver.eigenvalues()[d] <= least) continue;
    const Vector3d axis = solver.eigenvectors().col(d);
    inverse += axis * axis.transpose() / solver.eigenvalues()[d];
  }
  return inverse;
}

}  // namespace

// A cluster holds the particles within 1.5 spacings along each axis: 27 on a regular grid. If there are fewer
// than 4, it holds the nearest 8.
void LivegsV1Body::make_clusters() {
  using Key = std::tuple<int64_t, int64_t, int64_t>;
  const double reach = 1.5 * spacing_m_;
  const auto key = [&](const Vector3d& p) {
    return Key{static_cast<int64_t>(std::floor(p.x() / reach)),
               static_cast<int64_t>(std::floor(p.y() / reach)),
               static_cast<int64_t>(std::floor(p.z() / reach))};
  };
  std::map<Key, std::vector<uint32_t>> voxels;
  for (uint32_t i = 0; i < rest_m_.size(); ++i) voxels[key(rest_m_[i])].push_back(i);

  cluster_counts_.assign(rest_m_.size(), 0);
  std::vector<std::pair<double, uint32_t>> nearest;
  for (uint32_t i = 0; i < rest_m_.size(); ++i) {
    Cluster cluster;
    cluster.begin = static_cast<uint32_t>(members_.size());
    cluster.mass_kg = 0.0;
    cluster.rest_centre_m.setZero();
    cluster.rotation = orientation_;
    cluster.deformation = orientation_.toRotationMatrix();
    const auto [x, y, z] = key(rest_m_[i]);
    for (int64_t dx = -1; dx <= 1; ++dx) {
      for (int64_t dy = -1; dy <= 1; ++dy) {
        for (int64_t dz = -1; dz <= 1; ++dz) {
          const auto found = voxels.find({x + dx, y + dy, z + dz});
          if (found == voxels.end()) continue;
          for (const uint32_t j : found->second) {
            if ((rest_m_[j] - rest_m_[i]).cwiseAbs().maxCoeff() <= reach * (1.0 - 1e-9))
              members_.push_back(j);
          }
        }
      }
    }
    if (members_.size() - cluster.begin < 4) {
      members_.resize(cluster.begin);
      nearest.clear();
      for (uint32_t j = 0; j < rest_m_.size(); ++j)
        nearest.emplace_back((rest_m_[j] - rest_m_[i]).squaredNorm(), j);
      const size_t take = std::min<size_t>(8, nearest.size());
      std::partial_sort(nearest.begin(), nearest.begin() + static_cast<ptrdiff_t>(take), nearest.end());
      for (size_t k = 0; k < take; ++k) members_.push_back(nearest[k].second);
    }
    std::sort(members_.begin() + cluster.begin, members_.end());
    cluster.end = static_cast<uint32_t>(members_.size());
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      cluster.mass_kg += masses_kg_[members_[k]];
      cluster.rest_centre_m += masses_kg_[members_[k]] * rest_m_[members_[k]];
      ++cluster_counts_[members_[k]];
    }
    cluster.rest_centre_m /= cluster.mass_kg;
    Matrix3d moment = Matrix3d::Zero();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      const Vector3d r = rest_m_[members_[k]] - cluster.rest_centre_m;
      moment += masses_kg_[members_[k]] * r * r.transpose();
    }
    cluster.rest_moment_inverse = pseudo_inverse(moment);
    cluster.flat = Matrix3d::Identity() - moment * cluster.rest_moment_inverse;
    clusters_.push_back(cluster);
  }
}

bool creep_plastically(const Matrix3d& stretch, double plasticity, Matrix3d& plastic_part) {
  const Matrix3d identity = Matrix3d::Identity();
  const Matrix3d strain = stretch - identity;
  if (!(plasticity > 0.0) || !(strain.norm() > 1.0 - plasticity)) return false;
  Matrix3d crept = (identity + plasticity * strain) * plastic_part;
  const double size = (crept - identity).norm();
  if (size > plasticity) crept = identity + plasticity / size * (crept - identity);
  if (!(crept.determinant() > 1e-3)) return false;
  plastic_part = crept;
  return true;
}

void LivegsV1Body::match_shapes(double blend) {
  std::ranges::fill(goals_m_, Vector3d(Vector3d::Zero()));
  for (Cluster& cluster : clusters_) {
    Vector3d centre = Vector3d::Zero();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      centre += masses_kg_[members_[k]] * predicted_m_[members_[k]];
    }
    centre /= cluster.mass_kg;
    Matrix3d match = Matrix3d::Zero();
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      const uint32_t i = members_[k];
      match += masses_kg_[i] * (predicted_m_[i] - centre) * (rest_m_[i] - cluster.rest_centre_m).transpose();
    }
    // The matched shape is the rest shape stretched by D_p.
    cluster.rotation = extract_rotation(match * cluster.plastic_part.transpose(), cluster.rotation);
    const Matrix3d rotation = cluster.rotation.toRotationMatrix();
    cluster.deformation = match * cluster.rest_moment_inverse + rotation * cluster.flat;
    const Matrix3d stretch = rotation.transpose() * cluster.deformation * cluster.plastic_inverse;
    if (creep_plastically(stretch, material_.plasticity, cluster.plastic_part)) {
      cluster.plastic_inverse = cluster.plastic_part.inverse();
    }
    const Matrix3d goal = rotation * cluster.plastic_part;
    for (uint32_t k = cluster.begin; k < cluster.end; ++k) {
      const uint32_t i = members_[k];
      goals_m_[i] += centre + goal * (rest_m_[i] - cluster.rest_centre_m);
    }
  }
  for (size_t i = 0; i < goals_m_.size(); ++i) {
    if (held(i)) continue;
    predicted_m_[i] += blend * (goals_m_[i] / cluster_counts_[i] - predicted_m_[i]);
  }
}

}  // namespace livegs
