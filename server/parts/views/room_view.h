// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "splat/kernel_view.h"
#include "splat/project/project_kernels.h"

// Views of a room and the surface points seen in them. Lengths are in the unit of the asset, written _m.

namespace livegs {

// The kernels where the asset has them: the world is the frame of the asset.
PosedKernels pose_in_place(const GaussianAsset& asset);

struct RoomView {
  Camera camera;
  KernelView kernels;
};

// A point of the surface seen by one pixel.
struct ViewPoint {
  Eigen::Vector3f position_m;
  Eigen::Vector3f normal;  // towards the camera; zero at a jump of the depth
  Eigen::Vector3f rgb;
  uint32_t view = 0;
  uint32_t pixel = 0;
  float footprint_m = 0;  // edge of the pixel at the depth of the point
};

// Projects and back-projects points of one view.
class ViewRays {
 public:
  explicit ViewRays(const Camera& camera)
      : projection_(camera), world_from_image_(projection_.image_from_world.transpose()) {}

  Eigen::Vector3d point_m(int x, int y, double depth_m) const;
  const Eigen::Vector3d& position_m() const { return projection_.position_m; }
  double footprint_m(double depth_m) const { return depth_m / projection_.focal_x_px; }

  // The pixel of a point and its depth along the view axis; false if it is not in the picture.
  struct Hit {
    int x, y;
    double depth_m;
  };
  bool project(const Eigen::Vector3d& point_m, Hit& hit) const;

 private:
  Projection projection_;
  Eigen::Matrix3d world_from_image_;
};

// Points of every `stride`-th pixel in both directions that shows a surface, view by view.
std::vector<ViewPoint> view_points(std::span<const RoomView> views, int stride);

// Normal of the surface at a pixel from the depths of its neighbours; zero at a jump.
Eigen::Vector3f pixel_normal(const ViewRays& rays, const KernelView& view, int x, int y);

}  // namespace livegs
