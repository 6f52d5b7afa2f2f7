// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/motion/surface_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "scene/views/scene_drawing.h"
#include "splat/project/project_kernels.h"

namespace livegs {

Result<SurfaceView> SurfaceView::of(const Scene& scene, const Camera& camera,
                                    std::span<const std::string> objects) {
  SceneDrawing drawing;
  drawing.keep_deformation_gradients(true);
  auto drawn = drawing.pose(scene);
  if (!drawn) return drawn.error();
  SurfaceView result;
  result.camera_ = camera;
  Rasteriser rasteriser;
  RasterisedView whole;
  rasteriser.draw(*drawn, camera, drawing.options(), whole);
  result.object_id_ = std::move(whole.object_id);
  KernelRasteriser kernels;
  for (const DrawnObject& one : *drawn) {
    const SceneObject& object = *scene.find(one.object_id);
    if (object.environment || std::find(objects.begin(), objects.end(), object.name) == objects.end())
      continue;
    result.names_[one.object_id] = object.name;
    Seen& seen = result.seen_[one.object_id];
    kernels.draw(one, camera, seen.view);
    seen.positions_m = one.kernels->positions_m;
    seen.rest_points = object.asset->positions;
    const Similarity& placed = object.rest.object_from_asset;
    const Eigen::Matrix3f object_from_asset =
        (placed.scale * placed.rotation.toRotationMatrix()).cast<float>();
    for (const Eigen::Matrix3f& gradient : drawing.deformation_gradients(one.object_id))
      seen.asset_from_world.push_back((gradient * object_from_asset).inverse());
  }
  return result;
}

std::vector<uint8_t> SurfaceView::mask(const std::string& object, int rim_px) const {
  const int width = camera_.width, height = camera_.height;
  std::vector<uint8_t> inside(object_id_.size(), 0);
  for (size_t i = 0; i < inside.size(); ++i) {
    const auto name = names_.find(object_id_[i]);
    inside[i] = name != names_.end() && name->second == object ? 255 : 0;
  }
  // Erosion by a square window, over rows and then columns. Pixels beyond the picture are outside.
  const auto erode = [&](const std::vector<uint8_t>& of, int dx, int dy) {
    std::vector<uint8_t> eroded(of.size(), 0);
    for (int y = rim_px; y < height - rim_px; ++y) {
      for (int x = rim_px; x < width - rim_px; ++x) {
        uint8_t least = 255;
        for (int k = -rim_px; k <= rim_px; ++k)
          least =
              std::min(least, of[static_cast<size_t>(y + k * dy) * width + static_cast<size_t>(x + k * dx)]);
        eroded[static_cast<size_t>(y) * width + x] = least;
      }
    }
    return eroded;
  };
  return erode(erode(inside, 1, 0), 0, 1);
}

std::optional<TrackedPoint> SurfaceView::at(const Eigen::Vector2d& px) const {
  if (!(px.x() >= 0 && px.y() >= 0 && px.x() < camera_.width && px.y() < camera_.height)) return std::nullopt;
  const size_t pixel =
      static_cast<size_t>(px.y()) * static_cast<size_t>(camera_.width) + static_cast<size_t>(px.x());
  const auto found = seen_.find(object_id_[pixel]);
  if (found == seen_.end()) return std::nullopt;
  const Seen& seen = found->second;
  const uint32_t kernel = seen.view.kernel[pixel];
  const double depth_m = seen.view.depth_m[pixel];
  if (kernel == kNoKernel || !std::isfinite(depth_m)) return std::nullopt;
  const Projection projection(camera_);
  const Eigen::Vector3d in_image((px.x() - projection.centre_x_px) / projection.focal_x_px * depth_m,
                                 (px.y() - projection.centre_y_px) / projection.focal_y_px * depth_m,
                                 depth_m);
  const Eigen::Vector3f world_m =
      (projection.image_from_world.transpose() * in_image + projection.position_m).cast<float>();
  const Eigen::Vector3f point =
      seen.rest_points[kernel] + seen.asset_from_world[kernel] * (world_m - seen.positions_m[kernel]);
  if (!point.allFinite()) return std::nullopt;
  return TrackedPoint{names_.at(found->first), point};
}

}  // namespace livegs
