// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace livegs::sample {

// Poisson-disc thinning: a dart is accepted if no earlier dart on the same side of the surface is within its
// radius. Random packing leaves holes up to a radius wide. `fill` accepts darts in holes where the kernels of
// the surrounding darts would let light through. The hashed grid has cells twice as wide as the largest
// radius, so the eight nearest cells contain all relevant neighbours.
class PoissonDisk {
 public:
  PoissonDisk(double largest_radius, size_t expected_darts);

  // Normals define the side: darts with opposed normals (two faces of a thin wall) do not affect each other.
  bool take(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius);

  // Accepted if the optical depth of the surrounding darts, drawn as kernels of their radius, is below that
  // of a closed surface.
  bool fill(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius);

 private:
  struct Dart {
    Eigen::Vector3d point, normal;
    double radius;
    int32_t next;
  };
  size_t bucket(int64_t x, int64_t y, int64_t z) const;
  // Returns the heads of the eight lists near the point.
  std::array<int32_t, 8> lists_near(const Eigen::Vector3d& point) const;
  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius);

  double cell_;  // width of a cell
  std::vector<int32_t> heads_;
  std::vector<Dart> darts_;
};

}  // namespace livegs::sample
