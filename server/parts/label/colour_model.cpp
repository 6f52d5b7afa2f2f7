// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/label/colour_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace livegs {
namespace {

constexpr double kNormalShare = 0.05;        // of the normal distribution in the density
constexpr double kCellDeviation = 1.0 / 16;  // added to each axis of the normal distribution: half a cell

int cell_index(float value, int side) {
  return std::clamp(static_cast<int>(value * static_cast<float>(side)), 0, side - 1);
}

}  // namespace

ColourModel::ColourModel() : cells_(static_cast<size_t>(kSide) * kSide * kSide, 0.0) {}

void ColourModel::add(const Eigen::Vector3f& rgb) {
  cells_[static_cast<size_t>((cell_index(rgb.x(), kSide) * kSide + cell_index(rgb.y(), kSide)) * kSide +
                             cell_index(rgb.z(), kSide))] += 1;
  count_ += 1;
  mean_ += rgb.cast<double>();
  moment_ += rgb.cast<double>() * rgb.cast<double>().transpose();
}

void ColourModel::finish() {
  if (count_ == 0) return;
  for (int stride : {1, kSide, kSide * kSide}) {
    std::vector<double> blurred(cells_.size());
    for (int i = 0; i < static_cast<int>(cells_.size()); ++i) {
      const int at = i / stride % kSide;
      const double below = cells_[static_cast<size_t>(at > 0 ? i - stride : i)];
      const double above = cells_[static_cast<size_t>(at + 1 < kSide ? i + stride : i)];
      blurred[static_cast<size_t>(i)] = 0.25 * below + 0.5 * cells_[static_cast<size_t>(i)] + 0.25 * above;
    }
    cells_ = std::move(blurred);
  }
  for (double& cell : cells_) cell /= count_;
  mean_ /= count_;
  const Eigen::Matrix3d covariance = moment_ / count_ - mean_ * mean_.transpose() +
                                     kCellDeviation * kCellDeviation * Eigen::Matrix3d::Identity();
  inverse_ = covariance.inverse();
  peak_ = std::pow(static_cast<double>(kSide), -3) /
          std::sqrt(std::pow(2 * std::numbers::pi, 3) * covariance.determinant());
}

double ColourModel::density(const Eigen::Vector3f& rgb) const {
  if (count_ == 0) return 0;
  const Eigen::Vector3d d = rgb.cast<double>() - mean_;
  const double normal = peak_ * std::exp(-0.5 * d.dot(inverse_ * d));
  const size_t cell = static_cast<size_t>(
      (cell_index(rgb.x(), kSide) * kSide + cell_index(rgb.y(), kSide)) * kSide + cell_index(rgb.z(), kSide));
  return (1 - kNormalShare) * cells_[cell] + kNormalShare * normal;
}

}  // namespace livegs
