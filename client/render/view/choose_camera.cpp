// SPDX-License-Identifier: Apache-2.0
#include "render/choose_camera.h"

#include <cmath>

namespace livegs {
namespace {

// An environment whose centre is nearer than this to the objects' centre, relative to their size, surrounds
// them.
constexpr double kMaxCentreOffset = 0.15;

}  // namespace

Camera choose_camera(const SceneView& view, int width, int height,
                     const std::optional<PictureColumns>& free) {
  const std::vector<Eigen::AlignedBox3d> boxes = view.object_boxes();
  Eigen::AlignedBox3d all;
  for (const Eigen::AlignedBox3d& box : boxes) all.extend(box);
  double azimuth_rad = 0.0;
  if (const auto environment = view.environment_middle(); environment && !all.isEmpty()) {
    const Eigen::Vector3d away = all.center() - *environment;
    if (std::hypot(away.x(), away.z()) > kMaxCentreOffset * all.sizes().maxCoeff()) {
      azimuth_rad = std::atan2(away.x(), away.z());
    }
  }
  return frame_boxes(boxes, width, height, azimuth_rad, kDefaultElevation_rad, free);
}

}  // namespace livegs
