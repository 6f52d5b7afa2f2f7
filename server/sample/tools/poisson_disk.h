// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace livegs::sample {

// Poisson-disc thinning: a dart is taken when no earlier dart on the same side of the surface lies nearer
// than its radius. Random packing leaves holes nearly a radius wide; `fill` takes darts that fall into them,
// where the kernels of the darts around would let light through. Hashed grid with cells twice as wide as the
// largest radius: the eight nearest cells hold every neighbour that matters.
class PoissonDisk {
 public:
  PoissonDisk(double largest_radius, size_t expected_darts);

  // Normals decide the side: darts whose normals point apart do not see each other (two faces of a thin
  // wall).
  bool take(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius);

  // Taken when the optical depth of the darts around, drawn as kernels of their radius, is below what a
  // closed surface needs.
  bool fill(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius);

 private:
  struct Dart {
    Eigen::Vector3d point, normal;
    double radius;
    int32_t next;
  };
  size_t bucket(int64_t x, int64_t y, int64_t z) const;
  // The heads of the eight lists that hold what is near the point.
  std::array<int32_t, 8> lists_near(const Eigen::Vector3d& point) const;
  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double radius);

  double cell_;  // width
  std::vector<int32_t> heads_;
  std::vector<Dart> darts_;
};

}  // namespace livegs::sample
