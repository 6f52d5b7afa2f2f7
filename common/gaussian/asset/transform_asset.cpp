// SPDX-License-Identifier: Apache-2.0
#include "gaussian/transform_asset.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "gaussian/spherical_harmonics.h"

namespace livegs {
namespace {

// The matrix that takes the coefficients of a band to those of the rotated function f(R^-1 d). The band is
// closed under rotation, so that its values in enough directions determine it.
Eigen::MatrixXd band_rotation(int degree, const Eigen::Matrix3d& rotation) {
  constexpr int kDirections = 32;  // on a spiral; 7 coefficients at most
  const int count = 2 * degree + 1, first = degree * degree - 1;
  Eigen::MatrixXd values(kDirections, count), turned_back(kDirections, count);
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections;
    const double azimuth = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double radius = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(radius * std::cos(azimuth), radius * std::sin(azimuth), z);
    const Eigen::Vector3d before = rotation.transpose() * direction;
    float bands[15];
    evaluate_sh_bands(direction.cast<float>(), degree, bands);
    for (int m = 0; m < count; ++m) values(i, m) = bands[first + m];
    evaluate_sh_bands(before.cast<float>(), degree, bands);
    for (int m = 0; m < count; ++m) turned_back(i, m) = bands[first + m];
  }
  return values.colPivHouseholderQr().solve(turned_back);
}

}  // namespace

void transform_asset(GaussianAsset& asset, const Eigen::Quaterniond& rotation, double scale) {
  const Eigen::Matrix3d matrix = rotation.normalized().toRotationMatrix();
  const auto log_scale = static_cast<float>(std::log(scale));
  for (size_t k = 0; k < asset.size(); ++k) {
    asset.positions[k] = (scale * (matrix * asset.positions[k].cast<double>())).cast<float>();
    asset.log_scales[k].array() += log_scale;
    asset.rotations[k] =
        (rotation.normalized() * asset.rotations[k].cast<double>()).normalized().cast<float>();
  }
  const size_t rest = asset.sh_rest_count();
  for (int degree = 1; degree <= asset.sh_degree; ++degree) {
    const Eigen::MatrixXd turn = band_rotation(degree, matrix);
    const auto first = static_cast<size_t>(degree * degree - 1);
    const Eigen::Index count = 2 * degree + 1;
    for (size_t k = 0; k < asset.size(); ++k) {
      Eigen::Matrix<double, Eigen::Dynamic, 3> band(count, 3);
      Eigen::Vector3f* const own = &asset.sh_rest[k * rest + first];
      for (Eigen::Index m = 0; m < count; ++m) band.row(m) = own[m].cast<double>().transpose();
      band = (turn * band).eval();
      for (Eigen::Index m = 0; m < count; ++m) own[m] = band.row(m).transpose().cast<float>();
    }
  }
}

}  // namespace livegs
