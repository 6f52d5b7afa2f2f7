// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs {

// A density of colours: a blurred histogram of 8^3 cells, over a normal distribution where it is empty.
class ColourModel {
 public:
  ColourModel();
  void add(const Eigen::Vector3f& rgb);
  // After the last colour.
  void finish();
  // Probability of the cell of a colour; the same for all colours without samples.
  double density(const Eigen::Vector3f& rgb) const;
  double count() const { return count_; }

 private:
  static constexpr int kSide = 8;
  std::vector<double> cells_;
  double count_ = 0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment_ = Eigen::Matrix3d::Zero(), inverse_ = Eigen::Matrix3d::Identity();
  double peak_ = 0;
};

}  // namespace livegs
