// SPDX-License-Identifier: Apache-2.0
#include "client/render/renderer/posed_assets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace livegs {

PosedKernels pose_asset(const GaussianAsset& asset, double twist_rad_m) {
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& position : asset.positions) bounds.extend(position);
  const double scale = 1.5 / bounds.diagonal().norm();
  const Eigen::Quaterniond upright(0, 1, 0, 0);  // half a turn about x
  const double stretch = twist_rad_m > 0 ? 1.2 : 1.0;
  PosedKernels posed;
  posed.resize(asset.size());
  for (size_t i = 0; i < asset.size(); ++i) {
    const Eigen::Vector3d rest = scale * (upright * (asset.positions[i] - bounds.center()).cast<double>());
    // x' = turn(twist y) (x, stretch y, z); F is its derivative.
    const double angle = twist_rad_m * rest.y();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Vector3d stretched(rest.x(), stretch * rest.y(), rest.z());
    const Eigen::Vector3d moved = turn * stretched;
    Eigen::Matrix3d f = turn * Eigen::Vector3d(1, stretch, 1).asDiagonal();
    f.col(1) += twist_rad_m * Eigen::Vector3d::UnitY().cross(moved);
    const Eigen::Vector3d deviations = scale * asset.log_scales[i].cast<double>().array().exp();
    const Eigen::Matrix3d a =
        f * (upright * asset.rotations[i].cast<double>()).toRotationMatrix() * deviations.asDiagonal();
    const Eigen::Matrix3d c = a * a.transpose();
    posed.positions_m[i] = moved.cast<float>();
    posed.covariances_m2[i] = {static_cast<float>(c(0, 0)), static_cast<float>(c(0, 1)),
                               static_cast<float>(c(0, 2)), static_cast<float>(c(1, 1)),
                               static_cast<float>(c(1, 2)), static_cast<float>(c(2, 2))};
    posed.world_from_asset[i] = (Eigen::Quaterniond(turn) * upright).cast<float>();
  }
  return posed;
}

CloudExtent extent_of(const PosedKernels& kernels) {
  Eigen::Vector3d low, high;
  std::vector<float> along(kernels.positions_m.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < along.size(); ++i) along[i] = kernels.positions_m[i][axis];
    std::sort(along.begin(), along.end());
    low[axis] = along[along.size() / 20];
    high[axis] = along[along.size() - 1 - along.size() / 20];
  }
  return {0.5 * (low + high), (high - low).norm()};
}

const char* name_of(View view) {
  return view == View::Front ? "front" : view == View::Close ? "close" : "inside";
}

Camera view_of(const CloudExtent& extent, View view, int width, int height) {
  const Eigen::Vector3d toward = Eigen::Vector3d(0.3, 0.25, 1.0).normalized();
  const double distance = view == View::Front ? 1.3 : view == View::Close ? 0.6 : 0.001;
  return look_at(extent.centre_m + distance * extent.size_m * toward, extent.centre_m,
                 Eigen::Vector3d::UnitY(), view == View::Inside ? 1.4 : 0.8, width, height);
}

}  // namespace livegs
