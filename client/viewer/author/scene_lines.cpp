// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/scene_lines.h"

#include "viewer/camera/orbit_camera.h"

namespace livegs {

void add_line(const Camera& camera, Eigen::Vector3d a, Eigen::Vector3d b, WindowLine::Ink ink, float width_px,
              std::vector<WindowLine>& lines) {
  const Pose camera_from_world = camera.world_from_camera.inverse();
  Eigen::Vector3d from = camera_from_world * a, to = camera_from_world * b;
  const double near = -camera.near_m;
  if (from.z() > near && to.z() > near) return;
  if (from.z() > near) from += (near - from.z()) / (to.z() - from.z()) * (to - from);
  if (to.z() > near) to += (near - to.z()) / (from.z() - to.z()) * (from - to);
  const auto first = pixel_of(camera, camera.world_from_camera * from),
             last = pixel_of(camera, camera.world_from_camera * to);
  if (first && last) lines.push_back({{*first, *last}, ink, width_px, false, ""});
}

void add_box(const Camera& camera, const Eigen::AlignedBox3d& box, const Pose& world_from_box,
             WindowLine::Ink ink, std::vector<WindowLine>& lines) {
  if (box.isEmpty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < 4; ++corner) {
      Eigen::Vector3d a = box.min();
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (corner & 1) a[u] = box.max()[u];
      if (corner & 2) a[v] = box.max()[v];
      Eigen::Vector3d b = a;
      b[axis] = box.max()[axis];
      add_line(camera, world_from_box * a, world_from_box * b, ink, 1.5f, lines);
    }
  }
}

}  // namespace livegs
