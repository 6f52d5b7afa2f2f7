// SPDX-License-Identifier: Apache-2.0
#include "render/choose_camera.h"

#include <cmath>

#include "splat/frame_bounds.h"

namespace livegs {
namespace {

// An environment whose middle is nearer than this to the objects' middle, in units of their size, is around
// them.
constexpr double kAround = 0.15;

}  // namespace

Camera choose_camera(const SceneView& view, int width, int height) {
  Eigen::AlignedBox3d bounds = view.object_bounds();
  if (bounds.isEmpty()) bounds = {Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5)};
  double azimuth_rad = 0.0;
  if (const auto environment = view.environment_middle()) {
    const Eigen::Vector3d away = bounds.center() - *environment;
    if (std::hypot(away.x(), away.z()) > kAround * bounds.sizes().maxCoeff())
      azimuth_rad = std::atan2(away.x(), away.z());
  }
  return frame_bounds(bounds, width, height, azimuth_rad);
}

}  // namespace livegs
