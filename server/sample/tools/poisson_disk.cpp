// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/poisson_disk.h"

#include <algorithm>
#include <cmath>

namespace livegs::sample {

PoissonDisk::PoissonDisk(double largest_radius, size_t expected_darts) : cell_(2.0 * largest_radius) {
  size_t buckets = 1024;
  while (buckets < 2 * expected_darts) buckets *= 2;
  heads_.assign(buckets, -1);
  darts_.reserve(expected_darts);
}

size_t PoissonDisk::bucket(int64_t x, int64_t y, int64_t z) const {
  return static_cast<size_t>(static_cast<uint64_t>(x) * 73856093u ^ static_cast<uint64_t>(y) * 19349663u ^
                             static_cast<uint64_t>(z) * 83492791u) &
         (heads_.size() - 1);
}

std::array<int32_t, 8> PoissonDisk::lists_near(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d low = (point / cell_ - Eigen::Vector3d::Constant(0.5)).array().floor();
  const auto x = static_cast<int64_t>(low.x()), y = static_cast<int64_t>(low.y()),
             z = static_cast<int64_t>(low.z());
  std::array<int32_t, 8> heads;
  std::array<size_t, 8> seen;
  for (int corner = 0; corner < 8; ++corner) {
    const size_t b = bucket(x + (corner & 1), y + ((corner >> 1) & 1), z + (corner >> 2));
    seen[corner] = b;
    // Two cells may share a bucket; its list is visited once.
    const bool again = std::find(seen.begin(), seen.begin() + corner, b) != seen.begin() + corner;
    heads[corner] = again ? -1 : heads_[b];
  }
  return heads;
}

bool PoissonDisk::take(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius) {
  for (int32_t i : lists_near(point))
    for (; i >= 0; i = darts_[i].next) {
      const Dart& dart = darts_[i];
      if ((dart.point - point).squaredNorm() < radius * radius && dart.normal.dot(normal) > 0.0) return false;
    }
  add(point, normal, radius);
  return true;
}

bool PoissonDisk::fill(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius) {
  // Kernels with a standard deviation of 0.75 radius and an opacity of 0.95; a hole is a point where more
  // than 5 % of the light passes.
  constexpr double kSigma = 0.75, kOpacity = 0.95, kClosed = 0.05;
  double transmittance = 1.0;
  for (int32_t i : lists_near(point))
    for (; i >= 0; i = darts_[i].next) {
      const Dart& dart = darts_[i];
      const double sigma = kSigma * dart.radius;
      const double power = 0.5 * (dart.point - point).squaredNorm() / (sigma * sigma);
      if (power > 4.0 || dart.normal.dot(normal) <= 0.0) continue;
      transmittance *= 1.0 - kOpacity * std::exp(-power);
      if (transmittance < kClosed) return false;
    }
  add(point, normal, radius);
  return true;
}

void PoissonDisk::add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius) {
  const Eigen::Vector3d cell = (point / cell_).array().floor();
  int32_t& head = heads_[bucket(static_cast<int64_t>(cell.x()), static_cast<int64_t>(cell.y()),
                                static_cast<int64_t>(cell.z()))];
  darts_.push_back({point, normal, radius, head});
  head = static_cast<int32_t>(darts_.size()) - 1;
}

}  // namespace livegs::sample
