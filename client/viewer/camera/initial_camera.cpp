// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/initial_camera.h"

namespace livegs {

Result<Camera> initial_camera(const SceneView& view, PictureSize size,
                              const std::filesystem::path& camera_file,
                              const std::optional<PictureColumns>& free) {
  if (!camera_file.empty()) return read_camera_file(camera_file, size);
  return choose_camera(view, size.width, size.height, free);
}

OrbitCamera orbit_of(const SceneView& view, const Camera& camera) {
  Eigen::AlignedBox3d all;
  for (const Eigen::AlignedBox3d& box : view.object_boxes()) all.extend(box);
  return {camera, all.isEmpty() ? 1.0 : (all.center() - camera.world_from_camera.position_m).norm()};
}

}  // namespace livegs
