// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"

// Simple solids and the flat kernels on their visible faces. Modelling frame: metres, y up.

namespace livegs::sample {

struct SurfacePoint {
  Eigen::Vector3d position_m, normal, tangent;  // unit normal outward, unit tangent
  double spacing_m;
};

enum class SolidShape { Box, Cylinder, Ball, Mug, Bottle };

struct Solid {
  std::string name;
  SolidShape shape = SolidShape::Box;
  Eigen::Vector3d size_m{0.1, 0.1, 0.1};  // extents of the bounding box, without the handle of a mug
  Eigen::Vector3d base_m{0, 0, 0};        // middle of the lowest face
  double yaw_rad = 0.0;
  Eigen::Vector3d rgb{0.5, 0.5, 0.5};
  int pattern = 0;  // 0 plain, 1 label, 2 stripes

  Eigen::Vector3d local(const Eigen::Vector3d& point_m) const;  // from the middle of the base
  // Signed distance of the convex outline, negative inside: a bound for mugs and bottles.
  double distance_m(const Eigen::Vector3d& point_m) const;
  Eigen::AlignedBox3d bounds_m() const;
  Eigen::Vector3d colour_at(const SurfacePoint& point, uint64_t seed) const;
};

// Points on all faces of a standing solid except the underside.
std::vector<SurfacePoint> solid_points(const Solid& solid, double spacing_m, uint64_t seed);
// Points on a rectangle. The normal is the cross product of `along_m` and `across_m`.
std::vector<SurfacePoint> rectangle_points(const Eigen::Vector3d& corner_m, const Eigen::Vector3d& along_m,
                                           const Eigen::Vector3d& across_m, double spacing_m, uint64_t seed);

// Collects kernels in the frame of GaussianAsset.
struct SolidKernels {
  GaussianAsset asset;
  std::vector<uint16_t> owner;
  // `rgb` is the albedo; the light comes from above, the right and the front.
  void add(const SurfacePoint& point, const Eigen::Vector3d& rgb, size_t owner_number);
};

}  // namespace livegs::sample
